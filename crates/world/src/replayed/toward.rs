//! The search for the insulin action with which mean glucose is the one sought.

/// Fall of mean glucose with the logarithm of insulin action, mg/dL, of the order for all kinds of
/// bodies. The searches use it for their steps.
pub(super) const SLOPE: f64 = 200.0;
/// Range of the fall of mean glucose with the logarithm of insulin action, mg/dL.
const SLOPES: (f64, f64) = (80.0, 500.0);
/// Limits of the search for the logarithm of the factor on insulin action.
const SCALES: (f64, f64) = (-1.6, 1.6);

/// A secant search for the log action, with the slope kept within the range of bodies.
pub(super) struct Toward {
    /// Logarithm of the factor on insulin action to be tried next.
    pub(super) scale: f64,
    slope: f64,
    last: Option<(f64, f64)>,
}

impl Toward {
    /// A search from a first guess.
    pub(super) fn new(scale: f64) -> Self {
        Self { scale: scale.clamp(SCALES.0, SCALES.1), slope: SLOPE, last: None }
    }

    /// One step, given how far the mean is too high, mg/dL.
    pub(super) fn step(&mut self, excess: f64) {
        if let Some((scale, before)) = self.last
            && (self.scale - scale).abs() > 0.005
        {
            self.slope = ((before - excess) / (self.scale - scale)).clamp(SLOPES.0, SLOPES.1);
        }
        self.last = Some((self.scale, excess));
        let step = (excess / self.slope).clamp(-0.5, 0.5);
        self.scale = (self.scale + step).clamp(SCALES.0, SCALES.1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_of_a_bent_curve_is_found_in_a_few_steps() {
        let mut toward = Toward::new(-0.9);
        let mean = |scale: f64| 60.0 + 90.0 * (-scale).exp();
        for _ in 0..8 {
            toward.step(mean(toward.scale) - 140.0);
        }
        assert!((mean(toward.scale) - 140.0).abs() < 0.5, "{}", toward.scale); // 0.5 mg/dL suffice
    }
}
