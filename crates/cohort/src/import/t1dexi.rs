//! The T1DEXI and T1DEXIP studies (doi:10.25934/PR00008428): SDTM domains as `*.xpt` in a folder.
//!
//! | domain | what is read |
//! |---|---|
//! | `LB` | `LBTESTCD` GLUC of `LBCAT` CGM |
//! | `FACM` | `BOLUS INSULIN`, U; `BASAL FLOW RATE`, U/h, a missing one is a suspension |
//! | `FAMLPM`, `FAMLPI` | `DCARBT` of `FACAT` CONSUMED, g |
//! | `VS` | heart rate, weight |
//! | `FA` | steps in ten seconds |
//! | `NV` | sleep: its stages between start and end |
//! | `DX` | the device that gives insulin |
//!
//! The variables of `NV` and `PR` are those of the study's own Define-XML (`docs/t1d-define.xml` and
//! `data/vlm.json` of `swhume/T1Dexi`); suspensions, times, and extended boluses are read as
//! `nudgebg/egvinsulin` (`babelbetes/studies/t1dexi.py`) reads them. Exercise (`PR`) is counted, since
//! a record has no column for it.
//!
//! Times are seconds since 1960 on the local clock. A pump's basal insulin is in `FACM` twice, as
//! rates and as amounts: the rates are used. Basal injections have no rate and are left out.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use physiology::Kilograms;

use super::diary::{Diary, Rate, people};
use super::files::{self, name};
use crate::error::CohortError;
use crate::person::{KG_PER_LB, Therapy, WEIGHTS, is_person_id};
use crate::record::Channel;

mod duration;
mod sleep;
mod xpt;

use xpt::{Variable, Xpt, XptRow};

const FORMAT: &str = "t1dexi";
/// Seconds from 1960-01-01 to 1970-01-01.
const FROM_1960: f64 = 315_619_200.0;
const MG_PER_DL_PER_MMOL: f64 = physiology::MG_PER_DL_PER_MMOL_PER_L;
const STEPS_OF_TEN_SECONDS: &str = "10-SECOND INTERVAL STEP COUNT";
const LONG_ACTING: &str = "long-acting injections, which no basal rate describes: left out";
const INJECTIONS: &str = "MULTIPLE DAILY INJECTIONS";

/// Reads the study's folder.
pub(super) fn import(source: &Path) -> Result<super::Import, CohortError> {
    let files = domains(source)?;
    if !files.contains_key("LB") {
        let reason = "no file LB.xpt, which has the sensor's readings";
        return Err(CohortError::layout(source.display(), FORMAT, reason));
    }
    let mut study = Study::default();
    for (domain, read) in [
        ("DX", Study::devices as fn(&mut Study, Xpt) -> Result<(), CohortError>),
        ("LB", Study::glucose),
        ("FACM", Study::insulin),
        ("FAMLPM", Study::meals),
        ("FAMLPI", Study::meals),
        ("VS", Study::vital_signs),
        ("FA", Study::steps),
        ("NV", Study::sleep),
        ("PR", Study::exercise),
    ] {
        if let Some(path) = files.get(domain) {
            read(&mut study, Xpt::open(path)?)?;
        }
    }
    let mut diaries = study.diaries;
    diaries.sort_by(|a, b| a.account.id.cmp(&b.account.id));
    people(FORMAT, source, diaries)
}

/// The `*.xpt` of a folder by the name of their domain.
fn domains(source: &Path) -> Result<HashMap<String, PathBuf>, CohortError> {
    files::folder(source, FORMAT, "LB.xpt, FACM.xpt and the others")?;
    let mut found: HashMap<String, PathBuf> = HashMap::new();
    for path in files::entries(source)? {
        let file = name(&path);
        let upper = file.to_ascii_uppercase();
        let Some(domain) = upper.strip_suffix(".XPT") else { continue };
        if let Some(other) = found.insert(domain.to_owned(), path) {
            let reason = format!("'{}' is of the same domain; keep one of them", name(&other));
            return Err(CohortError::layout(file, FORMAT, reason));
        }
    }
    Ok(found)
}

/// The people while the domains are read.
#[derive(Default)]
struct Study {
    diaries: Vec<Diary>,
    index: HashMap<String, usize>,
    /// The person of the row before: rows of one person follow each other.
    last: usize,
}

impl Study {
    fn person(&mut self, row: &XptRow<'_>, id: &Variable) -> Result<&mut Diary, CohortError> {
        let text = row.text(id);
        if self.diaries.get(self.last).is_none_or(|last| last.account.id != *text) {
            self.last = match self.index.get(&*text) {
                Some(at) => *at,
                None if is_person_id(&text) => {
                    self.diaries.push(Diary::new(&text, "LB.xpt"));
                    self.index.insert(text.into_owned(), self.diaries.len() - 1);
                    self.diaries.len() - 1
                }
                None => {
                    let expected = "a person's identifier of letters, digits, '_', '-' and '.'";
                    return Err(row.wrong(id, expected));
                }
            };
        }
        Ok(&mut self.diaries[self.last])
    }

    fn devices(&mut self, file: Xpt) -> Result<(), CohortError> {
        let (id, device) = (file.variable(&["USUBJID"])?, file.variable(&["DXTRT"])?);
        file.for_each(|row| {
            let device = row.text(&device).to_ascii_uppercase();
            let diary = self.person(&row, &id)?;
            diary.therapy = match (therapy(&device), diary.therapy) {
                // A row says `INSULIN PUMP`, another which one: the one that says more holds.
                (Some(Therapy::OpenLoopPump) | None, Some(known)) => Some(known),
                (found, _) => found,
            };
            Ok(())
        })
    }

    fn glucose(&mut self, file: Xpt) -> Result<(), CohortError> {
        let [id, test, category, time] =
            ["USUBJID", "LBTESTCD", "LBCAT", "LBDTC"].map(|name| file.variable(&[name]));
        let (id, test, category, time) = (id?, test?, category?, time?);
        let value = file.variable(&["LBSTRESN", "LBORRES"])?;
        let unit = file.optional(&["LBSTRESU", "LBORRESU"]);
        file.for_each(|row| {
            if row.text(&test) != "GLUC" || row.text(&category) != "CGM" {
                return Ok(());
            }
            let factor = match &*row.text(&unit) {
                "" | "mg/dL" | "MG/DL" | "mg/dl" => 1.0,
                "mmol/L" | "MMOL/L" | "mmol/l" => MG_PER_DL_PER_MMOL,
                _ => return Err(row.wrong(&unit, "mg/dL or mmol/L")),
            };
            let diary = self.person(&row, &id)?;
            let Some(glucose) = row.number(&value)? else {
                diary.note("readings without a value: left out", || row.place(&value));
                return Ok(());
            };
            diary.reading(at(&row, &time)?, glucose * factor, || row.place(&value))
        })
    }

    fn insulin(&mut self, file: Xpt) -> Result<(), CohortError> {
        let [id, test, time] = ["USUBJID", "FATEST", "FADTC"].map(|name| file.variable(&[name]));
        let (id, test, time) = (id?, test?, time?);
        let amount = file.variable(&["FAORRES", "FASTRESN"])?;
        let duration = file.variable(&["FADUR"])?;
        let [normal, extended] = ["INSNMBOL", "INSEXBOL"].map(|name| file.optional(&[name]));
        file.for_each(|row| {
            let diary = self.person(&row, &id)?;
            let seconds = || match &*row.text(&duration) {
                "" => Ok(None),
                text => duration::seconds(text)
                    .map(Some)
                    .ok_or_else(|| row.wrong(&duration, "a duration like PT5M, up to 10 days")),
            };
            let place = || row.place(&amount);
            match &*row.text(&test) {
                "BOLUS INSULIN" => {
                    let at = at(&row, &time)?;
                    let (normal, extended) = (row.number(&normal)?, row.number(&extended)?);
                    let normal = match (normal, extended) {
                        (None, None) => row.number(&amount)?,
                        (normal, _) => normal,
                    };
                    if normal.is_none() && extended.is_none() {
                        diary.note("boluses without an amount: left out", place);
                    }
                    if let Some(u) = normal {
                        diary.dose(Channel::Bolus, at, 0, u, place)?;
                    }
                    if let Some(u) = extended.filter(|u| *u != 0.0) {
                        let seconds = seconds()?.unwrap_or(0);
                        diary.dose(Channel::Bolus, at, seconds, u, place)?;
                    }
                }
                "BASAL FLOW RATE" if diary.therapy == Some(Therapy::Mdi) => {
                    diary.note("rates of a person on injections: left out", place);
                }
                "BASAL FLOW RATE" => {
                    let from = at(&row, &time)?;
                    let u_h = row.number(&amount)?;
                    if u_h.is_none() {
                        diary.note("missing rates: a suspension, 0 U/h", place);
                    }
                    let to = seconds()?.map(|seconds| from + seconds);
                    diary.rate(Rate { from, to, u_h: u_h.unwrap_or(0.0) }, place)?;
                }
                "BASAL INSULIN" if diary.therapy == Some(Therapy::Mdi) => {
                    diary.leave_out_injection(row.number(&amount)?.unwrap_or(0.0), place)?;
                    diary.note(LONG_ACTING, place);
                }
                "BASAL INSULIN" => {
                    diary.note("basal amounts, which the rates repeat: left out", place);
                }
                _ => {}
            }
            Ok(())
        })
    }

    fn meals(&mut self, file: Xpt) -> Result<(), CohortError> {
        let [id, test, time] = ["USUBJID", "FATESTCD", "FADTC"].map(|name| file.variable(&[name]));
        let (id, test, time) = (id?, test?, time?);
        let category = file.optional(&["FACAT"]);
        let grams = file.variable(&["FASTRESN", "FAORRES"])?;
        file.for_each(|row| {
            // Taken, returned and consumed are three categories of one meal.
            let consumed = matches!(&*row.text(&category), "CONSUMED" | "");
            if row.text(&test) != "DCARBT" || !consumed {
                return Ok(());
            }
            let diary = self.person(&row, &id)?;
            let Some(amount) = row.number(&grams)? else {
                diary.note("meals without grams: left out", || row.place(&grams));
                return Ok(());
            };
            diary.dose(Channel::Carbs, at(&row, &time)?, 0, amount, || row.place(&grams))
        })
    }

    fn vital_signs(&mut self, file: Xpt) -> Result<(), CohortError> {
        let [id, test, time] = ["USUBJID", "VSTEST", "VSDTC"].map(|name| file.variable(&[name]));
        let (id, test, time) = (id?, test?, time?);
        let value = file.variable(&["VSSTRESN", "VSORRES"])?;
        let unit = file.optional(&["VSSTRESU", "VSORRESU"]);
        file.for_each(|row| {
            let test = row.text(&test);
            let heart_rate = matches!(&*test, "Heart Rate" | "Heart Rate, Mean");
            if !heart_rate && test != "Weight" {
                return Ok(());
            }
            let diary = self.person(&row, &id)?;
            let Some(number) = row.number(&value)? else { return Ok(()) };
            if heart_rate {
                return diary.heart_rate(at(&row, &time)?, number, || row.place(&value));
            }
            let kg = match row.text(&unit).to_ascii_lowercase().as_str() {
                "kg" => number,
                "lb" | "lbs" => number * KG_PER_LB,
                _ => {
                    diary.note("weights without kg or LB: left out", || row.place(&value));
                    return Ok(());
                }
            };
            if !WEIGHTS.contains(&kg) {
                return Err(row.wrong(&value, "a weight of 1 to 500 kg"));
            }
            diary.weight = Some(Kilograms(kg));
            Ok(())
        })
    }

    fn steps(&mut self, file: Xpt) -> Result<(), CohortError> {
        let [id, object, time] = ["USUBJID", "FAOBJ", "FADTC"].map(|name| file.variable(&[name]));
        let (id, object, time) = (id?, object?, time?);
        let count = file.variable(&["FASTRESN", "FAORRES"])?;
        file.for_each(|row| {
            if row.text(&object) != STEPS_OF_TEN_SECONDS {
                return Ok(());
            }
            let diary = self.person(&row, &id)?;
            let Some(number) = row.number(&count)? else { return Ok(()) };
            diary.steps(at(&row, &time)?, 10, number, || row.place(&count))
        })
    }

    /// Counts exercise of people who have a record.
    fn exercise(&mut self, file: Xpt) -> Result<(), CohortError> {
        let (id, name) = (file.variable(&["USUBJID"])?, file.variable(&["PRTRT"])?);
        file.for_each(|row| {
            let what = "exercise: a record has no column for it, left out";
            self.person(&row, &id)?.note(what, || row.place(&name));
            Ok(())
        })
    }
}

/// What a device says of the therapy.
fn therapy(device: &str) -> Option<Therapy> {
    let has = |words: &[&str]| words.iter().any(|word| device.contains(word));
    if device.contains(INJECTIONS) {
        Some(Therapy::Mdi)
    } else if has(&["CLOSED LOOP", "CONTROL IQ", "CONTROL-IQ", "BASAL IQ", "BASAL-IQ"])
        || has(&["AUTO MODE", "OMNIPOD 5"])
    {
        Some(Therapy::Aid)
    } else if has(&["PUMP", "OMNIPOD", "MEDTRONIC", "TANDEM"]) {
        Some(Therapy::OpenLoopPump)
    } else {
        None
    }
}

/// The local second of a row.
fn at(row: &XptRow<'_>, time: &Variable) -> Result<i64, CohortError> {
    let expected = "seconds since 1960-01-01";
    let seconds = row.number(time)?.ok_or_else(|| row.wrong(time, expected))?;
    // The years 1900 to 2199.
    if !(-1.9e9..7.6e9).contains(&seconds) {
        return Err(row.wrong(time, expected));
    }
    Ok((seconds - FROM_1960).round() as i64)
}
