//! Parameters of the Padova body and how they differ between people.

use physiology::Kilograms;
use rand::Rng;

use crate::body::parameters;
use crate::stream::standard_normal;

parameters! {
    /// Parameters of one body, in the symbols of Dalla Man et al. 2007, and its weight, with their
    /// nominal values.
    ///
    /// Kinetics, gut, uptake and renal values: the means of the normal adults (Dalla Man et al.
    /// 2007, Table 1), k_gri equal to k_max as there; subcutaneous rates: GIM 2007. Changed for
    /// T1D: no secretion, hepatic extraction constant at 0.6, hence m_3 = 0.6/0.4 m_1; m_2 and m_4
    /// two thirds of normal, which lowers insulin clearance by a third; production 2.4 mg/kg/min
    /// at 120 mg/dL and 75 pmol/L (basal values of this order are those of the adults of the T1D
    /// simulator). r_1 and r_2 as in S2013.
    PadovaParameters {
        /// Distribution volume of glucose V_G, dL/kg.
        v_g: 1.88,
        /// Rate from plasma to tissue k_1, 1/min.
        k_1: 0.065,
        /// Rate from tissue to plasma k_2, 1/min.
        k_2: 0.079,
        /// Distribution volume of insulin V_I, L/kg.
        v_i: 0.05,
        /// Rate from liver to plasma m_1, 1/min.
        m_1: 0.190,
        /// Rate from plasma to liver m_2, 1/min.
        m_2: 0.484 * 2.0 / 3.0,
        /// Degradation in the liver m_3, 1/min.
        m_3: 0.285,
        /// Degradation in the periphery m_4, 1/min.
        m_4: 0.194 * 2.0 / 3.0,
        /// Largest rate of gastric emptying k_max, 1/min.
        k_max: 0.0558,
        /// Smallest rate of gastric emptying k_min, 1/min.
        k_min: 0.0080,
        /// Rate of absorption from the intestine k_abs, 1/min.
        k_abs: 0.057,
        /// Rate of grinding k_gri, 1/min.
        k_gri: 0.0558,
        /// Share of the carbohydrate that appears in plasma f, unitless.
        f: 0.90,
        /// Share of the meal in the stomach at which emptying has slowed half-way b, unitless.
        b: 0.82,
        /// Share of the meal in the stomach at which emptying has recovered half-way d, unitless.
        d: 0.010,
        /// Effect of glucose on production k_p2, 1/min.
        k_p2: 0.0021,
        /// Effect of insulin on production k_p3, mg/kg/min per pmol/L.
        k_p3: 0.009,
        /// Rate of the two delays of the insulin signal to the liver k_i, 1/min.
        k_i: 0.0079,
        /// Uptake by brain and red cells F_cns, mg/kg/min.
        f_cns: 1.0,
        /// Effect of insulin on uptake V_mx, mg/kg/min per pmol/L.
        v_mx: 0.047,
        /// Tissue glucose of half-maximal uptake K_m0, mg/kg.
        k_m0: 225.59,
        /// Rate of insulin action on uptake p_2U, 1/min.
        p_2u: 0.0331,
        /// Renal excretion rate k_e1, 1/min.
        k_e1: 0.0005,
        /// Renal threshold k_e2, mg/kg.
        k_e2: 339.0,
        /// Rate from non-monomeric to monomeric insulin k_d, 1/min.
        k_d: 0.0164,
        /// Absorption of non-monomeric insulin k_a1, 1/min.
        k_a1: 0.0018,
        /// Absorption of monomeric insulin k_a2, 1/min.
        k_a2: 0.0182,
        /// Basal glucose G_b, mg/dL, at which the basal values below hold.
        g_b: 120.0,
        /// Basal plasma insulin I_b, pmol/L.
        i_b: 75.0,
        /// Basal endogenous production EGP_b, mg/kg/min.
        egp_b: 2.4,
        /// Gain of uptake at low glucose r_1, unitless (S2013).
        r_1: 1.44,
        /// Exponent of the risk r_2, unitless (S2013).
        r_2: 0.81,
    }
}

impl PadovaParameters {
    /// One draw around the nominal body, accepted or not.
    ///
    /// Log-normal factors with these standard deviations, assumed after the spread of the
    /// adults of the T1D simulator: 0.22 shared by V_mx and k_p3 and 0.15 for each alone; k_max
    /// and k_gri 0.20 shared, k_min 0.25, k_abs 0.25; k_d and k_a2 0.18 shared, k_a1 0.20; k_i
    /// and p_2U 0.20; m_2 and m_4 0.12 shared; K_m0 0.08; EGP_b 0.10; I_b 0.15; V_G and V_I
    /// 0.05; k_1 and k_2 0.08; k_p2 0.20. b normal 0.80 (SD 0.06), f normal 0.90 (SD 0.03), G_b
    /// normal 120 (SD 8) mg/dL, k_e2 normal 339 (SD 15) mg/kg; weight as for the other
    /// generator.
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
}
