//! Other people's formats, read into a cohort with an account of everything that was inferred,
//! changed or left out.
//!
//! Each importer keeps the column names of its format to itself and converts units in one function.

use std::path::{Path, PathBuf};

use crate::error::CohortError;
use crate::person::Cohort;
use crate::range::looks_like_mmol;

mod babelbetes;
mod dexcom;
mod diary;
mod files;
mod hupa_ucm;
mod hupa_units;
mod json_records;
mod libre;
mod metabonet;
mod nightscout;
mod ohio;
mod parquet_rows;
mod rates;
mod replaybg;
mod report;
mod simglucose;
mod steps;
mod t1d_uom;
mod t1dexi;
mod t1dsim;
mod table;
mod tidepool;
mod workbook;
mod zone;

pub use contract::import_report::{ImportReport, Inference, Note, PersonImport, Totals};
pub use table::{DateOrder, Only, Role, TableGuess, TableOptions, guess_table};

/// An importer.
enum Importer {
    /// Of one folder or file.
    Folder(fn(&Path) -> Result<Import, CohortError>),
    /// Of one folder or file whose times are instants; a zone says what the wall clock showed.
    Zoned(fn(&Path, Option<zone::Clock>) -> Result<Import, CohortError>),
    /// Of several files, with [`TableOptions`].
    Tables(fn(&[PathBuf], &TableOptions) -> Result<Import, CohortError>),
}

/// The formats: name on the command line, what it says of the source, and the importer.
macro_rules! formats {
    ($($format:ident $name:literal $says:literal $kind:ident($module:ident);)*) => {
        named::named! {
            /// A format that [`import()`] reads, by its name on the command line.
            ImportFormat { $(#[doc = $says] $format: $name,)* }
        }

        impl ImportFormat {
            /// What the source is.
            #[must_use]
            pub const fn says(self) -> &'static str {
                match self { $(Self::$format => $says,)* }
            }

            fn importer(self) -> Importer {
                match self { $(Self::$format => Importer::$kind($module::import),)* }
            }
        }
    };
}

formats! {
    Table "table" "Anybody's CSV or Excel sheet, one file or one a channel, as `--map` says" Tables(table);
    Dexcom "dexcom" "Dexcom Clarity: exported CSVs, or a folder of them" Tables(dexcom);
    Libre "libre" "LibreView: exported CSVs, or a folder of them" Tables(libre);
    HupaUcm "hupa-ucm" "HUPA-UCM (doi:10.17632/3hbcscwz44.1): `HUPA*.csv` or their folder" Folder(hupa_ucm);
    T1dUom "t1d-uom" "T1D-UOM (doi:10.5281/zenodo.15169263): the folder with `Glucose Data`" Folder(t1d_uom);
    T1dSim "t1dsim" "The example day of T1DSim_AI: `example_subject*.csv`" Folder(t1dsim);
    Nightscout "nightscout" "A Nightscout site's JSON files in a folder, or a folder of such folders" Zoned(nightscout);
    Tidepool "tidepool" "Tidepool's JSON or XLSX export: a file, or a folder with one a person" Zoned(tidepool);
    T1dexi "t1dexi" "T1DEXI or T1DEXIP: the folder with `LB.xpt`, `FACM.xpt` and the others" Folder(t1dexi);
    Metabonet "metabonet" "MetaboNet: the Parquet file, or a folder with its parts" Folder(metabonet);
    Babelbetes "babelbetes" "BabelBetes: the folder it writes" Folder(babelbetes);
    Ohio "ohio" "OhioT1DM: a folder of its XML files, or one of them" Folder(ohio);
    Simglucose "simglucose" "simglucose: a folder of results like `adult#001.csv`, or one of them" Folder(simglucose);
    Replaybg "replaybg" "ReplayBG: a table, or a folder with one a person" Folder(replaybg);
}

/// A cohort and the account of how it was read.
#[derive(Debug, Clone, PartialEq)]
pub struct Import {
    /// The people.
    pub cohort: Cohort,
    /// What was inferred, changed and left out.
    pub report: ImportReport,
}

/// Reads foreign files.
///
/// # Errors
/// If `source` is not in the format, or a file of it cannot be read; the error names file, row and
/// column. What can be read but looks wrong becomes a note or a finding of the report instead.
pub fn import(format: ImportFormat, source: &Path) -> Result<Import, CohortError> {
    import_with(format, &[source.to_owned()], &TableOptions::default())
}

/// Reads several foreign files, with what the user says of them.
///
/// # Errors
/// As [`import()`]; also if the format takes neither.
pub fn import_with(
    format: ImportFormat,
    sources: &[PathBuf],
    options: &TableOptions,
) -> Result<Import, CohortError> {
    let imported = match format.importer() {
        Importer::Folder(read) => read(single(format, sources, options, "--zone")?)?,
        Importer::Zoned(read) => {
            let zone = options.zone.as_deref().map(table::clock::find).transpose()?;
            let others = TableOptions { zone: None, ..options.clone() };
            read(single(format, sources, &others, "--utc")?, zone.map(zone::Clock::Zone))?
        }
        Importer::Tables(read) => read(sources, options)?,
    };
    for person in &imported.cohort.people {
        if let Some(median) = looks_like_mmol(person.record.cgm()) {
            return Err(CohortError::Refused(format!(
                "person '{}': the median glucose would be {median} mg/dL, which nobody has; check \
                 the unit of glucose in the files",
                person.id
            )));
        }
    }
    Ok(imported)
}

/// The one source of a format that takes no options of tables; a refusal names `clock` among them.
fn single<'a>(
    format: ImportFormat,
    sources: &'a [PathBuf],
    options: &TableOptions,
    clock: &str,
) -> Result<&'a Path, CohortError> {
    let name = format.name();
    if !options.is_default() {
        let reason =
            format!("{name} needs none of --map, --unit, {clock}, --dates, --decimal and --sheet");
        return Err(CohortError::option("--from", reason));
    }
    match sources {
        [source] => Ok(source.as_path()),
        several => {
            let reason = format!("{name} takes one folder or file, not {}", several.len());
            Err(CohortError::option("SOURCE", reason))
        }
    }
}
