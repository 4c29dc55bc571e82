//! Other people's formats, read into a cohort with an account of everything that was inferred,
//! changed or left out.
//!
//! Each importer keeps the column names of its format to itself and converts units in one function.

use std::path::Path;

use crate::error::CohortError;
use crate::person::Cohort;

mod babelbetes;
mod diary;
mod files;
mod hupa_ucm;
mod hupa_units;
mod json_records;
mod metabonet;
mod nightscout;
mod ohio;
mod parquet_rows;
mod replaybg;
mod report;
mod simglucose;
mod t1d_uom;
mod t1dexi;
mod t1dsim;
mod tidepool;
mod zone;

pub use contract::import_report::{ImportReport, Inference, Note, PersonImport, Totals};

/// Reads a Parquet file. The table library panics on some damaged files; here that becomes an error
/// like any other (the library's own message still goes to the panic hook). A damaged page length
/// can still exhaust the memory inside the library.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImportFormat {
    /// `HUPA*.csv` of the HUPA-UCM study (doi:10.17632/3hbcscwz44.1): a file or a folder of them.
    HupaUcm,
    /// Folders of events of the T1D-UOM study (doi:10.5281/zenodo.15169263).
    T1dUom,
    /// `example_subject*.csv` of T1DSim_AI: a file or a folder of them.
    T1dSim,
    /// `entries*.json`, `treatments*.json` and `profile*.json` of a Nightscout site.
    Nightscout,
    /// JSON exports of Tidepool: a file or a folder of them, one person each.
    Tidepool,
    /// SDTM domains of T1DEXI or T1DEXIP as SAS transport files in a folder.
    T1dexi,
    /// The Parquet file of MetaboNet, or a folder with its parts.
    Metabonet,
    /// The folder that BabelBetes writes: tables `cgm`, `bolus` and `basal`.
    Babelbetes,
    /// XML files of OhioT1DM: a file or a folder of them.
    Ohio,
    /// Results of simglucose, `adult#001.csv` and the like: a file or a folder of them.
    Simglucose,
    /// Tables of ReplayBG: a file or a folder of them, one person each.
    Replaybg,
}

impl ImportFormat {
    /// Every format.
    pub const ALL: &[Self] = &[
        Self::HupaUcm,
        Self::T1dUom,
        Self::T1dSim,
        Self::Nightscout,
        Self::Tidepool,
        Self::T1dexi,
        Self::Metabonet,
        Self::Babelbetes,
        Self::Ohio,
        Self::Simglucose,
        Self::Replaybg,
    ];

    /// The format's name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::HupaUcm => "hupa-ucm",
            Self::T1dUom => "t1d-uom",
            Self::T1dSim => "t1dsim",
            Self::Nightscout => "nightscout",
            Self::Tidepool => "tidepool",
            Self::T1dexi => "t1dexi",
            Self::Metabonet => "metabonet",
            Self::Babelbetes => "babelbetes",
            Self::Ohio => "ohio",
            Self::Simglucose => "simglucose",
            Self::Replaybg => "replaybg",
        }
    }

    /// The format of a name; `None` for an unknown name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|format| format.name() == name)
    }
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
    match format {
        ImportFormat::HupaUcm => hupa_ucm::import(source),
        ImportFormat::T1dUom => t1d_uom::import(source),
        ImportFormat::T1dSim => t1dsim::import(source),
        ImportFormat::Nightscout => nightscout::import(source),
        ImportFormat::Tidepool => tidepool::import(source),
        ImportFormat::T1dexi => t1dexi::import(source),
        ImportFormat::Metabonet => metabonet::import(source),
        ImportFormat::Babelbetes => babelbetes::import(source),
        ImportFormat::Ohio => ohio::import(source),
        ImportFormat::Simglucose => simglucose::import(source),
        ImportFormat::Replaybg => replaybg::import(source),
    }
}
