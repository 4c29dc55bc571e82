//! Options of the commands that make, read and change cohorts.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use pipeline::stages::export::ExportFormat;
use pipeline::stages::import::{DateOrder, ImportFormat};
use pipeline::stages::reconcile::{DetectorName, Rule};

use super::words::{self, DATE_ORDER, DETECTOR, EXPORT_FORMAT, RULE, one_of};

/// Options of `import`.
#[derive(Debug, Args)]
pub(crate) struct ImportArgs {
    /// Format of the source.
    #[arg(long, value_parser = words::cohort_format(), value_name = "FORMAT")]
    pub from: ImportFormat,
    /// The study's folder or file; for tables several are possible.
    #[arg(required = true)]
    pub source: Vec<PathBuf>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/import")]
    pub out: PathBuf,
    /// Write `records.parquet` in place of `records.csv`.
    #[arg(long)]
    pub parquet: bool,
    /// Which column is what: `time=COL,glucose=COL,...` (person, time or date and clock, glucose,
    /// basal, bolus, long_acting, carbs, heart_rate, steps, sleep, set_change; `FILE:COL` for a
    /// column of one file), or a TOML file.
    #[arg(long, value_name = "MAP")]
    pub map: Vec<String>,
    /// Units that are not mg/dL, U/h, U, g: `glucose=mmol/L,basal=U/5min,carbs=10 g`.
    #[arg(long, value_name = "UNITS")]
    pub unit: Vec<String>,
    /// Where the people lived, for times in UTC and daylight-saving time: `Europe/Madrid`.
    #[arg(long, value_name = "ZONE")]
    pub zone: Option<String>,
    /// Times without an offset are UTC.
    #[arg(long)]
    pub utc: bool,
    /// Order of day and month, where a table leaves it open.
    #[arg(long, value_parser = one_of(DATE_ORDER), value_name = "ORDER")]
    pub dates: Option<DateOrder>,
    /// The decimal mark, where a table leaves it open: `.` or `,`.
    #[arg(long, value_name = "MARK")]
    pub decimal: Option<char>,
    /// The sheet of an Excel workbook; without it the first.
    #[arg(long, value_name = "SHEET")]
    pub sheet: Option<String>,
    /// Propose a map of the tables, and write nothing.
    #[arg(long)]
    pub guess: bool,
}

/// What to do with a cohort folder.
#[derive(Debug, Subcommand)]
pub(crate) enum CohortCommand {
    /// List everything that is wrong with a folder, with row, column and remedy.
    Check {
        /// The cohort folder.
        folder: PathBuf,
    },
    /// Write a template with three example rows.
    New {
        /// The folder to make.
        folder: PathBuf,
    },
}

/// Options of `export`.
#[derive(Debug, Args)]
pub(crate) struct ExportArgs {
    /// Cohort folder.
    #[arg(long, value_name = "DIR")]
    pub cohort: PathBuf,
    /// Format to write.
    #[arg(long, value_parser = one_of(EXPORT_FORMAT), value_name = "FORMAT")]
    pub to: ExportFormat,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/export")]
    pub out: PathBuf,
}

/// Options of `simulate`.
#[derive(Debug, Args)]
pub(crate) struct SimulateArgs {
    /// Parameters of the patients, a row each.
    #[arg(long, value_name = "FILE")]
    pub patients: PathBuf,
    /// Meals: step and grams.
    #[arg(long, value_name = "FILE")]
    pub meals: PathBuf,
    /// Initial states, a row a patient [default: the steady state at 160 mg/dL].
    #[arg(long, value_name = "FILE")]
    pub initial: Option<PathBuf>,
    /// Days to simulate.
    #[arg(long, value_name = "N", default_value_t = 4)]
    pub days: usize,
    /// One scenario by name [default: both].
    #[arg(long, value_name = "NAME")]
    pub scenario: Option<String>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/simulate")]
    pub out: PathBuf,
}

/// Options of `reconcile`.
#[derive(Debug, Args)]
pub(crate) struct ReconcileArgs {
    /// Cohort folder.
    #[arg(long, value_name = "DIR")]
    pub cohort: PathBuf,
    /// How meals are found.
    #[arg(long, value_parser = one_of(DETECTOR), value_name = "DETECTOR", default_value = "plant")]
    pub detector: DetectorName,
    /// How they and the log become one log.
    #[arg(long, value_parser = one_of(RULE), value_name = "RULE", default_value = "published")]
    pub rule: Rule,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/reconcile")]
    pub out: PathBuf,
}
