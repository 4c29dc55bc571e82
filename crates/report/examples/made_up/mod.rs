//! A made-up run: JSON of every part, as the pipeline would write it.

mod blind_check;
mod complete;
mod diagnosis;
mod people;
mod what_if;

use std::f64::consts::TAU;

use report::Part;
use serde_json::{Value, json};

pub(crate) use blind_check::{blind_check, seal};
pub(crate) use complete::completed;
pub(crate) use diagnosis::diagnosis;
pub(crate) use people::{data_in_use, glucose_by_person, truth};
use what_if::what_if;

/// The parts that the output folder of a command holds: `diagnose`, `none` and `unknown` for
/// diagnoses with that verdict, `blind-check`; anything else has every part.
pub(crate) fn folder(of: &str) -> Vec<(Part, Value)> {
    let manifest = (Part::Manifest, manifest());
    match of {
        "diagnose" => vec![manifest, (Part::Diagnosis, diagnosis("effect"))],
        "none" | "unknown" => vec![manifest, (Part::Diagnosis, diagnosis(of))],
        "blind-check" => {
            vec![manifest, (Part::BlindCheck, blind_check()), (Part::Seal, seal())]
        }
        _ => parts(),
    }
}

/// Every part with its JSON.
pub(crate) fn parts() -> Vec<(Part, Value)> {
    vec![
        (Part::Manifest, manifest()),
        (Part::Outcomes, outcomes()),
        (Part::Conformance, conformance()),
        (Part::Diagnosis, diagnosis("effect")),
        (Part::Training, training()),
        (Part::Twins, twins()),
        (Part::ImportReport, import_report()),
        (Part::ExampleDay, example_day()),
        (Part::WhatIf, what_if(&["p03", "p09"])),
        (Part::WhatIfConstrained, what_if(&[])),
        (Part::Agp, agp()),
        (Part::BlindCheck, blind_check()),
        (Part::Seal, seal()),
        (Part::DataInUse, data_in_use()),
        (Part::GlucoseByPerson, glucose_by_person(3)),
        (Part::Truth, truth()),
    ]
}

fn manifest() -> Value {
    json!({"schema": "manifest/1", "stage": "pipeline",
        "command": "cargo xtask pipeline --profile quick --out out --seed 1",
        "version": "0.1.0", "seed": 1,
        "config": {"profile": "quick", "people": 12, "days": 28, "window_minutes": 300},
        "inputs": [{"path": "made-up/records.csv",
            "sha256": "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"}]})
}

fn outcomes() -> Value {
    let row = |metric: &str, unit: &str, margin: f64, mean: f64, sd: f64, shift: f64, half: f64| {
        let p = if shift.abs() + half < margin { 0.0004 } else { 0.37 };
        json!({"metric": metric, "unit": unit, "margin": margin,
            "actual": {"mean": mean, "sd": sd}, "simulated": {"mean": mean + shift, "sd": 1.1 * sd},
            "difference": {"value": shift, "lower": shift - 0.9 * half, "upper": shift + 0.9 * half},
            "difference_t": {"value": shift, "lower": shift - half, "upper": shift + half},
            "p": p, "p_holm": 2.0 * p, "equivalent": p < 0.05,
            "p_unbiased": if half < margin { 0.002 } else { 0.18 }})
    };
    let method = |name: &str, label: &str, size: f64, scatter: f64| {
        json!({"name": name, "label": label, "starts_not_at_rest": 0,
            "rmse_5h": {"mean": 34.0 + 6.0 * size, "sd": 7.0}, "rows": [
            row("tir", "%", 5.0, 70.5, 16.2, -1.1 * size, 1.4 * scatter),
            row("tar", "%", 5.0, 26.1, 17.1, 1.6 * size, 1.5 * scatter),
            row("tbr", "%", 1.0, 3.4, 3.5, -0.5 * size, 0.6 * scatter),
            row("lbgi", "", 0.5, 0.9, 0.8, -0.09 * size, 0.11 * scatter),
            row("hbgi", "", 1.0, 5.9, 4.3, 0.2 * size, 0.4 * scatter),
            row("mg", "mg/dL", 10.0, 151.2, 26.9, 2.2 * size, 3.1 * scatter)]})
    };
    let ablated = || {
        [("time_only", "Time only", 1.7), ("none", "No inputs", 2.4)]
            .map(|(name, label, size)| method(name, label, size, 1.3))
    };
    let scenario = |name: &str, label: &str, windows: usize, size: f64| {
        let mut methods = vec![method("twin", "Digital twin", size, 1.2)];
        methods.extend(ablated());
        json!({"scenario": name, "label": label, "people": 12, "windows": windows,
            "methods": methods})
    };
    let forecast: Vec<Value> = [("twin", 15.0), ("population", 18.0), ("persistence", 21.0)]
        .iter()
        .flat_map(|(name, base)| {
            [30, 60, 120].map(|minutes| {
                let mean = base * (f64::from(minutes) / 30.0_f64).sqrt();
                json!({"method": name, "minutes": minutes, "people": 12, "rmse": {"mean": mean, "sd": 0.2 * mean}})
            })
        })
        .collect();
    json!({"schema": "outcomes/2", "cohort": "made-up cohort", "people": 12, "windows": 412,
        "window_minutes": 300,
        "exclusions": [{"person_id": "p13", "reason": "no carbohydrate in the second part"}],
        "interval": {"method": "bootstrap over people", "level": 0.9, "replicates": 2000},
        "training_days": method("", "", 0.3, 0.8)["rows"],
        "methods": [method("twin", "Digital twin", 1.0, 1.0),
            method("population", "Population network", 3.2, 1.1),
            method("ode", "ODE, population parameters", 3.0, 1.2),
            method("closest", "ODE, closest virtual patient", 2.1, 1.9),
            method("bayesian_optimisation", "ODE, Bayesian optimisation", 1.9, 1.4),
            method("map", "ODE, most probable", 1.6, 1.3),
            method("posterior", "ODE, posterior", 1.4, 1.3),
            method("constrained_twin", "Twin, signs kept", 1.2, 1.0)],
        "ablation": ablated(),
        "scenarios": [scenario("physical_activity", "Physical activity", 44, 1.5),
            scenario("meal", "Meals", 131, 1.1),
            json!({"scenario": "sleep", "label": "Sleep", "people": 1, "windows": 7, "methods": []})],
        "forecast": forecast,
        "comparisons": [
            {"first": "twin", "second": "closest", "quantity": "RMSE over 5 h", "unit": "mg/dL",
             "difference": {"value": -4.1, "lower": -6.0, "upper": -2.3}, "p": 0.002, "p_holm": 0.004},
            {"first": "twin", "second": "none", "quantity": "RMSE over 5 h", "unit": "mg/dL",
             "difference": {"value": -0.9, "lower": -2.0, "upper": 0.3}, "p": 0.21, "p_holm": 0.21}]})
}

fn conformance() -> Value {
    let row = |network, input, property, kind, low: f64, high: f64, verdict| {
        json!({"network": network, "input": input, "property": property, "kind": kind,
            "m_lower": low, "m_upper": high, "verdict": verdict, "seconds": 0.013})
    };
    json!({"rows": [
        row("Q1", "X1", "decreasing", "physical", -0.021, -0.0208, "proved"),
        row("Q1", "X3", "decreasing", "physical", 0.3275, 0.3276, "violated"),
        row("X2", "X2", "decreasing", "physical", -0.0108953, -0.0108953, "proved"),
        row("C1", "u_carbs", "increasing", "physical", -1.2e-4, 2.0e-5, "undecided"),
        row("X2", "I", "decreasing", "opposite_informational", 0.041, 0.0411, "violated")]})
}

fn training() -> Value {
    let epochs: Vec<Value> = (1..=15)
        .map(|epoch| {
            let fall = (-0.25 * f64::from(epoch)).exp();
            json!({"epoch": epoch, "train_loss": 0.012 + 0.9 * fall,
                "validation_loss": 0.019 + 0.95 * fall, "learning_rate": 0.001})
        })
        .collect();
    json!({"schema": "training/1", "model": "population", "seed": 1, "epochs": epochs,
        "data": {"windows_train": 9000, "windows_validation": 1000,
            "hash": "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"},
        "seconds": 41.2})
}

fn twins() -> Value {
    let mut people: Vec<Value> = (1..=12_u32)
        .map(|k| {
            let population = 38.0 + f64::from(k * 7 % 12) * 2.5;
            let twin = population * (0.72 + 0.03 * f64::from(k * 5 % 12));
            json!({"person_id": format!("p{k:02}"), "windows_train": 180 + k, "windows_test": 60,
                "excluded": null, "loss_first": 1.31, "loss_last": 0.42,
                "rmse_population": population, "rmse_twin": twin})
        })
        .collect();
    people.push(json!({"person_id": "p13", "excluded": "no insulin in the first two weeks"}));
    json!({"schema": "twins/1", "people": people})
}

fn import_report() -> Value {
    let person = |k: u32| {
        let (id, basal) = (format!("p{k:02}"), 20.0 + f64::from(k));
        json!({
            "line": format!("{id}: 28 days, {basal:.1} + 18.0 U/day, 160 g/day, mean 150 mg/dL"),
            "balance": {"person": id, "days": 28.0, "basal_u_day": basal, "bolus_u_day": 18.0,
                "carbs_g_day": 160.0, "mean_glucose_mg_dl": 150.0, "cgm_share": 0.97,
                "heart_rate_share": 0.9},
            "findings": if k == 4 {
                json!([{"person": id, "column": "carbs_g", "date": null, "step": 1204,
                    "time": "2021-03-05 04:20:00", "what": "meal", "value": 900.0, "unit": "g",
                    "plausible": [0.0, 250.0]}])
            } else {
                json!([])
            },
        })
    };
    json!({"format": "a study's tables", "people": (1..=13).map(person).collect::<Vec<_>>(),
        "inferences": [{"person": "p02", "file": "records.csv", "column": "carbs_g",
            "conclusion": "servings of 10 g", "evidence": "16 g/U"}],
        "notes": [{"person": "p03", "file": "records.csv", "row": 1204, "what": "filled gap",
            "count": 3}]})
}

fn example_day() -> Value {
    let days = 3_u32;
    let steps = 288 * days;
    let hour = |k: u32| f64::from(k % 288) / 12.0;
    let meal = |k: u32, at: f64, size: f64| {
        let since = hour(k) - at;
        if since < 0.0 { 0.0 } else { size * since * (-since / 1.1).exp() * 2.4 }
    };
    let glucose = |k: u32, dawn: f64, size: f64| {
        let rise = dawn * (-((hour(k) - 6.0) / 1.8).powi(2)).exp();
        105.0
            + rise
            + meal(k, 7.5, 70.0 * size)
            + meal(k, 13.0, 60.0 * size)
            + meal(k, 19.5, 85.0 * size)
    };
    let series = |of: &dyn Fn(u32) -> Value| -> Vec<Value> { (0..steps).map(of).collect() };
    let doses = |k: u32, at: [u32; 3], of: [f64; 3], otherwise: f64| {
        at.iter().position(|step| *step == k % 288).map_or(otherwise, |meal| of[meal])
    };
    let shares = |tbr: f64, tir: f64, tar: f64| json!({"tbr": tbr, "tir": tir, "tar": tar});
    json!({"person_id": "p07", "date": "days 17 to 19", "days": days,
        "time": series(&|k| json!(format!("{:02}:{:02}", k % 288 / 12, k % 12 * 5))),
        "cgm": series(&|k| if (200..212).contains(&k) { Value::Null } else {
            json!((glucose(k, 38.0, 1.0) + 4.0 * (f64::from(k) * 1.7).sin()).round()) }),
        "population": series(&|k| json!(glucose(k, 0.0, 0.7))),
        "twin": series(&|k| json!(glucose(k, 33.0, 0.95))),
        "ode": series(&|k| json!(glucose(k, 5.0, 1.2))),
        "closest": series(&|k| json!(glucose(k, 12.0, 1.1))),
        "basal_u_h": series(&|_| json!(0.9)),
        "bolus_u": series(&|k| json!(doses(k, [88, 154, 232], [5.5, 4.5, 7.2], 0.0))),
        "carbs_g": series(&|k| json!(doses(k, [90, 156, 234], [55.0, 45.0, 72.0], 0.0))),
        "heart_rate_over_baseline": series(&|k| json!(
            10.0 * (hour(k) / 24.0 * TAU - 2.0).sin()
                + if (204..216).contains(&(k % 288)) { 45.0 } else { 0.0 })),
        "sleep_efficiency": series(&|k| json!(
            if !(78..=276).contains(&(k % 288)) { 0.92 } else { 0.0 })),
        "outcomes": {"cgm": shares(1.9, 83.1, 15.0), "population": shares(0.0, 97.4, 2.6),
            "twin": shares(4.7, 88.4, 6.8), "ode": shares(0.3, 84.0, 15.7),
            "closest": shares(16.6, 62.6, 20.8)},
        "chosen": "person with the median twin error, first 3 consecutive days after training"})
}

fn agp() -> Value {
    let hours: Vec<f64> = (0..=96).map(|k| f64::from(k) / 4.0).collect();
    let percentile = |z: f64, shift: f64| -> Vec<f64> {
        let middle = |h: f64| 135.0 + 25.0 * ((h - 9.0) / 24.0 * 2.0 * TAU).sin() + shift;
        hours.iter().map(|h| middle(*h) * (0.28 * z).exp()).collect()
    };
    let percentiles = |shift: f64| {
        json!({"p05": percentile(-1.64, shift), "p25": percentile(-0.67, shift),
            "p50": percentile(0.0, shift), "p75": percentile(0.67, shift),
            "p95": percentile(1.64, shift)})
    };
    json!({"person_id": "cohort", "hour": hours, "observed": percentiles(0.0),
        "twin": percentiles(-9.0)})
}
