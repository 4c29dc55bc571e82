//! The steady state at a given glucose: basal rate and states at which nothing changes.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use physiology::{Compartment, Grams, MgPerDl, STEP, UnitsPerHour};

use crate::error::ModelError;
use crate::population::PopulationModel;
use crate::scaler::{ScaledInputs, ScaledStates};
use crate::signal::Signal;

/// Number of equations (ten rates) and of unknowns (nine states and the basal rate).
const SIZE: usize = 10;
/// Rates below this count as standing still, scaled units per minute: some thousand roundings of
/// sums over a few hundred units of order one.
const STANDING_STILL: f64 = 1e-11;
/// Basal rates from which a search starts, U/h: those of therapy, several to a decade.
const STARTING_BASALS: [f64; 9] = [0.0, 0.3, 0.6, 0.9, 1.2, 1.6, 2.2, 3.0, 5.0];
/// The highest basal rate that counts as physical, U/h: above what pumps deliver to adults.
const HIGHEST_BASAL: f64 = 10.0;
/// Iterations after which a search is given up; a piecewise linear problem needs few.
const MOST_ITERATIONS: usize = 200;

/// A state at which the model stands still, or the nearest there is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SteadyState {
    /// The states; Q1 is the glucose that was asked for.
    pub states: ScaledStates,
    /// The basal insulin rate that holds them, without carbohydrate.
    pub basal: UnitsPerHour,
    /// The largest rate of change left, scaled units per minute.
    pub residual: f64,
    /// Whether it is one.
    pub outcome: SteadyStateOutcome,
    /// Whether the other states return to it after a small disturbance while glucose and basal are
    /// held: every eigenvalue of the Euler step lies within the unit circle.
    pub attracting: bool,
}

/// What a search for a steady state came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SteadyStateOutcome {
    /// Every rate vanishes to rounding, with a basal rate from 0 to 10 U/h and no state below
    /// zero in physical units.
    Found,
    /// Every rate vanishes to rounding, but only with a negative or absurd basal rate or a
    /// negative state.
    OutsidePhysicalRange,
    /// No search reached vanishing rates; the states are those with the smallest residual.
    NotFound,
}

/// Solves `dx = 0` at the given glucose with no carbohydrate, for the basal rate and the nine
/// other states (paper, section "Estimating initial states").
///
/// Newton's method with halved steps, and Levenberg-Marquardt steps where those do not help, in
/// f64 with exact slopes, from several basal rates; each start first lets the states settle at its
/// basal rate with glucose held. Of several steady states (the published weights have up to five for
/// one basal rate) an attracting one is preferred, then the one whose basal rate is nearest to the
/// centre of the scaler. Sure to end, not sure to find: the networks are piecewise
/// linear and need not have a root.
///
/// # Errors
/// [`ModelError::Glucose`] if `glucose` is not a positive finite number.
pub fn steady_state(model: &PopulationModel, glucose: MgPerDl) -> Result<SteadyState, ModelError> {
    if !glucose.0.is_finite() || glucose.0 <= 0.0 {
        return Err(ModelError::Glucose(glucose));
    }
    let q1 = model.scaler().of(Signal::State(Compartment::Q1));
    let carbs = model.scaler().scale_carbs(Grams(0.0));
    let problem = Problem { model, q1: q1.scale(glucose.0), carbs };
    let mut best: Option<SteadyState> = None;
    for basal in STARTING_BASALS {
        let insulin = model.scaler().scale_insulin(UnitsPerHour(basal));
        for start in [problem.settled(insulin), problem.centred(insulin)] {
            let candidate = problem.classify(&problem.search(start));
            if best.as_ref().is_none_or(|best| problem.prefers(&candidate, best)) {
                best = Some(candidate);
            }
        }
    }
    Ok(best.expect("there is at least one start"))
}

struct Problem<'a> {
    model: &'a PopulationModel,
    /// Glucose, scaled.
    q1: f64,
    /// No carbohydrate, scaled.
    carbs: f64,
}

/// The unknowns: one for each compartment, with the insulin rate in the place of Q1.
type Unknowns = [f64; SIZE];

impl Problem<'_> {
    fn unpack(&self, z: &Unknowns) -> (ScaledStates, ScaledInputs) {
        let mut x = ScaledStates::default();
        for (compartment, value) in Compartment::ALL.into_iter().zip(z) {
            x[compartment] = if compartment == Compartment::Q1 { self.q1 } else { *value };
        }
        (x, ScaledInputs { insulin: z[Compartment::Q1 as usize], carbs: self.carbs })
    }

    /// The states after two days at one insulin rate, glucose held.
    fn settled(&self, insulin: f64) -> Unknowns {
        let mut z = self.centred(insulin);
        for _ in 0..576 {
            let (x, u) = self.unpack(&z);
            let rates = self.model.derivative(&x, u);
            for (compartment, slot) in Compartment::ALL.into_iter().zip(&mut z) {
                if compartment != Compartment::Q1 {
                    *slot = (*slot + STEP.0 * rates[compartment]).clamp(-1e3, 1e3);
                }
            }
        }
        z
    }

    /// Every state at the centre of the scaler.
    fn centred(&self, insulin: f64) -> Unknowns {
        let mut z = [0.0; SIZE];
        z[Compartment::Q1 as usize] = insulin;
        z
    }

    fn residuals(&self, z: &Unknowns) -> Unknowns {
        let (x, u) = self.unpack(z);
        Compartment::ALL.map(|compartment| self.model.rate(compartment, &x, u))
    }

    /// Entry (i, j): slope of rate i with respect to unknown j.
    fn jacobian(&self, z: &Unknowns) -> Mat<f64> {
        let (x, u) = self.unpack(z);
        let mut jacobian = Mat::zeros(SIZE, SIZE);
        for (row, compartment) in Compartment::ALL.into_iter().enumerate() {
            let seen = self.model.seen_by(compartment, &x, u);
            let mut gradient = vec![0.0; seen.len()];
            self.model.network(compartment).add_gradient(&seen, 1.0, &mut gradient);
            for (signal, slope) in self.model.wiring().inputs(compartment).iter().zip(gradient) {
                match signal {
                    Signal::State(Compartment::Q1) | Signal::Carbs => {}
                    Signal::State(state) => jacobian[(row, *state as usize)] = slope,
                    Signal::Insulin => jacobian[(row, Compartment::Q1 as usize)] = slope,
                }
            }
        }
        jacobian
    }

    fn search(&self, mut z: Unknowns) -> Unknowns {
        let mut residuals = self.residuals(&z);
        for _ in 0..MOST_ITERATIONS {
            if largest(&residuals) == 0.0 {
                break;
            }
            let jacobian = self.jacobian(&z);
            let right = Mat::from_fn(SIZE, 1, |i, _| -residuals[i]);
            let newton = jacobian.partial_piv_lu().solve(&right);
            let halved = (0..8).map(|k| scaled(&newton, 0.5_f64.powi(k)));
            let normal = jacobian.transpose() * &jacobian;
            let gradient = jacobian.transpose() * &right;
            let damped = (0..14).filter_map(|k| {
                let damping = 1e-9 * 10_f64.powi(k);
                let matrix = &normal + damping * Mat::<f64>::identity(SIZE, SIZE);
                matrix.llt(Side::Lower).ok().map(|factor| scaled(&factor.solve(&gradient), 1.0))
            });
            let better = halved.chain(damped).find_map(|step| {
                let trial: Unknowns = std::array::from_fn(|i| z[i] + step[i]);
                let left = self.residuals(&trial);
                (sum_of_squares(&left) < sum_of_squares(&residuals)).then_some((trial, left))
            });
            let Some((trial, left)) = better else { break };
            (z, residuals) = (trial, left);
        }
        z
    }

    fn classify(&self, z: &Unknowns) -> SteadyState {
        let (states, u) = self.unpack(z);
        let residual = largest(&self.residuals(z));
        let basal = self.model.scaler().unscale_insulin(u.insulin);
        // Small negative values are the networks' rounding of zero, below 1 % of a scale.
        let physical = self.model.scaler().unscale(&states);
        let negative = physical.iter().any(|(compartment, value)| {
            value < -0.01 * self.model.scaler().of(Signal::State(compartment)).scale
        });
        let outcome = if residual > STANDING_STILL || residual.is_nan() {
            SteadyStateOutcome::NotFound
        } else if negative || basal.0 < 0.0 || basal.0 > HIGHEST_BASAL {
            SteadyStateOutcome::OutsidePhysicalRange
        } else {
            SteadyStateOutcome::Found
        };
        SteadyState { states, basal, residual, outcome, attracting: self.attracts(z) }
    }

    /// Whether an Euler step with glucose and insulin held contracts around `z`.
    fn attracts(&self, z: &Unknowns) -> bool {
        let jacobian = self.jacobian(z);
        let held = Compartment::Q1 as usize;
        let place = |i: usize| if i < held { i } else { i + 1 };
        let step = Mat::from_fn(SIZE - 1, SIZE - 1, |i, j| {
            STEP.0 * jacobian[(place(i), place(j))] + if i == j { 1.0 } else { 0.0 }
        });
        step.eigenvalues().is_ok_and(|values| values.iter().all(|value| value.norm() < 1.0))
    }

    /// Whether `a` is a better answer than `b`.
    fn prefers(&self, a: &SteadyState, b: &SteadyState) -> bool {
        let rank = |s: &SteadyState| match s.outcome {
            SteadyStateOutcome::Found => 0,
            SteadyStateOutcome::OutsidePhysicalRange => 1,
            SteadyStateOutcome::NotFound => 2,
        };
        let far = |s: &SteadyState| match s.outcome {
            SteadyStateOutcome::NotFound => s.residual,
            _ => self.model.scaler().scale_insulin(s.basal).abs(),
        };
        let repelling =
            |s: &SteadyState| s.outcome != SteadyStateOutcome::NotFound && !s.attracting;
        (rank(a), repelling(a), far(a)) < (rank(b), repelling(b), far(b))
    }
}

fn scaled(step: &Mat<f64>, factor: f64) -> Unknowns {
    std::array::from_fn(|i| factor * step[(i, 0)])
}

/// The largest magnitude, or NaN if one is NaN.
fn largest(values: &Unknowns) -> f64 {
    values.iter().fold(0.0, |most, v| if v.abs() > most || v.is_nan() { v.abs() } else { most })
}

fn sum_of_squares(values: &Unknowns) -> f64 {
    values.iter().map(|value| value * value).sum()
}
