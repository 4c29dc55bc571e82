//! Parameters of the saturating body and how they differ between people.

use physiology::Kilograms;
use rand::Rng;

use crate::body::parameters;
use crate::stream::standard_normal;

parameters! {
    /// Parameters of one body and its weight, with their nominal values.
    ///
    /// Insulin under the skin after Wilinska et al. 2005 (67 % on the slow channel, 0.011 and 0.021
    /// per min; loss of at most 1.93 mU/min half-saturated by 62.6 mU): 62 %, 0.014 and 0.023,
    /// chosen within their ranges so that covered meals peak within two hours. Carriers: the brain
    /// 1.1 mg/kg/min with K 1 mmol/L, muscle K_m 2.2 mmol/L (GLUT3 and GLUT4, 1 to 7, of the
    /// order), capacity of muscle half-raised by 70 mU/L and production half-suppressed by less
    /// than 29 mU/L (Rizza et al. 1981: 55 to 120 and 29). Production: Wendt et al. 2017
    /// (gluconeogenesis 6 umol/kg/min, release 56 umol/kg/min at most, C_50 436 pg/mL). Glucagon of
    /// 60 pg/mL with a half-time of 6 min; a low raises it by 20 % where healthy people treble it
    /// (blunted, Cryer, N Engl J Med 2013;369:362). Stomach: 0.8 g/min of the carbohydrate of a
    /// mixed meal of 75 g at first, less later (2 to 4 kcal/min). Threshold 10.5 mmol/L.
    SaturatingParameters {
        /// Distribution volume of plasma and fast tissues V_p, L/kg.
        v_p: 0.155,
        /// Distribution volume of muscle V_m, L/kg.
        v_m: 0.10,
        /// Transport between them, L/kg/min.
        transport: 0.025,
        /// Capacity of the brain's carriers V_b, mmol/kg/min.
        v_b: 0.0070,
        /// Their half-saturation K_b, mmol/L.
        k_b: 1.0,
        /// Capacity of muscle without insulin V_0, mmol/kg/min.
        v_0: 0.0030,
        /// Capacity that insulin adds at most V_i, mmol/kg/min.
        v_i: 0.080,
        /// Insulin that adds half of it x_50, mU/L.
        x_50: 70.0,
        /// Half-saturation of the muscle's carriers K_m, mmol/L.
        k_m: 2.2,
        /// Gluconeogenesis G_ng, mmol/kg/min.
        g_ng: 0.0060,
        /// Largest release from glycogen E_max, mmol/kg/min.
        e_max: 0.0564,
        /// Glucagon that frees half of it C_50, pg/mL.
        c_50: 436.0,
        /// Insulin that suppresses half of it y_50, mU/L.
        y_50: 12.0,
        /// Steepness of that h, unitless.
        y_h: 1.5,
        /// Rate of insulin's action on muscle k_x, 1/min.
        k_x: 0.022,
        /// Rate of insulin's action on the liver k_y, 1/min.
        k_y: 0.030,
        /// Glucagon without insulin n_0, pg/mL.
        n_0: 70.0,
        /// Rise of glucagon in a low, as a share.
        n_low: 0.20,
        /// Insulin that halves glucagon n_i, mU/L.
        n_i: 60.0,
        /// Rate of glucagon k_n, 1/min.
        k_n: 0.12,
        /// Share of the insulin on the slow channel k, unitless.
        k: 0.62,
        /// Rate of the slow channel k_a1, 1/min.
        k_a1: 0.014,
        /// Rate of the fast channel k_a2, 1/min.
        k_a2: 0.023,
        /// Largest loss under the skin V_LD, mU/min.
        v_ld: 1.93,
        /// Insulin at which half of it is lost K_LD, mU.
        k_ld: 62.6,
        /// Elimination of insulin k_e, 1/min.
        k_e: 0.133,
        /// Distribution volume of insulin, L/kg.
        v_ins: 0.16,
        /// Largest rate of emptying of the stomach E_m, g/min.
        e_m: 1.2,
        /// Content at which it is half of that, g.
        e_half: 35.0,
        /// Rate from upper to lower intestine k_u, 1/min.
        k_u: 0.10,
        /// Rate of absorption k_l, 1/min.
        k_l: 0.10,
        /// Share of the carbohydrate that appears in plasma f, unitless.
        f: 0.88,
        /// Renal threshold G_r, mmol/L.
        g_r: 10.5,
        /// Renal clearance above it k_r, L/kg/min.
        k_r: 0.0008,
    }
}

impl SaturatingParameters {
    /// One draw around the nominal body, accepted or not.
    ///
    /// Log-normal factors with these standard deviations: 0.22 shared by x_50 and y_50
    /// (inverse) and 0.15 for each alone; k_a1 and k_a2 0.15 shared and 0.15 for each alone,
    /// V_LD 0.40 (ranges of Wilinska et al. 2005, narrowed, since they hold error); V_b 0.06,
    /// V_i 0.12, K_m 0.10, V_0 0.20; G_ng 0.10, E_max 0.12, n_0 0.15, n_low 0.40; k_x and k_y
    /// 0.20; k_e 0.10, volumes 0.06; E_m 0.22, its half-content 0.25, k_u and k_l 0.20 shared;
    /// k_r 0.30; transport 0.15 (assumed). k normal 0.62 (SD 0.07), f 0.88 (SD 0.03), G_r 10.5
    /// (SD 0.7) mmol/L; weight as for the other generators.
    pub(super) fn draw(rng: &mut (impl Rng + ?Sized)) -> Self {
        let nominal = Self::nominal();
        let mut factor = |sd: f64| (sd * standard_normal(rng)).clamp(-2.5 * sd, 2.5 * sd).exp();
        let (action, depot, intestine) = (factor(0.22), factor(0.15), factor(0.20));
        let drawn = Self {
            v_p: nominal.v_p * factor(0.06),
            v_m: nominal.v_m * factor(0.06),
            transport: nominal.transport * factor(0.15),
            v_b: nominal.v_b * factor(0.06),
            v_0: nominal.v_0 * factor(0.20),
            v_i: nominal.v_i * factor(0.12),
            x_50: nominal.x_50 / (action * factor(0.15)),
            k_m: nominal.k_m * factor(0.10),
            g_ng: nominal.g_ng * factor(0.10),
            e_max: nominal.e_max * factor(0.12),
            y_50: nominal.y_50 / (action * factor(0.15)),
            k_x: nominal.k_x * factor(0.20),
            k_y: nominal.k_y * factor(0.20),
            n_0: nominal.n_0 * factor(0.15),
            n_low: nominal.n_low * factor(0.40),
            k_a1: nominal.k_a1 * depot * factor(0.15),
            k_a2: nominal.k_a2 * depot * factor(0.15),
            v_ld: nominal.v_ld * factor(0.40),
            k_e: nominal.k_e * factor(0.10),
            v_ins: nominal.v_ins * factor(0.06),
            e_m: nominal.e_m * factor(0.22),
            e_half: nominal.e_half * factor(0.25),
            k_u: nominal.k_u * intestine,
            k_l: nominal.k_l * intestine,
            k_r: nominal.k_r * factor(0.30),
            ..nominal
        };
        let mut normal =
            |mean: f64, sd: f64| mean + (sd * standard_normal(rng)).clamp(-2.0 * sd, 2.0 * sd);
        Self {
            k: normal(0.62, 0.07),
            f: normal(0.88, 0.03),
            g_r: normal(nominal.g_r, 0.7),
            weight: Kilograms(normal(76.3, 15.9).clamp(50.0, 115.0)),
            ..drawn
        }
    }
}
