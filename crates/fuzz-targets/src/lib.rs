//! Everything that reads files, as functions of bytes.
//!
//! A [`Target`] panics if a reader panics, or if what was read cannot be written and read again. A
//! fuzzer calls it with bytes of its own (`fuzz/` beside the crates), the tests of this crate with
//! damaged seeds.
//!
//! ```
//! let nightscout = fuzz_targets::target("nightscout").expect("one of the targets");
//! (nightscout.run)(b"no JSON at all");
//! ```

mod folders;
mod models;

use cohort::ImportFormat::*;
use cohort::RecordsFormat::{Csv, Parquet};

use folders::{downloads, import, imports, read_cohort};

/// A reader with inputs to begin from.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// Its name: that of a format, or of what is read.
    pub name: &'static str,
    /// Good inputs.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Reads bytes; panics where the reader is wrong.
    pub run: fn(&[u8]),
}

impl Target {
    const fn of(name: &'static str, seeds: fn() -> Vec<Vec<u8>>, run: fn(&[u8])) -> Self {
        Self { name, seeds, run }
    }
}

/// Every target.
pub const TARGETS: &[Target] = &[
    Target::of("cohort_csv", folders::csv_seeds, |bytes| read_cohort(bytes, Csv)),
    Target::of("cohort_parquet", folders::parquet_seeds, |bytes| read_cohort(bytes, Parquet)),
    Target::of("table", folders::table_seeds, folders::read_table),
    Target::of("workbook", folders::workbook_seeds, folders::read_workbook),
    Target::of("dexcom", || downloads("dexcom"), |bytes| import(Dexcom, bytes)),
    Target::of("libre", || downloads("libre"), |bytes| import(Libre, bytes)),
    Target::of("hupa_ucm", || vec![pack(&folders::HUPA)], |bytes| import(HupaUcm, bytes)),
    Target::of("t1d_uom", || vec![pack(&folders::UOM)], |bytes| import(T1dUom, bytes)),
    Target::of("t1dsim", || vec![pack(&folders::T1DSIM)], |bytes| import(T1dSim, bytes)),
    Target::of("nightscout", || imports(["nightscout"]), |bytes| import(Nightscout, bytes)),
    Target::of(
        "tidepool",
        || imports(["tidepool", "tidepool-site", "tidepool-xlsx"]),
        |bytes| import(Tidepool, bytes),
    ),
    Target::of("t1dexi", || imports(["t1dexi"]), |bytes| import(T1dexi, bytes)),
    Target::of("metabonet", || imports(["metabonet"]), |bytes| import(Metabonet, bytes)),
    Target::of("babelbetes", || imports(["babelbetes"]), |bytes| import(Babelbetes, bytes)),
    Target::of("ohio", || imports(["ohio"]), |bytes| import(Ohio, bytes)),
    Target::of("simglucose", || imports(["simglucose"]), |bytes| import(Simglucose, bytes)),
    Target::of("replaybg", || imports(["replaybg"]), |bytes| import(Replaybg, bytes)),
    Target::of("weights", || vec![models::WEIGHTS.to_vec()], models::read_weights),
    Target::of("twin", || vec![models::twin()], models::read_twin),
    Target::of("region", || vec![models::REGION.to_vec()], models::read_region),
    Target::of("certificate", models::certificate_seeds, models::read_certificate),
    Target::of("documents", models::document_seeds, models::read_document),
];

/// The target of a name.
#[must_use]
pub fn target(name: &str) -> Option<&'static Target> {
    TARGETS.iter().find(|target| target.name == name)
}

/// What stands before the name of a file; the name ends at the end of its line.
const MARK: &[u8] = b"\n\x01file ";

/// Packs files: name and content.
#[must_use]
pub fn pack(files: &[(impl AsRef<str>, impl AsRef<[u8]>)]) -> Vec<u8> {
    let marked = files.iter().flat_map(|(name, content)| {
        [MARK, name.as_ref().as_bytes(), b"\n", content.as_ref()].concat()
    });
    marked.collect()
}

/// The files of packed bytes. What stands before the first name, and files whose name leads out of
/// their folder, are left out.
#[must_use]
pub fn unpack(bytes: &[u8]) -> Vec<(String, &[u8])> {
    let starts: Vec<usize> = (0..bytes.len()).filter(|at| bytes[*at..].starts_with(MARK)).collect();
    let ends = starts.iter().skip(1).copied().chain([bytes.len()]);
    let files = starts.iter().zip(ends).filter_map(|(start, end)| {
        let file = &bytes[start + MARK.len()..end];
        let line = file.iter().position(|byte| *byte == b'\n')?;
        let name = std::str::from_utf8(&file[..line]).ok()?;
        let inside = !name.is_empty()
            && name.split('/').all(|part| !matches!(part, "" | "." | ".."))
            && !name.contains('\0');
        inside.then(|| (name.to_owned(), &file[line + 1..]))
    });
    files.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_come_back_and_names_stay_inside() {
        let files = [("a.csv".to_owned(), b"x,y\n".to_vec()), ("b/c".to_owned(), Vec::new())];
        let packed = pack(&files);
        let back: Vec<_> = unpack(&packed).into_iter().map(|(n, b)| (n, b.to_vec())).collect();
        assert_eq!(back, files);
        for name in ["../a", "/a", "a/../b", ""] {
            assert!(unpack(&pack(&[(name, "")])).is_empty(), "{name}");
        }
    }
}
