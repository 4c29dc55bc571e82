//! The equations of the Padova body, term by term.
//!
//! Pure functions on bare `f64`; glucose masses in mg/kg, insulin in pmol/kg and pmol/L, time in
//! min, as in Dalla Man et al. 2007.

use physiology::GRAMS_PER_MMOL_GLUCOSE;

use super::parameters::PadovaParameters;
use crate::body::compartments;
use crate::effects::Condition;

/// Glucose below which the risk of S2013 grows no further, mg/dL.
const RISK_FLOOR: f64 = 60.0;

/// Parameters with the values derived from them, so that these are not computed again at every
/// step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Prepared {
    pub(super) p: PadovaParameters,
    k_p1: f64,
    v_m0: f64,
    /// ln(G_b)^r_2
    log_basal: f64,
}

impl Prepared {
    pub(super) fn new(p: PadovaParameters) -> Self {
        Self { p, k_p1: p.k_p1(), v_m0: p.v_m0(), log_basal: p.g_b.ln().powf(p.r_2) }
    }
}

/// Mass of one millimole of glucose, mg.
pub(super) const MG_PER_MMOL: f64 = 1000.0 * GRAMS_PER_MMOL_GLUCOSE;

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

/// What acts on the compartments through one step. All factors are 1 in the body as drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Forcing {
    /// Circumstances, with what exercise does to them.
    pub(super) condition: Condition,
    /// Insulin infusion under the skin, pmol/kg/min.
    pub(super) insulin: f64,
    /// Carbohydrate of the last meal plus the content of the stomach at that time D, mg.
    pub(super) meal: f64,
}

/// Rate of gastric emptying k_empt, 1/min, with `q_sto` mg in the stomach after a meal of `meal`
/// mg.
///
/// k_min + (k_max - k_min)/2 (tanh(alpha (q - b D)) - tanh(beta (q - d D)) + 2) with alpha = 5/(2 D
/// (1 - b)) and beta = 5/(2 D d) (Dalla Man et al. 2006 and 2007); k_max without a meal.
#[must_use]
pub(super) fn gastric_emptying(p: &PadovaParameters, q_sto: f64, meal: f64) -> f64 {
    if meal <= 0.0 {
        return p.k_max;
    }
    let alpha = 2.5 / (meal * (1.0 - p.b));
    let beta = 2.5 / (meal * p.d);
    let shape = (alpha * (q_sto - p.b * meal)).tanh() - (beta * (q_sto - p.d * meal)).tanh() + 2.0;
    p.k_min + 0.5 * (p.k_max - p.k_min) * shape
}

/// Endogenous production EGP = k_p1 - k_p2 G_p - k_p3 X^L, mg/kg/min, never negative.
#[must_use]
pub(super) fn production(body: &Prepared, g_p: f64, x_l: f64) -> f64 {
    let p = &body.p;
    (body.k_p1 - p.k_p2 * g_p - p.k_p3 * x_l).max(0.0)
}

/// Insulin-dependent uptake U_id, mg/kg/min: V_m G_t/(K_m0 + G_t).
///
/// V_m = capacity V_m0 + V_mx X (1 + r_1 risk), never negative; the risk of S2013 is 10
/// (ln(G)^r_2 - ln(G_b)^r_2)^2 below basal glucose, 0 above it, and does not grow below 60 mg/dL.
/// `glucose` in mg/dL, `g_t` in mg/kg, `x` in pmol/L.
#[must_use]
pub(super) fn uptake(body: &Prepared, glucose: f64, g_t: f64, x: f64, capacity: f64) -> f64 {
    let p = &body.p;
    let risk = if glucose < p.g_b {
        let distance = glucose.max(RISK_FLOOR).ln().powf(p.r_2) - body.log_basal;
        10.0 * distance * distance
    } else {
        0.0
    };
    let v_m = capacity * body.v_m0 + p.v_mx * x * (1.0 + p.r_1 * risk);
    v_m.max(0.0) * g_t / (p.k_m0 + g_t)
}

/// Renal excretion E, mg/kg/min: k_e1 (G_p - k_e2) above the threshold, else 0.
#[must_use]
pub(super) fn excretion(k_e1: f64, k_e2: f64, g_p: f64) -> f64 {
    k_e1 * (g_p - k_e2).max(0.0)
}

/// Uptake by brain and red cells, mg/kg/min: F_cns, in proportion to glucose below 60 mg/dL.
///
/// The publication has it constant, so glucose could become negative. `glucose` in mg/dL.
#[must_use]
pub(super) fn brain_uptake(p: &PadovaParameters, glucose: f64) -> f64 {
    p.f_cns * (glucose / RISK_FLOOR).clamp(0.0, 1.0)
}

/// Rate of change of the twelve compartments, per minute.
#[must_use]
pub(super) fn derivative(
    body: &Prepared,
    s: &PadovaCompartments,
    forcing: &Forcing,
) -> PadovaCompartments {
    let (p, c) = (&body.p, &forcing.condition);
    let glucose = s.g_p / p.v_g;
    let insulin = s.i_p / p.v_i;
    let k_empt = if s.q_sto2 == 0.0 && s.q_sto1 == 0.0 {
        p.k_max
    } else {
        gastric_emptying(p, s.q_sto1 + s.q_sto2, forcing.meal)
    };
    let gut = 1.0 / c.gut_time;
    let (ground, emptied, absorbed) =
        (gut * p.k_gri * s.q_sto1, gut * k_empt * s.q_sto2, gut * p.k_abs * s.q_gut);
    let depot = 1.0 / c.insulin_time;
    let appearance = p.f * absorbed / p.weight.0;
    let renal = excretion(p.k_e1 * c.renal_slope, p.k_e2 * c.renal_threshold, s.g_p);
    PadovaCompartments {
        g_p: c.production * production(body, s.g_p, s.x_l)
            + appearance
            + c.glucose_flux * MG_PER_MMOL
            - brain_uptake(p, glucose)
            - renal
            - p.k_1 * s.g_p
            + p.k_2 * s.g_t,
        g_t: p.k_1 * s.g_p - p.k_2 * s.g_t - uptake(body, glucose, s.g_t, s.x, c.uptake),
        i_p: p.m_1 * s.i_l - (p.m_2 + p.m_4) * s.i_p
            + depot * (p.k_a1 * s.i_sc1 + p.k_a2 * s.i_sc2),
        i_l: p.m_2 * s.i_p - (p.m_1 + p.m_3) * s.i_l,
        i_1: -p.k_i * (s.i_1 - c.liver_action * insulin),
        x_l: -p.k_i * (s.x_l - s.i_1),
        x: -p.p_2u * (s.x - (c.action * insulin - p.i_b)),
        q_sto1: -ground,
        q_sto2: ground - emptied,
        q_gut: emptied - absorbed,
        i_sc1: forcing.insulin - depot * (p.k_a1 + p.k_d) * s.i_sc1,
        i_sc2: depot * (p.k_d * s.i_sc1 - p.k_a2 * s.i_sc2),
    }
}
