//! Sensor lag: interstitial glucose follows plasma more slowly than assumed.

use super::prelude::*;

/// Time constant at amplitude 1, as a factor: 12 min where 8 are assumed.
const SLOWER: f64 = 1.5;

/// See the module.
#[derive(Debug, Clone, Copy)]
pub(super) struct SensorLag;

impl Effect for SensorLag {
    fn card(&self) -> Card {
        Card {
            id: EffectId::SENSOR_LAG,
            port: Port::Sensor,
            summary: "the sensor follows plasma glucose more slowly than assumed",
            size_at_one: "time constant 1.5 times as long (12 min where 8 are assumed)",
            source: "6 to 15 min: Vettoretti et al., Sensors 2019;19:5320; Basu et al., Diabetes 2013;62:4083",
            signature: "errors in proportion to the rate of change: over-predicted in rises, under-predicted in falls",
            channels: &[Channel::Glucose],
            confusable_with: &[
                EffectId::SLOW_MEALS,
                EffectId::COUNTER_REGULATION,
                EffectId::UNLOGGED_RESCUE_CARBS,
            ],
            relations: Relations { shown_by: ShownBy::SensorLag, ..Relations::USUAL },
            prior: Prior { median: 1.0, log_sd: 0.4, largest: 3.0 },
        }
    }

    fn form(&self, course: &Course) -> Option<Form> {
        (!course.is_empty()).then_some(Form::Driven)
    }

    fn modulate(&self, _: usize, amplitude: f64, _: &Course, into: &mut [Modulation]) {
        for modulation in into {
            modulation[Field::SensorLag] *= (amplitude * SLOWER.ln()).exp();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{fortnight, modulated};

    #[test]
    fn the_sensor_is_slower_throughout() {
        let steps = modulated(&SensorLag, 0, 1.0, &fortnight());
        assert!(steps.iter().all(|m| (m[Field::SensorLag] - SLOWER).abs() < 1e-12));
    }
}
