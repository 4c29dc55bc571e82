//! Sleep in the domain `NV`: a row for the duration of each stage of a night.
//!
//! `NVTESTCD` is `DPSLPDUR` (deep), `LTSLPDUR` (light), `UNMESSLP` (not told apart) or `AWSLPDUR`
//! (awake) where `NVCAT` is `Sleep`; the night begins at `NVDTC`. The Define-XML calls its end
//! `VSENDTC`, by the usual rule it is `NVENDTC`: either is read, and without both the stages together
//! are the night. The unit stands in `NVSTRESU` or `NVORRESU`. A row of sleep without a duration is
//! sleep from start to end.

use std::collections::BTreeMap;

use super::xpt::{Variable, Xpt, XptRow};
use super::{Study, at, duration};
use crate::error::{CohortError, Place};

/// Seconds of a night.
struct Night {
    asleep: i64,
    awake: i64,
    place: Place,
}

impl Study {
    pub(super) fn sleep(&mut self, file: Xpt) -> Result<(), CohortError> {
        let (id, from) = (file.variable(&["USUBJID"])?, file.variable(&["NVDTC"])?);
        let test = file.variable(&["NVTESTCD", "NVTEST"])?;
        let (name, category) = (file.optional(&["NVTEST"]), file.optional(&["NVCAT"]));
        let to = file.optional(&["NVENDTC", "VSENDTC"]);
        let value = file.optional(&["NVSTRESN", "NVORRES"]);
        let unit = file.optional(&["NVSTRESU", "NVORRESU"]);
        let text = |row: &XptRow<'_>, variable| row.text(variable).to_ascii_uppercase();
        let mut nights: BTreeMap<(String, i64, Option<i64>), Night> = BTreeMap::new();
        file.for_each(|row| {
            let words = format!("{} {}", text(&row, &test), text(&row, &name));
            if !is_of_sleep(&words, &text(&row, &category)) {
                return Ok(());
            }
            let begin = at(&row, &from)?;
            let end = row.number(&to)?.map(|_| at(&row, &to)).transpose()?;
            let length = if value.exists() {
                seconds(&row, &value, &text(&row, &unit))?
            } else {
                end.map(|end| end - begin)
            };
            let diary = self.person(&row, &id)?;
            let Some(length) = length else {
                let what = "sleep without a duration in seconds, minutes or hours: left out";
                diary.note(what, || row.place(&test));
                return Ok(());
            };
            let key = (diary.account.id.clone(), begin, end);
            let place = row.place(&from);
            let night = nights.entry(key).or_insert(Night { asleep: 0, awake: 0, place });
            let awake = words.starts_with("AWSLP") || words.contains("WAKE");
            let sum = if awake { &mut night.awake } else { &mut night.asleep };
            *sum = sum.saturating_add(length);
            Ok(())
        })?;
        for ((person, begin, end), night) in nights {
            let diary = &mut self.diaries[self.index[&person]];
            let all = night.asleep.saturating_add(night.awake);
            let end = end.unwrap_or_else(|| begin.saturating_add(all));
            if night.asleep > end.saturating_sub(begin) {
                let what = "stages of sleep longer than the night: the whole night counts";
                diary.note(what, || night.place.clone());
            }
            diary.asleep(begin, end, night.asleep, || night.place.clone())?;
        }
        Ok(())
    }
}

fn is_of_sleep(words: &str, category: &str) -> bool {
    match category {
        "" => words.contains("SLEEP") || words.contains("SLP"),
        category => category == "SLEEP",
    }
}

/// Whole seconds of a duration; `None` where it is missing or its unit is not known.
fn seconds(row: &XptRow<'_>, value: &Variable, unit: &str) -> Result<Option<i64>, CohortError> {
    if row.text(value).starts_with('P') {
        return Ok(duration::seconds(&row.text(value)));
    }
    let Some(number) = row.number(value)? else { return Ok(None) };
    let factor = match unit {
        unit if unit.starts_with('S') => 1.0,
        unit if unit.starts_with("MIN") => 60.0,
        unit if unit.starts_with('H') => 3600.0,
        _ => return Ok(None),
    };
    // Longer than any night is cut where the interval is checked.
    Ok(Some((number * factor).round().clamp(0.0, 1e9) as i64))
}
