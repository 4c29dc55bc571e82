//! Output of BabelBetes (github.com/nudgebg/egvinsulin): the tables `cgm`, `bolus` and `basal`.
//!
//! Either partitioned folders `study_name=S/data_type=T/patient_id=P/*.parquet`, or the files
//! `cgm.parquet`, `bolus.parquet` and `basal.parquet` with a column `patient_id`. Within a folder
//! `study_name=S` study and patient together name the person. Glucose is in
//! mg/dL; a bolus takes `delivery_duration`; `basal_rate` (U/h) holds until the next one; `carbs`,
//! in g, where a study has them.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::diary::{Diary, Rate, people, second};
use super::files::{entries, name};
use super::parquet_rows::{Kind, ParquetRow, Wanted, for_each};
use crate::error::CohortError;
use crate::person::is_person_id;
use crate::record::Channel;

const FORMAT: &str = "babelbetes";
/// Deepest folder below the source.
const DEPTH: usize = 4;
/// Longest time a bolus takes, s, as for every dose.
const LONGEST: f64 = 172_800.0;

/// A table of the output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Table {
    Cgm,
    Bolus,
    Basal,
    Carbs,
}

impl Table {
    const ALL: [(Self, &str); 4] = [
        (Self::Cgm, "cgm"),
        (Self::Bolus, "bolus"),
        (Self::Basal, "basal"),
        (Self::Carbs, "carbs"),
    ];

    fn of(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(_, known)| *known == name).map(|(table, _)| *table)
    }

    /// Person, time, value and duration.
    const fn columns(self, person: bool) -> [Wanted; 4] {
        let value = match self {
            Self::Cgm => "cgm",
            Self::Bolus => "bolus",
            Self::Basal => "basal_rate",
            Self::Carbs => "carbs",
        };
        [
            ("patient_id", Kind::Text, person),
            ("datetime", Kind::Time, true),
            (value, Kind::Number, true),
            ("delivery_duration", Kind::Span, matches!(self, Self::Bolus)),
        ]
    }
}

const PERSON: usize = 0;
const TIME: usize = 1;
const VALUE: usize = 2;
const DURATION: usize = 3;

/// A file, and of which study and whose it is where its folders say so.
struct Part {
    path: PathBuf,
    shown: String,
    table: Table,
    study: Option<String>,
    /// The study is part of it.
    person: Option<String>,
}

impl Part {
    /// The identifier of a row's person: study and patient; `None` where no patient is named.
    fn person<'a>(&'a self, row: &'a ParquetRow<'_>) -> Option<Cow<'a, str>> {
        match (&self.person, &self.study) {
            (Some(person), _) => Some(Cow::Borrowed(person.as_str())),
            (None, None) => row.text(PERSON).map(Cow::Borrowed),
            (None, Some(study)) => {
                let patient = row.text(PERSON)?;
                Some(Cow::Owned(format!("{study}-{patient}")))
            }
        }
    }
}

/// Reads the output's folder.
pub(super) fn import(source: &Path) -> Result<super::Import, CohortError> {
    if !source.is_dir() {
        let reason = "not a folder; give the folder that it writes";
        return Err(CohortError::layout(source.display(), FORMAT, reason));
    }
    let mut parts = Vec::new();
    find(source, source, None, None, None, 0, &mut parts)?;
    parts.sort_by(|a, b| (a.table, &a.shown).cmp(&(b.table, &b.shown)));
    if !parts.iter().any(|part| part.table == Table::Cgm) {
        let reason = "no cgm.parquet and no folder data_type=cgm";
        return Err(CohortError::layout(source.display(), FORMAT, reason));
    }
    let mut diaries: BTreeMap<String, Diary> = BTreeMap::new();
    for part in &parts {
        for_each(&part.path, &part.shown, &part.table.columns(part.person.is_none()), |row| {
            let id = part.person(&row).unwrap_or_default();
            if !is_person_id(&id) {
                return Err(row.wrong(PERSON, "an identifier of letters, digits, '_', '-' and '.'"));
            }
            if !diaries.contains_key(&*id) {
                let diary = Diary::new(&id, &part.shown);
                diaries.insert(id.to_string(), diary);
            }
            let diary = diaries.get_mut(&*id).expect("inserted above");
            read(part.table, &row, diary)
        })?;
    }
    people(FORMAT, source, diaries.into_values())
}

fn read(table: Table, row: &ParquetRow<'_>, diary: &mut Diary) -> Result<(), CohortError> {
    let place = || row.place(VALUE);
    let Some(value) = row.number(VALUE)? else {
        diary.note("rows without a value: left out", place);
        return Ok(());
    };
    let at = second(row.time(TIME)?);
    match table {
        Table::Cgm => diary.reading(at, value, place),
        Table::Carbs => diary.dose(Channel::Carbs, at, 0, value, place),
        Table::Basal => diary.rate(Rate { from: at, to: None, u_h: value }, place),
        Table::Bolus => {
            let seconds = row.number(DURATION)?.unwrap_or(0.0);
            if !(0.0..=LONGEST).contains(&seconds) {
                return Err(row.wrong(DURATION, "a duration from 0 to 2 days"));
            }
            diary.dose(Channel::Bolus, at, seconds.round() as i64, value, place)
        }
    }
}

/// The Parquet files below a folder whose table is known.
fn find(
    source: &Path,
    folder: &Path,
    study: Option<&str>,
    table: Option<Table>,
    person: Option<&str>,
    depth: usize,
    parts: &mut Vec<Part>,
) -> Result<(), CohortError> {
    for path in entries(folder)? {
        let name = name(&path);
        if path.is_dir() && depth < DEPTH {
            match name.split_once('=') {
                Some(("study_name", value)) => {
                    find(source, &path, Some(value), table, person, depth + 1, parts)?;
                }
                Some(("data_type", value)) => {
                    if let Some(table) = Table::of(value) {
                        find(source, &path, study, Some(table), person, depth + 1, parts)?;
                    }
                }
                Some(("patient_id", value)) => {
                    find(source, &path, study, table, Some(value), depth + 1, parts)?;
                }
                _ => {}
            }
            continue;
        }
        let Some(stem) = name.strip_suffix(".parquet") else { continue };
        let Some(table) = table.or_else(|| Table::of(stem)) else { continue };
        let person = person.map(|person| match study {
            Some(study) => format!("{study}-{person}"),
            None => person.to_owned(),
        });
        let study = study.map(str::to_owned);
        let shown = path.strip_prefix(source).unwrap_or(&path).display().to_string();
        parts.push(Part { path, shown, table, study, person });
    }
    Ok(())
}
