//! A folder to fill in: every column, one person, three steps.

use std::path::Path;

use physiology::Kilograms;

use super::{RecordsFormat, write_folder};
use crate::error::CohortError;
use crate::person::{Cohort, Person, Therapy};
use crate::record::{Channel, Record};

/// First example step.
const START: &str = "2024-03-01T08:00:00";
/// What the three steps hold; `None` is left empty.
const ROWS: [(Channel, [Option<f64>; 3]); 8] = [
    (Channel::Cgm, [Some(112.0), Some(115.0), None]),
    (Channel::Basal, [Some(0.8), Some(0.8), Some(0.8)]),
    (Channel::Bolus, [Some(4.5), Some(0.0), Some(0.0)]),
    (Channel::Carbs, [Some(45.0), Some(0.0), Some(0.0)]),
    (Channel::HeartRate, [Some(64.0), Some(66.0), Some(71.0)]),
    (Channel::Steps, [Some(0.0), Some(12.0), Some(140.0)]),
    (Channel::SleepEfficiency, [Some(0.0), Some(0.0), Some(0.0)]),
    (Channel::SetChange, [Some(0.0), Some(0.0), Some(1.0)]),
];

/// Writes a template of a cohort folder as text: `people.csv` with one person and `records.csv` with
/// three example rows. It can be read as it is.
///
/// # Errors
/// If the folder holds anything, or cannot be written.
pub fn new_folder(folder: &Path) -> Result<(), CohortError> {
    let holds_files = std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some());
    if holds_files || folder.is_file() {
        let reason = "there are files; choose another name";
        return Err(CohortError::layout(folder.display(), "a new folder", reason));
    }
    let start = START.parse().expect("a literal time");
    let mut record = Record::new(start, 3)?;
    for (channel, values) in ROWS {
        record.channel_mut(channel).copy_from_slice(&values);
    }
    let person = Person {
        id: "example".into(),
        weight: Some(Kilograms(70.0)),
        therapy: Therapy::OpenLoopPump,
        heart_rate_baseline: None,
        record,
    };
    write_folder(&Cohort { people: vec![person] }, folder, RecordsFormat::Csv)
}
