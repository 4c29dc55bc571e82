//! The ODE model as a plant of the one simulation loop.

use physiology::Compartment::{C2, Q1};
use physiology::{
    Compartment, Kilograms, MG_PER_DL_PER_MMOL_PER_L, MgPerDl, MmolPerL, NonFinite, Plant, STEP,
    States, StepInput,
};

use crate::equations::{EgpMode, Forcing, infusion};
use crate::error::OdeError;
use crate::gut::{GutPair, RESCUE_T_MAX, glucose_dose};
use crate::integrator::{Flow, Integrator};
use crate::parameters::OdeParameters;
use crate::state::OdeState;

/// A body described by the ODE model, and how it is integrated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OdePlant {
    /// Model parameters.
    pub parameters: OdeParameters,
    /// Body weight.
    pub weight: Kilograms,
    /// Numerical method.
    pub integrator: Integrator,
    /// What happens where endogenous production would turn negative.
    pub egp: EgpMode,
}

impl OdePlant {
    /// The plant as the authors run it: forward Euler at 5 min, production not clamped.
    #[must_use]
    pub fn reproduction(parameters: OdeParameters, weight: Kilograms) -> Self {
        Self {
            parameters,
            weight,
            integrator: Integrator::ForwardEuler,
            egp: EgpMode::Reproduction,
        }
    }

    /// Amount Q1, mmol/kg, at a glucose concentration.
    #[inline]
    #[must_use]
    pub fn q1_at(&self, glucose: MgPerDl) -> f64 {
        MmolPerL::from(glucose).0 * self.parameters.v_g
    }

    /// The state one step later.
    ///
    /// A step is: carbohydrate enters the gut at its start; insulin, exercise multipliers and
    /// `glucose_flux` are held through it; the gut empties exactly; the other eight states follow
    /// [`integrator`](Self::integrator). `glucose_flux` is a disturbance of dQ1/dt, mmol/kg/min.
    ///
    /// # Errors
    /// [`OdeError::NonFinite`], and for the adaptive integrator [`OdeError::Integration`] and
    /// [`OdeError::Argument`] (a tolerance that cannot be).
    #[inline]
    pub fn advance(
        &self,
        state: &OdeState,
        input: &StepInput,
        glucose_flux: f64,
    ) -> Result<OdeState, OdeError> {
        let fed = self.fed(state, input);
        // Before the step, since what is not a number spreads: the cause is named, not the effect.
        finite(&fed)?;
        let flow = self.flow(&fed, input, glucose_flux);
        let end = self.integrator.advance(&flow, fed.vector(), STEP.0)?;
        let rescue = fed.rescue.after(STEP.0, RESCUE_T_MAX.0);
        let following = OdeState { rescue, ..fed.with_vector(&end) };
        finite(&following)?;
        Ok(following)
    }

    /// `state` after what is eaten at the start of the step, with the exercise memory of the step.
    #[inline]
    pub(crate) fn fed(&self, state: &OdeState, input: &StepInput) -> OdeState {
        let a_g = self.parameters.a_g;
        let meal = a_g * glucose_dose(input.carbs, self.weight);
        let mut rescue = state.rescue;
        if input.rescue.amount.0 != 0.0 {
            let snack =
                GutPair::default().fed(a_g * glucose_dose(input.rescue.amount, self.weight));
            let snack = snack.after(input.rescue.eaten_before.0, RESCUE_T_MAX.0);
            rescue = GutPair { c1: rescue.c1 + snack.c1, c2: rescue.c2 + snack.c2 };
        }
        OdeState {
            meals: state.meals.fed(meal),
            rescue,
            exercise: state.exercise.during(input.exercise),
            ..*state
        }
    }

    #[inline]
    pub(crate) fn flow(&self, fed: &OdeState, input: &StepInput, glucose_flux: f64) -> Flow<'_> {
        Flow {
            parameters: &self.parameters,
            egp: self.egp,
            held: Forcing {
                insulin: infusion(input.insulin().0, self.weight.0),
                glucose_flux,
                exercise: fed.exercise.multipliers(),
            },
            meals: fed.meals,
            rescue: fed.rescue,
        }
    }
}

/// Names a compartment that is not finite; a snack counts to Q1, where it arrives.
#[inline]
fn finite(state: &OdeState) -> Result<(), OdeError> {
    let snack = state.rescue.c1 + state.rescue.c2;
    let in_vector = state.vector().first_non_finite();
    match in_vector.or_else(|| (!snack.is_finite()).then_some(Q1)) {
        Some(compartment) => Err(OdeError::NonFinite { compartment }),
        None => Ok(()),
    }
}

impl Plant for OdePlant {
    type State = OdeState;

    /// One step of [`advance`](OdePlant::advance) without a disturbance.
    ///
    /// If the adaptive integrator gives up, there is no number for the end of the step: this
    /// reports Q1; [`advance`](OdePlant::advance) tells the reason.
    fn step(&self, state: &OdeState, input: &StepInput) -> Result<OdeState, NonFinite> {
        self.advance(state, input, 0.0).map_err(|error| match error {
            OdeError::NonFinite { compartment } => NonFinite { compartment },
            _ => NonFinite { compartment: Q1 },
        })
    }

    #[inline]
    fn glucose(&self, state: &OdeState) -> MgPerDl {
        MgPerDl(state.q1 / self.parameters.v_g * MG_PER_DL_PER_MMOL_PER_L)
    }

    /// C1 is the amount of meal carbohydrate in the first gut compartment, mmol/kg; C2 the meals'
    /// appearance rate U_G. Rescue carbohydrate is not part of either.
    fn report(&self, state: &OdeState) -> States {
        let mut states = States::default();
        for compartment in Compartment::ALL {
            states[compartment] = state.vector()[compartment];
        }
        states[Q1] = self.glucose(state).0;
        states[C2] = state.meals.appearance(self.parameters.t_max_g);
        states
    }
}
