//! One random stream per person and concept, derived from the seed of the world.
//!
//! Streams do not depend on one another. Switching an effect off, or changing the controller or the
//! number of threads, leaves every other draw of every person unchanged. So two worlds can differ
//! in one effect and in nothing else.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, Normal};

/// What a stream of random numbers is used for.
///
/// The discriminants are part of what a seed means; new concepts are added at the end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Concept {
    /// Parameters of the body.
    Body = 0,
    /// Habits of the person.
    Habits = 1,
    /// Errors in the therapy settings.
    Settings = 2,
    /// Amplitudes of the effects.
    Effects = 3,
    /// Bed and wake times, awakenings.
    Sleep = 4,
    /// Exercise sessions.
    Exercise = 5,
    /// Meals: times, sizes, counting, bolus timing.
    Meals = 6,
    /// Evenings with alcohol.
    Alcohol = 7,
    /// Infusion set changes.
    InfusionSets = 8,
    /// Heart rate and steps.
    Wearable = 9,
    /// Day-to-day variability of insulin and meals.
    Variability = 10,
    /// Sensor noise, drift and lost readings.
    Sensor = 11,
    /// Reactions to a low or a high reading, one set of draws per step.
    Reactions = 12,
    /// Forms of the effects.
    Shapes = 13,
    /// Second errors in counting carbohydrate.
    Counting = 14,
    /// Failures of infusion sets.
    SetFailures = 15,
    /// Pressure on the sensor.
    Compressions = 16,
    /// Drift of sensors.
    SensorDrifts = 17,
    /// Events of effects outside the library.
    Outside = 18,
    /// Insulin action within and between the days of a Padova body.
    ActionWithinDays = 19,
    /// Smooth changes of the functional forms of the body.
    Warps = 20,
    /// What varies in everyday life, for the world (person [`WORLD`]) and for a person.
    Everyday = 21,
    /// Speed and phases of meals.
    MealSpeeds = 22,
    /// Sites at which insulin enters.
    Sites = 23,
    /// What a sensor of another kind adds.
    SensorKind = 24,
    /// Habits from wide priors.
    WideHabits = 25,
    /// Long-acting injections.
    Injections = 26,
    /// How a log is kept.
    LogHabits = 27,
    /// Which form each effect takes in a world.
    Forms = 28,
    /// Draws by day or by unit for other forms of effects.
    FormDraws = 29,
}

/// Stands for a person: what the people of a world share.
pub const WORLD: usize = 1 << 40;

/// The stream of one person for one concept.
#[must_use]
pub fn stream(seed: u64, person: usize, concept: Concept) -> ChaCha8Rng {
    numbered(seed, person, concept as u64)
}

/// The stream of one item for the purpose of a number below 256.
pub(crate) fn numbered(seed: u64, item: usize, purpose: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(((item as u64) << 8) | purpose);
    rng
}

/// One standard normal draw.
pub(crate) fn standard_normal(rng: &mut (impl Rng + ?Sized)) -> f64 {
    Normal::new(0.0, 1.0).expect("unit standard deviation").sample(rng)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;

    #[test]
    fn streams_are_reproducible_and_apart() {
        let draw = |person, concept| stream(7, person, concept).random::<u64>();
        assert_eq!(draw(1, Concept::Meals), draw(1, Concept::Meals));
        assert_ne!(draw(1, Concept::Meals), draw(1, Concept::Sleep));
        assert_ne!(draw(1, Concept::Meals), draw(2, Concept::Meals));
        assert_ne!(draw(1, Concept::Meals), stream(8, 1, Concept::Meals).random::<u64>());
    }
}
