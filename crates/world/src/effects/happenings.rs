//! What chance brings to a person's days, whether an effect makes use of it or not.

use physiology::STEPS_PER_DAY;

use super::compression_lows::{self, Compression};
use super::outside::Events;
use super::sensor_drift::{self, Drift};
use super::set_failure::{self, SetFailure};
use super::variability::Variability;
use crate::behaviour::Life;
use crate::stream::{Concept, stream};

/// Everything that is drawn for the effects of one person's days.
///
/// It is drawn from streams of its own before any amplitude is looked at, so that worlds with and
/// without an effect share it.
#[derive(Debug, Clone, PartialEq)]
pub struct Happenings {
    /// Day-to-day variability.
    pub variability: Variability,
    /// What would happen to each set.
    pub set_failures: Vec<SetFailure>,
    /// Nights on the sensor.
    pub compressions: Vec<Compression>,
    /// How each sensor would drift.
    pub drifts: Vec<Drift>,
    /// Events of the effects outside the library.
    pub outside: Events,
}

impl Happenings {
    /// Draws the happenings of a life of person `person` of the world with this seed.
    #[must_use]
    pub fn sample(life: &Life, seed: u64, person: usize) -> Self {
        let rng = |concept| stream(seed, person, concept);
        // Sensors are changed at most once a day, and one was put in before the record.
        let sensors = life.calendar.steps() / STEPS_PER_DAY + 2;
        Self {
            variability: Variability::sample(&life.calendar, &mut rng(Concept::Variability)),
            set_failures: set_failure::sample(life, &mut rng(Concept::SetFailures)),
            compressions: compression_lows::sample(life, &mut rng(Concept::Compressions)),
            drifts: sensor_drift::sample(sensors, &mut rng(Concept::SensorDrifts)),
            outside: Events::sample(life, seed, person),
        }
    }
}
