//! Renal threshold: glucose is lost to the urine from a level, and at a rate, of the person's own.

use super::prelude::*;

/// Shift of the threshold at amplitude 1, mg/dL: a standard deviation of about 2 mmol/L between people.
const SHIFT: f64 = 36.0;
/// Rate above the threshold at amplitude 1, as a factor.
const RATE: f64 = 1.3;
/// Glucose above which a record says anything about it, mg/dL: the threshold of Hovorka et al. 2004.
const HIGH: f64 = 162.0;

/// See the module.
#[derive(Debug, Clone, Copy)]
pub(super) struct RenalThreshold;

impl Effect for RenalThreshold {
    fn card(&self) -> Card {
        Card {
            id: EffectId::RENAL_THRESHOLD,
            port: Port::GlucoseFlux,
            summary: "glucose is lost to the urine from a lower or higher level than assumed, at another rate",
            size_at_one: "threshold 36 mg/dL lower and rate 1.3 times as high, or the other way round",
            source: "thresholds of 6.0 to 14.3 mmol/L and slopes that differ sevenfold: Johansen et al., Diabetologia \
                     1984;26:180",
            signature: "glucose over-predicted (or under-predicted) while high, whatever the hour or meal",
            channels: &[Channel::Glucose],
            confusable_with: &[EffectId::CARB_MISCOUNT, EffectId::SENSOR_DRIFT],
            relations: Relations {
                is_itself: &[Allowance::Shedding],
                structure: Structure::Guard,
                ..Relations::USUAL
            },
            prior: Prior { median: 1.0, log_sd: 0.5, largest: 3.0 },
        }
    }

    fn form(&self, course: &Course) -> Option<Form> {
        course.glucose.iter().any(|glucose| *glucose > HIGH).then_some(Form::Driven)
    }

    /// More is lost; less is lost.
    fn variants(&self) -> usize {
        2
    }

    fn modulate(&self, variant: usize, amplitude: f64, _: &Course, into: &mut [Modulation]) {
        let loss = if variant.is_multiple_of(2) { amplitude } else { -amplitude };
        for modulation in into {
            modulation[Field::RenalRate] *= (loss * RATE.ln()).exp();
            modulation[Field::RenalThreshold] -= loss * SHIFT;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{fortnight, modulated};

    #[test]
    fn more_is_lost_in_one_variant_and_less_in_the_other() {
        let mut course = fortnight();
        let more = modulated(&RenalThreshold, 0, 1.0, &course)[0];
        let less = modulated(&RenalThreshold, 1, 1.0, &course)[0];
        assert!(more[Field::RenalRate] > 1.0 && more[Field::RenalThreshold] < 0.0);
        assert!(less[Field::RenalRate] < 1.0 && less[Field::RenalThreshold] > 0.0);
        course.glucose.fill(120.0);
        assert_eq!(RenalThreshold.form(&course), None);
        course.glucose[7] = 200.0;
        assert_eq!(RenalThreshold.form(&course), Some(Form::Driven));
    }
}
