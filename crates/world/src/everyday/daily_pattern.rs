//! A small pattern by the clock that everybody has.

use std::f64::consts::TAU;

use rand::{Rng, RngExt};

/// Logarithms of factors by the clock: amplitude and peak hour of a wave of 24 h and one of 12 h.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DailyPattern {
    /// Of insulin action.
    pub action: [(f64, f64); 2],
    /// Of production.
    pub production: [(f64, f64); 2],
}

impl DailyPattern {
    /// None.
    pub const NONE: Self = Self { action: [(0.0, 0.0); 2], production: [(0.0, 0.0); 2] };

    /// Draws one: amplitudes of 0 to 6 % (24 h) and 0 to 3 % (12 h) of action, half of that of
    /// production, with any peak hour. As an effect, simulators use patterns of 20 % (Visentin et
    /// al., Diabetes Technol Ther 2015;17:1); nobody is free of any pattern.
    #[must_use]
    pub fn sample(rng: &mut (impl Rng + ?Sized)) -> Self {
        let mut waves = |most: f64| {
            let mut wave = |most: f64| (rng.random_range(0.0..most), rng.random_range(0.0..24.0));
            [wave(most), wave(0.5 * most)]
        };
        Self { action: waves(0.06), production: waves(0.03) }
    }

    /// Logarithms of the factors on action and production at an hour of the day.
    #[must_use]
    pub fn at(&self, hour: f64) -> (f64, f64) {
        let sum = |waves: &[(f64, f64); 2]| -> f64 {
            let wave = |(k, (height, top)): (usize, &(f64, f64))| {
                height * (TAU * (k + 1) as f64 * (hour - top) / 24.0).cos()
            };
            waves.iter().enumerate().map(wave).sum()
        };
        (sum(&self.action), sum(&self.production))
    }
}
