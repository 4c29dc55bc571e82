//! The record of a type 1 diabetes cohort: who was observed, what was given and what was measured,
//! on a five-minute grid.
//!
//! - [`Cohort`], [`Person`], [`Record`]: the data in memory, missing values marked as missing.
//! - [`read_folder`], [`write_folder`]: the canonical folder (`people.csv` with `records.csv` or
//!   `records.parquet`).
//! - [`check_folder`], [`new_folder`]: everything wrong with a folder at once; a template.
//! - [`import()`], [`import_with`]: other people's formats and anybody's tables, with an
//!   [`ImportReport`] whose sums close; [`guess_table`] proposes what a table's columns hold.
//! - [`export()`]: a cohort in the formats of other programs.
//! - [`findings`], [`StraightLines`], [`mass_balance`]: what looks wrong, and the daily totals.
//! - [`Person::inputs`]: a person's columns as the inputs of a plant.
//! - [`windows`], [`split_by_time`]: training and held-out parts.
//!
//! The crate knows no model. It reads and writes paths because the tables demand files; it prints
//! nothing.
//!
//! ```
//! let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/embedded/cohort");
//! let cohort = cohort::read_folder(folder.as_ref())?;
//! let person = &cohort.people[0];
//! let readings = person.record.cgm().iter().flatten().count();
//! assert!(readings > person.record.len() / 2);
//! let copy = tempfile::tempdir()?;
//! let (written, format) = (copy.path().join("cohort"), cohort::RecordsFormat::Csv);
//! cohort::write_folder(&cohort, &written, format)?;
//! assert_eq!(cohort::read_folder(&written)?.people.len(), cohort.people.len());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod best_days;
mod error;
mod export;
mod faults;
mod folder;
mod import;
mod inputs;
mod mass_balance;
mod near_name;
mod parquet_footer;
mod parquet_frame;
mod parquet_pages;
mod parquet_sink;
mod person;
mod plausibility;
mod range;
mod record;
mod resting_heart_rate;
mod sensor_cadence;
mod split;
mod straight_lines;
mod text_table;
mod wall_clock;
mod window;

pub use contract::import_report::{ImplausibleFigure, MassBalance};
pub use error::{CohortError, Place};
pub use export::{Csv, CsvCell, ExportFormat, export};
pub use faults::Fault;
pub use folder::{FolderCheck, RecordsFormat, check_folder, new_folder, read_folder, write_folder};
pub use import::{
    DateOrder, Import, ImportFormat, ImportReport, Inference, Note, Only, PersonImport, Role,
    TableGuess, TableOptions, Totals, guess_table, import, import_with,
};
pub use inputs::MissingDoses;
pub use mass_balance::{insulin_u_day, mass_balance};
pub use parquet_sink::{CellKind, Cells, ParquetSink};
pub use person::{Cohort, Person, Therapy};
pub use plausibility::findings;
pub use record::{Channel, Record};
pub use sensor_cadence::SensorCadence;
pub use split::{TRAINING_DAYS, TimeSplit, split_by_time};
pub use straight_lines::StraightLines;
pub use text_table::{TextColumn, TextTable};
pub use window::{DoseRule, Window, WindowRule, windows};
