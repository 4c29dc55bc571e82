//! Where an effect acts.

use serde::Serialize;

/// Where in the body or the measurement an effect acts, by the name that the diagnosis uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Port {
    /// Share of the insulin that reaches the tissue.
    InsulinInput,
    /// How fast insulin is absorbed.
    InsulinAbsorption,
    /// Insulin action in the periphery.
    InsulinAction,
    /// Insulin action in the liver.
    InsulinActionLiver,
    /// Endogenous glucose production.
    Egp,
    /// How fast meals are absorbed.
    GutAbsorption,
    /// Carbohydrate of a logged meal.
    CarbAmount,
    /// Glucose that enters or leaves the accessible compartment in another way.
    GlucoseFlux,
    /// The sensor.
    Sensor,
}

impl Port {
    /// Every port.
    pub const ALL: [Self; 9] = [
        Self::InsulinInput,
        Self::InsulinAbsorption,
        Self::InsulinAction,
        Self::InsulinActionLiver,
        Self::Egp,
        Self::GutAbsorption,
        Self::CarbAmount,
        Self::GlucoseFlux,
        Self::Sensor,
    ];

    /// The name that files use.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::InsulinInput => "insulin_input",
            Self::InsulinAbsorption => "insulin_absorption",
            Self::InsulinAction => "insulin_action",
            Self::InsulinActionLiver => "insulin_action_liver",
            Self::Egp => "egp",
            Self::GutAbsorption => "gut_absorption",
            Self::CarbAmount => "carb_amount",
            Self::GlucoseFlux => "glucose_flux",
            Self::Sensor => "sensor",
        }
    }
}
