//! Personal calibration: the plant's six most personal parameters by maximum a posteriori.
//!
//! Without it every person's own insulin action would count as a gap. The loss is that of the innovations of the
//! whole record, prewhitened and weighted by Huber, while gains, variances and whitening of the filter are held: first
//! at those of everybody's parameters, then at those of what was found. A loss under held gains has one
//! minimum, to which a search descends; gains that follow the factors lead elsewhere after a small change of the
//! record. Variances that are held do not reward parameters for promising small errors
//! (`docs/decisions/0027-...`).
//! The data's loss is divided by how much more the gradient varies from day to day than independent steps
//! would make it, and the posterior covariance is that of days, not of steps ([`Calibration::covariance`]).

mod information;
mod point;
pub(crate) mod rule;
mod search;
mod unlogged;

use physiology::Plant as _;

pub use self::rule::CalibrationRule;
use self::search::solved;
use crate::error::GapError;
use crate::filter::augmented::AugmentedModel;
use crate::filter::kalman::{Filtered, filter};
use crate::filter::observations::Observations;
use crate::filter::scored::{Whitening, clipped_scale, normalised};
use crate::filter::tangent::{Direction, Parameter};
use crate::filter::whitening::Autoregression;

pub use ode_sim::personal::{FACTORS, Factor, PersonalFactors};

/// A calibrated person.
#[derive(Debug, Clone)]
pub struct Calibration {
    /// The log factors.
    pub factors: PersonalFactors,
    /// Their posterior standard deviations.
    pub sd: [f64; FACTORS],
    /// Their posterior covariance, days taken for independent, in the order of [`Factor::ALL`]: what other days
    /// would have changed, by the jackknife, what the prior leaves open, and what meals that are not in the log would change.
    pub covariance: [[f64; FACTORS]; FACTORS],
    /// How many times the variance of what the record says is what independent steps would make it, at least 1.
    pub dependence: f64,
    /// The filter's model with the calibrated parameters.
    pub model: AugmentedModel,
    /// The filter's run with that model.
    pub filtered: Filtered,
    /// The autoregression that whitens the normalised innovations.
    pub autoregression: Autoregression,
    /// Whitened innovations in units of [`scale`](Self::scale), one a step; `None` where not scored.
    pub whitened: Vec<Option<f64>>,
    /// Standard deviation of the whitened normalised innovations; 1 for a perfect noise model. The
    /// calibration itself takes values below 1 as 1.
    pub scale: f64,
    /// Iterations made.
    pub iterations: usize,
    /// Whether the iteration met its tolerance.
    pub converged: bool,
    /// Factors that ended at the rule's bound.
    pub at_bound: Vec<Factor>,
}

impl Calibration {
    /// Filtered plasma glucose, mg/dL, one entry a step.
    #[must_use]
    pub fn glucose(&self) -> Vec<f64> {
        let person = self.model.person();
        self.filtered.states.iter().map(|s| person.glucose(&s.body).0).collect()
    }

    /// The same factors on the same record under other modulations: the filter is run again and its
    /// innovations are whitened again.
    ///
    /// # Errors
    /// As [`filter`].
    pub fn about(&self, record: &Observations, rule: &CalibrationRule) -> Result<Self, GapError> {
        let setting = Setting::of(&self.model, record, rule);
        let filtered = filter(&self.model, record)?;
        let (Whitening { autoregression, scale }, whitened) = setting.whitened(&filtered);
        Ok(Self {
            filtered,
            autoregression,
            whitened,
            scale,
            at_bound: self.at_bound.clone(),
            model: self.model.clone(),
            ..*self
        })
    }
}

/// The calibrated parameters, in the order of [`Factor::ALL`].
pub(crate) const PARAMETERS: [Parameter; FACTORS] = [
    Parameter::Action,
    Parameter::Egp0,
    Parameter::TMaxG,
    Parameter::TMaxI,
    Parameter::AG,
    Parameter::F01,
];

/// The calibrated parameters as directions.
pub(crate) fn directions() -> [Direction; FACTORS] {
    PARAMETERS.map(Direction::Parameter)
}

/// A move of the log factors.
type Factors = [f64; FACTORS];
/// A matrix over the factors, row by row.
type Square = [[f64; FACTORS]; FACTORS];

/// What does not change during one person's calibration.
struct Setting<'a> {
    /// The model of everybody.
    population: &'a AugmentedModel,
    record: &'a Observations,
    rule: &'a CalibrationRule,
    scored: Vec<bool>,
}

impl<'a> Setting<'a> {
    fn of(
        population: &'a AugmentedModel,
        record: &'a Observations,
        rule: &'a CalibrationRule,
    ) -> Self {
        let scored = rule.scored(record, &(0..record.len()));
        Self { population, record, rule, scored }
    }

    fn singular(&self) -> GapError {
        GapError::Singular { person: self.record.person.clone() }
    }

    fn model(&self, factors: &PersonalFactors) -> AugmentedModel {
        self.population.with_parameters(|population| factors.applied_to(population))
    }

    /// Whitens the innovations of a run of the filter with its own gains. What is left is in units of the scale.
    fn whitened(&self, filtered: &Filtered) -> (Whitening, Vec<Option<f64>>) {
        let z = normalised(&filtered.innovations, &self.scored);
        let (whitening, left) = Whitening::fitted(&z, clipped_scale);
        let whitened = left.iter().map(|w| w.map(|w| w / whitening.scale)).collect();
        (whitening, whitened)
    }
}

/// Calibrates a person: `population` is the model of everybody, of any body, with the person's weight. See the module
/// for the method.
///
/// # Errors
/// As [`filter`], and [`GapError::Singular`].
pub fn calibrate(
    population: &AugmentedModel,
    record: &Observations,
    rule: &CalibrationRule,
) -> Result<Calibration, GapError> {
    solved(&Setting::of(population, record, rule))
}

#[cfg(test)]
mod tests {
    use ode_sim::OdeParameters;

    use super::*;

    #[test]
    fn factors_act_on_the_parameters_they_name() {
        let population = OdeParameters::nominal();
        type ReadFactor = fn(&OdeParameters) -> f64;
        let cases: [(Factor, ReadFactor); FACTORS] = [
            (Factor::Action, |p| p.s_f2),
            (Factor::Egp0, |p| p.egp_0),
            (Factor::TMaxG, |p| p.t_max_g),
            (Factor::TMaxI, |p| p.t_max_i),
            (Factor::AG, |p| p.a_g),
            (Factor::F01, |p| p.f_01),
        ];
        for (factor, value) in cases {
            let mut factors = PersonalFactors::default();
            factors.0[factor as usize] = 0.2;
            let ratio = value(&factors.applied_to(&population)) / value(&population);
            assert!((ratio - 0.2f64.exp()).abs() < 1e-12, "{factor:?}: {ratio}"); // rounding
        }
        assert_eq!(PersonalFactors::default().applied_to(&population), population);
    }
}
