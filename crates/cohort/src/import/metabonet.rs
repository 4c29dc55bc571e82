//! MetaboNet (metabo-net.org): one Parquet file of many studies on a five-minute grid.
//!
//! A row has the reading at its time and what was given in the five minutes before: `basal` and
//! `bolus` in U, `carbs` in g. `weight` is in lb. An `id` is one person only together with its
//! `source_file`, so both make the identifier.

use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};
use std::path::Path;

use physiology::Kilograms;

use super::diary::{Diary, people, second};
use super::files::files;
use super::parquet_rows::{Kind, ParquetRow, Wanted, for_each};
use crate::error::CohortError;
use crate::person::{KG_PER_LB, Therapy, WEIGHTS, is_person_id, with_id_letters};
use crate::record::Channel;

const FORMAT: &str = "metabonet";
/// Seconds before a row's time in which its amounts were given.
const BEFORE: i64 = 300;

const ID: usize = 0;
const SOURCE: usize = 1;
const DATE: usize = 2;
const CGM: usize = 3;
const BASAL: usize = 4;
const BOLUS: usize = 5;
const INSULIN: usize = 6;
const CARBS: usize = 7;
const WEIGHT: usize = 8;
const HEART_RATE: usize = 9;
const STEPS: usize = 10;
const MODALITY: usize = 11;
const WANTED: [Wanted; 12] = [
    ("id", Kind::Text, true),
    ("source_file", Kind::Text, true),
    ("date", Kind::Time, true),
    ("CGM", Kind::Number, true),
    ("basal", Kind::Number, false),
    ("bolus", Kind::Number, false),
    ("insulin", Kind::Number, false),
    ("carbs", Kind::Number, false),
    ("weight", Kind::Number, false),
    ("heartrate", Kind::Number, false),
    ("steps", Kind::Number, false),
    ("insulin_delivery_modality", Kind::Text, false),
];

/// Reads a file or the folder's `*.parquet`.
pub(super) fn import(source: &Path) -> Result<super::Import, CohortError> {
    let mut study = Study::default();
    for (path, name) in files(source, FORMAT, "*.parquet", |name| name.ends_with(".parquet"))? {
        for_each(&path, &name, &WANTED, |row| study.read(&name, &row))?;
    }
    let mut diaries: Vec<Diary> = study.diaries.into_values().collect();
    diaries.sort_by(|a, b| a.account.id.cmp(&b.account.id));
    people(FORMAT, source, diaries)
}

#[derive(Default)]
struct Study {
    /// By source and number.
    diaries: HashMap<(String, String), Diary>,
    /// Identifiers of the persons.
    names: HashSet<String>,
}

impl Study {
    fn read(&mut self, file: &str, row: &ParquetRow<'_>) -> Result<(), CohortError> {
        let expected = "a text; source_file and id together name the person";
        let source = row.text(SOURCE).ok_or_else(|| row.wrong(SOURCE, expected))?;
        let id = row.text(ID).ok_or_else(|| row.wrong(ID, expected))?;
        let diary = match self.diaries.entry((source.to_owned(), id.to_owned())) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(vacant) => {
                let name = with_id_letters(&format!("{source}-{id}"));
                if !is_person_id(&name) {
                    return Err(row.wrong(ID, "a name that letters and digits can write"));
                }
                if !self.names.insert(name.clone()) {
                    let expected = "a name that stays unique in letters, digits, '_', '-' and '.'";
                    return Err(row.wrong(ID, expected));
                }
                vacant.insert(Diary::new(&name, file))
            }
        };
        let at = second(row.time(DATE)?);
        if let Some(glucose) = row.number(CGM)? {
            diary.reading(at, glucose, || row.place(CGM))?;
        }
        let (basal, bolus) = (row.number(BASAL)?, row.number(BOLUS)?);
        let before = at - BEFORE;
        if let Some(amount) = basal {
            diary.dose(Channel::Basal, before, BEFORE, amount, || row.place(BASAL))?;
        }
        if let Some(amount) = bolus {
            diary.dose(Channel::Bolus, before, 0, amount, || row.place(BOLUS))?;
        }
        if basal.is_none() && bolus.is_none() && row.number(INSULIN)?.is_some_and(|u| u > 0.0) {
            let what = "insulin that is neither basal nor bolus: left out";
            diary.note(what, || row.place(INSULIN));
        }
        if let Some(grams) = row.number(CARBS)? {
            diary.dose(Channel::Carbs, before, 0, grams, || row.place(CARBS))?;
        }
        if let Some(rate) = row.number(HEART_RATE)? {
            diary.heart_rate(before, rate, || row.place(HEART_RATE))?;
        }
        if let Some(count) = row.number(STEPS)? {
            diary.steps(before, 0, count, || row.place(STEPS))?;
        }
        if let Some(pounds) = row.number(WEIGHT)? {
            let kg = pounds * KG_PER_LB;
            if !WEIGHTS.contains(&kg) {
                return Err(row.wrong(WEIGHT, "a weight of 1 to 500 kg, in lb"));
            }
            diary.weight = Some(Kilograms(kg));
        }
        match row.text(MODALITY) {
            Some("MDI") => diary.therapy = Some(Therapy::Mdi),
            Some("AID") => diary.therapy = Some(Therapy::Aid),
            Some("SAP" | "CSII") => diary.therapy = Some(Therapy::OpenLoopPump),
            _ => {}
        }
        Ok(())
    }
}
