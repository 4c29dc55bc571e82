//! Compartments of the minimal body, without the stomach.

use crate::body::compartments;

compartments! {
    /// The seven compartments, and their rates of change.
    MinimalCompartments {
        /// Glucose G, mg/dL.
        glucose: Q1,
        /// Remote insulin X, the clearance of glucose that it causes, 1/min.
        x: X2,
        /// Remote insulin of the liver Y, the fall of production as a logarithm, unitless.
        y: X3,
        /// Insulin in plasma I, mU/L.
        insulin: I,
        /// Insulin under the skin that is not yet monomeric, U.
        bound: S1,
        /// Insulin under the skin that can be absorbed, U.
        free: S2,
        /// Carbohydrate in the intestine, mg.
        intestine: C2,
    }
}
