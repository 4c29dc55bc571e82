//! The equations of the saturating body, term by term.
//!
//! Pure functions on bare `f64`; glucose in mmol/L and mmol/kg/min, insulin in mU and mU/L,
//! glucagon in pg/mL, carbohydrate in g, time in min.

use physiology::GRAMS_PER_MMOL_GLUCOSE;

use super::parameters::SaturatingParameters;
use crate::body::compartments;
use crate::effects::Condition;

/// Glucose about which glucagon reacts to a low, and the width of that reaction, mmol/L.
const LOW: (f64, f64) = (3.6, 0.35);
/// Glucose over which the kidneys begin to lose it, as a share of the threshold (splay).
const SPLAY: f64 = 0.25;

compartments! {
    /// The twelve compartments, and their rates of change.
    SaturatingCompartments {
        /// Glucose in plasma, mmol/L.
        plasma: Q1,
        /// Glucose in the fluid around the muscle cells, mmol/L.
        muscle: Q2,
        /// Insulin in plasma I, mU/L.
        insulin: I,
        /// Insulin that acts on muscle, mU/L.
        at_muscle: X2,
        /// Insulin that acts on the liver, mU/L.
        at_liver: X3,
        /// Glucagon in plasma, pg/mL.
        glucagon: X3,
        /// Insulin in the first compartment of the slow channel Q_1a, mU.
        slow: S1,
        /// Insulin in the second compartment of the slow channel Q_2, mU.
        slow_next: S2,
        /// Insulin in the fast channel Q_1b, mU.
        fast: S1,
        /// Carbohydrate in the stomach, g.
        stomach: C1,
        /// Carbohydrate in the upper intestine, g.
        upper: C2,
        /// Carbohydrate in the lower intestine, g.
        lower: C2,
    }
}

/// What acts on the compartments through one step. All factors are 1 in the body as drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Forcing {
    /// Circumstances, with what exercise does to them.
    pub(super) condition: Condition,
    /// Insulin that arrives under the skin, mU/min.
    pub(super) insulin: f64,
    /// Capacity of muscle that work adds, mmol/kg/min.
    pub(super) work: f64,
}

/// Flux of a substance through a carrier of this capacity and half-saturation.
fn carried(capacity: f64, half: f64, substance: f64) -> f64 {
    capacity * substance / (half + substance)
}

/// Endogenous production, mmol/kg/min: gluconeogenesis, and release from glycogen by glucagon,
/// which insulin suppresses: G_ng + E_max C/(C_50 + C) / (1 + (y/y_50)^h).
#[must_use]
pub(super) fn production(p: &SaturatingParameters, at_liver: f64, glucagon: f64) -> f64 {
    let held_back = 1.0 + (at_liver / p.y_50).powf(p.y_h);
    p.g_ng + carried(p.e_max, p.c_50, glucagon) / held_back
}

/// Uptake by muscle, mmol/kg/min: (V_0 + V_i x/(x_50 + x) + work) m/(K_m + m).
#[must_use]
pub(super) fn uptake(p: &SaturatingParameters, muscle: f64, at_muscle: f64, work: f64) -> f64 {
    let capacity = p.v_0 + carried(p.v_i, p.x_50, at_muscle) + work;
    carried(capacity, p.k_m, muscle)
}

/// Uptake by the brain, mmol/kg/min.
#[must_use]
pub(super) fn brain(p: &SaturatingParameters, plasma: f64) -> f64 {
    carried(p.v_b, p.k_b, plasma)
}

/// Renal excretion, mmol/kg/min: the filtered glucose beyond a capacity of reabsorption that sets
/// in smoothly: k_r (d + sqrt(d^2 + s^2))/2 with d = G - G_r and s a quarter of G_r, less its value
/// at 0.
#[must_use]
pub(super) fn excretion(k_r: f64, threshold: f64, plasma: f64) -> f64 {
    let splay = SPLAY * threshold;
    let beyond = |glucose: f64| {
        let above = glucose - threshold;
        0.5 * (above + above.hypot(splay))
    };
    k_r * (beyond(plasma) - beyond(0.0))
}

/// Level to which glucagon tends, pg/mL: lowered by insulin, raised by a low.
#[must_use]
pub(super) fn glucagon_wanted(p: &SaturatingParameters, plasma: f64, insulin: f64) -> f64 {
    let (middle, width) = LOW;
    let low = 1.0 / (1.0 + ((plasma - middle) / width).exp());
    p.n_0 * (1.0 + p.n_low * low) / (1.0 + insulin / p.n_i)
}

/// Insulin lost under the skin, mU/min: V_LD Q/(K_LD + Q).
#[must_use]
pub(super) fn lost(p: &SaturatingParameters, amount: f64) -> f64 {
    carried(p.v_ld, p.k_ld, amount.max(0.0))
}

/// Rate of change of the compartments, per minute.
#[must_use]
pub(super) fn derivative(
    p: &SaturatingParameters,
    s: &SaturatingCompartments,
    forcing: &Forcing,
) -> SaturatingCompartments {
    let c = &forcing.condition;
    let depot = 1.0 / c.insulin_time;
    let (k_a1, k_a2) = (depot * p.k_a1, depot * p.k_a2);
    let gut = 1.0 / c.gut_time;
    let emptied = gut * carried(p.e_m, p.e_half, s.stomach.max(0.0));
    let (passed, absorbed) = (gut * p.k_u * s.upper, gut * p.k_l * s.lower);
    let appearing = p.f * absorbed / (GRAMS_PER_MMOL_GLUCOSE * p.weight.0);
    let renal = excretion(p.k_r * c.renal_slope, p.g_r * c.renal_threshold, s.plasma);
    let exchanged = p.transport * (s.plasma - s.muscle);
    let made = c.production * production(p, s.at_liver, s.glucagon);
    SaturatingCompartments {
        plasma: (made + appearing + c.glucose_flux
            - c.uptake * brain(p, s.plasma)
            - renal
            - exchanged)
            / p.v_p,
        muscle: (exchanged - uptake(p, s.muscle, s.at_muscle, forcing.work)) / p.v_m,
        insulin: (k_a1 * s.slow_next + k_a2 * s.fast) / (p.v_ins * p.weight.0) - p.k_e * s.insulin,
        at_muscle: p.k_x * (c.action * s.insulin - s.at_muscle),
        at_liver: p.k_y * (c.liver_action * s.insulin - s.at_liver),
        glucagon: p.k_n * (glucagon_wanted(p, s.plasma, s.insulin) - s.glucagon),
        slow: p.k * forcing.insulin - k_a1 * s.slow - lost(p, s.slow),
        slow_next: k_a1 * (s.slow - s.slow_next),
        fast: (1.0 - p.k) * forcing.insulin - k_a2 * s.fast - lost(p, s.fast),
        stomach: -emptied,
        upper: emptied - passed,
        lower: passed - absorbed,
    }
}
