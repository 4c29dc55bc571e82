//! State of the saturating body.

use physiology::Compartment;

/// The twelve compartments, and their rates of change.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SaturatingState {
    /// Glucose in plasma, mmol/L.
    pub plasma: f64,
    /// Glucose in the fluid around the muscle cells, mmol/L.
    pub muscle: f64,
    /// Insulin in plasma I, mU/L.
    pub insulin: f64,
    /// Insulin that acts on muscle, mU/L.
    pub at_muscle: f64,
    /// Insulin that acts on the liver, mU/L.
    pub at_liver: f64,
    /// Glucagon in plasma, pg/mL.
    pub glucagon: f64,
    /// Insulin in the first compartment of the slow channel Q_1a, mU.
    pub slow: f64,
    /// Insulin in the second compartment of the slow channel Q_2, mU.
    pub slow_next: f64,
    /// Insulin in the fast channel Q_1b, mU.
    pub fast: f64,
    /// Carbohydrate in the stomach, g.
    pub stomach: f64,
    /// Carbohydrate in the upper intestine, g.
    pub upper: f64,
    /// Carbohydrate in the lower intestine, g.
    pub lower: f64,
}

impl SaturatingState {
    /// The compartments, each with the reporting compartment for a fault in it.
    pub(crate) fn entries(&self) -> [(Compartment, f64); 12] {
        [
            (Compartment::Q1, self.plasma),
            (Compartment::Q2, self.muscle),
            (Compartment::I, self.insulin),
            (Compartment::X2, self.at_muscle),
            (Compartment::X3, self.at_liver),
            (Compartment::X3, self.glucagon),
            (Compartment::S1, self.slow),
            (Compartment::S2, self.slow_next),
            (Compartment::S1, self.fast),
            (Compartment::C1, self.stomach),
            (Compartment::C2, self.upper),
            (Compartment::C2, self.lower),
        ]
    }

    /// `self + h * slope`, entry by entry.
    #[must_use]
    pub fn plus(&self, h: f64, slope: &Self) -> Self {
        Self {
            plasma: self.plasma + h * slope.plasma,
            muscle: self.muscle + h * slope.muscle,
            insulin: self.insulin + h * slope.insulin,
            at_muscle: self.at_muscle + h * slope.at_muscle,
            at_liver: self.at_liver + h * slope.at_liver,
            glucagon: self.glucagon + h * slope.glucagon,
            slow: self.slow + h * slope.slow,
            slow_next: self.slow_next + h * slope.slow_next,
            fast: self.fast + h * slope.fast,
            stomach: self.stomach + h * slope.stomach,
            upper: self.upper + h * slope.upper,
            lower: self.lower + h * slope.lower,
        }
    }
}
