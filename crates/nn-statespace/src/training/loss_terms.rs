//! The loss of the population model as a sum of terms with their slopes, for the kernel.
//!
//! The same loss as [`Loss`](super::loss::Loss), which is its oracle: one term for each sample, step
//! and state, so that no graph is needed.

use physiology::Compartment;

use super::loss::{HIGH_GLUCOSE, LOW_GLUCOSE, LossConfig, SoftConstraint, consistency_weight};
use crate::kernel::{Real, StateLoss};
use crate::per_compartment::PerCompartment;
use crate::scaler::Scaler;
use crate::signal::Signal;

/// The loss of a batch of a given size.
#[derive(Debug, Clone, Copy)]
pub struct LossTerms<T> {
    /// The two glucose thresholds, scaled.
    low: T,
    high: T,
    /// What L_fit gives an error's square: otherwise, and where a low or a high is missed.
    fit: T,
    missed_low: T,
    missed_high: T,
    states: PerCompartment<StateTerms<T>>,
}

/// What L_consistency takes from one state.
#[derive(Debug, Clone, Copy)]
struct StateTerms<T> {
    /// Factor of an error's square.
    error: T,
    /// min(x^i), scaled.
    least: T,
    /// Factor of what is missing to it.
    constraint: T,
}

impl<T: Real> LossTerms<T> {
    /// The loss for data with this scaler and these scaled minima, over `samples`: the sequences of
    /// the batch times their steps.
    #[must_use]
    pub fn new(
        config: &LossConfig,
        scaler: &Scaler,
        minima: &PerCompartment<f64>,
        samples: usize,
    ) -> Self {
        let glucose = scaler.of(Signal::State(Compartment::Q1));
        let mean = 1.0 / samples as f64;
        let constraint_share = match config.soft_constraint {
            SoftConstraint::Mean => mean,
            SoftConstraint::Sum => 1.0,
        };
        Self {
            low: T::of(glucose.scale(LOW_GLUCOSE.0)),
            high: T::of(glucose.scale(HIGH_GLUCOSE.0)),
            fit: T::of(mean),
            missed_low: T::of(config.penalty.missed_low * mean),
            missed_high: T::of(config.penalty.missed_high * mean),
            states: PerCompartment::from_fn(|compartment| {
                let weight = config.alpha * consistency_weight(compartment);
                StateTerms {
                    // C1 has no ground truth.
                    error: match compartment {
                        Compartment::C1 => T::ZERO,
                        _ => T::of(weight * mean),
                    },
                    least: T::of(minima[compartment]),
                    constraint: T::of(weight * config.beta * constraint_share),
                }
            }),
        }
    }

    /// The term of an error of glucose within L_fit, as a factor of its square.
    #[inline(always)]
    fn fit(&self, simulated: T, truth: T) -> T {
        if truth <= self.low && simulated > truth {
            self.missed_low
        } else if truth >= self.high && simulated < truth {
            self.missed_high
        } else {
            self.fit
        }
    }
}

impl<T: Real> StateLoss<T> for LossTerms<T> {
    fn terms(
        &self,
        compartment: Compartment,
        simulated: &[T],
        truth: &[T],
        slopes: &mut [T],
        values: &mut [T],
    ) {
        let StateTerms { error, least, constraint } = self.states[compartment];
        let is_glucose = compartment == Compartment::Q1;
        let rows = simulated.iter().zip(truth).zip(slopes).zip(values);
        for (((simulated, truth), slope), value) in rows {
            let difference = *simulated - *truth;
            let mut factor = error;
            if is_glucose {
                factor = factor + self.fit(*simulated, *truth);
            }
            let below = if *simulated < least { constraint } else { T::ZERO };
            *value = *value + factor * difference * difference + below * (least - *simulated);
            *slope = (factor + factor) * difference - below;
        }
    }
}

#[cfg(test)]
mod tests {
    use candle_core::{DType, Device, Tensor, Var};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::scaler::CentreAndScale;
    use crate::training::loss::Loss;
    use crate::training::windows::STATES;

    /// Values and slopes of both, over random states around thresholds and minima.
    #[test]
    fn terms_and_slopes_are_those_of_the_graph() {
        let unit = CentreAndScale { centre: 0.0, scale: 1.0 };
        let mut states = PerCompartment::from_fn(|_| unit);
        states[Compartment::Q1] = CentreAndScale { centre: 130.0, scale: 60.0 };
        let scaler = Scaler::new(states, unit, unit).expect("positive");
        let minima = PerCompartment::from_fn(|c| -0.5 - 0.1 * f64::from(c as u8));
        let (steps, batch) = (40, 9);
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        let mut draw = || -> Vec<f64> {
            (0..steps * batch * STATES).map(|_| rng.random_range(-3.0..3.0)).collect()
        };
        let (simulated, truth) = (draw(), draw());
        let tensor = |values: &[f64]| {
            Tensor::from_slice(values, (steps, batch, STATES), &Device::Cpu).expect("the shape")
        };
        for soft_constraint in [SoftConstraint::Mean, SoftConstraint::Sum] {
            let config = LossConfig { soft_constraint, ..LossConfig::paper() };
            let graph = Loss::new(config, &scaler, &minima, DType::F64).expect("ten columns");
            let variable = Var::from_tensor(&tensor(&simulated)).expect("a copy");
            let total = graph.total(&variable, &tensor(&truth)).expect("one shape");
            let gradients = total.backward().expect("differentiable");
            let expected = gradients.get(&variable).and_then(|g| g.flatten_all().ok());
            let expected = expected.and_then(|g| g.to_vec1::<f64>().ok()).expect("a gradient");

            let terms = LossTerms::<f64>::new(&config, &scaler, &minima, steps * batch);
            let mut sum = 0.0;
            for (index, (simulated, truth)) in simulated.iter().zip(&truth).enumerate() {
                let compartment = Compartment::ALL[index % STATES];
                let (mut slope, mut value) = ([f64::NAN], [0.0]);
                terms.terms(compartment, &[*simulated], &[*truth], &mut slope, &mut value);
                sum += value[0];
                // Rounding of a few products.
                let error = (slope[0] - expected[index]).abs();
                assert!(error < 1e-14, "{compartment}: {} {}", slope[0], expected[index]);
            }
            let total = total.to_scalar::<f64>().expect("a scalar");
            assert!((sum - total).abs() < 1e-12 * total, "{sum} {total}"); // rounding of sums
        }
    }
}
