//! What a twin answers to meals under other doses (paper, "Evaluation of digital twins behavior under
//! variable insulin boluses and carbohydrate inputs"), and whether its answers are in order.

use contract::Document as _;
use contract::what_if::{WhatIf, WhatIfCurve, WhatIfOrder, WhatIfPlan};
use nn_statespace::initial_state::steady_state;
use physiology::{Context, Grams, MgPerDl, STEP, StepInput, Units, UnitsPerHour};
use rayon::prelude::*;
use stats::quantile;
use twins::Twin;

use crate::error::EvaluationError;
use crate::readings::readings;

/// The paper's meals and ratios over five hours; the order is checked at three glucose levels
/// and three hours, which the paper leaves open.
#[must_use]
pub fn paper_plan() -> WhatIfPlan {
    WhatIfPlan {
        carbs_g: vec![30.0, 60.0, 90.0],
        ratios_g_per_u: vec![10.0, 20.0, 30.0],
        starts_mg_dl: vec![120.0, 90.0, 180.0],
        hours: vec![12, 7, 19],
        steps: 60,
    }
}

/// Runs every twin through the plan.
///
/// A run starts from the population model's steady state at its glucose, with the basal rate that
/// holds it, heart rate at the person's median, awake, on a weekday. Meal and bolus are taken in the
/// first step.
///
/// # Errors
/// Those of the steady state, and a simulation that leaves the finite numbers.
pub fn what_if(twins: &[(&str, &Twin)], plan: &WhatIfPlan) -> Result<WhatIf, EvaluationError> {
    let answers: Vec<Vec<Condition>> = twins
        .par_iter()
        .map(|(person, twin)| answers(twin, plan).map_err(|error| error.of_person(person)))
        .collect::<Result<_, _>>()?;
    let mut curves = Vec::new();
    for (meal, carbs_g) in plan.carbs_g.iter().enumerate() {
        for (ratio, ratio_g_per_u) in plan.ratios_g_per_u.iter().enumerate() {
            let of_people: Vec<&[f64]> =
                answers.iter().map(|a| a[0].curves[meal][ratio].as_slice()).collect();
            curves.push(curve(*carbs_g, *ratio_g_per_u, &of_people));
        }
    }
    let order = twins.iter().zip(&answers);
    let order = order.map(|((person, _), answers)| self::order(person, answers, plan)).collect();
    Ok(WhatIf { schema: WhatIf::SCHEMA.to_owned(), plan: plan.clone(), curves, order })
}

/// One twin's runs at a start and an hour.
struct Condition {
    start: f64,
    hour: u8,
    /// Glucose by meal and ratio, mg/dL.
    curves: Vec<Vec<Vec<f64>>>,
}

/// One twin's runs under every condition.
fn answers(twin: &Twin, plan: &WhatIfPlan) -> Result<Vec<Condition>, EvaluationError> {
    let mut conditions = Vec::new();
    for start in &plan.starts_mg_dl {
        let held = steady_state(&twin.population, MgPerDl(*start))?;
        for hour in &plan.hours {
            let run = |carbs: f64, ratio: f64| -> Result<Vec<f64>, EvaluationError> {
                let inputs = inputs(plan, held.basal, *hour, carbs, ratio);
                let readings = readings(twin, held.states, &inputs)?;
                Ok(readings.into_iter().map(|glucose| glucose.0).collect())
            };
            let of_meal = |carbs: &f64| -> Result<Vec<Vec<f64>>, EvaluationError> {
                plan.ratios_g_per_u.iter().map(|ratio| run(*carbs, *ratio)).collect()
            };
            let curves = plan.carbs_g.iter().map(of_meal).collect::<Result<_, _>>()?;
            conditions.push(Condition { start: *start, hour: *hour, curves });
        }
    }
    Ok(conditions)
}

/// Whether the answers are in order.
fn order(person: &str, answers: &[Condition], plan: &WhatIfPlan) -> WhatIfOrder {
    let mean = |curve: &[f64]| curve.iter().sum::<f64>() / curve.len() as f64;
    let peak = |curve: &[f64]| curve.iter().copied().fold(f64::MIN, f64::max);
    let mut order = WhatIfOrder {
        person_id: person.to_owned(),
        ordered: true,
        worst_mg_dl: 0.0,
        worst_at: String::new(),
        peaks_grow_with_meals: true,
    };
    for condition in answers {
        for (curves, carbs) in condition.curves.iter().zip(&plan.carbs_g) {
            for (pair, ratios) in curves.windows(2).zip(plan.ratios_g_per_u.windows(2)) {
                let excess = pair[0].iter().zip(&pair[1]).map(|(more, less)| more - less);
                let excess = excess.fold(0.0, f64::max);
                if excess > order.worst_mg_dl {
                    order.worst_mg_dl = excess;
                    order.worst_at = format!(
                        "{carbs} g at {} mg/dL and {} h, {} against {} g/U",
                        condition.start, condition.hour, ratios[1], ratios[0]
                    );
                }
                order.ordered &= mean(&pair[1]) > mean(&pair[0]);
            }
        }
        for ratio in 0..plan.ratios_g_per_u.len() {
            let mut peaks = condition.curves.windows(2);
            order.peaks_grow_with_meals &=
                peaks.all(|pair| peak(&pair[1][ratio]) >= peak(&pair[0][ratio]));
        }
    }
    order.ordered &= order.worst_mg_dl <= WhatIfOrder::SAME_MG_DL;
    order
}

fn inputs(
    plan: &WhatIfPlan,
    basal: UnitsPerHour,
    hour: u8,
    carbs: f64,
    ratio: f64,
) -> Vec<StepInput> {
    (0..plan.steps)
        .map(|step| {
            let passed = (step as f64 * STEP.0 / 60.0) as u8;
            let first = step == 0;
            StepInput {
                basal,
                bolus: Units(if first { carbs / ratio } else { 0.0 }),
                carbs: Grams(if first { carbs } else { 0.0 }),
                context: Context { hour: (hour + passed) % 24, ..Context::default() },
                ..StepInput::default()
            }
        })
        .collect()
}

/// Quartiles over people, step by step.
fn curve(carbs_g: f64, ratio_g_per_u: f64, people: &[&[f64]]) -> WhatIfCurve {
    let steps = people.first().map_or(0, |curve| curve.len());
    let quartiles: Vec<[f64; 3]> = (0..steps)
        .map(|step| {
            let mut at: Vec<f64> = people.iter().map(|curve| curve[step]).collect();
            at.sort_by(f64::total_cmp);
            [0.25, 0.5, 0.75].map(|level| quantile(&at, level))
        })
        .collect();
    WhatIfCurve {
        carbs_g,
        ratio_g_per_u,
        minutes: (0..steps).map(|step| step as f64 * STEP.0).collect(),
        lower: quartiles.iter().map(|q| q[0]).collect(),
        median: quartiles.iter().map(|q| q[1]).collect(),
        upper: quartiles.iter().map(|q| q[2]).collect(),
    }
}
