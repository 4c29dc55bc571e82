//! A person's columns on a five-minute grid without gaps.

use chrono::{Datelike, NaiveDateTime, TimeDelta, Timelike, Weekday};

use crate::error::{CohortError, Place};

/// Longest record, days: 20 years. Anything longer is a wrong date.
pub(crate) const MAX_DAYS: i64 = 20 * 366;

/// Most steps of a cohort: 300 people for a year.
const MOST_STEPS: usize = 1 << 25;

/// Shortest span that is never too long for what it holds, days.
const FEW_DAYS: i64 = 28;

/// Longest span of a record that is imported from so many entries, days: one for each. Whatever is sparser has a wrong date,
/// and would fill the memory with empty steps.
fn longest(entries: usize) -> i64 {
    i64::try_from(entries).unwrap_or(MAX_DAYS).clamp(FEW_DAYS, MAX_DAYS)
}

/// Refuses a record that spans more days than its entries can fill.
pub(crate) fn check_span(
    days: i64,
    entries: usize,
    person: &str,
    place: impl FnOnce() -> Place,
) -> Result<(), CohortError> {
    let limit = longest(entries);
    if days < limit {
        return Ok(());
    }
    Err(CohortError::TooLong { place: place(), person: person.into(), days, limit })
}

/// Steps of the people of a cohort so far.
#[derive(Debug, Default)]
pub(crate) struct GridSteps(usize);

impl GridSteps {
    /// Adds those of a person in `file`.
    ///
    /// # Errors
    /// Where they are too many for one cohort.
    pub(crate) fn add(&mut self, steps: usize, file: &str) -> Result<(), CohortError> {
        self.0 = self.0.saturating_add(steps);
        if self.0 <= MOST_STEPS {
            return Ok(());
        }
        let what = format!("the records span more than {MOST_STEPS} steps of five minutes");
        let remedy = "look for times that are wrong, or split the cohort into folders";
        Err(CohortError::too_large(file, what, remedy))
    }
}

named::named! {
    /// A column of the record, by its name in `records.csv` and in the order of that file.
    Channel {
        /// Sensor glucose at the start of the step, mg/dL.
        Cgm: "cgm_mg_dl",
        /// Basal rate through the step, U/h.
        Basal: "basal_u_h",
        /// Bolus insulin delivered within the step, U.
        Bolus: "bolus_u",
        /// Carbohydrate logged in the step, g.
        Carbs: "carbs_g",
        /// Mean heart rate over the step, 1/min; the difference from the baseline where
        /// [`Person::heart_rate_baseline`](crate::Person::heart_rate_baseline) is 0.
        HeartRate: "heart_rate_bpm",
        /// Steps walked within the step, a count (fractional where the source's interval is longer).
        Steps: "steps",
        /// Share of the step asleep, 0 to 1.
        SleepEfficiency: "sleep_efficiency",
        /// 1 if the infusion set was changed within the step, else 0.
        SetChange: "set_change",
    }
}

impl Channel {
    /// The unit's symbol; empty for shares and flags.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Cgm => "mg/dL",
            Self::Basal => "U/h",
            Self::Bolus => "U",
            Self::Carbs => "g",
            Self::HeartRate => "1/min",
            Self::Steps => "steps",
            Self::SleepEfficiency | Self::SetChange => "",
        }
    }
}

/// A person's columns on a gap-free five-minute grid.
///
/// Step `k` starts at [`time(k)`](Self::time). Every channel has [`len`](Self::len) values;
/// `None` is "not recorded" and never zero.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    start: NaiveDateTime,
    len: usize,
    channels: [Vec<Option<f64>>; Channel::ALL.len()],
}

impl Record {
    /// A record of `len` steps from `start` in which nothing is recorded.
    ///
    /// # Errors
    /// If `start` is off the five-minute grid or outside the years 1900 to 2199, or if `len`
    /// exceeds 20 years.
    pub fn new(start: NaiveDateTime, len: usize) -> Result<Self, CohortError> {
        let reason = if !on_grid(start) {
            "the start is off the 5-minute grid; use minute 0, 5, 10, ..."
        } else if !(1900..2200).contains(&start.year()) {
            "the start is outside the years 1900 to 2199"
        } else if len as i64 > MAX_DAYS * physiology::STEPS_PER_DAY as i64 {
            "longer than 20 years; a time is probably wrong"
        } else {
            return Ok(Self { start, len, channels: std::array::from_fn(|_| vec![None; len]) });
        };
        Err(CohortError::Grid { start, steps: len, reason })
    }

    /// Start of the first step, local wall clock.
    #[must_use]
    pub const fn start(&self) -> NaiveDateTime {
        self.start
    }

    /// Number of steps.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.len
    }

    /// Whether the record has no step.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// A channel's values, one per step.
    #[must_use]
    pub fn channel(&self, channel: Channel) -> &[Option<f64>] {
        &self.channels[channel as usize]
    }

    /// A channel's values, for filling. Only finite values may be stored here;
    /// [`write_folder`](crate::write_folder) and [`Person::inputs`](crate::Person::inputs) refuse
    /// others.
    pub fn channel_mut(&mut self, channel: Channel) -> &mut [Option<f64>] {
        &mut self.channels[channel as usize]
    }

    /// Sensor glucose, mg/dL.
    #[must_use]
    pub fn cgm(&self) -> &[Option<f64>] {
        self.channel(Channel::Cgm)
    }

    /// Basal rate, U/h.
    #[must_use]
    pub fn basal(&self) -> &[Option<f64>] {
        self.channel(Channel::Basal)
    }

    /// Bolus insulin, U.
    #[must_use]
    pub fn bolus(&self) -> &[Option<f64>] {
        self.channel(Channel::Bolus)
    }

    /// Carbohydrate, g.
    #[must_use]
    pub fn carbs(&self) -> &[Option<f64>] {
        self.channel(Channel::Carbs)
    }

    /// Heart rate, 1/min.
    #[must_use]
    pub fn heart_rate(&self) -> &[Option<f64>] {
        self.channel(Channel::HeartRate)
    }

    /// Steps walked.
    #[must_use]
    pub fn steps(&self) -> &[Option<f64>] {
        self.channel(Channel::Steps)
    }

    /// Share of the step asleep, 0 to 1.
    #[must_use]
    pub fn sleep_efficiency(&self) -> &[Option<f64>] {
        self.channel(Channel::SleepEfficiency)
    }

    /// Infusion set changes, 0 or 1.
    #[must_use]
    pub fn set_change(&self) -> &[Option<f64>] {
        self.channel(Channel::SetChange)
    }

    /// Start of step `k`, local wall clock. `k` may lie beyond the end.
    #[must_use]
    pub fn time(&self, k: usize) -> NaiveDateTime {
        let minutes = i64::try_from(k).unwrap_or(i64::MAX).saturating_mul(5);
        TimeDelta::try_minutes(minutes)
            .and_then(|elapsed| self.start.checked_add_signed(elapsed))
            .unwrap_or(NaiveDateTime::MAX)
    }

    /// The step whose start is `time`, or `None` off the grid or outside the record.
    #[must_use]
    pub fn step_at(&self, time: NaiveDateTime) -> Option<usize> {
        let seconds = time.signed_duration_since(self.start).num_seconds();
        let k = usize::try_from(seconds).ok()? / 300;
        (k < self.len && self.time(k) == time).then_some(k)
    }

    /// Hour of the local day at the start of step `k`, 0 to 23.
    #[must_use]
    pub fn hour(&self, k: usize) -> u8 {
        u8::try_from(self.time(k).hour()).expect("an hour is below 24")
    }

    /// Whether step `k` lies on a Saturday or Sunday.
    #[must_use]
    pub fn weekend(&self, k: usize) -> bool {
        matches!(self.time(k).weekday(), Weekday::Sat | Weekday::Sun)
    }

    /// Calendar days from the date of the first step to the date of step `k`.
    #[must_use]
    pub fn day_index(&self, k: usize) -> usize {
        let days = self.time(k).date().signed_duration_since(self.start.date()).num_days();
        usize::try_from(days).expect("step k is not before the start")
    }

    /// Steps with a basal rate, a bolus or carbohydrate that was not recorded.
    #[must_use]
    pub fn steps_without_doses(&self) -> usize {
        let doses = [self.basal(), self.bolus(), self.carbs()];
        (0..self.len).filter(|k| doses.iter().any(|dose| dose[*k].is_none())).count()
    }

    /// Refuses steps that leave the record of `person`.
    pub(crate) fn check_range(
        &self,
        range: &std::ops::Range<usize>,
        person: &str,
    ) -> Result<(), CohortError> {
        if range.start <= range.end && range.end <= self.len {
            return Ok(());
        }
        let (start, end, len) = (range.start, range.end, self.len);
        Err(CohortError::Range { person: person.into(), start, end, len })
    }

    /// The steps `range` as a new record, or `None` if the range leaves the record.
    #[must_use]
    pub fn slice(&self, range: std::ops::Range<usize>) -> Option<Self> {
        if range.start > range.end || range.end > self.len {
            return None;
        }
        Some(Self {
            start: self.time(range.start),
            len: range.len(),
            channels: std::array::from_fn(|c| self.channels[c][range.clone()].to_vec()),
        })
    }
}

/// Refuses a row's time that is off the grid or not after the person's row above, `previous`.
pub(crate) fn follows(
    time: NaiveDateTime,
    previous: Option<NaiveDateTime>,
    person: &str,
    place: impl FnOnce() -> Place,
) -> Result<(), CohortError> {
    if !on_grid(time) {
        return Err(CohortError::OffGrid { place: place(), time });
    }
    match previous {
        Some(previous) if time == previous => {
            Err(CohortError::DuplicateStep { place: place(), person: person.into(), time })
        }
        Some(previous) if time < previous => {
            Err(CohortError::OutOfOrder { place: place(), person: person.into(), time, previous })
        }
        _ => Ok(()),
    }
}

/// Whether a time is a multiple of five minutes.
pub(crate) fn on_grid(time: NaiveDateTime) -> bool {
    time.minute().is_multiple_of(5) && time.second() == 0 && time.nanosecond() == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(text: &str) -> NaiveDateTime {
        text.parse().expect("a literal time")
    }

    #[test]
    fn clock_calendar_and_steps_agree() {
        // Friday evening: 2024-03-08 was a Friday.
        let record = Record::new(at("2024-03-08T23:50:00"), 300).expect("on the grid");
        assert_eq!(record.time(2), at("2024-03-09T00:00:00"));
        assert_eq!((record.hour(1), record.hour(2)), (23, 0));
        assert_eq!((record.weekend(1), record.weekend(2)), (false, true));
        assert_eq!((record.day_index(1), record.day_index(2), record.day_index(290)), (0, 1, 2));
        assert_eq!(record.step_at(record.time(299)), Some(299));
        assert_eq!(record.step_at(record.time(300)), None);
        assert_eq!(record.step_at(at("2024-03-08T23:51:00")), None);
        assert_eq!(record.step_at(at("2024-03-08T23:45:00")), None);
    }

    #[test]
    fn a_record_is_no_longer_than_what_it_holds_can_fill() {
        assert_eq!([0, 28, 400, 1 << 20, usize::MAX].map(longest), [28, 28, 400, 7320, 7320]);
    }

    #[test]
    fn a_cohort_has_so_many_steps_and_no_more() {
        let mut steps = GridSteps::default();
        steps.add(MOST_STEPS, "a.csv").expect("as many as there may be");
        let error = steps.add(1, "b.csv").expect_err("one more").to_string();
        assert!(error.contains("b.csv") && error.contains("more than 33554432 steps"), "{error}");
        assert!(steps.add(usize::MAX, "c.csv").is_err());
    }

    #[test]
    fn a_slice_keeps_times_and_values() {
        let mut record = Record::new(at("2024-03-08T23:50:00"), 4).expect("on the grid");
        record.channel_mut(Channel::Cgm)[2] = Some(101.5);
        let part = record.slice(1..4).expect("inside");
        assert_eq!(part.start(), at("2024-03-08T23:55:00"));
        assert_eq!(part.cgm(), &[None, Some(101.5), None]);
        assert_eq!(record.slice(2..5), None);
    }

    #[test]
    fn grids_that_cannot_be_laid_are_refused() {
        for (start, len, says) in [
            ("2024-03-08T23:51:00", 1, "off the 5-minute grid"),
            ("0001-01-01T00:00:00", 1, "outside the years"),
            ("2024-01-01T00:00:00", usize::MAX >> 2, "longer than 20 years"),
        ] {
            let message = Record::new(at(start), len).expect_err("refused").to_string();
            assert!(message.contains(says), "{message}");
        }
    }
}
