//! Personal calibration: the plant's six most personal parameters by maximum a posteriori.
//!
//! Without it every person's own insulin action would count as a gap. Two searches over log factors on the
//! population parameters follow each other. The first looks for the best posterior on a few days, in which all
//! that a factor changes counts, the filter's own uncertainty included; it finds the neighbourhood. The
//! second solves an estimating equation on the whole record: innovations, prewhitened and weighted by Huber,
//! shall have no part along their derivatives ("signatures") with the filter's gains held. Innovations have mean
//! zero given the past whatever they are weighed with, so that its answer does not lean on the noise model; the
//! posterior would rather halve a person's meals than believe that they are counted well.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use ode_sim::{EgpMode, OdeParameters};
use physiology::{Plant as _, STEPS_PER_DAY};
use serde::{Deserialize, Serialize};

use crate::augmented::AugmentedModel;
use crate::error::GapError;
use crate::filter::{Filtered, Innovation, filter, innovations, replay};
use crate::noise::NoiseModel;
use crate::observations::{Observations, Reading};
use crate::tangent::{Direction, Lanes, Parameter, filtered_along};
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
            model: self.model.clone(),
            ..*self
        })
    }
}

/// The calibrated parameters, in the order of [`Factor::ALL`].
const PARAMETERS: [Parameter; FACTORS] = [
    Parameter::Action,
    Parameter::Egp0,
    Parameter::TMaxG,
    Parameter::TMaxI,
    Parameter::AG,
    Parameter::F01,
];
/// Spacing of the differences of the first search in log factors. Wide enough to average over the kinks of
/// uptake, renal clearance and production, across which gains jump; the curvature over it is allowed for.
const SPACING: f64 = 0.02;
/// Longest move of a log factor in one iteration.
const LONGEST_MOVE: f64 = 0.3;
/// Starting values tried for insulin action, and for how slow insulin and how fast and small meals are:
/// bodies with slow insulin and quick meals are told from their opposite by a distant optimum only.
const ACTION_STARTS: [f64; 5] = [-0.6, -0.3, 0.0, 0.3, 0.6];
const SPEED_STARTS: [f64; 2] = [0.0, 0.5];
/// Scored readings of the first search: three days.
const FIRST_READINGS: usize = 3 * STEPS_PER_DAY;
/// The step, in posterior standard deviations, and the iteration at which it ends.
const FIRST_TOLERANCE: f64 = 0.5;
const FIRST_ITERATIONS: usize = 10;
/// Shortest share of a step that is tried; what gains less lies between kinks.
const SHORTEST_SHARE: f64 = 0.1;
/// Steps longer than this, in posterior standard deviations, are checked against the loss with gains held.
const CHECKED_ABOVE: f64 = 2.0;
/// Earlier iterations that an extrapolation learns from.
const DEPTH: usize = 3;
/// Longest extrapolation, in steps.
const LONGEST_LEAP: f64 = 5.0;
/// How much a step may change between neighbouring factors because gains jump where a state crosses a kink
/// of the model, posterior standard deviations.
const JUMP: f64 = 0.1;

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
    let mut scored = record.trusted(rule.dose_memory);
    let burn_in = rule.burn_in.min(scored.len());
    scored[..burn_in].fill(false);
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

/// Factors near the best posterior of the first days, by Fisher's scoring.
fn near_posterior(setting: &Setting<'_>) -> Result<PersonalFactors, GapError> {
    let end = setting.steps_of(FIRST_READINGS);
    let mut factors = best_start(setting, end)?;
    let mut innovations = setting.innovations(&factors, end)?;
    for _ in 0..FIRST_ITERATIONS {
        let whitening = Whitening::fitted(&innovations);
        let scored = whitening.of(&innovations);
        let equations = NormalEquations::of_posterior(setting, &whitening, &scored, &factors)?;
        let step = equations.step(&factors, setting)?;
        if equations.length(&step) < FIRST_TOLERANCE {
            break;
        }
        let before = whitening.loss(&scored, &factors);
        let mut share = 1.0;
        let better = loop {
            let trial = moved(&factors, &step.map(|value| share * value), setting.bound);
            innovations = setting.innovations(&trial, end)?;
            if whitening.loss(&whitening.of(&innovations), &trial) < before {
                break Some(trial);
            }
            share *= 0.5;
            if share < SHORTEST_SHARE {
                break None;
            }
        };
        let Some(better) = better else { break };
        factors = better;
    }
    Ok(factors)
}

/// The start with the best posterior over the steps before `end`.
fn best_start(setting: &Setting<'_>, end: usize) -> Result<PersonalFactors, GapError> {
    let mut best = (f64::INFINITY, PersonalFactors::default());
    for (action, speed) in ACTION_STARTS.into_iter().flat_map(|a| SPEED_STARTS.map(|s| (a, s))) {
        let mut factors = PersonalFactors::default();
        factors.0[Factor::Action as usize] = action;
        factors.0[Factor::TMaxI as usize] = speed;
        factors.0[Factor::TMaxG as usize] = -speed;
        factors.0[Factor::AG as usize] = -speed;
        let mut loss = factors.prior_loss();
        for i in setting.innovations(&factors, end)?.iter().flatten() {
            loss += huber_loss(i.normalised(), 1.0) + 0.5 * i.variance.ln();
        }
        if loss < best.0 {
            best = (loss, factors);
        }
    }
    Ok(best.1)
}

/// A run of the filter over the whole record, its whitened innovations, and the derivatives of the innovations
/// by the factors.
struct Run {
    filtered: Filtered,
    whitening: Whitening,
    whitened: Vec<Option<f64>>,
    /// One row a step, the factors beside each other; mg/dL.
    signatures: Vec<Lanes>,
}

impl Run {
    /// `room` is forgotten and filled anew.
    fn at(
        setting: &Setting<'_>,
        factors: &PersonalFactors,
        room: Option<Self>,
    ) -> Result<Self, GapError> {
        let mut filtered = room
            .map_or_else(|| Filtered::with_capacity(setting.record.len()), |room| room.filtered);
        let mut signatures = Vec::new();
        let directions = PARAMETERS.map(Direction::Parameter);
        let model = setting.model(factors);
        filtered_along(&model, setting.record, &directions, &mut filtered, |_, rows| {
            signatures = rows;
        })?;
        let innovations: Vec<Option<Innovation>> = filtered
            .innovations
            .iter()
            .zip(&setting.scored)
            .map(|(innovation, scored)| innovation.filter(|_| *scored))
            .collect();
        let whitening = Whitening::fitted(&innovations);
        let whitened = whitening.autoregression.whitened(&normalised(&innovations));
        Ok(Self { filtered, whitening, whitened, signatures })
    }

    /// Whitened innovations of other factors with gains and whitening held.
    fn held_at(
        &self,
        setting: &Setting<'_>,
        factors: &PersonalFactors,
    ) -> Result<Vec<Option<f64>>, GapError> {
        let values = replay(&setting.model(factors), setting.record, &self.filtered)?;
        let z: Vec<_> = values
            .iter()
            .zip(&self.filtered.innovations)
            .zip(&setting.scored)
            .map(|((value, held), scored)| {
                let held = held.filter(|_| *scored)?;
                Some((*value)? / held.variance.sqrt())
            })
            .collect();
        Ok(self.whitening.autoregression.whitened(&z))
    }

    /// The loss whose derivative the estimating equation is, nats.
    fn loss(&self, whitened: &[Option<f64>], factors: &PersonalFactors) -> f64 {
        let scale = self.whitening.scale;
        let data: f64 = whitened.iter().flatten().map(|w| huber_loss(w / scale, 1.0)).sum();
        data + factors.prior_loss()
    }
}

/// Where the estimating equation is solved.
struct Solved {
    factors: PersonalFactors,
    run: Run,
    sd: Factors,
    iterations: usize,
    converged: bool,
}

/// Solves the estimating equation from `factors` on.
fn solved(
    setting: &Setting<'_>,
    mut factors: PersonalFactors,
    rule: &CalibrationRule,
) -> Result<Solved, GapError> {
    let mut path: Vec<(PersonalFactors, Factors)> = Vec::new();
    let mut nearest = (f64::INFINITY, factors);
    let mut iterations = 0;
    let mut room = None;
    loop {
        let run = Run::at(setting, &factors, room.take())?;
        let equations = NormalEquations::of_held_gains(&run, &factors);
        let step = equations.step(&factors, setting)?;
        let size = equations.length(&step);
        let converged = size < rule.tolerance;
        if converged || iterations > rule.max_iterations {
            let sd = equations.posterior_sd(setting)?;
            let iterations = iterations.min(rule.max_iterations);
            return Ok(Solved { factors, run, sd, iterations, converged });
        }
        if size < nearest.0 {
            nearest = (size, factors);
        }
        iterations += 1;
        if iterations > rule.max_iterations {
            // Where gains turn the equation about faster than factors approach its solution, there may be
            // none; the least step that was seen comes nearest.
            factors = nearest.1;
            room = Some(run);
            continue;
        }
        let mut share = 1.0;
        if size > CHECKED_ABOVE {
            let before = run.loss(&run.whitened, &factors);
            let worse = |share: f64| -> Result<bool, GapError> {
                let trial = moved(&factors, &step.map(|value| share * value), setting.bound);
                Ok(run.loss(&run.held_at(setting, &trial)?, &trial) >= before)
            };
            while share > SHORTEST_SHARE && worse(share)? {
                share *= 0.5;
            }
        }
        if share == 1.0 {
            path.push((factors, step));
            factors = extrapolated(&path, &equations, setting.bound);
        } else {
            path.clear();
            factors = moved(&factors, &step.map(|value| share * value), setting.bound);
        }
        room = Some(run);
    }
}

/// Anderson's extrapolation: gains and whitening are held within a step and change from one to the next, so
/// that steps shrink by much the same ratios along the same directions; the last few tell where they
/// lead. `path` holds the factors of each iteration and their steps and is not empty.
fn extrapolated(
    path: &[(PersonalFactors, Factors)],
    equations: &NormalEquations,
    bound: f64,
) -> PersonalFactors {
    let Some(((factors, step), earlier)) = path.split_last() else {
        return PersonalFactors::default();
    };
    let depth = earlier.len().min(DEPTH);
    let earlier = &earlier[earlier.len() - depth..];
    // Differences from the last iteration: of the steps, and of where they lead.
    let differences: Vec<(Factors, Factors)> = earlier
        .iter()
        .map(|(at, by)| {
            let change: Factors = std::array::from_fn(|k| step[k] - by[k]);
            (change, std::array::from_fn(|k| factors.0[k] - at.0[k] + change[k]))
        })
        .collect();
    let mut forward = *step;
    if depth > 0 {
        let gram = Mat::from_fn(depth, depth, |row, column| {
            let product = equations.product(&differences[row].0, &differences[column].0);
            // Steps jump by about this much where gains do; ratios of smaller changes tell nothing.
            if row == column { product + JUMP * JUMP } else { product }
        });
        let right = Mat::from_fn(depth, 1, |row, _| equations.product(&differences[row].0, step));
        if let Ok(factorised) = gram.llt(Side::Lower) {
            let weights = factorised.solve(&right);
            for (place, (_, led)) in differences.iter().enumerate() {
                for (value, led) in forward.iter_mut().zip(led) {
                    *value -= weights[(place, 0)] * led;
                }
            }
        }
    }
    // Steps that hardly shrink do not tell where they lead.
    let limit = LONGEST_LEAP * equations.length(step);
    let length = equations.length(&forward);
    if !length.is_finite() {
        forward = *step;
    } else if length > limit {
        forward = forward.map(|value| value * limit / length);
    }
    moved(factors, &forward, bound)
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

/// Curvature (6, 6) and gradient (6) of a loss at one set of factors, the prior's included.
struct NormalEquations {
    curvature: [[f64; FACTORS]; FACTORS],
    gradient: Factors,
}

impl NormalEquations {
    /// Of the posterior, by differences.
    fn of_posterior(
        setting: &Setting<'_>,
        whitening: &Whitening,
        scored: &Scored,
        factors: &PersonalFactors,
    ) -> Result<Self, GapError> {
        let loss = whitening.loss(scored, factors);
        // Towards the prior's mean, so that the difference never leaves the bounds.
        let spacings = factors.0.map(|value| if value > 0.0 { -SPACING } else { SPACING });
        let mut gradient = [0.0; FACTORS];
        let mut slopes = vec![[[0.0; 2]; FACTORS]; scored.len()];
        for (place, spacing) in spacings.into_iter().enumerate() {
            let mut neighbour = *factors;
            neighbour.0[place] += spacing;
            let moved = whitening.of(&setting.innovations(&neighbour, scored.len())?);
            gradient[place] = (whitening.loss(&moved, &neighbour) - loss) / spacing;
            for ((slopes, after), before) in slopes.iter_mut().zip(&moved).zip(scored) {
                if let Some((after, before)) = after.zip(*before) {
                    slopes[place] =
                        [(after.0 - before.0) / spacing, (after.1 - before.1) / spacing];
                }
            }
        }
        let mut curvature = [[0.0; FACTORS]; FACTORS];
        let inverse = whitening.scale.powi(-2);
        for (slopes, scored) in slopes.iter().zip(scored) {
            let Some((w, _)) = scored else { continue };
            let weight = huber_weight(*w, whitening.scale) * inverse;
            for row in 0..FACTORS {
                let [value, variance] = slopes[row];
                let (value, variance) = (weight * value, 0.5 * variance);
                for (entry, other) in curvature[row].iter_mut().zip(slopes) {
                    *entry += value * other[0] + variance * other[1];
                }
            }
        }
        for (place, factor) in Factor::ALL.into_iter().enumerate() {
            curvature[place][place] += factor.prior_sd().powi(-2);
            // The difference is the slope halfway to the neighbour.
            gradient[place] -= 0.5 * spacings[place] * curvature[place][place];
        }
        Ok(Self { curvature, gradient })
    }

    /// Of the estimating equation at a run of the filter.
    fn of_held_gains(run: &Run, factors: &PersonalFactors) -> Self {
        let Autoregression { a1, a2, spacing } = run.whitening.autoregression;
        // Signatures in the units of the innovations they are whitened with, factors beside each other.
        let normalised: Vec<Factors> = run
            .filtered
            .innovations
            .iter()
            .zip(&run.signatures)
            .map(|(innovation, signature)| {
                let inverse = innovation.map_or(0.0, |i| i.variance.sqrt().recip());
                std::array::from_fn(|k| inverse * f64::from(signature[k]))
            })
            .collect();
        let (mut curvature, mut gradient) = ([[0.0; FACTORS]; FACTORS], [0.0; FACTORS]);
        let inverse = run.whitening.scale.powi(-2);
        for (step, w) in run.whitened.iter().enumerate() {
            // What is whitened has both of the entries before it.
            let Some(w) = w else { continue };
            let weight = huber_weight(*w, run.whitening.scale) * inverse;
            let (now, before) = (&normalised[step], &normalised[step - spacing]);
            let earlier = &normalised[step - 2 * spacing];
            let signature: Factors =
                std::array::from_fn(|k| now[k] - a1 * before[k] - a2 * earlier[k]);
            for row in 0..FACTORS {
                let weighted = weight * signature[row];
                gradient[row] += weighted * w;
                for (entry, value) in curvature[row].iter_mut().zip(signature) {
                    *entry += weighted * value;
                }
            }
        }
        for (place, factor) in Factor::ALL.into_iter().enumerate() {
            let precision = factor.prior_sd().powi(-2);
            curvature[place][place] += precision;
            gradient[place] += precision * factors.0[place];
        }
        Self { curvature, gradient }
    }

    /// The step that solves the equations.
    fn step(&self, factors: &PersonalFactors, setting: &Setting<'_>) -> Result<Factors, GapError> {
        let bound = setting.bound;
        // A factor at its bound that the gradient pushes outwards stays there.
        let held: [bool; FACTORS] = std::array::from_fn(|k| {
            factors.0[k].abs() >= bound && -self.gradient[k] * factors.0[k] > 0.0
        });
        let matrix = Mat::from_fn(FACTORS, FACTORS, |row, column| {
            let apart = row != column && (held[row] || held[column]);
            if apart { 0.0 } else { self.curvature[row][column] }
        });
        let right =
            Mat::from_fn(FACTORS, 1, |row, _| if held[row] { 0.0 } else { -self.gradient[row] });
        let singular = || GapError::Singular { person: setting.record.person.clone() };
        let solution = matrix.llt(Side::Lower).map_err(|_| singular())?.solve(&right);
        // No further than the bound, so that what leads beyond it does not count as a way to go.
        let step: Factors = std::array::from_fn(|k| {
            let step = solution[(k, 0)].clamp(-LONGEST_MOVE, LONGEST_MOVE);
            (factors.0[k] + step).clamp(-bound, bound) - factors.0[k]
        });
        if step.iter().any(|v| !v.is_finite()) { Err(singular()) } else { Ok(step) }
    }

    /// Product of two moves, each in posterior standard deviations.
    fn product(&self, a: &Factors, b: &Factors) -> f64 {
        let along = |row: &Factors| row.iter().zip(b).map(|(c, b)| c * b).sum::<f64>();
        self.curvature.iter().zip(a).map(|(row, a)| a * along(row)).sum()
    }

    /// Length of a move, posterior standard deviations: no factor moves by more of its own.
    fn length(&self, step: &Factors) -> f64 {
        self.product(step, step).sqrt()
    }

    fn posterior_sd(&self, setting: &Setting<'_>) -> Result<Factors, GapError> {
        let matrix = Mat::from_fn(FACTORS, FACTORS, |row, column| self.curvature[row][column]);
        let inverse = matrix
            .llt(Side::Lower)
            .map_err(|_| GapError::Singular { person: setting.record.person.clone() })?
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
