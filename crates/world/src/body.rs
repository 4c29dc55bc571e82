//! A simulated body of any kind at one-minute resolution, with the effects that act on it.

mod compartments;
mod model;
mod parameters;
mod steady_state;

use ode_sim::OdeError;
use physiology::{Compartment, MgPerDl, NonFinite, Plant, STEP, States, StepInput, UnitsPerHour};

use crate::effects::{Amplitudes, Condition, LowTrace};
use crate::warp::{RESTING_GLUCOSE, Warped, Warps};

pub use compartments::Compartments;
pub use model::BodyModel;

pub(crate) use compartments::compartments;
pub(crate) use parameters::{Spread, draw, parameters};
pub(crate) use steady_state::{balancing_insulin, falling, require_possible};

/// Runge-Kutta steps within the five minutes: one per minute.
pub(crate) const SUBSTEPS: u32 = 5;
/// Length of such a step, min.
pub(crate) const SUBSTEP: f64 = STEP.0 / SUBSTEPS as f64;

/// A body whose parameters change from step to step.
///
/// The step is part of the state, so [`physiology::simulate`] drives it like any other plant.
#[derive(Debug, Clone)]
pub struct Body<'a, M> {
    model: M,
    conditions: &'a [Condition],
    amplitudes: Amplitudes,
    warped: Option<Warped>,
}

/// State of a [`Body`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyState<S> {
    /// State of its model.
    pub model: S,
    /// How far a low has activated counter-regulation.
    pub low: LowTrace,
    /// Steps done.
    pub step: usize,
}

impl<'a, M: BodyModel> Body<'a, M> {
    /// A body under the course of `conditions`, one per step. After their end the body is as drawn.
    #[must_use]
    pub const fn new(model: M, conditions: &'a [Condition], amplitudes: Amplitudes) -> Self {
        Self { model, conditions, amplitudes, warped: None }
    }

    /// The body as drawn, without any effect or variability.
    #[must_use]
    pub const fn undisturbed(model: M) -> Self {
        Self::new(model, &[], Amplitudes::NONE)
    }

    /// The same body with a form of its own: warped functions.
    ///
    /// # Errors
    /// If it has no steady state at the glucose at which warps are 1.
    pub fn with_warps(self, warps: Warps) -> Result<Self, OdeError> {
        if warps == Warps::NONE {
            return Ok(Self { warped: None, ..self });
        }
        let (rest, _) = self.at_rest(RESTING_GLUCOSE)?;
        let insulin = self.report(&rest)[Compartment::I];
        let warped = Some(Warped::new(warps, insulin, self.model.weight()));
        Ok(Self { warped, ..self })
    }

    /// The state that a constant basal rate holds at a glucose concentration, and that rate: the
    /// start of a life, and of the trials that find its settings.
    ///
    /// # Errors
    /// As [`BodyModel::at_rest`].
    pub fn at_rest(
        &self,
        glucose: MgPerDl,
    ) -> Result<(BodyState<M::State>, UnitsPerHour), OdeError> {
        let (model, basal) = self.model.at_rest(glucose)?;
        Ok((BodyState { model, low: LowTrace::default(), step: 0 }, basal))
    }

    /// A condition with the warps at a state.
    fn warped(&self, condition: Condition, state: &BodyState<M::State>) -> Condition {
        match &self.warped {
            Some(warped) => warped.act(condition, &self.report(state)),
            None => condition,
        }
    }
}

impl<M: BodyModel> Plant for Body<'_, M> {
    type State = BodyState<M::State>;

    fn step(&self, state: &Self::State, input: &StepInput) -> Result<Self::State, NonFinite> {
        let glucose = self.glucose(state);
        let drawn = self.conditions.get(state.step).unwrap_or(&Condition::AS_DRAWN);
        let low = state.low.after_step(glucose, drawn.low_form, drawn.low_response_time);
        let condition = self.warped(drawn.at_glucose(glucose, &low), state);
        let felt = StepInput { exercise: drawn.felt(input.exercise), ..*input };
        let model = self.model.advance(&state.model, &felt, &condition, &self.amplitudes)?;
        Ok(BodyState { model, low, step: state.step + 1 })
    }

    fn glucose(&self, state: &Self::State) -> MgPerDl {
        self.model.glucose(&state.model)
    }

    fn report(&self, state: &Self::State) -> States {
        self.model.report(&state.model)
    }
}
