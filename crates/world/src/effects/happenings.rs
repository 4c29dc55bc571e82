//! The chance events of a person's days, whether an effect uses them or not.

use physiology::STEPS_PER_DAY;

use super::compression_lows::{self, Compression};
use super::forms::AbsorptionForm;
use super::insulin_absorption;
use super::outside::Events;
use super::sensor_drift::{self, Drift};
use super::set_failure::{self, SetFailure};
use super::variability::{Spreads, Variability};
use crate::behaviour::Life;
use crate::everyday::EverydayLogs;
use crate::stream::{Concept, stream};

/// Everything that is drawn for the effects of one person's days.
///
/// They are drawn from separate streams before any amplitude is read, so worlds with and without an
/// effect share them.
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
    /// Logarithms of the time of insulin absorption at amplitude 1 in the forms by site and
    /// wandering over half days, one per step.
    pub absorption_by_site: Vec<f64>,
    /// See [`Self::absorption_by_site`].
    pub absorption_wandering: Vec<f64>,
    /// Everyday variation beyond that of the embedded cohort's people; empty where there is none.
    pub everyday: Vec<EverydayLogs>,
}

impl Happenings {
    /// Draws the happenings of a life of person `person` of the world with this seed.
    #[must_use]
    pub fn sample(life: &Life, seed: u64, person: usize) -> Self {
        Self::sample_with(life, &Spreads::NARROW, seed, person)
    }

    /// As [`Self::sample`], with given spreads between days.
    #[must_use]
    pub fn sample_with(life: &Life, spreads: &Spreads, seed: u64, person: usize) -> Self {
        let rng = |concept| stream(seed, person, concept);
        let spread = spreads.insulin_time_between_days;
        let (absorption_by_site, absorption_wandering) =
            insulin_absorption::sample(life, spread, &mut rng(Concept::FormDraws));
        let calendar = &life.calendar;
        // Sensors are changed at most once a day, and one was inserted before the record.
        let sensors = calendar.steps() / STEPS_PER_DAY + 2;
        Self {
            variability: Variability::sample(calendar, spreads, &mut rng(Concept::Variability)),
            set_failures: set_failure::sample(life, &mut rng(Concept::SetFailures)),
            compressions: compression_lows::sample(life, &mut rng(Concept::Compressions)),
            drifts: sensor_drift::sample(sensors, &mut rng(Concept::SensorDrifts)),
            outside: Events::sample(life, seed, person),
            absorption_by_site,
            absorption_wandering,
            everyday: Vec::new(),
        }
    }

    /// Logarithm of the factor on the time of insulin absorption in a step, at amplitude 1.
    pub(super) fn absorption(&self, form: AbsorptionForm, life: &Life, step: usize) -> f64 {
        let of = |values: &[f64]| values.get(step).copied().unwrap_or(0.0);
        match form {
            AbsorptionForm::ByDay => of(&self.variability.insulin_time),
            AbsorptionForm::BySite => of(&self.absorption_by_site),
            AbsorptionForm::Wandering => of(&self.absorption_wandering),
            AbsorptionForm::FasterWithAge => insulin_absorption::by_age(life.sets.age_days(step)),
        }
    }
}
