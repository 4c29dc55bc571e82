//! Places in a model or its measurement at which an effect can enter.

use serde::{Deserialize, Serialize};

/// A port.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Port {
    /// Share of the delivered insulin that reaches the depot (bioavailability of u).
    InsulinInput,
    /// Time of insulin absorption (t_max,I).
    InsulinAbsorption,
    /// Insulin action on transport and disposal (sources of X1 and X2).
    InsulinAction,
    /// Insulin action on the liver (source of X3).
    InsulinActionLiver,
    /// Endogenous glucose production.
    Egp,
    /// Time of meal absorption (t_max,G).
    GutAbsorption,
    /// Carbohydrate eaten over carbohydrate logged (A_G D).
    CarbAmount,
    /// Glucose flux into or out of Q1 beside the modelled ones.
    GlucoseFlux,
    /// The sensor: gain, offset, lag.
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
