//! What the filter holds of a person, whatever body stands in it.

use ode_sim::{EgpMode, Integrator, OdeParameters, OdePlant, OdeState};
use physiology::{Kilograms, MgPerDl, Plant as _};

/// A person's parameters. For the ODE they are the model's; for another body their ratios to the nominal
/// parameters are factors at its ports ([`Body`](crate::filter::body::Body)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Personal {
    /// Parameters of the ODE model.
    pub parameters: OdeParameters,
    /// Body weight.
    pub weight: Kilograms,
    /// What happens where endogenous production would turn negative.
    pub egp: EgpMode,
}

impl Personal {
    /// The ODE plant of the person, at 5-minute Euler steps.
    #[inline(always)]
    #[must_use]
    pub fn ode(&self) -> OdePlant {
        let Self { parameters, weight, egp } = *self;
        OdePlant { parameters, weight, integrator: Integrator::ForwardEuler, egp }
    }

    /// Amount Q1, mmol/kg, at a glucose concentration.
    #[inline(always)]
    #[must_use]
    pub fn q1_at(&self, glucose: MgPerDl) -> f64 {
        self.ode().q1_at(glucose)
    }

    /// Plasma glucose of a state.
    #[inline(always)]
    #[must_use]
    pub fn glucose(&self, state: &OdeState) -> MgPerDl {
        self.ode().glucose(state)
    }
}
