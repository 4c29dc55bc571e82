//! Compartments of the saturating body.

use crate::body::compartments;

compartments! {
    /// The twelve compartments, and their rates of change.
    SaturatingCompartments {
        /// Glucose in plasma, mmol/L.
        plasma: Q1,
        /// Glucose in the fluid around the muscle cells, mmol/L.
        muscle: Q2,
        /// Insulin in plasma I, mU/L.
        insulin: I,
        /// Insulin that acts on muscle, mU/L.
        at_muscle: X2,
        /// Insulin that acts on the liver, mU/L.
        at_liver: X3,
        /// Glucagon in plasma, pg/mL.
        glucagon: X3,
        /// Insulin in the first compartment of the slow channel Q_1a, mU.
        slow: S1,
        /// Insulin in the second compartment of the slow channel Q_2, mU.
        slow_next: S2,
        /// Insulin in the fast channel Q_1b, mU.
        fast: S1,
        /// Carbohydrate in the stomach, g.
        stomach: C1,
        /// Carbohydrate in the upper intestine, g.
        upper: C2,
        /// Carbohydrate in the lower intestine, g.
        lower: C2,
    }
}
