//! Parameters of the Padova body and how they differ between people.

use crate::stream::standard_normal;
use physiology::Kilograms;
use rand::Rng;

/// Parameters of one body, in the symbols of Dalla Man et al. 2007, and its weight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PadovaParameters {
    /// Distribution volume of glucose V_G, dL/kg.
    pub v_g: f64,
    /// Rate from plasma to tissue k_1, 1/min.
    pub k_1: f64,
    /// Rate from tissue to plasma k_2, 1/min.
    pub k_2: f64,
    /// Distribution volume of insulin V_I, L/kg.
    pub v_i: f64,
    /// Rate from liver to plasma m_1, 1/min.
    pub m_1: f64,
    /// Rate from plasma to liver m_2, 1/min.
    pub m_2: f64,
    /// Degradation in the liver m_3, 1/min.
    pub m_3: f64,
    /// Degradation in the periphery m_4, 1/min.
    pub m_4: f64,
    /// Largest rate of gastric emptying k_max, 1/min.
    pub k_max: f64,
    /// Smallest rate of gastric emptying k_min, 1/min.
    pub k_min: f64,
    /// Rate of absorption from the intestine k_abs, 1/min.
    pub k_abs: f64,
    /// Rate of grinding k_gri, 1/min.
    pub k_gri: f64,
    /// Share of the carbohydrate that appears in plasma f, unitless.
    pub f: f64,
    /// Share of the meal in the stomach at which emptying has slowed half-way b, unitless.
    pub b: f64,
    /// Share of the meal in the stomach at which emptying has recovered half-way d, unitless.
    pub d: f64,
    /// Effect of glucose on production k_p2, 1/min.
    pub k_p2: f64,
    /// Effect of insulin on production k_p3, mg/kg/min per pmol/L.
    pub k_p3: f64,
    /// Rate of the two delays of the insulin signal to the liver k_i, 1/min.
    pub k_i: f64,
    /// Uptake by brain and red cells F_cns, mg/kg/min.
    pub f_cns: f64,
    /// Effect of insulin on uptake V_mx, mg/kg/min per pmol/L.
    pub v_mx: f64,
    /// Tissue glucose of half-maximal uptake K_m0, mg/kg.
    pub k_m0: f64,
    /// Rate of insulin action on uptake p_2U, 1/min.
    pub p_2u: f64,
    /// Renal excretion rate k_e1, 1/min.
    pub k_e1: f64,
    /// Renal threshold k_e2, mg/kg.
    pub k_e2: f64,
    /// Rate from non-monomeric to monomeric insulin k_d, 1/min.
    pub k_d: f64,
    /// Absorption of non-monomeric insulin k_a1, 1/min.
    pub k_a1: f64,
    /// Absorption of monomeric insulin k_a2, 1/min.
    pub k_a2: f64,
    /// Basal glucose G_b, mg/dL, at which the basal values below hold.
    pub g_b: f64,
    /// Basal plasma insulin I_b, pmol/L.
    pub i_b: f64,
    /// Basal endogenous production EGP_b, mg/kg/min.
    pub egp_b: f64,
    /// Gain of uptake at low glucose r_1, unitless (S2013).
    pub r_1: f64,
    /// Exponent of the risk r_2, unitless (S2013).
    pub r_2: f64,
    /// Body weight.
    pub weight: Kilograms,
}

impl PadovaParameters {
    /// The nominal adult with type 1 diabetes.
    ///
    /// Kinetics, gut, uptake and renal values: the means of the normal adults (Dalla Man et al.
    /// 2007, Table 1), k_gri equal to k_max as there; subcutaneous rates: GIM 2007. Changed for
    /// T1D: no secretion, hepatic extraction constant at 0.6, hence m_3 = 0.6/0.4 m_1; m_2 and m_4
    /// two thirds of normal, which lowers insulin clearance by a third; production 2.4 mg/kg/min
    /// at 120 mg/dL and 75 pmol/L (basal values of this order are those of the adults of the T1D
    /// simulator). r_1 and r_2 as in S2013.
    #[must_use]
    pub fn nominal() -> Self {
        Self {
            v_g: 1.88,
            k_1: 0.065,
            k_2: 0.079,
            v_i: 0.05,
            m_1: 0.190,
            m_2: 0.484 * 2.0 / 3.0,
            m_3: 0.285,
            m_4: 0.194 * 2.0 / 3.0,
            k_max: 0.0558,
            k_min: 0.0080,
            k_abs: 0.057,
            k_gri: 0.0558,
            f: 0.90,
            b: 0.82,
            d: 0.010,
            k_p2: 0.0021,
            k_p3: 0.009,
            k_i: 0.0079,
            f_cns: 1.0,
            v_mx: 0.047,
            k_m0: 225.59,
            p_2u: 0.0331,
            k_e1: 0.0005,
            k_e2: 339.0,
            k_d: 0.0164,
            k_a1: 0.0018,
            k_a2: 0.0182,
            g_b: 120.0,
            i_b: 75.0,
            egp_b: 2.4,
            r_1: 1.44,
            r_2: 0.81,
            weight: Kilograms(76.3),
        }
    }

    /// One draw, accepted or not.
    pub(super) fn draw(rng: &mut (impl Rng + ?Sized)) -> Self {
        let nominal = Self::nominal();
        let mut factor = |sd: f64| (sd * standard_normal(rng)).clamp(-2.5 * sd, 2.5 * sd).exp();
        let (action, stomach, depot, clearance) =
            (factor(0.22), factor(0.20), factor(0.18), factor(0.12));
        let drawn = Self {
            v_g: nominal.v_g * factor(0.05),
            k_1: nominal.k_1 * factor(0.08),
            k_2: nominal.k_2 * factor(0.08),
            v_i: nominal.v_i * factor(0.05),
            m_2: nominal.m_2 * clearance,
            m_4: nominal.m_4 * clearance,
            k_max: nominal.k_max * stomach,
            k_gri: nominal.k_gri * stomach,
            k_min: nominal.k_min * factor(0.25),
            k_abs: nominal.k_abs * factor(0.25),
            k_p2: nominal.k_p2 * factor(0.20),
            k_p3: nominal.k_p3 * action * factor(0.15),
            k_i: nominal.k_i * factor(0.20),
            v_mx: nominal.v_mx * action * factor(0.15),
            k_m0: nominal.k_m0 * factor(0.08),
            p_2u: nominal.p_2u * factor(0.20),
            k_d: nominal.k_d * depot,
            k_a1: nominal.k_a1 * factor(0.20),
            k_a2: nominal.k_a2 * depot,
            i_b: nominal.i_b * factor(0.15),
            egp_b: nominal.egp_b * factor(0.10),
            ..nominal
        };
        let mut normal =
            |mean: f64, sd: f64| mean + (sd * standard_normal(rng)).clamp(-2.0 * sd, 2.0 * sd);
        Self {
            b: normal(0.80, 0.06),
            f: normal(0.90, 0.03),
            g_b: normal(nominal.g_b, 8.0),
            k_e2: normal(nominal.k_e2, 15.0),
            weight: Kilograms(normal(76.3, 15.9).clamp(50.0, 115.0)),
            ..drawn
        }
    }

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

    /// The same body with insulin `factor` times as effective on uptake and production:
    /// `1 / factor` of it does the same work.
    #[must_use]
    pub fn with_action_scaled(self, factor: f64) -> Self {
        Self { v_mx: self.v_mx * factor, k_p3: self.k_p3 * factor, i_b: self.i_b / factor, ..self }
    }

    /// Each parameter with its name, in the order of the fields.
    #[must_use]
    pub fn named(&self) -> [(&'static str, f64); 32] {
        [
            ("v_g", self.v_g),
            ("k_1", self.k_1),
            ("k_2", self.k_2),
            ("v_i", self.v_i),
            ("m_1", self.m_1),
            ("m_2", self.m_2),
            ("m_3", self.m_3),
            ("m_4", self.m_4),
            ("k_max", self.k_max),
            ("k_min", self.k_min),
            ("k_abs", self.k_abs),
            ("k_gri", self.k_gri),
            ("f", self.f),
            ("b", self.b),
            ("d", self.d),
            ("k_p2", self.k_p2),
            ("k_p3", self.k_p3),
            ("k_i", self.k_i),
            ("f_cns", self.f_cns),
            ("v_mx", self.v_mx),
            ("k_m0", self.k_m0),
            ("p_2u", self.p_2u),
            ("k_e1", self.k_e1),
            ("k_e2", self.k_e2),
            ("k_d", self.k_d),
            ("k_a1", self.k_a1),
            ("k_a2", self.k_a2),
            ("g_b", self.g_b),
            ("i_b", self.i_b),
            ("egp_b", self.egp_b),
            ("r_1", self.r_1),
            ("r_2", self.r_2),
        ]
    }
}
