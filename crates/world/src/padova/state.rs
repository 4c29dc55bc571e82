//! State of the Padova body.

use physiology::Compartment;

/// The twelve compartments, and their rates of change.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PadovaState {
    /// Glucose in plasma and fast tissues G_p, mg/kg.
    pub g_p: f64,
    /// Glucose in slow tissues G_t, mg/kg.
    pub g_t: f64,
    /// Insulin in plasma I_p, pmol/kg.
    pub i_p: f64,
    /// Insulin in the liver I_l, pmol/kg.
    pub i_l: f64,
    /// First delay of the insulin signal to the liver I', pmol/L.
    pub i_1: f64,
    /// Delayed insulin signal to the liver X^L, pmol/L.
    pub x_l: f64,
    /// Insulin in the interstitial fluid X, as a difference from basal, pmol/L.
    pub x: f64,
    /// Solid phase in the stomach Q_sto1, mg.
    pub q_sto1: f64,
    /// Ground phase in the stomach Q_sto2, mg.
    pub q_sto2: f64,
    /// Glucose in the intestine Q_gut, mg.
    pub q_gut: f64,
    /// Non-monomeric insulin under the skin I_sc1, pmol/kg.
    pub i_sc1: f64,
    /// Monomeric insulin under the skin I_sc2, pmol/kg.
    pub i_sc2: f64,
}

impl PadovaState {
    /// The compartments, each with the reporting compartment for a fault in it.
    pub(crate) fn entries(&self) -> [(Compartment, f64); 12] {
        [
            (Compartment::Q1, self.g_p),
            (Compartment::Q2, self.g_t),
            (Compartment::I, self.i_p),
            (Compartment::I, self.i_l),
            (Compartment::X3, self.i_1),
            (Compartment::X3, self.x_l),
            (Compartment::X2, self.x),
            (Compartment::C1, self.q_sto1),
            (Compartment::C1, self.q_sto2),
            (Compartment::C2, self.q_gut),
            (Compartment::S1, self.i_sc1),
            (Compartment::S2, self.i_sc2),
        ]
    }

    /// `self + h * slope`, entry by entry.
    #[must_use]
    pub fn plus(&self, h: f64, slope: &Self) -> Self {
        Self {
            g_p: self.g_p + h * slope.g_p,
            g_t: self.g_t + h * slope.g_t,
            i_p: self.i_p + h * slope.i_p,
            i_l: self.i_l + h * slope.i_l,
            i_1: self.i_1 + h * slope.i_1,
            x_l: self.x_l + h * slope.x_l,
            x: self.x + h * slope.x,
            q_sto1: self.q_sto1 + h * slope.q_sto1,
            q_sto2: self.q_sto2 + h * slope.q_sto2,
            q_gut: self.q_gut + h * slope.q_gut,
            i_sc1: self.i_sc1 + h * slope.i_sc1,
            i_sc2: self.i_sc2 + h * slope.i_sc2,
        }
    }

    /// Carbohydrate in stomach and intestine, mg.
    #[must_use]
    pub fn carbohydrate(&self) -> f64 {
        self.q_sto1 + self.q_sto2 + self.q_gut
    }
}
