//! People for whom no twin is built, and why.

use std::ops::Range;

use cohort::Person;

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
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exclusion {
    /// No basal rate above 0 and no bolus in a part of the record.
    NoInsulin(Part),
    /// No carbohydrate in a part of the record.
    NoCarbs(Part),
    /// Too few windows with every sensor reading and every dose.
    TooFewWindows {
        /// The part.
        part: Part,
        /// Complete windows found.
        found: usize,
        /// Complete windows needed.
        needed: usize,
    },
}

impl std::fmt::Display for Exclusion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoInsulin(part) => write!(f, "no insulin recorded in the {part} days"),
            Self::NoCarbs(part) => write!(f, "no carbohydrate recorded in the {part} days"),
            Self::TooFewWindows { part, found, needed } => {
                write!(f, "{found} complete {part} windows, {needed} needed")
            }
        }
    }
}

/// The paper's rule: insulin and carbohydrate must be recorded in both parts.
#[must_use]
pub(crate) fn without_doses(
    person: &Person,
    train: &Range<usize>,
    test: &Range<usize>,
) -> Option<Exclusion> {
    let record = &person.record;
    let given = |channel: &[Option<f64>], part: &Range<usize>| {
        channel[part.clone()].iter().any(|dose| dose.is_some_and(|dose| dose > 0.0))
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
