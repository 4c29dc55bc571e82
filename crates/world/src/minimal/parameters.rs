//! Parameters of the minimal body and how they differ between people.

use crate::body::Spread::{Normal, Own, Shared, SharedAndOwn};
use crate::body::parameters;

// What parameters share.
const ACTION: usize = 0;
const DEPOT: usize = 1;

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
    ///
    /// The spreads are assumed of the order of those between the ten patients of Kanderian et al. 2009,
    /// which also hold error.
    MinimalParameters, shared [0.22, 0.18];
    /// Distribution volume of glucose V_G, dL/kg.
    v_g: 1.70, Own(0.06);
    /// Clearance of glucose without insulin (GEZI), 1/min.
    k_g: 0.0012, Own(0.25);
    /// Zero-order uptake R_d0, mg/kg/min.
    r_d0: 1.05, Own(0.08);
    /// Production without insulin P_0, mg/kg/min.
    p_0: 2.90, Own(0.10);
    /// Insulin sensitivity of disposal S_I, 1/min per mU/L.
    s_i: 3.2e-4, SharedAndOwn(ACTION, 0.15);
    /// Insulin sensitivity of production S_L, 1 per mU/L.
    s_l: 0.0315, SharedAndOwn(ACTION, 0.15);
    /// Rate of remote insulin p_2, 1/min.
    p_2: 0.015, Own(0.25);
    /// Rate of the liver's remote insulin p_L, 1/min.
    p_l: 0.030, Own(0.20);
    /// Clearance of insulin, L/kg/min.
    clearance: 0.017, Own(0.12);
    /// Distribution volume of insulin V_I, L/kg.
    v_i: 0.10, Own(0.08);
    /// Rate at which insulin under the skin falls apart k_h, 1/min.
    k_h: 0.040, Shared(DEPOT);
    /// Rate of absorption of a small depot k_a, 1/min.
    k_a: 0.020, SharedAndOwn(DEPOT, 0.10);
    /// Depot that is absorbed at half that rate D_50, U.
    d_50: 22.0, Own(0.30);
    /// Time in which half of solid food leaves the stomach t_half, min.
    t_half: 55.0, Own(0.22);
    /// Shape of the emptying beta, unitless.
    beta: 1.35, Normal(1.35, 0.18);
    /// Rate of absorption from the intestine k_abs, 1/min.
    k_abs: 0.050, Own(0.20);
    /// Share of the carbohydrate that appears in plasma f, unitless.
    f: 0.90, Normal(0.90, 0.03);
    /// Renal threshold G_r, mg/dL.
    g_r: 190.0, Normal(190.0, 12.0);
    /// Renal clearance above it k_r, dL/kg/min.
    k_r: 0.006, Own(0.30);
}
