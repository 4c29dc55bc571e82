//! A cohort in the formats that other programs read.
//!
//! Text cells that a spreadsheet would take for a formula get an apostrophe before them.

use std::path::Path;

use crate::error::CohortError;
use crate::person::Cohort;

mod csv;
mod iglu;
mod metabonet;
mod replaybg;
mod simglucose;

pub use self::csv::{Cell as CsvCell, Csv};

/// A format of other programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExportFormat {
    /// `iglu.csv` with `id,time,gl`, as the R package iglu reads it.
    Iglu,
    /// One table a person, as ReplayBG reads it.
    Replaybg,
    /// One table a person, like the results of simglucose.
    Simglucose,
    /// `metabonet.parquet` with the columns of MetaboNet.
    Metabonet,
}

impl ExportFormat {
    /// Every format.
    pub const ALL: &[Self] = &[Self::Iglu, Self::Replaybg, Self::Simglucose, Self::Metabonet];

    /// The format's name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Iglu => "iglu",
            Self::Replaybg => "replaybg",
            Self::Simglucose => "simglucose",
            Self::Metabonet => "metabonet",
        }
    }
}

/// Writes a cohort into a folder that exists, in another format.
///
/// # Errors
/// If a file cannot be written.
pub fn export(cohort: &Cohort, format: ExportFormat, folder: &Path) -> Result<(), CohortError> {
    match format {
        ExportFormat::Iglu => iglu::write(cohort, folder),
        ExportFormat::Replaybg => replaybg::write(cohort, folder),
        ExportFormat::Simglucose => simglucose::write(cohort, folder),
        ExportFormat::Metabonet => metabonet::write(cohort, folder),
    }
}
