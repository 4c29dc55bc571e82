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

mod bundle;
mod folders;
mod models;

pub use bundle::{pack, unpack};

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

macro_rules! targets {
    ($($name:ident: $module:ident;)*) => {
        /// Every target.
        pub const TARGETS: &[Target] = &[$(Target {
            name: stringify!($name),
            seeds: $module::$name::seeds,
            run: $module::$name::run,
        },)*];
    };
}

targets! {
    cohort_csv: folders;
    cohort_parquet: folders;
    table: folders;
    workbook: folders;
    dexcom: folders;
    libre: folders;
    hupa_ucm: folders;
    t1d_uom: folders;
    t1dsim: folders;
    nightscout: folders;
    tidepool: folders;
    t1dexi: folders;
    metabonet: folders;
    babelbetes: folders;
    ohio: folders;
    simglucose: folders;
    replaybg: folders;
    weights: models;
    twin: models;
    region: models;
    certificate: models;
    documents: models;
}

/// The target of a name.
#[must_use]
pub fn target(name: &str) -> Option<&'static Target> {
    TARGETS.iter().find(|target| target.name == name)
}
