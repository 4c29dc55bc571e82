//! Parameters of the minimal body and how they differ between people.

use physiology::Kilograms;
use rand::Rng;

use crate::body::parameters;
use crate::stream::standard_normal;

parameters! {
    /// Parameters of one body and its weight, with their nominal values.
    ///
    /// V_G, p_2 and the size of S_I are those of minimal models (Bergman et al. 1979; in type 1
    /// diabetes S_I 7e-4 and GEZI 2e-3 per min, of the order, Kanderian et al. 2009); R_d0 1
    /// mg/kg/min (Caumo and Cobelli 1993). Production 2 mg/kg/min at basal insulin, halved by 22
    /// mU/L (Rizza et al., Am J Physiol 1981;240:E630 have 29). Insulin clearance 17 mL/kg/min,
    /// single molecules after 25 min and absorption over 50 min: plasma insulin peaks an hour after
    /// a bolus (Heinemann and Muchmore, J Diabetes Sci Technol 2012;6:728). Half of a solid meal
    /// leaves the stomach in 55 min with beta 1.35 (carbohydrate leads the meal, whose half-time is
    /// 70 to 100 min; Elashoff et al. 1982). Threshold 190 mg/dL, clearance above it 0.45 dL/min, a
    /// third of the filtration.
    MinimalParameters {
        /// Distribution volume of glucose V_G, dL/kg.
        v_g: 1.70,
        /// Clearance of glucose without insulin (GEZI), 1/min.
        k_g: 0.0012,
        /// Zero-order uptake R_d0, mg/kg/min.
        r_d0: 1.05,
        /// Production without insulin P_0, mg/kg/min.
        p_0: 2.90,
        /// Insulin sensitivity of disposal S_I, 1/min per mU/L.
        s_i: 3.2e-4,
        /// Insulin sensitivity of production S_L, 1 per mU/L.
        s_l: 0.0315,
        /// Rate of remote insulin p_2, 1/min.
        p_2: 0.015,
        /// Rate of the liver's remote insulin p_L, 1/min.
        p_l: 0.030,
        /// Clearance of insulin, L/kg/min.
        clearance: 0.017,
        /// Distribution volume of insulin V_I, L/kg.
        v_i: 0.10,
        /// Rate at which insulin under the skin falls apart k_h, 1/min.
        k_h: 0.040,
        /// Rate of absorption of a small depot k_a, 1/min.
        k_a: 0.020,
        /// Depot that is absorbed at half that rate D_50, U.
        d_50: 22.0,
        /// Time in which half of solid food leaves the stomach t_half, min.
        t_half: 55.0,
        /// Shape of the emptying beta, unitless.
        beta: 1.35,
        /// Rate of absorption from the intestine k_abs, 1/min.
        k_abs: 0.050,
        /// Share of the carbohydrate that appears in plasma f, unitless.
        f: 0.90,
        /// Renal threshold G_r, mg/dL.
        g_r: 190.0,
        /// Renal clearance above it k_r, dL/kg/min.
        k_r: 0.006,
    }
}

impl MinimalParameters {
    /// One draw around the nominal body, accepted or not.
    ///
    /// Log-normal factors with these standard deviations, assumed of the order of the spreads
    /// between the ten patients of Kanderian et al. 2009, which also hold error: 0.22 shared by
    /// S_I and S_L and 0.15 for each alone; p_2 0.25, p_L 0.20; clearance 0.12, V_I 0.08; k_h
    /// and k_a 0.18 shared and k_a 0.10 alone, D_50 0.30; t_half 0.22, k_abs 0.20; P_0 0.10,
    /// k_g 0.25, R_d0 0.08; V_G 0.06; k_r 0.30. beta normal 1.35 (SD 0.18), f 0.90 (SD 0.03),
    /// G_r 190 (SD 12) mg/dL; weight as for the other generators.
    pub(super) fn draw(rng: &mut (impl Rng + ?Sized)) -> Self {
        let nominal = Self::nominal();
        let mut factor = |sd: f64| (sd * standard_normal(rng)).clamp(-2.5 * sd, 2.5 * sd).exp();
        let (action, depot) = (factor(0.22), factor(0.18));
        let drawn = Self {
            v_g: nominal.v_g * factor(0.06),
            k_g: nominal.k_g * factor(0.25),
            r_d0: nominal.r_d0 * factor(0.08),
            p_0: nominal.p_0 * factor(0.10),
            s_i: nominal.s_i * action * factor(0.15),
            s_l: nominal.s_l * action * factor(0.15),
            p_2: nominal.p_2 * factor(0.25),
            p_l: nominal.p_l * factor(0.20),
            clearance: nominal.clearance * factor(0.12),
            v_i: nominal.v_i * factor(0.08),
            k_h: nominal.k_h * depot,
            k_a: nominal.k_a * depot * factor(0.10),
            d_50: nominal.d_50 * factor(0.30),
            t_half: nominal.t_half * factor(0.22),
            k_abs: nominal.k_abs * factor(0.20),
            k_r: nominal.k_r * factor(0.30),
            ..nominal
        };
        let mut normal =
            |mean: f64, sd: f64| mean + (sd * standard_normal(rng)).clamp(-2.0 * sd, 2.0 * sd);
        Self {
            beta: normal(1.35, 0.18),
            f: normal(0.90, 0.03),
            g_r: normal(nominal.g_r, 12.0),
            weight: Kilograms(normal(76.3, 15.9).clamp(50.0, 115.0)),
            ..drawn
        }
    }
}
