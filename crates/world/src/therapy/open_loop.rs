//! A pump that follows its programmed profile.

use physiology::Units;

use super::settings::TherapySettings;
use super::{Controller, Observation, Order};

/// Share of the programmed rate that is left in exercise: a temporary rate of half, as consensus
/// advice has it (Riddell et al., Lancet Diabetes Endocrinol 2017;5:377).
const IN_EXERCISE: f64 = 0.5;

/// The programmed profile with a temporary rate in exercise.
#[derive(Debug, Clone)]
pub struct OpenLoopPump {
    settings: TherapySettings,
}

impl OpenLoopPump {
    /// A pump with these settings.
    #[must_use]
    pub fn new(settings: TherapySettings) -> Self {
        Self { settings }
    }
}

impl Controller for OpenLoopPump {
    fn order(&mut self, observation: &Observation) -> Order {
        let share = if observation.exercising { IN_EXERCISE } else { 1.0 };
        Order { basal: self.settings.basal_at(observation.hour) * share, bolus: Units(0.0) }
    }
}
