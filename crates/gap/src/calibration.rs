//! Personal calibration: the plant's six most personal parameters by maximum a posteriori.
//!
//! Without it every person's own insulin action would count as a gap. Two searches over log factors on the
//! population parameters follow each other. The first looks for the best posterior on a few days, in which all
//! that a factor changes counts, the filter's own uncertainty included; it finds the neighbourhood. The
//! second solves an estimating equation on the whole record: innovations, prewhitened and weighted by Huber,
//! shall have no part along their derivatives ("signatures") with the filter's gains held. Innovations have mean
//! zero given the past whatever they are weighed with, so that its answer does not lean on the noise model; the
//! posterior would rather halve a person's meals than believe that they are counted well.

mod equations;
mod estimating;
mod first_search;

use ode_sim::{EgpMode, OdeParameters};
use physiology::Plant as _;
use serde::{Deserialize, Serialize};

use self::estimating::{Solved, solved};
use self::first_search::near_posterior;
use crate::augmented::AugmentedModel;
use crate::error::GapError;
use crate::filter::{Filtered, Innovation, filter, innovations};
use crate::noise::NoiseModel;
use crate::observations::{Observations, Reading};
use crate::whitening::{Autoregression, HUBER_THRESHOLD, huber_loss, robust_scale};

pub use ode_sim::personal::{FACTORS, Factor, PersonalFactors};

/// How a calibration is run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CalibrationRule {
    /// Steps at the start of the record whose innovations are not scored.
    pub burn_in: usize,
    /// Steps after an unrecorded dose whose innovations are not scored.
    pub dose_memory: usize,
    /// Iterations after which the calibration gives up and says so.
    pub max_iterations: usize,
    /// The iteration ends when a step is no longer than this many posterior standard deviations, in whatever
    /// direction.
    pub tolerance: f64,
    /// Log factors are kept within plus and minus this.
    pub bound: f64,
}

impl CalibrationRule {
    /// The values in use: 12 h of burn-in, 4 h of dose memory, 30 iterations, 0.15 posterior standard
    /// deviations (which add a fiftieth to the variance), factors within exp(-0.9) to exp(0.9).
    #[must_use]
    pub const fn working() -> Self {
        Self { burn_in: 144, dose_memory: 48, max_iterations: 30, tolerance: 0.15, bound: 0.9 }
    }
}

/// A calibrated person.
#[derive(Debug, Clone)]
pub struct Calibration {
    /// The log factors.
    pub factors: PersonalFactors,
    /// Their posterior standard deviations.
    pub sd: [f64; FACTORS],
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
        let plant = self.model.plant();
        self.filtered.states.iter().map(|s| plant.glucose(&s.body).0).collect()
    }

    /// The same factors on the same record under other modulations: the filter is run again and its
    /// innovations are whitened anew.
    ///
    /// # Errors
    /// As [`filter`].
    pub fn about(&self, record: &Observations, rule: &CalibrationRule) -> Result<Self, GapError> {
        let scored = rule.scored(record, &(0..record.len()));
        let filtered = filter(&self.model, record)?;
        let z = crate::scored::normalised(&filtered.innovations, &scored);
        let autoregression = Autoregression::fitted(&z);
        let whitened = autoregression.whitened(&z);
        let scale = clipped_scale(&whitened);
        Ok(Self {
            filtered,
            autoregression,
            whitened: whitened.iter().map(|w| w.map(|w| w / scale)).collect(),
            scale,
            at_bound: self.at_bound.clone(),
            model: self.model.clone(),
            ..*self
        })
    }
}

/// Longest move of a log factor in one iteration.
const LONGEST_MOVE: f64 = 0.3;
/// Shortest share of a step that is tried; what gains less lies between kinks.
const SHORTEST_SHARE: f64 = 0.1;
/// A move of the log factors.
type Factors = [f64; FACTORS];

/// What does not change during one person's calibration.
struct Setting<'a> {
    /// The model of everybody.
    population: &'a AugmentedModel,
    record: &'a Observations,
    scored: Vec<bool>,
    bound: f64,
}

impl Setting<'_> {
    fn model(&self, factors: &PersonalFactors) -> AugmentedModel {
        self.population.with_parameters(|population| factors.applied_to(population))
    }

    /// Innovations before `end`; `None` where not scored.
    fn innovations(
        &self,
        factors: &PersonalFactors,
        end: usize,
    ) -> Result<Vec<Option<Innovation>>, GapError> {
        let mut found = innovations(&self.model(factors), self.record, end)?;
        for (innovation, scored) in found.iter_mut().zip(&self.scored) {
            *innovation = innovation.filter(|_| *scored);
        }
        Ok(found)
    }

    /// Steps in which the first `readings` scored readings lie.
    fn steps_of(&self, readings: usize) -> usize {
        let within = self.record.readings.iter().map(|r| matches!(r, Reading::Within(_)));
        let scored = within.zip(&self.scored).enumerate().filter(|(_, (r, s))| *r && **s);
        scored.map(|(step, _)| step + 1).take(readings).last().unwrap_or(0)
    }
}

fn normalised(innovations: &[Option<Innovation>]) -> Vec<Option<f64>> {
    innovations.iter().map(|i| i.map(|i| i.normalised())).collect()
}

/// The whitening that is held while one step of the calibration is taken.
struct Whitening {
    autoregression: Autoregression,
    scale: f64,
}

/// Whitened innovations and the logarithms of their variances; `None` where not scored.
type Scored = Vec<Option<(f64, f64)>>;

impl Whitening {
    fn fitted(innovations: &[Option<Innovation>]) -> Self {
        let z = normalised(innovations);
        let autoregression = Autoregression::fitted(&z);
        // Readings smoother than the noise model (interpolated ones) are not trusted more for that.
        let scale = clipped_scale(&autoregression.whitened(&z)).max(1.0);
        Self { autoregression, scale }
    }

    fn of(&self, innovations: &[Option<Innovation>]) -> Scored {
        let whitened = self.autoregression.whitened(&normalised(innovations));
        let both = whitened.into_iter().zip(innovations);
        both.map(|(w, i)| Some((w?, (*i)?.variance.ln()))).collect()
    }

    /// Negative log posterior up to a constant, nats.
    fn loss(&self, scored: &Scored, factors: &PersonalFactors) -> f64 {
        let of = |(w, variance): &(f64, f64)| huber_loss(w / self.scale, 1.0) + 0.5 * variance;
        scored.iter().flatten().map(of).sum::<f64>() + factors.prior_loss()
    }
}

/// Calibrates a person on the ODE plant. See the module for the method.
///
/// # Errors
/// As [`filter`], and [`GapError::Singular`].
pub fn calibrate(
    population: &OdeParameters,
    egp: EgpMode,
    noise: &NoiseModel,
    record: &Observations,
    rule: &CalibrationRule,
) -> Result<Calibration, GapError> {
    calibrated(&AugmentedModel::new(*population, record.weight, egp, *noise), record, rule)
}

/// Calibrates a person on any body: `population` is the model of everybody, with the person's weight.
///
/// # Errors
/// As [`calibrate`].
pub fn calibrated(
    population: &AugmentedModel,
    record: &Observations,
    rule: &CalibrationRule,
) -> Result<Calibration, GapError> {
    let scored = rule.scored(record, &(0..record.len()));
    let setting = Setting { population, record, scored, bound: rule.bound };
    let start = near_posterior(&setting)?;
    let Solved { factors, run, sd, iterations, converged } = solved(&setting, start, rule)?;
    let scale = clipped_scale(&run.whitened);
    let at_bound =
        Factor::ALL.into_iter().filter(|f| factors.get(*f).abs() >= rule.bound).collect();
    Ok(Calibration {
        factors,
        sd,
        model: setting.model(&factors),
        filtered: run.filtered,
        autoregression: run.whitening.autoregression,
        whitened: run.whitened.iter().map(|w| w.map(|w| w / scale)).collect(),
        scale,
        iterations,
        converged,
        at_bound,
    })
}

/// Factors after a move, none of which is longer than [`LONGEST_MOVE`] or leads out of bounds.
fn moved(factors: &PersonalFactors, by: &Factors, bound: f64) -> PersonalFactors {
    PersonalFactors(std::array::from_fn(|k| {
        (factors.0[k] + by[k].clamp(-LONGEST_MOVE, LONGEST_MOVE)).clamp(-bound, bound)
    }))
}

/// Standard deviation with values clipped at Huber's threshold, so that wild readings do not
/// inflate it; 1 where nothing is scored.
pub(crate) fn clipped_scale(whitened: &[Option<f64>]) -> f64 {
    let robust = robust_scale(whitened);
    let limit = HUBER_THRESHOLD * robust;
    let (mut sum, mut n) = (0.0, 0.0);
    for w in whitened.iter().flatten() {
        sum += w.clamp(-limit, limit).powi(2);
        n += 1.0;
    }
    if sum > 0.0 { f64::sqrt(sum / n) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_act_on_the_parameters_they_name() {
        let population = OdeParameters::nominal();
        type Reading = fn(&OdeParameters) -> f64;
        let cases: [(Factor, Reading); FACTORS] = [
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
