//! Insulin acts more and less strongly by the clock.

use std::f64::consts::TAU;

use super::prelude::*;

/// Published steps: hour from which, and action as a factor.
const STEPS: [(f64, f64); 4] = [(0.0, 1.0), (4.0, 0.8), (11.0, 0.9), (17.0, 1.0)];
/// Mean logarithm of the published steps over the day: (7 ln 0.8 + 6 ln 0.9)/24. Without it the
/// person's calibration would carry it.
const STEPS_MEAN_LN: f64 = -0.091_425;
/// Hours of least action of the smooth patterns: before breakfast and lunch, where most people have it. A wave that turns the
/// other way is what meals at fixed hours leave in a plant that absorbs them at another speed.
const TROUGHS: [f64; 2] = [7.0, 13.0];
/// Half the range of the logarithm of a smooth pattern: the same variance as the steps.
const HALF_RANGE: f64 = 0.134;

/// See the module.
#[derive(Debug, Clone, Copy)]
pub(super) struct CircadianSensitivity;

impl Effect for CircadianSensitivity {
    fn card(&self) -> Card {
        Card {
            id: EffectId::CIRCADIAN_SENSITIVITY,
            port: Port::InsulinAction,
            summary: "insulin acts more and less strongly by the clock, in a pattern of the person's own",
            size_at_one: "action 1, 0.8, 0.9 and 1 from 0, 4, 11 and 17 h, or a daily wave of the same variance \
                          (12 % to either side)",
            source: "the pattern is individual: Hinshaw et al., Diabetes 2013;62:2223; classes and sizes: Visentin \
                     et al., J Diabetes Sci Technol 2018;12:273",
            signature: "errors of one sign for many hours at the same time of every day, larger with more insulin \
                        acting",
            channels: &[Channel::Clock],
            confusable_with: &[EffectId::DAWN, EffectId::SLOW_MEALS],
            relations: Relations {
                is_itself: &[Allowance::Clock],
                structure: Structure::Mimics,
                ..Relations::USUAL
            },
            prior: Prior { median: 1.0, log_sd: 0.5, largest: 4.0 },
        }
    }

    fn form(&self, _: &Course) -> Option<Form> {
        Some(Form::Driven)
    }

    fn variants(&self) -> usize {
        1 + TROUGHS.len()
    }

    fn modulate(&self, variant: usize, amplitude: f64, course: &Course, into: &mut [Modulation]) {
        let variant = variant % self.variants();
        let factor = |hour: f64| {
            let exponent = match variant.checked_sub(1) {
                None => steps(hour).ln() - STEPS_MEAN_LN,
                Some(phase) => -HALF_RANGE * (TAU * (hour - TROUGHS[phase]) / 24.0).cos(),
            };
            (amplitude * exponent).exp()
        };
        for (factor, modulation) in course.by_hour(factor).zip(into) {
            modulation[Field::Action] *= factor;
            modulation[Field::LiverAction] *= factor;
        }
    }
}

/// Action by the published steps.
fn steps(hour: f64) -> f64 {
    STEPS.iter().rev().find(|(from, _)| hour >= *from).map_or(1.0, |(_, action)| *action)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{DAY, fortnight, modulated};

    #[test]
    fn every_pattern_leaves_the_mean_of_a_day_alone_and_has_one_variance() {
        let course = fortnight();
        for variant in 0..CircadianSensitivity.variants() {
            let day = &modulated(&CircadianSensitivity, variant, 1.0, &course)[..DAY];
            let ln: Vec<f64> = day.iter().map(|m| m[Field::Action].ln()).collect();
            let mean = ln.iter().sum::<f64>() / DAY as f64;
            let sd = (ln.iter().map(|v| v * v).sum::<f64>() / DAY as f64).sqrt();
            // The constants are rounded at the sixth and third digit.
            assert!(mean.abs() < 1e-5, "variant {variant}: mean {mean}");
            assert!((sd - 0.0946).abs() < 5e-4, "variant {variant}: sd {sd}");
        }
    }

    #[test]
    fn action_is_least_when_stated() {
        let course = fortnight();
        let at = |variant: usize, hour: f64| {
            modulated(&CircadianSensitivity, variant, 1.0, &course)[(hour * 12.0) as usize]
                [Field::Action]
        };
        assert!((at(0, 5.0) / at(0, 2.0) - 0.8).abs() < 1e-12);
        assert!((at(0, 12.0) / at(0, 20.0) - 0.9).abs() < 1e-12);
        assert!(at(1, 7.0) < at(1, 3.0) && at(1, 7.0) < at(1, 11.0));
        assert!(at(2, 13.0) < 1.0 && at(2, 1.0) > 1.0);
    }
}
