//! How exactly a log is kept.

use physiology::Grams;
use rand::{Rng, RngExt};

use crate::generator::Generator;

/// How one person logs what they eat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogHabit {
    /// Steps to which the time of an entry is rounded: 1 for the minute, 3 and 6 for a quarter and
    /// half of an hour.
    pub steps: usize,
    /// Amounts are whole multiples of this, g.
    pub grams: f64,
}

impl LogHabit {
    /// To the step and the gram.
    pub const EXACT: Self = Self { steps: 1, grams: 1.0 };

    /// Draws it: whether people round is drawn by world, how they round by person. Apps stamp
    /// entries to the minute; diaries and memories hold quarters and halves of hours. Amounts in
    /// HUPA-UCM are rations of 10 g and halves of them in most people.
    #[must_use]
    pub(super) fn sample(hand: Generator, world: &mut impl Rng, own: &mut impl Rng) -> Self {
        let (times, amounts) = (world.random::<f64>(), world.random::<f64>());
        let (time, amount) = (own.random::<f64>(), own.random::<f64>());
        // Weights of a quarter and of half an hour, of 5 and of 10 g, by hand.
        let (quarter, half, five, ten) = match hand {
            Generator::Hovorka => (0.6, 0.0, 0.9, 0.0),
            Generator::Padova => (0.0, 0.6, 0.5, 0.4),
            Generator::Minimal => (0.3, 0.3, 0.0, 0.9),
            Generator::Saturating => (0.9, 0.0, 0.5, 0.2),
        };
        let steps = if time < half * times {
            6
        } else if time < (half + quarter) * times {
            3
        } else {
            1
        };
        let grams = if amount < ten * amounts {
            10.0
        } else if amount < (ten + five) * amounts {
            5.0
        } else {
            1.0
        };
        Self { steps, grams }
    }

    /// An amount as it is logged, at least one unit.
    #[must_use]
    pub fn rounded(&self, grams: f64) -> Grams {
        Grams((grams / self.grams).round().max(1.0) * self.grams)
    }

    /// The entries of a log, one per step, under the times at which they are logged; entries at the
    /// same step are added.
    #[must_use]
    pub fn written(&self, entries: impl ExactSizeIterator<Item = Grams>) -> Vec<Grams> {
        let steps = entries.len();
        let mut log = vec![Grams(0.0); steps];
        for (step, entry) in entries.enumerate() {
            if let Some(slot) = log.get_mut(self.written_at(step, steps)) {
                *slot = *slot + entry;
            }
        }
        log
    }

    /// The step under which an entry of `step` is logged, in a record of `steps` steps.
    #[must_use]
    pub fn written_at(&self, step: usize, steps: usize) -> usize {
        let unit = self.steps.max(1);
        ((step + unit / 2) / unit * unit).min(steps.saturating_sub(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_go_to_the_nearest_quarter_and_amounts_to_whole_units() {
        let habit = LogHabit { steps: 3, grams: 5.0 };
        assert_eq!([6, 7, 8, 9, 99].map(|s| habit.written_at(s, 100)), [6, 6, 9, 9, 99]);
        assert_eq!([1.0, 12.0, 13.0].map(|g| habit.rounded(g).0), [5.0, 10.0, 15.0]);
        assert_eq!(LogHabit::EXACT.written_at(7, 100), 7);
        assert_eq!(LogHabit::EXACT.rounded(0.2).0, 1.0);
    }
}
