//! What the filter holds of a person, whatever body stands in it.

use ode_sim::{EgpMode, Integrator, OdeParameters, OdePlant, OdeState, OdeVector};
use physiology::Compartment::{I, Q1, Q2, S1, S2, X1, X2, X3};
use physiology::{Kilograms, MgPerDl, Plant as _, UnitsPerHour};

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

    /// The ODE with insulin at rest under `basal`, glucose as given, the gut empty.
    pub(crate) fn at_rest(&self, basal: UnitsPerHour, glucose: MgPerDl) -> OdeVector {
        let p = &self.parameters;
        let infusion = ode_sim::equations::infusion(basal.0, self.weight.0);
        let mut x = OdeVector::default();
        x[S1] = infusion * p.t_max_i;
        x[S2] = x[S1];
        x[I] = infusion / (p.v_i * p.k_e);
        x[X1] = p.s_f1 * x[I];
        x[X2] = p.s_f2 * x[I];
        x[X3] = p.s_f3 * x[I];
        x[Q1] = self.q1_at(glucose);
        x[Q2] = x[X1] * x[Q1] / (p.k_12 + x[X2]);
        x
    }
}
