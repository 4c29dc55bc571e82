//! Made-up answers of twins to meals under other doses.

use serde_json::{Value, json};

/// Answers of the twelve twins; those in `out` are out of order.
pub(super) fn what_if(out: &[&str]) -> Value {
    let minutes: Vec<f64> = (0..=60).map(|k| f64::from(k) * 5.0).collect();
    let curve = |carbs: f64, ratio: f64| {
        let at = |minute: f64, share: f64| {
            let hours = minute / 60.0;
            let rise = 1.7 * carbs * hours * (-hours / 1.2).exp();
            let fall = 22.0 * carbs / ratio * (hours / 3.0).powi(2).min(1.0);
            120.0 + share * (rise - fall)
        };
        let course = |share: f64| -> Vec<f64> { minutes.iter().map(|m| at(*m, share)).collect() };
        // Below the start the smaller share gives the higher glucose.
        let (one, other) = (course(0.8), course(1.25));
        let pick = |of: fn(f64, f64) -> f64| -> Vec<f64> {
            one.iter().zip(&other).map(|(a, b)| of(*a, *b)).collect()
        };
        json!({"carbs_g": carbs, "ratio_g_per_u": ratio, "minutes": minutes,
            "lower": pick(f64::min), "median": course(1.0), "upper": pick(f64::max)})
    };
    let curves: Vec<Value> = [30.0, 60.0, 90.0]
        .into_iter()
        .flat_map(|carbs| [10.0, 20.0, 30.0].map(|ratio| (carbs, ratio)))
        .map(|(carbs, ratio)| curve(carbs, ratio))
        .collect();
    let order: Vec<Value> = (1..=12)
        .map(|k| format!("p{k:02}"))
        .map(|person| {
            let ordered = !out.contains(&person.as_str());
            let (worst, place) = match ordered {
                true => (0.0, ""),
                false => (6.4, "30 g at 180 mg/dL and 7 h, 20 against 10 g/U"),
            };
            json!({"person_id": person, "ordered": ordered, "worst_mg_dl": worst,
                "worst_at": place, "peaks_grow_with_meals": person != "p05"})
        })
        .collect();
    json!({"schema": "what-if/1", "plan": {"carbs_g": [30.0, 60.0, 90.0],
            "ratios_g_per_u": [10.0, 20.0, 30.0], "starts_mg_dl": [120.0, 90.0, 180.0],
            "hours": [12, 7, 19], "steps": 60},
        "curves": curves, "order": order})
}
