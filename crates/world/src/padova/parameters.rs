//! Parameters of the Padova body and how they differ between people.

use crate::body::Spread::{Fixed, Normal, Own, Shared, SharedAndOwn};
use crate::body::parameters;

// What parameters share.
const ACTION: usize = 0;
const STOMACH: usize = 1;
const DEPOT: usize = 2;
const CLEARANCE: usize = 3;

parameters! {
    /// Parameters of one body, in the symbols of Dalla Man et al. 2007, and its weight, with their
    /// nominal values.
    ///
    /// Kinetics, gut, uptake and renal values: the means of the normal adults (Dalla Man et al.
    /// 2007, Table 1), k_gri equal to k_max as there; subcutaneous rates: GIM 2007. Changed for
    /// T1D: no secretion, hepatic extraction constant at 0.6, hence m_3 = 0.6/0.4 m_1; m_2 and m_4
    /// two thirds of normal, which lowers insulin clearance by a third; production 2.4 mg/kg/min
    /// at 120 mg/dL and 75 pmol/L (basal values of this order are those of the adults of the T1D
    /// simulator). r_1 and r_2 as in S2013. The spreads are assumed after those of the adults of the T1D
    /// simulator.
    PadovaParameters, shared [0.22, 0.20, 0.18, 0.12];
    /// Distribution volume of glucose V_G, dL/kg.
    v_g: 1.88, Own(0.05);
    /// Rate from plasma to tissue k_1, 1/min.
    k_1: 0.065, Own(0.08);
    /// Rate from tissue to plasma k_2, 1/min.
    k_2: 0.079, Own(0.08);
    /// Distribution volume of insulin V_I, L/kg.
    v_i: 0.05, Own(0.05);
    /// Rate from liver to plasma m_1, 1/min.
    m_1: 0.190, Fixed;
    /// Rate from plasma to liver m_2, 1/min.
    m_2: 0.484 * 2.0 / 3.0, Shared(CLEARANCE);
    /// Degradation in the liver m_3, 1/min.
    m_3: 0.285, Fixed;
    /// Degradation in the periphery m_4, 1/min.
    m_4: 0.194 * 2.0 / 3.0, Shared(CLEARANCE);
    /// Largest rate of gastric emptying k_max, 1/min.
    k_max: 0.0558, Shared(STOMACH);
    /// Smallest rate of gastric emptying k_min, 1/min.
    k_min: 0.0080, Own(0.25);
    /// Rate of absorption from the intestine k_abs, 1/min.
    k_abs: 0.057, Own(0.25);
    /// Rate of grinding k_gri, 1/min.
    k_gri: 0.0558, Shared(STOMACH);
    /// Share of the meal in the stomach at which emptying has slowed half-way b, unitless.
    b: 0.82, Normal(0.80, 0.06);
    /// Share of the carbohydrate that appears in plasma f, unitless.
    f: 0.90, Normal(0.90, 0.03);
    /// Share of the meal in the stomach at which emptying has recovered half-way d, unitless.
    d: 0.010, Fixed;
    /// Effect of glucose on production k_p2, 1/min.
    k_p2: 0.0021, Own(0.20);
    /// Effect of insulin on production k_p3, mg/kg/min per pmol/L.
    k_p3: 0.009, SharedAndOwn(ACTION, 0.15);
    /// Rate of the two delays of the insulin signal to the liver k_i, 1/min.
    k_i: 0.0079, Own(0.20);
    /// Uptake by brain and red cells F_cns, mg/kg/min.
    f_cns: 1.0, Fixed;
    /// Effect of insulin on uptake V_mx, mg/kg/min per pmol/L.
    v_mx: 0.047, SharedAndOwn(ACTION, 0.15);
    /// Tissue glucose of half-maximal uptake K_m0, mg/kg.
    k_m0: 225.59, Own(0.08);
    /// Rate of insulin action on uptake p_2U, 1/min.
    p_2u: 0.0331, Own(0.20);
    /// Rate from non-monomeric to monomeric insulin k_d, 1/min.
    k_d: 0.0164, Shared(DEPOT);
    /// Absorption of non-monomeric insulin k_a1, 1/min.
    k_a1: 0.0018, Own(0.20);
    /// Absorption of monomeric insulin k_a2, 1/min.
    k_a2: 0.0182, Shared(DEPOT);
    /// Basal glucose G_b, mg/dL, at which the basal values below hold.
    g_b: 120.0, Normal(120.0, 8.0);
    /// Basal plasma insulin I_b, pmol/L.
    i_b: 75.0, Own(0.15);
    /// Basal endogenous production EGP_b, mg/kg/min.
    egp_b: 2.4, Own(0.10);
    /// Renal excretion rate k_e1, 1/min.
    k_e1: 0.0005, Fixed;
    /// Renal threshold k_e2, mg/kg.
    k_e2: 339.0, Normal(339.0, 15.0);
    /// Gain of uptake at low glucose r_1, unitless (S2013).
    r_1: 1.44, Fixed;
    /// Exponent of the risk r_2, unitless (S2013).
    r_2: 0.81, Fixed;
}

impl PadovaParameters {
    /// Glucose in the slow tissues at basal G_tb, mg/kg.
    #[must_use]
    pub fn g_tb(&self) -> f64 {
        let g_pb = self.g_b * self.v_g;
        (self.f_cns - self.egp_b + self.k_1 * g_pb) / self.k_2
    }

    /// Production extrapolated to no glucose and no insulin k_p1, mg/kg/min.
    #[must_use]
    pub fn k_p1(&self) -> f64 {
        self.egp_b + self.k_p2 * self.g_b * self.v_g + self.k_p3 * self.i_b
    }

    /// Uptake capacity at basal insulin V_m0, mg/kg/min.
    #[must_use]
    pub fn v_m0(&self) -> f64 {
        let g_tb = self.g_tb();
        (self.egp_b - self.f_cns) * (self.k_m0 + g_tb) / g_tb
    }
}
