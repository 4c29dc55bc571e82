//! State of the minimal body, without the stomach.

use physiology::Compartment;

/// The seven compartments, and their rates of change.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MinimalState {
    /// Glucose G, mg/dL.
    pub glucose: f64,
    /// Remote insulin X, the clearance of glucose that it causes, 1/min.
    pub x: f64,
    /// Remote insulin of the liver Y, the fall of production as a logarithm, unitless.
    pub y: f64,
    /// Insulin in plasma I, mU/L.
    pub insulin: f64,
    /// Insulin under the skin that is not yet monomeric, U.
    pub bound: f64,
    /// Insulin under the skin that can be absorbed, U.
    pub free: f64,
    /// Carbohydrate in the intestine, mg.
    pub intestine: f64,
}

impl MinimalState {
    /// The compartments, each with the reporting compartment for a fault in it.
    pub(crate) fn entries(&self) -> [(Compartment, f64); 7] {
        [
            (Compartment::Q1, self.glucose),
            (Compartment::X2, self.x),
            (Compartment::X3, self.y),
            (Compartment::I, self.insulin),
            (Compartment::S1, self.bound),
            (Compartment::S2, self.free),
            (Compartment::C2, self.intestine),
        ]
    }

    /// `self + h * slope`, entry by entry.
    #[must_use]
    pub fn plus(&self, h: f64, slope: &Self) -> Self {
        Self {
            glucose: self.glucose + h * slope.glucose,
            x: self.x + h * slope.x,
            y: self.y + h * slope.y,
            insulin: self.insulin + h * slope.insulin,
            bound: self.bound + h * slope.bound,
            free: self.free + h * slope.free,
            intestine: self.intestine + h * slope.intestine,
        }
    }
}
