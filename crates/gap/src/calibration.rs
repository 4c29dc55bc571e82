//! Personal calibration: the plant's six most personal parameters by maximum a posteriori.
//!
//! Without it every person's own insulin action would count as a gap. The innovations of the filter
//! are prewhitened, weighted by Huber, and made small by a Levenberg-Marquardt iteration over log
//! factors on the population parameters. Their derivatives ("signatures") are finite differences
//! through the same filter with its gains frozen.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use ode_sim::{EgpMode, OdeParameters};
use physiology::Plant as _;
use serde::{Deserialize, Serialize};

use crate::augmented::AugmentedModel;
use crate::error::GapError;
use crate::filter::{Filtered, filter, replay};
use crate::noise::NoiseModel;
use crate::observations::Observations;
use crate::whitening::{Autoregression, HUBER_THRESHOLD, huber_loss, huber_weight, robust_scale};

/// A parameter that is calibrated to a person.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Factor {
    /// The three insulin sensitivities together.
    Action,
    /// Endogenous glucose production at zero insulin.
    Egp0,
    /// Time to the maximal appearance of meal glucose.
    TMaxG,
    /// Time to the maximal insulin absorption.
    TMaxI,
    /// Carbohydrate bioavailability.
    AG,
    /// Non-insulin-mediated uptake.
    F01,
}

/// Number of calibrated parameters.
pub const FACTORS: usize = 6;

impl Factor {
    /// Every factor, in the order of [`PersonalFactors`].
    pub const ALL: [Self; FACTORS] =
        [Self::Action, Self::Egp0, Self::TMaxG, Self::TMaxI, Self::AG, Self::F01];

    /// Standard deviation of the prior of the factor's logarithm; its mean is 0.
    #[must_use]
    pub const fn prior_sd(self) -> f64 {
        match self {
            Self::Action => 0.3,
            Self::Egp0 | Self::F01 => 0.15,
            Self::TMaxG => 0.25,
            Self::TMaxI | Self::AG => 0.2,
        }
    }
}

/// Logarithms of a person's factors on the population parameters, in the order of [`Factor::ALL`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PersonalFactors(pub [f64; FACTORS]);

impl PersonalFactors {
    /// The person's parameters.
    #[must_use]
    pub fn applied_to(&self, population: &OdeParameters) -> OdeParameters {
        let [action, egp_0, t_max_g, t_max_i, a_g, f_01] = self.0.map(f64::exp);
        let p = population.with_sensitivity_scaled(action);
        OdeParameters {
            egp_0: p.egp_0 * egp_0,
            t_max_g: p.t_max_g * t_max_g,
            t_max_i: p.t_max_i * t_max_i,
            a_g: p.a_g * a_g,
            f_01: p.f_01 * f_01,
            ..p
        }
    }

    /// The logarithm of one factor.
    #[must_use]
    pub fn get(&self, factor: Factor) -> f64 {
        self.0[factor as usize]
    }

    /// Half the squared distance from the prior's mean, in nats.
    fn prior_loss(&self) -> f64 {
        self.0.iter().zip(Factor::ALL).map(|(v, f)| 0.5 * (v / f.prior_sd()).powi(2)).sum()
    }
}

/// How a calibration is run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CalibrationRule {
    /// Steps at the start of the record whose innovations are not scored.
    pub burn_in: usize,
    /// Steps after an unrecorded dose whose innovations are not scored.
    pub dose_memory: usize,
    /// Iterations after which the calibration gives up and says so.
    pub max_iterations: usize,
    /// The iteration ends when no log factor moves by more than this many prior standard deviations.
    pub tolerance: f64,
    /// Log factors are kept within plus and minus this.
    pub bound: f64,
}

impl CalibrationRule {
    /// The values in use: 12 h of burn-in, 4 h of dose memory, 30 iterations, a two-hundredth of a
    /// prior standard deviation (the posterior's is no less than a tenth), factors within exp(-0.9) to exp(0.9).
    #[must_use]
    pub const fn working() -> Self {
        Self { burn_in: 144, dose_memory: 48, max_iterations: 30, tolerance: 5e-3, bound: 0.9 }
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
        let mut scored = record.trusted(rule.dose_memory);
        let burn_in = rule.burn_in.min(scored.len());
        scored[..burn_in].fill(false);
        let filtered = filter(&self.model, record)?;
        let z: Vec<Option<f64>> = filtered
            .innovations
            .iter()
            .zip(&scored)
            .map(|(i, scored)| i.filter(|_| *scored).map(|i| i.normalised()))
            .collect();
        let autoregression = Autoregression::fitted(&z);
        let whitened = autoregression.whitened(&z);
        let scale = clipped_scale(&whitened);
        Ok(Self {
            filtered,
            autoregression,
            whitened: whitened.iter().map(|w| w.map(|w| w / scale)).collect(),
            scale,
            at_bound: self.at_bound.clone(),
            ..*self
        })
    }
}

/// Spacing of the differences in log factors. Wide enough to average over the kinks of uptake, renal
/// clearance and production, which would otherwise make the iteration wander; the estimate needs no
/// exact derivative, because innovations have mean zero given the past whatever they are weighed with.
const SPACING: f64 = 0.02;
/// Longest move of a log factor in one iteration.
const LONGEST_MOVE: f64 = 0.3;
/// Starting values tried for insulin action, the only factor with distant local optima.
const ACTION_STARTS: [f64; 5] = [-0.6, -0.3, 0.0, 0.3, 0.6];
/// Steps shorter than this, in prior standard deviations, are extrapolated.
const EXTRAPOLATED_BELOW: f64 = 0.3;
/// Smallest damping other than none.
const LEAST_DAMPING: f64 = 1e-2;

/// What does not change during one person's calibration.
struct Setting<'a> {
    population: &'a OdeParameters,
    egp: EgpMode,
    noise: &'a NoiseModel,
    record: &'a Observations,
    scored: Vec<bool>,
}

impl Setting<'_> {
    fn model(&self, factors: &PersonalFactors) -> AugmentedModel {
        let parameters = factors.applied_to(self.population);
        AugmentedModel::new(parameters, self.record.weight, self.egp, *self.noise)
    }

    fn run(&self, factors: &PersonalFactors) -> Result<Filtered, GapError> {
        filter(&self.model(factors), self.record)
    }

    /// Normalised innovations of a run, where they are scored.
    fn normalised(&self, run: &Filtered) -> Vec<Option<f64>> {
        let scored = self.scored.iter();
        run.innovations
            .iter()
            .zip(scored)
            .map(|(i, s)| i.filter(|_| *s).map(|i| i.normalised()))
            .collect()
    }
}

/// What is held while one step of the calibration is taken.
struct Frozen {
    run: Filtered,
    autoregression: Autoregression,
    scale: f64,
}

impl Frozen {
    fn new(setting: &Setting<'_>, run: Filtered) -> (Self, Vec<Option<f64>>) {
        let z = setting.normalised(&run);
        let autoregression = Autoregression::fitted(&z);
        let whitened = autoregression.whitened(&z);
        // Readings smoother than the noise model (interpolated ones) are not trusted more for that.
        let scale = clipped_scale(&whitened).max(1.0);
        (Self { run, autoregression, scale }, whitened)
    }

    /// Whitened innovations of other factors through the frozen filter.
    fn whitened(
        &self,
        setting: &Setting<'_>,
        factors: &PersonalFactors,
    ) -> Result<Vec<Option<f64>>, GapError> {
        let innovations = replay(&setting.model(factors), setting.record, &self.run)?;
        let z: Vec<_> = innovations
            .iter()
            .zip(&self.run.innovations)
            .zip(&setting.scored)
            .map(|((value, frozen), scored)| {
                let frozen = (*frozen).filter(|_| *scored)?;
                Some((*value)? / frozen.variance.sqrt())
            })
            .collect();
        Ok(self.autoregression.whitened(&z))
    }

    /// Negative log posterior up to a constant, nats.
    fn loss(&self, whitened: &[Option<f64>], factors: &PersonalFactors) -> f64 {
        let data: f64 = whitened.iter().flatten().map(|w| huber_loss(w / self.scale, 1.0)).sum();
        data + factors.prior_loss()
    }
}

/// Calibrates a person. See the module for the method.
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
    let mut scored = record.trusted(rule.dose_memory);
    let burn_in = rule.burn_in.min(scored.len());
    scored[..burn_in].fill(false);
    let setting = Setting { population, egp, noise, record, scored };

    let mut factors = best_start(&setting)?;
    let mut damping = 0.0;
    let mut before_last = None;
    let (mut converged, mut stalled, mut iterations) = (false, false, 0);
    let (frozen, whitened, sd) = loop {
        let (frozen, whitened) = Frozen::new(&setting, setting.run(&factors)?);
        let equations = NormalEquations::of(&setting, &frozen, &whitened, &factors)?;
        if converged || stalled || iterations == rule.max_iterations {
            let sd = equations.posterior_sd(record)?;
            break (frozen, whitened, sd);
        }
        iterations += 1;
        let before = frozen.loss(&whitened, &factors);
        let mut trial = equations.step(&factors, damping, rule.bound, record)?;
        let mut size = distance(&trial, &factors);
        // A move below the tolerance ends the search whether or not rounding lets it improve.
        while size >= rule.tolerance
            && frozen.loss(&frozen.whitened(&setting, &trial)?, &trial) >= before
        {
            damping = if damping == 0.0 { LEAST_DAMPING } else { 10.0 * damping };
            trial = equations.step(&factors, damping, rule.bound, record)?;
            size = distance(&trial, &factors);
        }
        let step = difference(&trial, &factors);
        let plain = damping == 0.0 && size < EXTRAPOLATED_BELOW;
        let next = match before_last.filter(|_| plain) {
            Some(last) => extrapolated(&factors, &step, &last, rule.bound),
            None => trial,
        };
        before_last = plain.then_some((factors, step));
        factors = next;
        converged = size < rule.tolerance && damping <= 1.0;
        stalled = size < rule.tolerance && !converged;
        damping = if damping <= LEAST_DAMPING { 0.0 } else { damping / 10.0 };
    };
    let scale = clipped_scale(&whitened);
    let at_bound =
        Factor::ALL.into_iter().filter(|f| factors.get(*f).abs() >= rule.bound).collect();
    Ok(Calibration {
        factors,
        sd,
        model: setting.model(&factors),
        autoregression: frozen.autoregression,
        whitened: whitened.iter().map(|w| w.map(|w| w / scale)).collect(),
        scale,
        filtered: frozen.run,
        iterations,
        converged,
        at_bound,
    })
}

/// The starting value of insulin action with the best posterior, the other factors at their priors.
fn best_start(setting: &Setting<'_>) -> Result<PersonalFactors, GapError> {
    let mut best = (f64::INFINITY, PersonalFactors::default());
    for action in ACTION_STARTS {
        let mut factors = PersonalFactors::default();
        factors.0[Factor::Action as usize] = action;
        let run = setting.run(&factors)?;
        let mut loss = factors.prior_loss();
        for (innovation, scored) in run.innovations.iter().zip(&setting.scored) {
            if let Some(i) = innovation.filter(|_| *scored) {
                loss += huber_loss(i.normalised(), 1.0) + 0.5 * i.variance.ln();
            }
        }
        if loss < best.0 {
            best = (loss, factors);
        }
    }
    Ok(best.1)
}

/// `a - b`, each in prior standard deviations.
fn difference(a: &PersonalFactors, b: &PersonalFactors) -> [f64; FACTORS] {
    std::array::from_fn(|k| (a.0[k] - b.0[k]) / Factor::ALL[k].prior_sd())
}

/// Anderson's extrapolation of depth one: gains and whitening are frozen within a step, so that steps
/// shrink by a constant ratio; two of them tell where they lead.
fn extrapolated(
    factors: &PersonalFactors,
    step: &[f64; FACTORS],
    (last_factors, last_step): &(PersonalFactors, [f64; FACTORS]),
    bound: f64,
) -> PersonalFactors {
    let moved = difference(factors, last_factors);
    let change: [f64; FACTORS] = std::array::from_fn(|k| step[k] - last_step[k]);
    let dot = |a: &[f64; FACTORS], b: &[f64; FACTORS]| -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    };
    let size = dot(&change, &change);
    // A ratio beyond four would mean that steps hardly shrink, and extrapolation is not to be trusted.
    let ratio = if size > 0.0 { (dot(step, &change) / size).clamp(-4.0, 4.0) } else { 0.0 };
    PersonalFactors(std::array::from_fn(|k| {
        let forward = step[k] - ratio * (moved[k] + change[k]);
        (factors.0[k] + Factor::ALL[k].prior_sd() * forward).clamp(-bound, bound)
    }))
}

/// Largest difference of two sets of factors, prior standard deviations.
fn distance(a: &PersonalFactors, b: &PersonalFactors) -> f64 {
    difference(a, b).into_iter().map(f64::abs).fold(0.0, f64::max)
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

/// Gauss-Newton normal equations at one set of factors: curvature (6, 6) and gradient (6).
struct NormalEquations {
    curvature: [[f64; FACTORS]; FACTORS],
    gradient: [f64; FACTORS],
}

impl NormalEquations {
    fn of(
        setting: &Setting<'_>,
        frozen: &Frozen,
        whitened: &[Option<f64>],
        factors: &PersonalFactors,
    ) -> Result<Self, GapError> {
        let mut signatures = Vec::with_capacity(FACTORS);
        for place in 0..FACTORS {
            // Towards the prior's mean, so that the difference never leaves the bounds.
            let spacing = if factors.0[place] > 0.0 { -SPACING } else { SPACING };
            let mut neighbour = *factors;
            neighbour.0[place] += spacing;
            let moved = frozen.whitened(setting, &neighbour)?;
            signatures.push(
                moved
                    .iter()
                    .zip(whitened)
                    .map(|(a, b)| a.zip(*b).map_or(0.0, |(a, b)| (a - b) / spacing))
                    .collect::<Vec<f64>>(),
            );
        }
        let mut curvature = [[0.0; FACTORS]; FACTORS];
        let mut gradient = [0.0; FACTORS];
        let inverse = frozen.scale.powi(-2);
        for (step, w) in whitened.iter().enumerate() {
            let Some(w) = w else { continue };
            let weight = huber_weight(*w, frozen.scale) * inverse;
            for row in 0..FACTORS {
                let weighted = weight * signatures[row][step];
                gradient[row] += weighted * w;
                for (entry, signature) in curvature[row].iter_mut().zip(&signatures).take(row + 1) {
                    *entry += weighted * signature[step];
                }
            }
        }
        for (place, factor) in Factor::ALL.into_iter().enumerate() {
            let precision = factor.prior_sd().powi(-2);
            curvature[place][place] += precision;
            gradient[place] += precision * factors.0[place];
        }
        // Only the lower triangle was summed.
        for row in 1..FACTORS {
            let (upper, lower) = curvature.split_at_mut(row);
            for (above, below) in upper.iter_mut().zip(&lower[0]) {
                above[row] = *below;
            }
        }
        Ok(Self { curvature, gradient })
    }

    /// The factors after one step damped by `damping` times the curvature's diagonal.
    fn step(
        &self,
        factors: &PersonalFactors,
        damping: f64,
        bound: f64,
        record: &Observations,
    ) -> Result<PersonalFactors, GapError> {
        // A factor at its bound that the gradient pushes outwards stays there.
        let held: [bool; FACTORS] = std::array::from_fn(|k| {
            factors.0[k].abs() >= bound && -self.gradient[k] * factors.0[k] > 0.0
        });
        let matrix = Mat::from_fn(FACTORS, FACTORS, |row, column| match row == column {
            true => self.curvature[row][column] * (1.0 + damping),
            false if held[row] || held[column] => 0.0,
            false => self.curvature[row][column],
        });
        let right =
            Mat::from_fn(FACTORS, 1, |row, _| if held[row] { 0.0 } else { -self.gradient[row] });
        let singular = || GapError::Singular { person: record.person.clone() };
        let solution = matrix.llt(Side::Lower).map_err(|_| singular())?.solve(&right);
        let moved = std::array::from_fn(|k| {
            let step = solution[(k, 0)].clamp(-LONGEST_MOVE, LONGEST_MOVE);
            (factors.0[k] + step).clamp(-bound, bound)
        });
        if moved.iter().any(|v: &f64| !v.is_finite()) {
            return Err(singular());
        }
        Ok(PersonalFactors(moved))
    }

    fn posterior_sd(&self, record: &Observations) -> Result<[f64; FACTORS], GapError> {
        let matrix = Mat::from_fn(FACTORS, FACTORS, |row, column| self.curvature[row][column]);
        let inverse = matrix
            .llt(Side::Lower)
            .map_err(|_| GapError::Singular { person: record.person.clone() })?
            .solve(&Mat::<f64>::identity(FACTORS, FACTORS));
        Ok(std::array::from_fn(|k| inverse[(k, k)].sqrt()))
    }
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
