//! How a person's record is cut into training and test windows, and for whom no twin is built.

use std::ops::Range;

use cohort::{MissingDoses, Person, Record, Window, WindowRule, split_by_time, windows};
use physiology::{STEPS_PER_DAY, StepInput, UnitsPerHour};

use crate::error::TwinError;
use crate::start::{WindowStart, reading};

/// Which of the training days do not train: they choose an epoch, or show how far a twin errs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HeldOut {
    /// None: all train.
    Nothing,
    /// That many, the last.
    Last(usize),
    /// One of `count` blocks of days that are as equal as whole days allow.
    Block {
        /// Which of them, counted from 0.
        index: usize,
        /// How many there are.
        count: usize,
    },
}

impl HeldOut {
    /// The days, within so many training days.
    #[must_use]
    pub fn within(self, training_days: usize) -> Range<usize> {
        match self {
            Self::Nothing => training_days..training_days,
            Self::Last(days) => training_days.saturating_sub(days)..training_days,
            Self::Block { index, count } => {
                let from = |block: usize| (block * training_days / count.max(1)).min(training_days);
                from(index)..from(index + 1)
            }
        }
    }

    /// Blocks that between them hold out each training day once, of every record its own days. Where
    /// there are fewer days than blocks, some are empty.
    pub fn blocks(count: usize) -> impl Iterator<Item = Self> {
        (0..count).map(move |index| Self::Block { index, count })
    }
}

/// How records are cut and windows started.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Protocol {
    /// Days that train, from the first step of the record; see
    /// [`training_days_of`](Self::training_days_of) for short records.
    pub training_days: usize,
    /// Training days that do not train.
    pub held_out: HeldOut,
    /// How training windows are cut.
    pub training: WindowRule,
    /// How test windows are cut.
    pub test: WindowRule,
    /// Where a window's simulation starts, in training and test alike.
    pub start: WindowStart,
    /// Fewest complete windows in either part.
    pub least_windows: usize,
}

impl Protocol {
    /// The paper: two weeks train, the rest tests; 5-hour windows with 90 % overlap in training,
    /// complete readings and doses. Test windows follow each other without overlap, which the paper
    /// leaves open. Windows start from a steady state, in training and test alike, as the paper
    /// starts its simulations. At least 10 windows in either part, so that a person's averages
    /// mean something.
    #[must_use]
    pub const fn paper() -> Self {
        Self {
            training_days: cohort::TRAINING_DAYS,
            held_out: HeldOut::Nothing,
            training: WindowRule::TRAINING,
            test: WindowRule::EVALUATION,
            start: WindowStart::SteadyState,
            least_windows: 10,
        }
    }

    /// As [`paper`](Self::paper), with training windows an hour apart instead of half an hour.
    #[must_use]
    pub const fn quick() -> Self {
        let training = WindowRule { overlap: 0.8, ..WindowRule::TRAINING };
        Self { training, ..Self::paper() }
    }

    /// Whole days of a record that train: [`training_days`](Self::training_days), but at most
    /// two thirds of the record, so that a record of less than three weeks keeps days to test on.
    #[must_use]
    pub fn training_days_of(&self, record: &Record) -> usize {
        self.training_days.min(2 * record.len() / (3 * STEPS_PER_DAY))
    }
}

/// A person's record, cut.
#[derive(Debug, Clone)]
pub struct PersonWindows {
    /// Inputs of every step of the record; doses that are not recorded are zero and lie outside
    /// the windows.
    pub inputs: Vec<StepInput>,
    /// Windows that train.
    pub train: Vec<Window>,
    /// Windows of the training days that do not train.
    pub held_out: Vec<Window>,
    /// Windows that test.
    pub test: Vec<Window>,
    /// Where a window's simulation starts, as the protocol says.
    pub start: WindowStart,
    /// Mean of the recorded basal rates over the training days; 0 if none is recorded.
    pub mean_basal: UnitsPerHour,
    /// Why the person is left out, if so.
    pub excluded: Option<Exclusion>,
}

impl PersonWindows {
    /// Cuts the record of the person with this index.
    ///
    /// # Errors
    /// [`TwinError::Cohort`] if a value of the record is not finite or a rule cannot be.
    pub fn new(index: usize, person: &Person, protocol: &Protocol) -> Result<Self, TwinError> {
        let record = &person.record;
        let training_days = protocol.training_days_of(record);
        let split = split_by_time(record, training_days);
        let cut = |range, rule| windows(index, record, range, rule);
        let days = protocol.held_out.within(training_days);
        let [from, to] = [days.start, days.end].map(|day| day * STEPS_PER_DAY);
        let mut train = cut(0..from, &protocol.training)?;
        train.extend(cut(to..split.train.end, &protocol.training)?);
        let held_out = cut(from..to, &protocol.training)?;
        let test = cut(split.test.clone(), &protocol.test)?;
        let inputs = person.inputs(0..record.len(), MissingDoses::Zero)?;

        let basal: Vec<f64> =
            record.basal()[split.train.clone()].iter().copied().flatten().collect();
        let mean_basal = match basal.len() {
            0 => UnitsPerHour(0.0),
            n => UnitsPerHour(basal.iter().sum::<f64>() / n as f64),
        };
        let needed = protocol.least_windows.max(1);
        let few = |part, found: usize| {
            (found < needed).then_some(Exclusion::TooFewWindows { part, found, needed })
        };
        // Without days there are no windows, and doses are not asked for.
        let no_days = |days: &Range<usize>, part| if days.is_empty() { few(part, 0) } else { None };
        let excluded = no_days(&split.train, Part::Training)
            .or_else(|| no_days(&split.test, Part::Test))
            .or_else(|| without_doses(person, &split.train, &split.test))
            .or_else(|| few(Part::Training, train.len()))
            .or_else(|| few(Part::Test, test.len()));
        Ok(Self { inputs, train, held_out, test, start: protocol.start, mean_basal, excluded })
    }
}

/// Which part of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The first days.
    Training,
    /// The days after them.
    Test,
}

impl std::fmt::Display for Part {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Training => "training",
            Self::Test => "test",
        })
    }
}

/// Why a person has no twin (paper, end of "Development dataset preprocessing", and what else makes
/// training or judging impossible).
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Exclusion {
    /// No basal rate above 0 and no bolus in a part of the record.
    #[error("no insulin recorded in the {0} days")]
    NoInsulin(Part),
    /// No carbohydrate in a part of the record.
    #[error("no carbohydrate recorded in the {0} days")]
    NoCarbs(Part),
    /// Too few windows with every sensor reading and every dose.
    #[error("{found} complete {part} windows, {needed} needed")]
    TooFewWindows {
        /// The part.
        part: Part,
        /// Complete windows found.
        found: usize,
        /// Complete windows needed.
        needed: usize,
    },
}

/// The paper's rule: insulin and carbohydrate must be recorded in both parts.
fn without_doses(person: &Person, train: &Range<usize>, test: &Range<usize>) -> Option<Exclusion> {
    let record = &person.record;
    let given = |channel: &[Option<f64>], part: &Range<usize>| {
        channel[part.clone()].iter().flatten().any(|dose| *dose > 0.0)
    };
    for (name, part) in [(Part::Training, train), (Part::Test, test)] {
        if !given(record.basal(), part) && !given(record.bolus(), part) {
            return Some(Exclusion::NoInsulin(name));
        }
        if !given(record.carbs(), part) {
            return Some(Exclusion::NoCarbs(name));
        }
    }
    None
}

/// Measured glucose of a window, mg/dL, one value a step.
///
/// # Errors
/// [`TwinError::NoReading`] if one is missing or not finite.
pub fn measured(person: &Person, window: &Window) -> Result<Vec<f64>, TwinError> {
    window.range().map(|step| reading(person, step).map(|glucose| glucose.0)).collect()
}

/// Inputs between the first and the last reading of a window: one fewer than readings.
#[must_use]
pub fn inputs_within<'a>(inputs: &'a [StepInput], window: &Window) -> &'a [StepInput] {
    &inputs[window.start..window.start + window.len - 1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_hold_out_every_training_day_once() {
        for (days, count) in [(14, 4), (14, 1), (3, 5), (1, 4), (10, 3), (0, 4)] {
            let blocks: Vec<Range<usize>> =
                HeldOut::blocks(count).map(|block| block.within(days)).collect();
            let sizes = blocks.iter().map(Range::len);
            assert!(sizes.clone().max() <= sizes.min().map(|least| least + 1));
            let held: Vec<usize> = blocks.into_iter().flatten().collect();
            assert_eq!(held, (0..days).collect::<Vec<usize>>(), "{days} in {count}");
        }
        assert_eq!(HeldOut::Last(4).within(14), 10..14);
        assert_eq!(HeldOut::Last(4).within(2), 0..2);
        assert!(HeldOut::Nothing.within(14).is_empty());
    }
}
