//! What is missing from a record, independently of the effects.

use cohort::{Channel, Cohort, Person};
use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};
use rand::{Rng, RngExt};

use super::streams::{Purpose, stream};

/// Parts of the record that are missing.
///
/// They are drawn with the plan, independently of the effects, and are removed after the days were
/// lived.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Nuisances {
    /// People without heart rate and steps.
    pub without_heart_rate: usize,
    /// Hours without readings, about one stretch in four days.
    pub gaps: bool,
    /// Records that begin later or end earlier, by up to a quarter.
    pub uneven_days: bool,
    /// Set changes that nobody logged.
    pub unlogged_sets: bool,
}

impl Nuisances {
    /// Draws them for a world of so many people. In half of the worlds people lack heart rate, a
    /// third of the people at most; gaps in half; uneven days in a third; unlogged set changes in
    /// half.
    pub(super) fn sample(people: usize, rng: &mut (impl Rng + ?Sized)) -> Self {
        let (some, up_to) = (rng.random_bool(0.5), rng.random_range(1..=(people / 3).max(1)));
        Self {
            without_heart_rate: if some { up_to } else { 0 },
            gaps: rng.random_bool(0.5),
            uneven_days: rng.random_bool(1.0 / 3.0),
            unlogged_sets: rng.random_bool(0.5),
        }
    }

    /// What is missing, in words.
    #[must_use]
    pub fn words(&self) -> Vec<String> {
        let without = match self.without_heart_rate {
            0 => None,
            1 => Some("1 person without heart rate".to_owned()),
            n => Some(format!("{n} people without heart rate")),
        };
        let others = [
            (self.gaps, "gaps in the readings"),
            (self.uneven_days, "uneven days"),
            (self.unlogged_sets, "set changes not logged"),
        ];
        let others = others.into_iter().filter(|(is, _)| *is).map(|(_, words)| words.to_owned());
        without.into_iter().chain(others).collect()
    }

    /// Removes the parts from a cohort of the world with this seed.
    pub(super) fn take_from(&self, cohort: &mut Cohort, seed: u64) {
        let count = cohort.people.len();
        let first = stream(seed, Purpose::Nuisances, 0).random_range(0..count.max(1));
        for (index, person) in cohort.people.iter_mut().enumerate() {
            let mut rng = stream(seed, Purpose::Nuisances, index + 1);
            let place = (index + count - first) % count.max(1);
            if place < self.without_heart_rate {
                clear(person, Channel::HeartRate);
                clear(person, Channel::Steps);
                person.heart_rate_baseline = None;
            }
            if self.unlogged_sets {
                clear(person, Channel::SetChange);
            }
            if self.gaps {
                tear(person, &mut rng);
            }
            if self.uneven_days {
                shorten(person, &mut rng);
            }
        }
    }
}

fn clear(person: &mut Person, channel: Channel) {
    person.record.channel_mut(channel).fill(None);
}

/// One to eight hours without readings on about every fourth day.
fn tear(person: &mut Person, rng: &mut impl Rng) {
    let days = person.record.len() / STEPS_PER_DAY;
    let readings = person.record.channel_mut(Channel::Cgm);
    for day in 0..days {
        let (torn, at) = (rng.random_bool(0.25), rng.random_range(0..STEPS_PER_DAY));
        let length = rng.random_range(STEPS_PER_HOUR..=8 * STEPS_PER_HOUR);
        if torn {
            let from = day * STEPS_PER_DAY + at;
            readings.iter_mut().skip(from).take(length).for_each(|reading| *reading = None);
        }
    }
}

/// Removes up to a quarter of the days, at the start or at the end.
fn shorten(person: &mut Person, rng: &mut impl Rng) {
    let days = person.record.len() / STEPS_PER_DAY;
    let (lost, at_the_start) = (rng.random_range(0..=days / 4), rng.random_bool(0.5));
    let steps = lost * STEPS_PER_DAY;
    let range =
        if at_the_start { steps..person.record.len() } else { 0..person.record.len() - steps };
    if let Some(part) = person.record.slice(range) {
        person.record = part;
    }
}
