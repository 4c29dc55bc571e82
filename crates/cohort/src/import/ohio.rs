//! XML files of OhioT1DM (the reader's own licensed copy): `ID-ws-training.xml`,
//! `ID-ws-testing.xml`.
//!
//! Files of one patient are one person. Times are `DD-MM-YYYY HH:MM:SS` on the local clock. `basal`
//! holds until the next one, `temp_basal` replaces it from begin to end. Boluses are spread from
//! begin to end. Finger sticks, and what only one of the two years has (skin and air temperature,
//! galvanic response, acceleration), are no part of a record. The weight is 99 for everybody, so it is not one. Sleep is that of the armband.
//!
//! A row in a message is the number of the event in its file, from 1.

use std::collections::BTreeMap;
use std::path::Path;

use chrono::NaiveDateTime;
use quick_xml::Reader;
use quick_xml::events::Event;

use super::diary::{Diary, Rate, people, second};
use super::files::files;
use crate::error::{CohortError, Place};
use crate::person::is_person_id;
use crate::record::Channel;
use crate::text_table::read_text;
use crate::wall_clock::parse_day_first;

const FORMAT: &str = "ohio";
/// Largest file, bytes; the largest of the study has 4 MB.
const LARGEST: u64 = 256 << 20;

/// Reads a file or the folder's `*.xml`.
pub(super) fn import(source: &Path) -> Result<super::Import, CohortError> {
    let mut patients: BTreeMap<String, Patient> = BTreeMap::new();
    for (path, name) in files(source, FORMAT, "*.xml", |name| name.ends_with(".xml"))? {
        let size = std::fs::metadata(&path).map_err(CohortError::io(&name, "read"))?.len();
        if size == 0 {
            return Err(CohortError::empty(name));
        }
        if size > LARGEST {
            return Err(CohortError::table(name, "larger than 256 MiB; no patient's file is"));
        }
        let bytes = read_text(&path, &name)?;
        let text = std::str::from_utf8(&bytes).map_err(|error| {
            let line = 1 + bytes[..error.valid_up_to()].iter().filter(|b| **b == b'\n').count();
            CohortError::at(Place::row(&name, line), "not UTF-8; save the file as UTF-8")
        })?;
        read(text, &name, &mut patients)?;
    }
    let diaries: Result<Vec<Diary>, _> = patients.into_values().map(Patient::finish).collect();
    people(FORMAT, source, diaries?)
}

/// One patient while the files are read.
#[derive(Default)]
struct Patient {
    diary: Diary,
    /// Programmed rates: from, U/h, where.
    basal: Vec<(i64, f64, Place)>,
    /// Temporary rates: from, to, U/h, where.
    temporary: Vec<(i64, i64, f64, Place)>,
}

/// An element `event` of a section.
struct Entry<'a> {
    file: &'a str,
    number: usize,
    section: &'a str,
    attributes: Vec<(String, String)>,
}

impl Entry<'_> {
    fn place(&self, name: &str) -> Place {
        Place::cell(self.file, self.number, format!("{} {name}", self.section))
    }

    fn text(&self, name: &str) -> Option<&str> {
        let found = self.attributes.iter().find(|(known, _)| known == name);
        found.map(|(_, text)| text.trim()).filter(|text| !text.is_empty())
    }

    fn wrong(&self, name: &str, expected: &'static str) -> CohortError {
        CohortError::cell(self.place(name), self.text(name).unwrap_or(""), expected)
    }

    fn number(&self, name: &str) -> Result<f64, CohortError> {
        let number = self.text(name).and_then(|text| text.parse::<f64>().ok());
        number
            .filter(|number| number.is_finite())
            .ok_or_else(|| self.wrong(name, "a number; write digits with a decimal point"))
    }

    fn time(&self, name: &str) -> Result<i64, CohortError> {
        let text = self.text(name).unwrap_or("");
        time(text).map(second).ok_or_else(|| self.wrong(name, "a time like 31-12-2021 08:05:00"))
    }
}

fn time(text: &str) -> Option<NaiveDateTime> {
    // `DD-MM-YYYY HH:MM:SS`; the last part is the second.
    let (minute, seconds) = (text.get(..16)?, text.get(16..)?.strip_prefix(':')?);
    let seconds: i64 = seconds.parse().ok().filter(|seconds| (0..60).contains(seconds))?;
    parse_day_first(&minute.replace('-', "/")).map(|at| at + chrono::TimeDelta::seconds(seconds))
}

fn read(
    text: &str,
    file: &str,
    patients: &mut BTreeMap<String, Patient>,
) -> Result<(), CohortError> {
    let mut reader = Reader::from_str(text);
    let mut sections: Vec<String> = Vec::new();
    let (mut id, mut number) = (None::<String>, 0);
    let table = |reader: &Reader<&[u8]>, reason: &str| {
        CohortError::table(file, format!("at byte {}: {reason}", reader.buffer_position()))
    };
    loop {
        let event = reader.read_event().map_err(|error| table(&reader, &error.to_string()))?;
        let (element, open) = match &event {
            Event::Eof => break,
            Event::Start(element) => (element, true),
            Event::Empty(element) => (element, false),
            Event::End(_) => {
                sections.pop();
                continue;
            }
            _ => continue,
        };
        let name = element.name().as_ref().to_owned();
        let attributes = element.attributes().map(|attribute| {
            let attribute = attribute.map_err(|error| table(&reader, &error.to_string()))?;
            // The study's numbers and times need no entity.
            Ok((attribute.key.as_ref().to_owned(), attribute.value.into_owned()))
        });
        let attributes: Vec<(String, String)> = attributes.collect::<Result<_, CohortError>>()?;
        if name == "patient" {
            let found = attributes.iter().find(|(name, _)| name == "id");
            let patient = found.map_or("", |(_, id)| id.trim());
            if !is_person_id(patient) {
                let expected = "a patient's identifier of letters and digits";
                let place = Place::column(file, "patient id");
                return Err(CohortError::cell(place, patient, expected));
            }
            let new = || Patient { diary: Diary::new(patient, file), ..Patient::default() };
            patients.entry(patient.into()).or_insert_with(new);
            id = Some(patient.into());
        } else if name == "event" {
            number += 1;
            let section = sections.last().map_or("", String::as_str);
            let entry = Entry { file, number, section, attributes };
            let patient = id.as_ref().and_then(|id| patients.get_mut(id));
            let Some(patient) = patient else { return Err(not_ohio(file)) };
            patient.event(&entry)?;
        }
        if open {
            sections.push(name);
        }
    }
    if id.is_none() {
        return Err(not_ohio(file));
    }
    if !sections.is_empty() {
        let reason = format!("the file is cut off within <{}>", sections.join("><"));
        return Err(CohortError::table(file, reason));
    }
    Ok(())
}

fn not_ohio(file: &str) -> CohortError {
    CohortError::layout(file, FORMAT, "no element <patient id=\"...\">")
}

impl Patient {
    fn event(&mut self, entry: &Entry<'_>) -> Result<(), CohortError> {
        let (diary, value) = (&mut self.diary, || entry.place("value"));
        match entry.section {
            "glucose_level" => diary.reading(entry.time("ts")?, entry.number("value")?, value),
            "basis_heart_rate" => {
                diary.heart_rate(entry.time("ts")?, entry.number("value")?, value)
            }
            "basis_steps" => diary.steps(entry.time("ts")?, 300, entry.number("value")?, value),
            "basal" => {
                self.basal.push((entry.time("ts")?, entry.number("value")?, value()));
                Ok(())
            }
            "temp_basal" => {
                let (from, to) = (entry.time("ts_begin")?, entry.time("ts_end")?);
                self.temporary.push((from, to, entry.number("value")?, value()));
                Ok(())
            }
            "bolus" => {
                let from = entry.time("ts_begin")?;
                let to = entry.text("ts_end").map(|_| entry.time("ts_end")).transpose()?;
                let seconds = to.map_or(0, |to| to - from);
                let place = || entry.place("dose");
                diary.dose(Channel::Bolus, from, seconds, entry.number("dose")?, place)
            }
            "meal" => {
                let place = || entry.place("carbs");
                diary.dose(Channel::Carbs, entry.time("ts")?, 0, entry.number("carbs")?, place)
            }
            "basis_sleep" => {
                let (from, to) = (entry.time("tbegin")?, entry.time("tend")?);
                if to < from {
                    let what = "sleep that ends before it begins: left out";
                    diary.note(what, || entry.place("tend"));
                    return Ok(());
                }
                diary.asleep(from, to, to - from, || entry.place("tend"))
            }
            _ => Ok(()),
        }
    }

    /// The diary with the rates that were given.
    fn finish(mut self) -> Result<Diary, CohortError> {
        self.basal.sort_by_key(|rate| rate.0);
        self.temporary.sort_by_key(|rate| rate.0);
        let programmed = |second: i64| {
            let after = self.basal.partition_point(|rate| rate.0 <= second);
            after.checked_sub(1).map(|at| self.basal[at].1)
        };
        // A temporary rate ends where the next one begins.
        for i in 1..self.temporary.len() {
            let next = self.temporary[i].0;
            let (from, to, ..) = &mut self.temporary[i - 1];
            if *from < next {
                *to = next.min(*to);
            }
        }
        // The latest end of the temporary rates up to each.
        let ends = self.temporary.iter().scan(i64::MIN, |latest, (_, end, ..)| {
            *latest = (*latest).max(*end);
            Some(*latest)
        });
        let ends: Vec<i64> = ends.collect();
        for (from, u_h, place) in &self.basal {
            let begun = self.temporary.partition_point(|rate| rate.0 < *from);
            let within = begun.checked_sub(1).is_some_and(|last| *from < ends[last]);
            // Within a temporary rate the programme goes on unseen.
            if !within {
                let rate = Rate { from: *from, to: None, u_h: *u_h };
                self.diary.rate(rate, || place.clone())?;
            }
        }
        for (i, (from, to, u_h, place)) in self.temporary.iter().enumerate() {
            if from >= to {
                self.diary.note("temporary rates without a duration: left out", || place.clone());
                continue;
            }
            let rate = Rate { from: *from, to: Some(*to), u_h: *u_h };
            self.diary.rate(rate, || place.clone())?;
            let follows = self.temporary.get(i + 1).is_some_and(|next| next.0 <= *to);
            if !follows && let Some(u_h) = programmed(*to) {
                self.diary.rate(Rate { from: *to, to: None, u_h }, || place.clone())?;
            }
        }
        let file = Place::column(&self.diary.account.file, "patient weight");
        self.diary.note("the weight is 99 for every patient: not used", || file);
        Ok(self.diary)
    }
}
