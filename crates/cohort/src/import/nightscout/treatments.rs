//! `treatments*.json`: boluses, carbohydrate, temporary rates, suspensions, profile switches and
//! set changes.

use serde_json::Value;

use super::profile::Schedule;
use crate::error::{CohortError, Place};
use crate::import::diary::Diary;
use crate::import::json_records::JsonRecord;
use crate::import::zone::Clock;
use crate::record::Channel;

/// What changes the basal rate.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Change {
    /// A rate, U/h.
    Rate(f64),
    /// Per cent more or less than the schedule.
    Percent(f64),
    /// The end of what went before.
    End,
}

/// A temporary change of the basal rate.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Temporary {
    pub(super) from: i64,
    /// `None` for a suspension, which holds until something follows.
    pub(super) seconds: Option<i64>,
    pub(super) change: Change,
    pub(super) place: Place,
}

/// A switch to another schedule.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Switch {
    pub(super) from: i64,
    /// 0 for good.
    pub(super) seconds: i64,
    pub(super) name: Option<String>,
    /// The schedule, if the switch brings it.
    pub(super) schedule: Option<Schedule>,
    /// Share of the schedule's rates, 1 for all.
    pub(super) share: f64,
    /// Hours by which the schedule is read ahead.
    pub(super) hours: f64,
    pub(super) place: Place,
}

/// `duration`, min.
fn minutes(record: &JsonRecord<'_>) -> Result<f64, CohortError> {
    let minutes = record.number("duration")?.unwrap_or(0.0);
    if (0.0..=366.0 * 1440.0).contains(&minutes) {
        return Ok(minutes);
    }
    Err(record.wrong("duration", "minutes, from 0 to those of a year"))
}

fn seconds_of(minutes: f64) -> i64 {
    (minutes * 60.0).round() as i64
}

/// Over how long carbohydrate is eaten, s. AndroidAPS, which alone states it, writes ms; less than a minute of them is
/// no such duration.
fn seconds_of_carbs(record: &JsonRecord<'_>) -> Result<i64, CohortError> {
    let milliseconds = record.number("duration")?.unwrap_or(0.0);
    if !(0.0..=86.4e6).contains(&milliseconds) {
        return Err(record.wrong("duration", "milliseconds, from 0 to those of a day"));
    }
    Ok(if milliseconds < 60e3 { 0 } else { (milliseconds / 1000.0).round() as i64 })
}

/// What the treatments say of the basal rate.
#[derive(Default)]
pub(super) struct Treatments {
    pub(super) clock: Option<Clock>,
    pub(super) temporaries: Vec<Temporary>,
    pub(super) switches: Vec<Switch>,
}

impl Treatments {
    /// Reads one treatment.
    pub(super) fn read(
        &mut self,
        record: &JsonRecord<'_>,
        diary: &mut Diary,
    ) -> Result<(), CohortError> {
        let kind = record.text("eventType")?.unwrap_or("");
        let amounts = ["insulin", "carbs", "absolute", "rate", "percent", "relative"];
        let known = matches!(
            kind,
            "Temp Basal"
                | "Temp Basal Start"
                | "Temp Basal End"
                | "Profile Switch"
                | "Suspend Pump"
                | "Resume Pump"
                | "Site Change"
                | "Cannula Change"
                | "Combo Bolus"
        );
        if !known && amounts.iter().all(|key| record.value(key).is_none()) {
            diary.note("treatments without an amount: left out", || record.place("eventType"));
            return Ok(());
        }
        let keys = ["created_at", "timestamp", "date", "mills"];
        let at = super::moment(record, &keys, self.clock)?.second;
        match kind {
            "Temp Basal" | "Temp Basal Start" | "Temp Basal End" => {
                return self.temporary(record, at, seconds_of(minutes(record)?));
            }
            "Profile Switch" => return self.switch(record, at, seconds_of(minutes(record)?)),
            "Suspend Pump" | "Resume Pump" => {
                let change = if kind == "Suspend Pump" { Change::Rate(0.0) } else { Change::End };
                let place = record.place("eventType");
                self.temporaries.push(Temporary { from: at, seconds: None, change, place });
                return Ok(());
            }
            "Site Change" | "Cannula Change" => {
                diary.set_change(at, || record.place("eventType"))?;
            }
            _ => {}
        }
        if let Some(insulin) = record.number("insulin")? {
            diary.dose(Channel::Bolus, at, 0, insulin, || record.place("insulin"))?;
        }
        if let Some(carbs) = record.number("carbs")? {
            let seconds = seconds_of_carbs(record)?;
            diary.dose(Channel::Carbs, at, seconds, carbs, || record.place("carbs"))?;
        }
        // The part of a combined bolus that is given as a rate.
        if kind == "Combo Bolus"
            && let Some(u_h) = record.number("relative")?
        {
            let minutes = minutes(record)?;
            let amount = u_h * minutes / 60.0;
            let place = || record.place("relative");
            diary.dose(Channel::Bolus, at, seconds_of(minutes), amount, place)?;
        }
        Ok(())
    }

    fn temporary(
        &mut self,
        record: &JsonRecord<'_>,
        from: i64,
        seconds: i64,
    ) -> Result<(), CohortError> {
        let absolute = record.number("absolute")?.or(record.number("rate")?);
        let change = match (absolute, record.number("percent")?) {
            _ if seconds == 0 => Change::End,
            (Some(u_h), _) => Change::Rate(u_h),
            (None, Some(percent)) if (-100.0..=900.0).contains(&percent) => {
                Change::Percent(percent)
            }
            (None, Some(_)) => {
                return Err(record.wrong("percent", "per cent more than the profile, from -100"));
            }
            (None, None) => {
                return Err(record.wrong("absolute", "U/h; the key (or percent) is missing"));
            }
        };
        let place = record.place(if absolute.is_some() { "absolute" } else { "percent" });
        let seconds = Some(seconds);
        self.temporaries.push(Temporary { from, seconds, change, place });
        Ok(())
    }

    fn switch(
        &mut self,
        record: &JsonRecord<'_>,
        from: i64,
        seconds: i64,
    ) -> Result<(), CohortError> {
        // The profile itself is a text inside the text.
        let parsed = record.text("profileJson")?.map(serde_json::from_str::<Value>).transpose();
        let parsed = parsed.map_err(|_| record.wrong("profileJson", "a profile as JSON"))?;
        let basal = parsed.as_ref().and_then(|profile| profile.get("basal"));
        let schedule = basal
            .map(|basal| Schedule::read(basal, || record.place("profileJson.basal")))
            .transpose()?;
        let percentage = record.number("percentage")?.filter(|percent| *percent != 0.0);
        let share = percentage.unwrap_or(100.0) / 100.0;
        if !(0.0..=10.0).contains(&share) {
            return Err(record.wrong("percentage", "per cent of the profile, from 0 to 1000"));
        }
        // Hours; more than a day of them are milliseconds.
        let shift = record.number("timeshift")?.unwrap_or(0.0);
        let hours = if shift.abs() > 24.0 { shift / 3.6e6 } else { shift };
        if hours.abs() > 24.0 {
            return Err(record.wrong("timeshift", "hours, from -24 to 24"));
        }
        // The old circadian profiles of Nightscout took the rate of later hours, AndroidAPS takes that of earlier ones.
        let circadian = record.value("CircadianPercentageProfile") == Some(&Value::Bool(true));
        let hours = if circadian { hours } else { -hours };
        let name = record.text("profile")?.map(str::to_owned);
        let place = record.place("profile");
        self.switches.push(Switch { from, seconds, name, schedule, share, hours, place });
        Ok(())
    }
}
