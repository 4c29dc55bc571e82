//! Made-up people: the checks of their data, their glucose, and the truth about them.

use std::f64::consts::TAU;

use serde_json::{Value, json};

/// Checks of made-up data.
const CHECKS: [&str; 4] = ["missing_channel", "flat_cgm", "insulin_clock_offset", "plausible_day"];

/// The data in use: one person with a warning, one left out, others without a finding.
pub(crate) fn data_in_use() -> Value {
    let person = |k: u32| {
        let result = |check: &str| match (k, check) {
            (5, "insulin_clock_offset") => ("warn", json!(["insulin runs ahead of glucose"])),
            (11, "flat_cgm") => ("fail", json!(["the sensor stands still for 3 days"])),
            _ => ("pass", json!([])),
        };
        let checks: Vec<Value> = CHECKS
            .iter()
            .map(|check| {
                let (result, findings) = result(check);
                json!({"check": check, "result": result, "findings": findings})
            })
            .collect();
        let days_left_out = if k == 5 {
            json!([{"date": "2021-03-04", "reason": "plausible_day"}])
        } else {
            json!([])
        };
        let left_out = if k == 11 { json!("the sensor stands still") } else { Value::Null };
        json!({"person_id": format!("p{k:02}"), "left_out": left_out, "checks": checks, "days": 28,
            "days_left_out": days_left_out, "channels_left_out": []})
    };
    json!({"schema": "data-in-use/1", "people": (1..=12).map(person).collect::<Vec<_>>()})
}

/// Glucose of so many people.
pub(crate) fn glucose_by_person(people: u32) -> Value {
    let hours: Vec<f64> = (0..48).map(|slot| f64::from(slot) / 2.0 + 0.25).collect();
    let person = |k: u32| {
        let percentile = |z: f64| -> Vec<f64> {
            let middle =
                |h: f64| 135.0 + f64::from(k % 7) + 25.0 * ((h - 9.0) / 24.0 * 2.0 * TAU).sin();
            hours.iter().map(|h| (10.0 * middle(*h) * (0.28 * z).exp()).round() / 10.0).collect()
        };
        json!({"person_id": format!("p{k:02}"), "readings": 7800, "mean_mg_dl": 151.0, "cv": 36.0,
            "gmi": 6.9, "insulin_u_day": 41.5, "carbs_g_day": null,
            "ranges": {"below_54": 1.0, "from_54_to_70": 3.0, "from_70_to_180": 70.0,
                "from_180_to_250": 20.0, "above_250": 6.0},
            "percentiles": {"p05": percentile(-1.64), "p25": percentile(-0.67),
                "p50": percentile(0.0), "p75": percentile(0.67), "p95": percentile(1.64)}})
    };
    json!({"schema": "glucose-by-person/1", "hour": hours,
        "people": (1..=people).map(person).collect::<Vec<_>>()})
}

/// Three effects act, of which the made-up diagnosis finds one; it finds another that does not.
pub(crate) fn truth() -> Value {
    let acts = |effect: &str, size: f64| {
        json!({"effect": effect, "amplitude": size, "lowest": 0.7 * size, "highest": 1.4 * size,
            "people": 12, "says": "as made up", "shift_mg_dl": null})
    };
    json!({"schema": "truth/1", "source": "info.json",
        "effects": [acts("dawn", 1.2), acts("sleep_loss", 0.9), acts("slow_meals", 1.0)]})
}
