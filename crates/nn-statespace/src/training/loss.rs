//! The loss of the population model (paper, Eqs. for L_total, L_fit, P and L_consistency).
//!
//! All errors are in scaled units, over every sample but the first: the start of a window is given
//! and has no error. Tensors have shape (steps, batch, states) with states in the order of
//! [`Compartment::ALL`], or (steps, batch) for glucose alone.

use candle_core::{Device, Tensor};
use physiology::{Compartment, MgPerDl};
use serde::{Deserialize, Serialize};

use crate::error::ModelError;
use crate::per_compartment::PerCompartment;
use crate::scaler::Scaler;
use crate::signal::Signal;

/// Below or at this glucose an over-estimate is penalised (paper, penalty P).
pub const LOW_GLUCOSE: MgPerDl = MgPerDl(70.0);
/// Above or at this glucose an under-estimate is penalised (paper, penalty P).
pub const HIGH_GLUCOSE: MgPerDl = MgPerDl(250.0);

/// Factors on squared errors of glucose that hide a clinical event.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Penalty {
    /// Where true glucose is at most [`LOW_GLUCOSE`] and the model says more.
    pub missed_low: f64,
    /// Where true glucose is at least [`HIGH_GLUCOSE`] and the model says less.
    pub missed_high: f64,
}

/// How the soft constraint is taken over a batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SoftConstraint {
    /// Mean over samples, on the scale of the squared error it stands beside.
    Mean,
    /// Sum over samples, as the paper's equation is written.
    Sum,
}

/// Weights of the loss.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LossConfig {
    /// Penalty within L_fit.
    pub penalty: Penalty,
    /// Weight of L_consistency against L_fit.
    pub alpha: f64,
    /// Weight of the soft constraint against the squared error of each state.
    pub beta: f64,
    /// Mean or sum in the soft constraint.
    pub soft_constraint: SoftConstraint,
}

impl LossConfig {
    /// The paper's values: penalties 2 and 6, alpha 0.7, beta 0.08. The paper's sum in the soft
    /// constraint is not normalised, unlike the term beside it; the mean is taken here.
    #[must_use]
    pub const fn paper() -> Self {
        Self {
            penalty: Penalty { missed_low: 2.0, missed_high: 6.0 },
            alpha: 0.7,
            beta: 0.08,
            soft_constraint: SoftConstraint::Mean,
        }
    }
}

/// Weight of a state in L_consistency (paper): 5/24 for Q1, 1/6 for Q2, 1/24 for C1, else 1/12.
#[must_use]
pub const fn consistency_weight(compartment: Compartment) -> f64 {
    match compartment {
        Compartment::Q1 => 5.0 / 24.0,
        Compartment::Q2 => 1.0 / 6.0,
        Compartment::C1 => 1.0 / 24.0,
        _ => 1.0 / 12.0,
    }
}

/// The loss with everything that depends on the data's scaler and minima.
#[derive(Debug, Clone)]
pub struct Loss {
    config: LossConfig,
    /// The two glucose thresholds, scaled.
    low: f64,
    high: f64,
    /// Shape (1, 1, 10): weights of the squared errors, 0 for C1, which has no ground truth.
    error_weights: Tensor,
    /// Shape (1, 1, 10): weights of the soft constraints.
    constraint_weights: Tensor,
    /// Shape (1, 1, 10): min(x^i), scaled.
    minima: Tensor,
}

impl Loss {
    /// The loss for data with this scaler and these scaled minima.
    ///
    /// # Errors
    /// [`ModelError::Tensor`] from candle.
    pub fn new(
        config: LossConfig,
        scaler: &Scaler,
        minima: &PerCompartment<f64>,
        dtype: candle_core::DType,
    ) -> Result<Self, ModelError> {
        let row = |value: &dyn Fn(Compartment) -> f64| {
            let values: Vec<f64> = Compartment::ALL.into_iter().map(value).collect();
            Tensor::from_vec(values, (1, 1, Compartment::ALL.len()), &Device::Cpu)?.to_dtype(dtype)
        };
        let glucose = scaler.of(Signal::State(Compartment::Q1));
        Ok(Self {
            config,
            low: glucose.scale(LOW_GLUCOSE.0),
            high: glucose.scale(HIGH_GLUCOSE.0),
            error_weights: row(&|c| match c {
                Compartment::C1 => 0.0,
                _ => consistency_weight(c),
            })?,
            constraint_weights: row(&consistency_weight)?,
            minima: row(&|c| minima[c])?,
        })
    }

    /// L_total of simulated against true states, both of shape (steps, batch, 10); a scalar.
    ///
    /// # Errors
    /// [`ModelError::Tensor`] if the shapes do not fit.
    pub fn total(&self, simulated: &Tensor, truth: &Tensor) -> Result<Tensor, ModelError> {
        let glucose = |states: &Tensor| states.get_on_dim(2, Compartment::Q1 as usize);
        let fit = self.fit(&glucose(simulated)?, &glucose(truth)?)?;
        Ok((fit + (self.consistency(simulated, truth)? * self.config.alpha)?)?)
    }

    /// L_fit of simulated against true glucose, both of one shape: the mean of the squared error
    /// times the penalty P (paper, Eqs. for L_fit and P), a scalar. The penalty is a constant where
    /// it does not jump, so that no gradient runs through it.
    ///
    /// # Errors
    /// [`ModelError::Tensor`] if the shapes do not fit.
    pub fn fit(&self, simulated: &Tensor, truth: &Tensor) -> Result<Tensor, ModelError> {
        let Penalty { missed_low, missed_high } = self.config.penalty;
        let (dtype, seen) = (simulated.dtype(), simulated.detach());
        let low = (truth.le(self.low)? * seen.gt(truth)?)?.to_dtype(dtype)?;
        let high = (truth.ge(self.high)? * seen.lt(truth)?)?.to_dtype(dtype)?;
        let factor = (((low * (missed_low - 1.0))? + (high * (missed_high - 1.0))?)? + 1.0)?;
        Ok(((simulated - truth)?.sqr()? * factor)?.mean_all()?)
    }

    /// L_consistency of simulated against true states, both of shape (steps, batch, 10); a scalar.
    ///
    /// # Errors
    /// [`ModelError::Tensor`] if the shapes do not fit.
    pub fn consistency(&self, simulated: &Tensor, truth: &Tensor) -> Result<Tensor, ModelError> {
        let (steps, batch, _) = simulated.dims3()?;
        let samples = (steps * batch) as f64;
        let squares = (simulated - truth)?.sqr()?.broadcast_mul(&self.error_weights)?.sum_all()?;
        let below = self
            .minima
            .broadcast_sub(simulated)?
            .relu()?
            .broadcast_mul(&self.constraint_weights)?
            .sum_all()?;
        let share = match self.config.soft_constraint {
            SoftConstraint::Mean => 1.0 / samples,
            SoftConstraint::Sum => 1.0,
        };
        Ok(((squares / samples)? + (below * (self.config.beta * share))?)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scaler::CentreAndScale;
    use candle_core::DType;

    fn loss(soft_constraint: SoftConstraint) -> Loss {
        let unit = CentreAndScale { centre: 0.0, scale: 1.0 };
        let mut states = PerCompartment::from_fn(|_| unit);
        states[Compartment::Q1] = CentreAndScale { centre: 100.0, scale: 50.0 };
        let scaler = Scaler::new(states, unit, unit).expect("positive");
        let mut minima = PerCompartment::from_fn(|_| -1.0);
        minima[Compartment::C1] = 0.0;
        let config = LossConfig { soft_constraint, ..LossConfig::paper() };
        Loss::new(config, &scaler, &minima, DType::F64).expect("ten columns")
    }

    fn scalar(tensor: Tensor) -> f64 {
        tensor.to_scalar().expect("a scalar")
    }

    /// Scaled states of one sample with the named values and 0 elsewhere.
    fn sample(values: &[(Compartment, f64)]) -> Vec<f64> {
        let mut row = vec![0.0; 10];
        for (compartment, value) in values {
            row[*compartment as usize] = *value;
        }
        row
    }

    fn tensor(rows: &[Vec<f64>]) -> Tensor {
        Tensor::from_vec(rows.concat(), (rows.len(), 1, 10), &Device::Cpu).expect("ten columns")
    }

    #[test]
    fn weights_sum_to_one() {
        let sum: f64 = Compartment::ALL.into_iter().map(consistency_weight).sum();
        assert!((sum - 1.0).abs() < 1e-15); // rounding of ten terms
    }

    #[test]
    fn missed_lows_and_highs_are_penalised_and_nothing_else() {
        // thresholds 70 and 250 are -0.6 and 3.0 at centre 100 and scale 50
        let cases = [
            (-0.6, -0.5, 2.0), // low, said too high
            (-0.6, -0.7, 1.0), // low, said too low
            (-0.59, -0.49, 1.0),
            (3.0, 2.9, 6.0), // high, said too low
            (3.0, 3.1, 1.0),
            (2.99, 2.89, 1.0),
        ];
        let loss = loss(SoftConstraint::Mean);
        for (truth, simulated, factor) in cases {
            let value =
                |v: f64| Tensor::from_vec(vec![v], (1, 1), &Device::Cpu).expect("one value");
            let fit = scalar(loss.fit(&value(simulated), &value(truth)).expect("one shape"));
            assert!((fit - 0.01 * factor).abs() < 1e-12, "{truth} {simulated}: {fit}"); // rounding
        }
    }

    #[test]
    fn the_total_is_that_worked_out_by_hand() {
        use Compartment::{C1, Q1, S1, X3};
        let truth = tensor(&[sample(&[(Q1, 3.5), (C1, 9.0)]), sample(&[(S1, 1.0)])]);
        let simulated =
            tensor(&[sample(&[(Q1, 3.0), (C1, -0.4)]), sample(&[(S1, 1.5), (X3, -1.25)])]);
        // fit: 0.5^2 x 6 over two samples
        let fit = 0.25 * 6.0 / 2.0;
        // squares: Q1 0.25, S1 0.25, X3 1.5625, no C1; two samples
        let squares = (0.25 * 5.0 / 24.0 + 0.25 / 12.0 + 1.5625 / 12.0) / 2.0;
        // below the minimum: C1 by 0.4 (minimum 0), X3 by 0.25 (minimum -1)
        let below = 0.4 / 24.0 + 0.25 / 12.0;
        for (kind, share) in [(SoftConstraint::Mean, 0.5), (SoftConstraint::Sum, 1.0)] {
            let total = scalar(loss(kind).total(&simulated, &truth).expect("one shape"));
            let expected = fit + 0.7 * (squares + 0.08 * share * below);
            assert!((total - expected).abs() < 1e-12, "{total} {expected}"); // rounding
        }
    }

    #[test]
    fn a_perfect_simulation_costs_nothing() {
        let truth = tensor(&[sample(&[(Compartment::Q1, -0.9)])]);
        let total = loss(SoftConstraint::Sum).total(&truth, &truth).expect("one shape");
        assert_eq!(scalar(total), 0.0);
    }
}
