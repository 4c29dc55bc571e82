//! Parameters of the saturating body and how they differ between people.

use crate::body::Spread::{Fixed, Inverse, Normal, Own, Shared, SharedAndOwn};
use crate::body::parameters;

// What parameters share.
const ACTION: usize = 0;
const DEPOT: usize = 1;
const INTESTINE: usize = 2;

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
    ///
    /// Spreads under the skin: the ranges of Wilinska et al. 2005, narrowed, since they hold error. The
    /// others are assumed.
    SaturatingParameters, shared [0.22, 0.15, 0.20];
    /// Distribution volume of plasma and fast tissues V_p, L/kg.
    v_p: 0.155, Own(0.06);
    /// Distribution volume of muscle V_m, L/kg.
    v_m: 0.10, Own(0.06);
    /// Transport between them, L/kg/min.
    transport: 0.025, Own(0.15);
    /// Capacity of the brain's carriers V_b, mmol/kg/min.
    v_b: 0.0070, Own(0.06);
    /// Their half-saturation K_b, mmol/L.
    k_b: 1.0, Fixed;
    /// Capacity of muscle without insulin V_0, mmol/kg/min.
    v_0: 0.0030, Own(0.20);
    /// Capacity that insulin adds at most V_i, mmol/kg/min.
    v_i: 0.080, Own(0.12);
    /// Insulin that adds half of it x_50, mU/L.
    x_50: 70.0, Inverse(ACTION, 0.15);
    /// Half-saturation of the muscle's carriers K_m, mmol/L.
    k_m: 2.2, Own(0.10);
    /// Gluconeogenesis G_ng, mmol/kg/min.
    g_ng: 0.0060, Own(0.10);
    /// Largest release from glycogen E_max, mmol/kg/min.
    e_max: 0.0564, Own(0.12);
    /// Glucagon that frees half of it C_50, pg/mL.
    c_50: 436.0, Fixed;
    /// Insulin that suppresses half of it y_50, mU/L.
    y_50: 12.0, Inverse(ACTION, 0.15);
    /// Steepness of that h, unitless.
    y_h: 1.5, Fixed;
    /// Rate of insulin's action on muscle k_x, 1/min.
    k_x: 0.022, Own(0.20);
    /// Rate of insulin's action on the liver k_y, 1/min.
    k_y: 0.030, Own(0.20);
    /// Glucagon without insulin n_0, pg/mL.
    n_0: 70.0, Own(0.15);
    /// Rise of glucagon in a low, as a share.
    n_low: 0.20, Own(0.40);
    /// Insulin that halves glucagon n_i, mU/L.
    n_i: 60.0, Fixed;
    /// Rate of glucagon k_n, 1/min.
    k_n: 0.12, Fixed;
    /// Share of the insulin on the slow channel k, unitless.
    k: 0.62, Normal(0.62, 0.07);
    /// Rate of the slow channel k_a1, 1/min.
    k_a1: 0.014, SharedAndOwn(DEPOT, 0.15);
    /// Rate of the fast channel k_a2, 1/min.
    k_a2: 0.023, SharedAndOwn(DEPOT, 0.15);
    /// Largest loss under the skin V_LD, mU/min.
    v_ld: 1.93, Own(0.40);
    /// Insulin at which half of it is lost K_LD, mU.
    k_ld: 62.6, Fixed;
    /// Elimination of insulin k_e, 1/min.
    k_e: 0.133, Own(0.10);
    /// Distribution volume of insulin, L/kg.
    v_ins: 0.16, Own(0.06);
    /// Largest rate of emptying of the stomach E_m, g/min.
    e_m: 1.2, Own(0.22);
    /// Content at which it is half of that, g.
    e_half: 35.0, Own(0.25);
    /// Rate from upper to lower intestine k_u, 1/min.
    k_u: 0.10, Shared(INTESTINE);
    /// Rate of absorption k_l, 1/min.
    k_l: 0.10, Shared(INTESTINE);
    /// Share of the carbohydrate that appears in plasma f, unitless.
    f: 0.88, Normal(0.88, 0.03);
    /// Renal threshold G_r, mmol/L.
    g_r: 10.5, Normal(10.5, 0.7);
    /// Renal clearance above it k_r, L/kg/min.
    k_r: 0.0008, Own(0.30);
}
