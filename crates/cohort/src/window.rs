//! Sequences of a few hours for training and for judging models.

use std::ops::Range;

use physiology::STEPS_PER_HOUR;

use crate::error::CohortError;
use crate::record::Record;

/// A sequence of consecutive steps of one person.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Window {
    /// Index into [`Cohort::people`](crate::Cohort::people).
    pub person: usize,
    /// First step.
    pub start: usize,
    /// Number of steps.
    pub len: usize,
}

impl Window {
    /// The steps of the window.
    #[must_use]
    pub const fn range(&self) -> Range<usize> {
        self.start..self.start + self.len
    }
}

/// How windows are cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowRule {
    /// Steps in a window.
    pub len: usize,
    /// Share of a window that the next one repeats, 0 (none) to below 1.
    pub overlap: f64,
    /// Smallest share of steps with a sensor reading, 0 to 1.
    pub cgm_share: f64,
    /// Whether every step must have basal, bolus and carbohydrate recorded.
    pub doses: DoseRule,
}

/// What a window requires of basal, bolus and carbohydrate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DoseRule {
    /// Recorded (possibly as 0) in every step.
    Complete,
    /// May be missing; the caller of [`Person::inputs`](crate::Person::inputs) says what happens
    /// then.
    MayBeMissing,
}

impl WindowRule {
    /// The paper's training windows: 5 hours, 90 % overlap, every sensor reading present, every
    /// dose recorded.
    pub const TRAINING: Self =
        Self { len: 5 * STEPS_PER_HOUR, overlap: 0.9, cgm_share: 1.0, doses: DoseRule::Complete };

    /// Windows of 5 hours that do not overlap, for judging a model; every sensor reading present,
    /// every dose recorded.
    pub const EVALUATION: Self = Self { overlap: 0.0, ..Self::TRAINING };

    /// Steps from one window's start to the next one's: `len (1 - overlap)`, rounded, at least 1.
    #[must_use]
    pub fn stride(&self) -> usize {
        ((self.len as f64 * (1.0 - self.overlap)).round() as usize).max(1)
    }

    fn check(&self) -> Result<(), CohortError> {
        let (rule, value, remedy) = if self.len == 0 {
            ("window length", 0.0, "use at least one step")
        } else if !(0.0..1.0).contains(&self.overlap) {
            ("window overlap", self.overlap, "use a share from 0 to below 1")
        } else if !(0.0..=1.0).contains(&self.cgm_share) {
            ("share of sensor readings", self.cgm_share, "use a share from 0 to 1")
        } else {
            return Ok(());
        };
        Err(CohortError::Rule { rule, value, remedy })
    }
}

/// The windows of one person inside the steps `range`, in order of time, none crossing its ends.
///
/// Starts are `stride` apart from `range.start`; windows that are not complete enough for the rule
/// are left out. `person` is the index that the windows hold.
///
/// # Errors
/// If the rule cannot be applied or the range leaves the record.
pub fn windows(
    person: usize,
    record: &Record,
    range: Range<usize>,
    rule: &WindowRule,
) -> Result<Vec<Window>, CohortError> {
    rule.check()?;
    record.check_range(&range, &format!("#{person}"))?;
    let needed = (rule.cgm_share * rule.len as f64).ceil() as usize;
    let complete = |steps: Range<usize>| {
        let readings = record.cgm()[steps.clone()].iter().flatten().count();
        let doses = match rule.doses {
            DoseRule::MayBeMissing => true,
            DoseRule::Complete => [record.basal(), record.bolus(), record.carbs()]
                .into_iter()
                .all(|channel| channel[steps.clone()].iter().all(Option::is_some)),
        };
        readings >= needed && doses
    };
    let end = range.end;
    Ok(range
        .step_by(rule.stride())
        .map(|start| Window { person, start, len: rule.len })
        .take_while(|window| window.range().end <= end)
        .filter(|window| complete(window.range()))
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Channel;

    fn record(len: usize) -> Record {
        let start = "2024-03-08T00:00:00".parse().expect("a literal time");
        let mut record = Record::new(start, len).expect("on the grid");
        for channel in [Channel::Cgm, Channel::Basal, Channel::Bolus, Channel::Carbs] {
            record.channel_mut(channel).fill(Some(1.0));
        }
        record
    }

    #[test]
    fn the_papers_windows_start_half_an_hour_apart() {
        let windows = windows(3, &record(80), 2..80, &WindowRule::TRAINING).expect("a good rule");
        let starts: Vec<usize> = windows.iter().map(|window| window.start).collect();
        assert_eq!(starts, [2, 8, 14, 20]);
        assert!(windows.iter().all(|window| window.person == 3 && window.len == 60));
    }

    #[test]
    fn incomplete_windows_are_left_out() {
        let mut gap = record(240);
        gap.channel_mut(Channel::Cgm)[65] = None;
        gap.channel_mut(Channel::Bolus)[130] = None;
        let starts = |rule: &WindowRule| -> Vec<usize> {
            windows(0, &gap, 0..240, rule).expect("a good rule").iter().map(|w| w.start).collect()
        };
        assert_eq!(starts(&WindowRule::EVALUATION), [0, 180]);
        let lenient = WindowRule { doses: DoseRule::MayBeMissing, ..WindowRule::EVALUATION };
        assert_eq!(starts(&lenient), [0, 120, 180]);
        assert_eq!(starts(&WindowRule { cgm_share: 59.0 / 60.0, ..lenient }), [0, 60, 120, 180]);
    }

    #[test]
    fn rules_and_ranges_that_cannot_be_are_errors() {
        let rule = WindowRule::TRAINING;
        for (rule, range, says) in [
            (WindowRule { len: 0, ..rule }, 0..10, "window length"),
            (WindowRule { overlap: 1.0, ..rule }, 0..10, "window overlap"),
            (WindowRule { overlap: f64::NAN, ..rule }, 0..10, "window overlap"),
            (WindowRule { cgm_share: 1.1, ..rule }, 0..10, "share of sensor readings"),
            (rule, 0..81, "steps 0..81"),
        ] {
            let message = windows(0, &record(80), range, &rule).expect_err("refused").to_string();
            assert!(message.contains(says), "{message}");
        }
    }
}
