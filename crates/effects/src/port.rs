//! Places in a model or its measurement at which an effect can enter.

use serde::{Deserialize, Serialize};

named::named_in_json! {
    /// A port.
    #[derive(Serialize, Deserialize)]
    Port {
        /// Share of the delivered insulin that reaches the depot (bioavailability of u).
        InsulinInput: "insulin_input",
        /// Time of insulin absorption (t_max,I).
        InsulinAbsorption: "insulin_absorption",
        /// Insulin action on transport and disposal (sources of X1 and X2).
        InsulinAction: "insulin_action",
        /// Insulin action on the liver (source of X3).
        InsulinActionLiver: "insulin_action_liver",
        /// Endogenous glucose production.
        Egp: "egp",
        /// Time of meal absorption (t_max,G).
        GutAbsorption: "gut_absorption",
        /// Carbohydrate eaten over carbohydrate logged (A_G D).
        CarbAmount: "carb_amount",
        /// Glucose flux into or out of Q1 beside the modelled ones.
        GlucoseFlux: "glucose_flux",
        /// The sensor: gain, offset, lag.
        Sensor: "sensor",
    }
}
