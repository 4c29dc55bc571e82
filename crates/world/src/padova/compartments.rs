//! Compartments of the Padova body.

use crate::body::compartments;

compartments! {
    /// The twelve compartments, and their rates of change.
    PadovaCompartments {
        /// Glucose in plasma and fast tissues G_p, mg/kg.
        g_p: Q1,
        /// Glucose in slow tissues G_t, mg/kg.
        g_t: Q2,
        /// Insulin in plasma I_p, pmol/kg.
        i_p: I,
        /// Insulin in the liver I_l, pmol/kg.
        i_l: I,
        /// First delay of the insulin signal to the liver I', pmol/L.
        i_1: X3,
        /// Delayed insulin signal to the liver X^L, pmol/L.
        x_l: X3,
        /// Insulin in the interstitial fluid X, as a difference from basal, pmol/L.
        x: X2,
        /// Solid phase in the stomach Q_sto1, mg.
        q_sto1: C1,
        /// Ground phase in the stomach Q_sto2, mg.
        q_sto2: C1,
        /// Glucose in the intestine Q_gut, mg.
        q_gut: C2,
        /// Non-monomeric insulin under the skin I_sc1, pmol/kg.
        i_sc1: S1,
        /// Monomeric insulin under the skin I_sc2, pmol/kg.
        i_sc2: S2,
    }
}

impl PadovaCompartments {
    /// Carbohydrate in stomach and intestine, mg.
    #[must_use]
    pub fn carbohydrate(&self) -> f64 {
        self.q_sto1 + self.q_sto2 + self.q_gut
    }
}
