//! What is judged.

use twins::InputSet;

/// A way to simulate a person's windows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Method {
    /// The person's twin with all personal inputs.
    Twin,
    /// A twin whose residual network keeps physiology's signs by construction.
    ConstrainedTwin,
    /// A twin trained on its error alone, with the courses around it drawn.
    SpreadTwin,
    /// A twin that sees other personal inputs (paper, "Contribution of individual-level inputs").
    Ablated(InputSet),
    /// The population model without the person's network.
    Population,
    /// The ODE model with population parameters and the person's weight.
    Ode,
    /// The ODE model of the closest virtual patient.
    Closest,
    /// The ODE model with three sensitivities by Bayesian optimisation.
    BayesianOptimisation,
    /// The ODE model with six factors at their most probable values.
    MaximumAPosteriori,
    /// The ODE model under draws of these factors: mean course, outcomes averaged over draws.
    Posterior,
}

impl Method {
    /// Everything that a twin is compared with, in the paper's order and then ours.
    pub const BASELINES: [Self; 6] = [
        Self::Population,
        Self::Ode,
        Self::Closest,
        Self::BayesianOptimisation,
        Self::MaximumAPosteriori,
        Self::Posterior,
    ];

    /// Whether it is a twin of some kind.
    pub(crate) const fn is_twin(self) -> bool {
        matches!(self, Self::Twin | Self::ConstrainedTwin | Self::SpreadTwin | Self::Ablated(_))
    }

    /// Place in tables: twins, then baselines, then the ablation.
    pub(crate) fn rank(self) -> usize {
        let twins = [Self::Twin, Self::SpreadTwin, Self::ConstrainedTwin];
        let order = twins.into_iter().chain(Self::BASELINES);
        order.clone().position(|method| method == self).unwrap_or(order.count())
    }

    /// The key in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Twin => "twin",
            Self::ConstrainedTwin => "constrained_twin",
            Self::SpreadTwin => "spread_twin",
            Self::Ablated(inputs) => inputs.name(),
            Self::Population => "population",
            Self::Ode => "ode",
            Self::Closest => "closest",
            Self::BayesianOptimisation => "bayesian_optimisation",
            Self::MaximumAPosteriori => "map",
            Self::Posterior => "posterior",
        }
    }

    /// The name for people.
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            Self::Twin => "Digital twin",
            Self::ConstrainedTwin => "Twin, signs kept",
            Self::SpreadTwin => "Twin with spread",
            Self::Ablated(InputSet::All) => "All inputs",
            Self::Ablated(InputSet::HeartRateOnly) => "Heart rate only",
            Self::Ablated(InputSet::SleepOnly) => "Sleep only",
            Self::Ablated(InputSet::WeekendOnly) => "Weekend only",
            Self::Ablated(InputSet::TimeOnly) => "Time only",
            Self::Ablated(InputSet::None) => "No inputs",
            Self::Population => "Population model",
            Self::Ode => "ODE, population parameters",
            Self::Closest => "ODE, closest virtual patient",
            Self::BayesianOptimisation => "ODE, Bayesian optimisation",
            Self::MaximumAPosteriori => "ODE, most probable",
            Self::Posterior => "ODE, posterior",
        }
    }
}
