//! Training and held-out parts of a record.

use std::ops::Range;

use physiology::STEPS_PER_DAY;
use rand::seq::SliceRandom;

use crate::error::CohortError;
use crate::record::Record;

/// Days a twin is trained on: the first two weeks (paper, section on the individual-level model).
pub const TRAINING_DAYS: usize = 14;

/// A record split in time. Windows inside either range never cross the boundary.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TimeSplit {
    /// The training steps.
    pub train: Range<usize>,
    /// The held-out steps; empty if the record is no longer than the training days.
    pub test: Range<usize>,
}

/// Splits a record `days` times 24 hours after its first step.
#[must_use]
pub fn split_by_time(record: &Record, days: usize) -> TimeSplit {
    let boundary = days.saturating_mul(STEPS_PER_DAY).min(record.len());
    TimeSplit { train: 0..boundary, test: boundary..record.len() }
}

/// People split into two groups.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PersonSplit {
    /// Indices of the training people, ascending.
    pub train: Vec<usize>,
    /// Indices of the held-out people, ascending.
    pub test: Vec<usize>,
}

/// Holds out `round(test_share * people)` of `people` people at random.
///
/// # Errors
/// If the share is not from 0 to 1.
pub fn split_by_person(
    people: usize,
    test_share: f64,
    rng: &mut impl rand::Rng,
) -> Result<PersonSplit, CohortError> {
    if !(0.0..=1.0).contains(&test_share) {
        return Err(CohortError::Rule {
            rule: "share of people held out",
            value: test_share,
            remedy: "use a share from 0 to 1",
        });
    }
    let mut order: Vec<usize> = (0..people).collect();
    order.shuffle(rng);
    let mut train = order.split_off((people as f64 * test_share).round() as usize);
    let mut test = order;
    train.sort_unstable();
    test.sort_unstable();
    Ok(PersonSplit { train, test })
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    use super::*;

    #[test]
    fn the_first_days_train_and_the_rest_tests() {
        let start = "2024-03-08T07:25:00".parse().expect("a literal time");
        let record = Record::new(start, 20 * 288 + 5).expect("on the grid");
        let split = split_by_time(&record, TRAINING_DAYS);
        assert_eq!((split.train, split.test), (0..4032, 4032..5765));
        let short = split_by_time(&record, 100);
        assert_eq!((short.train, short.test), (0..5765, 5765..5765));
    }

    #[test]
    fn people_are_parted_once_and_by_the_seed() {
        let draw = |seed| {
            split_by_person(10, 0.3, &mut ChaCha8Rng::seed_from_u64(seed)).expect("a good share")
        };
        let split = draw(1);
        assert_eq!((split.train.len(), split.test.len()), (7, 3));
        let mut all = [split.train.clone(), split.test.clone()].concat();
        all.sort_unstable();
        assert_eq!(all, (0..10).collect::<Vec<_>>());
        assert_eq!(split, draw(1));
        assert!((2..20).any(|seed| draw(seed) != split));
        let message = split_by_person(10, -0.1, &mut ChaCha8Rng::seed_from_u64(0))
            .expect_err("refused")
            .to_string();
        assert!(message.contains("share of people held out of -0.1"), "{message}");
    }
}
