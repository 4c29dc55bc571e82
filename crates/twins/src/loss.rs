//! The loss of a personal model (paper, Eq. `costInd`).

use nn_statespace::PopulationModel;
use physiology::MgPerDl;

use crate::prepared::scaled_glucose;

/// At and below this measured glucose, overestimates weigh more (paper, Eq. `penInd`).
pub const LOW: MgPerDl = MgPerDl(70.0);
/// At and above this measured glucose, underestimates weigh more (paper, Eq. `penInd`).
pub const HIGH: MgPerDl = MgPerDl(250.0);

/// Weights of the errors that matter clinically (paper, Eq. `penInd`); all others weigh 1.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Penalty {
    /// Weight where measured glucose is at most [`LOW`] and the simulation is above it.
    pub low: f64,
    /// Weight where measured glucose is at least [`HIGH`] and the simulation is below it.
    pub high: f64,
}

impl Penalty {
    /// The paper's 8.5 and 6.
    pub const PAPER: Self = Self { low: 8.5, high: 6.0 };
    /// Every error weighs the same, so that the fit is to the mean.
    pub const NONE: Self = Self { low: 1.0, high: 1.0 };
}

/// Penalised squared error plus `consistency` times the squared error of first differences, both
/// averaged over the steps of a window and in scaled units of Q1. The start counts in the first
/// difference and in nothing else.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TwinLoss {
    /// Weights of the clinically significant errors.
    pub penalty: Penalty,
    /// alpha^I of the paper, the weight of first differences.
    pub consistency: f64,
}

impl TwinLoss {
    /// The paper's weights: 8.5, 6 and alpha = 10.
    pub const PAPER: Self = Self { penalty: Penalty::PAPER, consistency: 10.0 };

    /// The loss with its thresholds in the scaled units of `population`'s Q1.
    #[must_use]
    pub fn scaled_by(self, population: &PopulationModel) -> ScaledLoss {
        let [low, high] = [LOW, HIGH].map(|level| scaled_glucose(population, level.0));
        ScaledLoss { weights: self, low, high }
    }
}

/// A [`TwinLoss`] whose thresholds are in scaled units of Q1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScaledLoss {
    weights: TwinLoss,
    low: f64,
    high: f64,
}

impl ScaledLoss {
    /// P(simulated, measured) of Eq. `penInd`, unitless.
    #[must_use]
    pub fn penalty(&self, simulated: f64, measured: f64) -> f64 {
        if measured <= self.low && simulated > measured {
            self.weights.penalty.low
        } else if measured >= self.high && simulated < measured {
            self.weights.penalty.high
        } else {
            1.0
        }
    }

    /// Loss of one window. Both slices hold the start and every step after it, scaled; they have
    /// the same length, at least 2.
    #[must_use]
    pub fn of(&self, simulated: &[f64], measured: &[f64]) -> f64 {
        let mut sum = 0.0;
        let mut previous = simulated[0] - measured[0];
        for (s, m) in simulated.iter().zip(measured).skip(1) {
            let error = s - m;
            let difference = error - previous;
            sum += self.penalty(*s, *m) * error * error
                + self.weights.consistency * difference * difference;
            previous = error;
        }
        sum / (simulated.len() - 1) as f64
    }

    /// Adds d loss / d simulated glucose of one window to `slope`, which has the length of both
    /// other slices; its first entry (the given start) is left alone. The penalty counts as
    /// constant, as it is almost everywhere.
    pub(crate) fn add_slope(&self, simulated: &[f64], measured: &[f64], slope: &mut [f64]) {
        let last = simulated.len() - 1;
        let factor = 2.0 / last as f64;
        let error = |m: usize| simulated[m] - measured[m];
        for m in 1..=last {
            let penalty = self.penalty(simulated[m], measured[m]);
            let mut sum = penalty * error(m);
            sum += self.weights.consistency * (error(m) - error(m - 1));
            if m < last {
                sum -= self.weights.consistency * (error(m + 1) - error(m));
            }
            slope[m] += factor * sum;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn loss() -> ScaledLoss {
        ScaledLoss { weights: TwinLoss::PAPER, low: -1.0, high: 2.0 }
    }

    #[test]
    fn only_dangerous_errors_are_penalised() {
        let cases = [
            (-0.5, -1.0, 8.5), // low measured, simulated too high
            (-1.5, -1.0, 1.0), // low measured, simulated lower still
            (1.5, 2.0, 6.0),   // high measured, simulated too low
            (2.5, 2.0, 1.0),   // high measured, simulated higher still
            (-1.0, -1.0, 1.0), // no error
            (1.0, 0.0, 1.0),   // in between
        ];
        for (simulated, measured, expected) in cases {
            assert_eq!(loss().penalty(simulated, measured), expected);
        }
    }

    #[test]
    fn the_loss_of_a_worked_window() {
        // Errors 0, 1, 0.5; differences 1, -0.5; second measured value is high and underestimated
        // by -0.5 once.
        let (measured, simulated) = ([0.0, 0.0, 2.0], [0.0, 1.0, 1.5]);
        let expected = ((1.0 + 6.0 * 0.25) + 10.0 * (1.0 + 2.25)) / 2.0;
        assert!((loss().of(&simulated, &measured) - expected).abs() < 1e-12); // rounding
    }

    #[test]
    fn slopes_agree_with_central_differences() {
        let measured = [0.0, 0.3, -1.2, 2.4, 2.1];
        let simulated = [0.0, 0.5, -0.7, 1.9, 2.6];
        let mut slope = [0.0; 5];
        loss().add_slope(&simulated, &measured, &mut slope);
        assert_eq!(slope[0], 0.0);
        for m in 1..5 {
            let moved = |h: f64| {
                let mut x = simulated;
                x[m] += h;
                loss().of(&x, &measured)
            };
            let central = (moved(1e-5) - moved(-1e-5)) / 2e-5;
            // The loss is quadratic between kinks: only rounding, 1e-16 / 1e-5 times its size.
            assert!((central - slope[m]).abs() < 1e-8, "{m}: {central} {}", slope[m]);
        }
    }
}
