//! Smooth changes of the functions of a body, drawn by person.
//!
//! No published function is exactly anybody's own. A warp multiplies what a body does by a smooth
//! factor of the quantity on which it depends: insulin action by one of plasma insulin, production
//! and uptake by one of glucose, emptying by one of the stomach's content. It works on any body
//! through its [`Condition`], and is 1 at rest, so settings and basal needs hardly change.

use std::f64::consts::PI;

use physiology::{Compartment, GRAMS_PER_MMOL_GLUCOSE, Kilograms, MgPerDl, States};
use rand::{Rng, RngExt};

use crate::effects::Condition;
use crate::stream::standard_normal;

/// Waves of a warp.
const WAVES: usize = 3;
/// Half of the range over which a warp of a logarithm varies; it is flat beyond.
const REACH: f64 = 1.5;
/// Steepest fall of the logarithm of a factor with that of its quantity. So what the body does
/// still grows with the quantity.
const STEEPEST: f64 = 0.6;
/// Glucose at which warps are 1, mg/dL, and the content of the stomach, g.
pub(crate) const RESTING_GLUCOSE: MgPerDl = MgPerDl(125.0);
const RESTING_CONTENT: f64 = 15.0;

/// A smooth function of a logarithm, 0 at 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Warp {
    waves: [Wave; WAVES],
}

/// A sine.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Wave {
    height: f64,
    phase: f64,
    /// Sine of the phase, which is asked for at each step.
    at_rest: f64,
}

impl Warp {
    /// No change.
    pub const NONE: Self = Self { waves: [Wave { height: 0.0, phase: 0.0, at_rest: 0.0 }; WAVES] };

    /// Draws one whose spread over the range is `size` (log), with a person's own form and height.
    ///
    /// Waves of one, two and three half-periods over the range, each of half the variance of the
    /// one before. A warp that is steeper than a monotone body allows is flattened as a whole.
    #[must_use]
    pub fn sample(size: f64, rng: &mut (impl Rng + ?Sized)) -> Self {
        let mut waves = Self::NONE.waves;
        let mut share = (4.0_f64 / 7.0).sqrt(); // 4/7, 2/7 and 1/7 of the variance
        for wave in &mut waves {
            let height = size * std::f64::consts::SQRT_2 * share * standard_normal(rng);
            let height = height.clamp(-2.5 * size, 2.5 * size);
            let phase = rng.random_range(0.0..2.0 * PI);
            *wave = Wave { height, phase, at_rest: phase.sin() };
            share *= std::f64::consts::FRAC_1_SQRT_2;
        }
        let slope: f64 = waves.iter().enumerate().map(|(k, w)| w.height.abs() * frequency(k)).sum();
        let kept = (STEEPEST / slope.max(STEEPEST)).min(1.0);
        Self { waves }.flattened(kept)
    }

    /// The same with this share of its height.
    fn flattened(&self, share: f64) -> Self {
        Self { waves: self.waves.map(|wave| Wave { height: share * wave.height, ..wave }) }
    }

    /// Its value at a logarithm.
    #[must_use]
    pub fn at(&self, logarithm: f64) -> f64 {
        let x = logarithm.clamp(-REACH, REACH);
        let wave = |(k, wave): (usize, &Wave)| {
            wave.height * ((frequency(k) * x + wave.phase).sin() - wave.at_rest)
        };
        self.waves.iter().enumerate().map(wave).sum()
    }
}

/// Angular frequency of wave `k`: that many half-periods and one over the whole range.
fn frequency(k: usize) -> f64 {
    PI * (k + 1) as f64 / (2.0 * REACH)
}

/// The warps of one person.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Warps {
    /// Of insulin action, by plasma insulin relative to that at rest.
    pub action: Warp,
    /// Of uptake without insulin, by glucose relative to that at rest.
    pub uptake: Warp,
    /// Of production, by glucose relative to that at rest.
    pub production: Warp,
    /// Of the time of the gut, by what is in the stomach.
    pub emptying: Warp,
    /// Where insulin action saturates: beyond this many times the insulin at rest, a further unit
    /// does half; none at infinity.
    pub half_action: f64,
}

impl Warps {
    /// A body as its equations have it.
    pub const NONE: Self = Self {
        action: Warp::NONE,
        uptake: Warp::NONE,
        production: Warp::NONE,
        emptying: Warp::NONE,
        half_action: f64::INFINITY,
    };

    /// Draws a person's warps, each with a spread of `size` (log). In four of ten people insulin
    /// action also saturates, half-way at 6 to 30 times the insulin at rest (55 to 120 mU/L in
    /// clamps, Rizza et al., Am J Physiol 1981;240:E630).
    #[must_use]
    pub fn sample(size: f64, rng: &mut (impl Rng + ?Sized)) -> Self {
        let (saturates, half) = (rng.random_bool(0.4), rng.random_range(6.0..30.0));
        Self {
            action: Warp::sample(size, rng),
            uptake: Warp::sample(size, rng),
            production: Warp::sample(0.7 * size, rng),
            emptying: Warp::sample(size, rng),
            half_action: if saturates { half } else { f64::INFINITY },
        }
    }

    /// The same warps with this share of their heights, and without saturation where it is below 1.
    #[must_use]
    pub fn flattened(&self, share: f64) -> Self {
        Self {
            action: self.action.flattened(share),
            uptake: self.uptake.flattened(share),
            production: self.production.flattened(share),
            emptying: self.emptying.flattened(share),
            half_action: if share < 1.0 { f64::INFINITY } else { self.half_action },
        }
    }

    /// Logarithm of the factor on insulin action at a multiple of the insulin at rest.
    #[must_use]
    pub fn log_action(&self, insulin: f64) -> f64 {
        let saturation = if self.half_action.is_finite() {
            ((1.0 + self.half_action) / (insulin + self.half_action)).ln()
        } else {
            0.0
        };
        self.action.at(insulin.max(1e-3).ln()) + saturation
    }
}

/// The warps of a body with the reference values of its quantities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Warped {
    warps: Warps,
    /// Plasma insulin at rest, mU/L.
    insulin: f64,
    weight: Kilograms,
}

impl Warped {
    /// The warps of a body of so much plasma insulin at rest, mU/L.
    pub(crate) fn new(warps: Warps, insulin: f64, weight: Kilograms) -> Self {
        Self { warps, insulin: insulin.max(1e-6), weight }
    }

    /// A condition with the warps of a body in this state.
    pub(crate) fn act(&self, condition: Condition, states: &States) -> Condition {
        let glucose = (states[Compartment::Q1].max(1.0) / RESTING_GLUCOSE.0).ln();
        let action = self.warps.log_action(states[Compartment::I] / self.insulin).exp();
        let content = states[Compartment::C1] * self.weight.0 * GRAMS_PER_MMOL_GLUCOSE;
        let full = ((content.max(0.0) + RESTING_CONTENT) / RESTING_CONTENT).ln();
        Condition {
            action: condition.action * action,
            liver_action: condition.liver_action * action,
            uptake: condition.uptake * self.warps.uptake.at(glucose).exp(),
            production: condition.production * self.warps.production.at(glucose).exp(),
            gut_time: condition.gut_time * self.warps.emptying.at(full).exp(),
            ..condition
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::{Concept, stream};

    #[test]
    fn a_warp_is_none_at_rest_smooth_and_of_the_stated_spread() {
        let mut squares = 0.0;
        for person in 0..200 {
            let warp = Warp::sample(0.18, &mut stream(1, person, Concept::Warps));
            assert_eq!(warp.at(0.0), 0.0);
            assert_eq!(warp.at(5.0), warp.at(REACH));
            let values: Vec<f64> =
                (0..=60).map(|k| warp.at(REACH * (f64::from(k) / 30.0 - 1.0))).collect();
            for pair in values.windows(2) {
                // What the body does, quantity times factor, grows: a slope of the log above -1.
                let slope = (pair[1] - pair[0]) / (REACH / 30.0);
                assert!(slope.abs() <= STEEPEST + 1e-9, "{slope}");
            }
            squares += values.iter().map(|v| v * v).sum::<f64>() / 61.0;
        }
        // Measured from rest, not from the mean, and flattened where steep.
        let spread = (squares / 200.0).sqrt();
        assert!((0.12..0.30).contains(&spread), "{spread}");
        assert_eq!(Warp::NONE.at(0.7), 0.0);
    }

    #[test]
    fn saturating_action_still_grows_with_insulin() {
        let warps = Warps { half_action: 6.0, ..Warps::NONE };
        assert!(warps.log_action(1.0).abs() < 1e-12); // rounding
        let done = |insulin: f64| insulin * warps.log_action(insulin).exp();
        assert!(done(12.0) > done(6.0) && done(12.0) < 1.6 * done(6.0));
        assert_eq!(Warps::NONE.log_action(9.0), 0.0);
    }
}
