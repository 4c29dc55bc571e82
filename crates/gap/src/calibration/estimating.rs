//! The second search: the solution of the estimating equation on the whole record.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use super::equations::NormalEquations;
use super::{
    CalibrationRule, FACTORS, Factor, Factors, PersonalFactors, SHORTEST_SHARE, Setting, Whitening,
    moved, normalised,
};
use crate::error::GapError;
use crate::filter::{Filtered, Innovation, replay};
use crate::tangent::{Direction, Lanes, Parameter, filtered_along};
use crate::whitening::{Autoregression, huber_loss, huber_weight};

/// The calibrated parameters, in the order of [`Factor::ALL`].
const PARAMETERS: [Parameter; FACTORS] = [
    Parameter::Action,
    Parameter::Egp0,
    Parameter::TMaxG,
    Parameter::TMaxI,
    Parameter::AG,
    Parameter::F01,
];
/// Steps longer than this, in posterior standard deviations, are checked against the loss with gains held.
const CHECKED_ABOVE: f64 = 2.0;
/// Earlier iterations that an extrapolation learns from.
const DEPTH: usize = 3;
/// Longest extrapolation, in steps.
const LONGEST_LEAP: f64 = 5.0;
/// How much a step may change between neighbouring factors because gains jump where a state crosses a kink
/// of the model, posterior standard deviations.
const JUMP: f64 = 0.1;

/// A run of the filter over the whole record, its whitened innovations, and the derivatives of the innovations
/// by the factors.
pub(super) struct Run {
    pub(super) filtered: Filtered,
    pub(super) whitening: Whitening,
    pub(super) whitened: Vec<Option<f64>>,
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
pub(super) struct Solved {
    pub(super) factors: PersonalFactors,
    pub(super) run: Run,
    pub(super) sd: Factors,
    pub(super) iterations: usize,
    pub(super) converged: bool,
}

/// Solves the estimating equation from `factors` on.
pub(super) fn solved(
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

impl NormalEquations {
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
}
