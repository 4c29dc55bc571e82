//! Counter-regulation: the liver answers low glucose.

use super::prelude::*;

/// Production added at amplitude 1 when interstitial glucose is 20 mg/dL below 70, as a share of the basal one.
const ADDED: f64 = 0.75;
/// Glucose below which a record says anything about it, mg/dL.
const LOW: f64 = 72.0;

/// See the module.
#[derive(Debug, Clone, Copy)]
pub(super) struct CounterRegulation;

impl Effect for CounterRegulation {
    fn card(&self) -> Card {
        Card {
            id: EffectId::COUNTER_REGULATION,
            port: Port::Egp,
            summary: "hormones raise endogenous production while glucose is low",
            size_at_one: "production up by 75 % of its basal rate at 50 mg/dL, in proportion below 70, following \
                          interstitial glucose",
            source: "50 to 100 % with a lag of 10 to 20 min, weaker in long diabetes: Rizza et al., J Clin Invest \
                     1979;64:62; Bolli et al., Diabetes 1983;32:134; as a term of glucose: Dalla Man et al., J Diabetes \
                     Sci Technol 2014;8:26",
            signature: "glucose under-predicted while below 70 mg/dL and for half an hour after, in proportion to its \
                        depth",
            channels: &[Channel::Glucose],
            confusable_with: &[
                EffectId::UNLOGGED_RESCUE_CARBS,
                EffectId::COMPRESSION_LOWS,
                EffectId::SENSOR_LAG,
            ],
            relations: Relations {
                is_itself: &[Allowance::Defence],
                structure: Structure::Guard,
                ..Relations::USUAL
            },
            prior: Prior { median: 1.0, log_sd: 0.6, largest: 4.0 },
        }
    }

    fn form(&self, course: &Course) -> Option<Form> {
        course.glucose.iter().any(|glucose| *glucose < LOW).then_some(Form::Driven)
    }

    fn modulate(&self, _: usize, amplitude: f64, _: &Course, into: &mut [Modulation]) {
        for modulation in into {
            modulation[Field::LowGlucoseProduction] += amplitude * ADDED;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{fortnight, modulated};

    #[test]
    fn production_rises_and_only_where_there_were_lows() {
        let mut course = fortnight();
        let steps = modulated(&CounterRegulation, 0, 2.0, &course);
        assert!(steps.iter().all(|m| m[Field::LowGlucoseProduction] == 2.0 * ADDED));
        course.glucose.fill(110.0);
        assert_eq!(CounterRegulation.form(&course), None);
    }
}
