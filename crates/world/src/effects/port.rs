//! Where an effect acts.

named::named! {
    /// Where in the body or the measurement an effect acts, by the name that the diagnosis uses.
    Port {
        /// Share of the insulin that reaches the tissue.
        InsulinInput: "insulin_input",
        /// How fast insulin is absorbed.
        InsulinAbsorption: "insulin_absorption",
        /// Insulin action in the periphery.
        InsulinAction: "insulin_action",
        /// Insulin action in the liver.
        InsulinActionLiver: "insulin_action_liver",
        /// Endogenous glucose production.
        Egp: "egp",
        /// How fast meals are absorbed.
        GutAbsorption: "gut_absorption",
        /// Carbohydrate of a logged meal.
        CarbAmount: "carb_amount",
        /// Glucose that enters or leaves the accessible compartment in another way.
        GlucoseFlux: "glucose_flux",
        /// The sensor.
        Sensor: "sensor",
    }
}

/// Declares effects, each with its name, the port at which it acts and what an amplitude of 1 does.
macro_rules! effect_table {
    (
        $(#[$about:meta])*
        $name:ident {
            $($(#[$doc:meta])* $variant:ident: $word:literal, $port:ident, $size:literal;)+
        }
    ) => {
        named::named! { $(#[$about])* $name { $($(#[$doc])* $variant: $word,)+ } }

        impl $name {
            /// Where it acts.
            #[must_use]
            pub const fn port(self) -> $crate::effects::Port {
                match self { $(Self::$variant => $crate::effects::Port::$port,)+ }
            }

            /// What an amplitude of 1 does, in one line for the labels of a world.
            #[must_use]
            pub const fn size_at_one(self) -> &'static str {
                match self { $(Self::$variant => $size,)+ }
            }
        }
    };
}

pub(super) use effect_table;
