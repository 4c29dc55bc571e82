//! Insulin acts less at some hours of the day than at others.

use std::f64::consts::TAU;

use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};

use super::forms::CircadianForm;

/// Fall of the action at its lowest hour, as a share of its height. Simulators use day patterns of
/// insulin sensitivity of 1, 0.8, 0.9 and 1 from 0, 4, 11 and 17 h (Visentin et al., Diabetes
/// Technol Ther 2015;17:1), after triple-tracer meals in which no pattern held for everybody
/// (Hinshaw et al., Diabetes 2013;62:2223).
const DEPTH: f64 = 0.22;

/// When and how long one person's insulin acts less.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CircadianPattern {
    /// Hour of the least action.
    pub trough_hour: f64,
    /// Sharpness of the trough: 1 is a broad one of about 9 h at half depth, 3 one of 5 h.
    pub sharpness: f64,
    /// Depth relative to the published one.
    pub depth: f64,
}

impl CircadianPattern {
    /// Course of the trough: 1 at its hour, near 0 on the other side of the day.
    fn trough(&self, form: CircadianForm, hour: f64) -> f64 {
        let angle = TAU * (hour - self.trough_hour) / 24.0;
        match form {
            CircadianForm::Trough => (self.sharpness * (angle.cos() - 1.0)).exp(),
            CircadianForm::Cosine => 0.5 + 0.5 * angle.cos(),
            CircadianForm::TwoTroughs => 0.5 + 0.5 * (2.0 * angle).cos(),
            // 1, 0.8, 0.9 and 1 from 0, 4, 11 and 17 h, with 7:30 the middle of the lowest.
            CircadianForm::Blocks => match (hour - self.trough_hour + 7.5).rem_euclid(24.0) {
                hour if (4.0..11.0).contains(&hour) => 1.0,
                hour if (11.0..17.0).contains(&hour) => 0.5,
                _ => 0.0,
            },
        }
    }
}

/// Factors on the action of insulin in the periphery and in the liver, by step of the day.
///
/// The mean of their logarithms over the day is 0. The liver takes part by half (assumed).
#[must_use]
pub(super) fn day(
    form: CircadianForm,
    pattern: &CircadianPattern,
    amplitude: f64,
) -> Vec<(f64, f64)> {
    let trough: Vec<f64> = (0..STEPS_PER_DAY)
        .map(|step| pattern.trough(form, step as f64 / STEPS_PER_HOUR as f64))
        .collect();
    let mean = trough.iter().sum::<f64>() / trough.len() as f64;
    let log = |trough: &f64| -amplitude * DEPTH * pattern.depth * (trough - mean);
    trough.iter().map(|t| (log(t).exp(), (0.5 * log(t)).exp())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn action_is_least_at_the_trough_and_the_day_is_balanced() {
        let pattern = CircadianPattern { trough_hour: 7.0, sharpness: 1.5, depth: 1.0 };
        let day = |pattern, amplitude| day(CircadianForm::Trough, pattern, amplitude);
        let by_step = day(&pattern, 1.0);
        let at = |hour: usize| by_step[hour * STEPS_PER_HOUR];
        let swing = at(19).0 / at(7).0;
        assert!((1.18..1.27).contains(&swing), "{swing}");
        assert!((at(7).1 - at(7).0.sqrt()).abs() < 1e-12); // rounding
        let balance: f64 = by_step.iter().map(|(action, _)| action.ln()).sum();
        assert!(balance.abs() < 1e-9, "{balance}"); // rounding of 288 terms
        assert!(day(&pattern, 0.0).iter().all(|factors| *factors == (1.0, 1.0)));
    }
}
