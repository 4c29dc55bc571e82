//! Folds of contiguous days.

use std::iter::once;
use std::ops::Range;

use physiology::STEPS_PER_DAY;

/// Folds in use; every whole day is held out in one of them.
pub(super) const FOLDS: usize = 3;

/// Blocks of contiguous days of one person; each is held out once.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Folds {
    /// Steps of each block, in their order; together they are the whole record.
    blocks: Vec<Range<usize>>,
    /// First step of each whole day.
    whole_days: Vec<usize>,
}

impl Folds {
    /// Splits a record into `folds` blocks of nearly as many whole days each; steps of a day that is not
    /// whole go with the nearest block. `days` is the calendar day of each step. There are fewer blocks
    /// where there are fewer days.
    pub(super) fn new(days: &[usize], folds: usize) -> Self {
        let (mut whole_days, mut first) = (Vec::new(), 0);
        for day in days.chunk_by(|one, next| one == next) {
            if day.len() >= STEPS_PER_DAY {
                whole_days.push(first);
            }
            first += day.len();
        }
        let count = folds.min(whole_days.len());
        let between = (1..count).map(|fold| whole_days[fold * whole_days.len() / count]);
        let cuts: Vec<usize> = once(0).chain(between).chain(once(days.len())).collect();
        let blocks = cuts.windows(2).map(|pair| pair[0]..pair[1]).collect();
        Self { blocks, whole_days }
    }

    /// Steps held out in a fold; `None` for a person whose record is too short for it, who then is trained
    /// and judged in none.
    pub(super) fn held_out(&self, fold: usize) -> Option<Range<usize>> {
        // A single block would leave nothing to train on.
        self.blocks.get(fold).filter(|_| self.blocks.len() > 1).cloned()
    }

    /// Stretches of training steps in a fold.
    pub(super) fn training(&self, fold: usize) -> Vec<Range<usize>> {
        let Some(out) = self.held_out(fold) else { return Vec::new() };
        let end = self.blocks.last().map_or(0, |block| block.end);
        [0..out.start, out.end..end].into_iter().filter(|range| !range.is_empty()).collect()
    }

    /// First steps of the whole days inside a range.
    pub(super) fn whole_days(&self, range: &Range<usize>) -> Vec<usize> {
        let inside =
            |first: &&usize| range.contains(*first) && **first + STEPS_PER_DAY <= range.end;
        self.whole_days.iter().filter(inside).copied().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A record that starts `before` steps ahead of midnight and ends `after` steps past one.
    fn days(before: usize, whole: usize, after: usize) -> Vec<usize> {
        let mut days = vec![0; before];
        for day in 0..whole {
            days.extend([day + 1; STEPS_PER_DAY]);
        }
        days.extend(std::iter::repeat_n(whole + 1, after));
        days
    }

    #[test]
    fn every_whole_day_is_held_out_once_and_never_trained_on_then() {
        for (before, whole, after, folds) in [(0, 14, 0, 2), (100, 13, 30, 3), (5, 4, 0, 9)] {
            let days = days(before, whole, after);
            let split = Folds::new(&days, folds);
            let mut held = vec![0; days.len()];
            let mut whole_days = 0;
            for fold in 0..folds {
                let Some(out) = split.held_out(fold) else { continue };
                held[out.clone()].iter_mut().for_each(|count| *count += 1);
                assert!(
                    split.training(fold).iter().all(|t| t.end <= out.start || t.start >= out.end)
                );
                let trained: usize = split.training(fold).iter().map(ExactSizeIterator::len).sum();
                assert_eq!(trained + out.len(), days.len());
                whole_days += split.whole_days(&out).len();
            }
            assert!(held.iter().all(|count| *count == 1), "{folds} folds of {whole} days");
            assert_eq!(whole_days, whole);
        }
    }

    #[test]
    fn a_record_of_one_day_has_nothing_to_hold_out() {
        let split = Folds::new(&days(10, 1, 20), 2);
        assert_eq!(split.held_out(0), None);
        assert!(split.training(0).is_empty());
    }
}
