//! The step of a body in the filter: the ODE's, prepared, or that of another body.

use std::sync::Arc;

use ode_sim::{OdeError, OdePlant, OdeState, OdeVector};
use physiology::StepInput;

use super::euler::Euler;
use crate::filter::body::OtherBody;
use crate::filter::transition::BodySlopes;

/// Which body moves, and what it needs for a step.
#[derive(Debug, Clone)]
pub(crate) enum Stepper {
    /// The ODE, with everything that does not change between steps.
    Ode(Euler),
    /// Another body.
    Other(Arc<OtherBody>),
}

impl Stepper {
    /// The body alone one step later; `flux` is added to dQ1/dt, mmol/kg/min.
    #[inline(always)]
    pub(super) fn advance(
        &self,
        person: &OdePlant,
        body: &OdeState,
        input: &StepInput,
        flux: f64,
    ) -> Result<OdeState, OdeError> {
        let euler = match self {
            Self::Ode(euler) => euler,
            Self::Other(other) => return other.advance(person, body, input, flux),
        };
        if Euler::covers(body, input) {
            let x = OdeVector(euler.step(&body.vector().0, euler.doses(input), flux));
            if x.first_non_finite().is_none() {
                return Ok(body.with_vector(&x));
            }
        }
        person.advance(body, input, flux)
    }

    /// The body alone one step later and the derivative by its compartments; that of the ODE is without exercise and
    /// rescue carbohydrate.
    #[inline]
    pub(super) fn linearised(
        &self,
        person: &OdePlant,
        body: &OdeState,
        input: &StepInput,
        flux: f64,
    ) -> Result<(OdeState, BodySlopes), OdeError> {
        let euler = match self {
            Self::Ode(euler) => euler,
            Self::Other(other) => return other.linearised(person, body, input, flux),
        };
        let following = self.advance(person, body, input, flux)?;
        Ok((following, euler.slopes(&body.vector().0)))
    }
}
