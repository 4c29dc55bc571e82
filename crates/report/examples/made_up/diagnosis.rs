//! A made-up diagnosis for each verdict.

use serde_json::{Value, json};

/// Effects that were tried: name, gain, probability.
const TRIED: [(&str, f64, f64); 12] = [
    ("dawn", 31.2, 0.97),
    ("circadian_sensitivity", 27.9, 0.02),
    ("exercise", 12.4, 0.91),
    ("post_exercise_sensitivity", 9.7, 0.06),
    ("slow_meals", 2.1, 0.0),
    ("missed_meals", 1.3, 0.0),
    ("carb_miscount", 0.4, 0.0),
    ("sensor_lag", 0.1, 0.0),
    ("renal_threshold", -0.2, 0.0),
    ("insulin_absorption", -0.8, 0.0),
    ("none", 0.0, 0.0),
    ("unknown", 6.2, 0.01),
];

/// Ports: name, gain, probability, what cannot be separated from it.
const PORTS: [(&str, f64, f64, &[&str]); 9] = [
    ("egp", 30.0, 0.62, &["glucose_flux"]),
    ("glucose_flux", 28.8, 0.31, &["egp"]),
    ("insulin_action", 14.2, 0.05, &[]),
    ("insulin_action_liver", 9.0, 0.01, &[]),
    ("gut_absorption", 2.2, 0.004, &["carb_amount"]),
    ("carb_amount", 1.9, 0.003, &["gut_absorption"]),
    ("insulin_absorption", 0.4, 0.0, &[]),
    ("insulin_input", 0.1, 0.0, &[]),
    ("sensor", -1.1, 0.0, &[]),
];

/// What made-up residual networks have absorbed.
fn absorbed() -> Value {
    json!({"without": "network", "verdict_without": "effect",
        "found_without": ["dawn", "exercise"],
        "effects": [
            {"effect": "dawn", "evidence_before": 88.0, "evidence_after": 31.2, "share": 0.65},
            {"effect": "exercise", "evidence_before": 10.0, "evidence_after": 12.4, "share": -0.24},
            {"effect": "alcohol", "evidence_before": 1.0, "evidence_after": 0.2, "share": null}],
        "baseline": [{"minutes": 60, "mae_before": 16.1, "mae_after": 14.5}]})
}

/// A diagnosis with the verdict `effect`, `unknown` or `none`.
pub(crate) fn diagnosis(verdict: &str) -> Value {
    let error = |value: f64| json!({"value": value, "lower": 0.9 * value, "upper": 1.1 * value});
    let finds = verdict == "effect";
    let something = if verdict == "none" { 0.07 } else { 0.97 };
    json!({"schema": "diagnosis/3", "verdict": verdict, "plant": "ode", "notes": [],
        "posterior": {"something": something, "sets": [], "speaks_from": 0.75, "names_from": 0.5,
            "source": "made up"},
        "effects": if finds { effects() } else { json!([]) },
        "candidates": candidates(verdict),
        "untried": [
            {"effect": "sleep_loss", "reason": "no person has sleep on record"},
            {"effect": "set_ageing", "reason": "set changes are not recorded"}],
        "ports": ports(),
        "where": if verdict == "none" { json!([]) } else { cells() },
        "hourly": if verdict == "none" { Value::Null } else { hourly(12) },
        "how_far": if finds { how_far() } else { json!({"horizons": [], "outcomes": []}) },
        "absorbed": if finds { absorbed() } else { Value::Null },
        "baseline": [
            {"minutes": 60, "mae": error(14.5), "rmse": error(20.1), "bias": error(1.2)},
            {"minutes": 300, "mae": error(30.4), "rmse": error(41.7), "bias": error(3.8)}],
        "data_quality": [{"check": "insulin_clock_offset", "person_id": "p05",
            "finding": "insulin runs ahead of glucose",
            "estimate": {"value": 55.0, "lower": 45.0, "upper": 65.0, "unit": "min"}},
            {"check": "missing_channel", "person_id": "p09", "finding": "no heart rate",
            "estimate": null}],
        "people": [{"person_id": "p01", "days": 28, "excluded": null},
            {"person_id": "p11", "days": 3, "excluded": "fewer than 7 days of record"}]})
}

fn effects() -> Value {
    let people = |size: f64, spread: f64| -> Vec<Value> {
        (1..=11_u32)
            .map(|k| {
                let amplitude = size + spread * (f64::from(k * 7 % 11) / 5.0 - 1.0);
                let half = 0.35 + 0.02 * f64::from(k);
                json!({"person_id": format!("p{k:02}"), "amplitude": amplitude,
                    "lower": amplitude - half, "upper": amplitude + half,
                    "gain_nats": 4.0 * amplitude - 1.0})
            })
            .collect()
    };
    json!([
        {"effect": "dawn", "port": "egp", "gain_nats": 31.2, "probability": 0.97,
            "amplitude": {"value": 1.1, "lower": 0.7, "upper": 1.5},
            "confusable_with": ["circadian_sensitivity"], "people": people(1.1, 0.5)},
        {"effect": "exercise", "port": "glucose_flux", "gain_nats": 4.4, "probability": 0.91,
            "amplitude": {"value": 0.62, "lower": 0.31, "upper": 0.95},
            "confusable_with": [], "people": people(0.6, 0.7)}])
}

fn candidates(verdict: &str) -> Value {
    let rows = TRIED.map(|(effect, gain, probability)| {
        let (gain, probability) = match (verdict, effect) {
            ("effect", _) => (gain, probability),
            ("none", "none") | ("unknown", "unknown") => (gain, 0.93),
            _ => (gain.min(6.0) / 5.0, 0.07 / 11.0),
        };
        json!({"effect": effect, "gain_nats": gain, "probability": probability})
    });
    json!(rows)
}

fn ports() -> Value {
    let rows = PORTS.map(|(port, gain, probability, like)| {
        json!({"port": port, "gain_nats": gain, "probability": probability, "confusable_with": like})
    });
    json!(rows)
}

fn how_far() -> Value {
    let horizon = |minutes: u32, before: f64, change: f64, half: f64, reconstructed: bool| {
        let floor = (!reconstructed).then_some(0.6 * before);
        let removed = floor.map(|floor| -change / (before - floor));
        json!({"minutes": minutes, "mae_before": before, "mae_after": before + change,
        "difference": {"value": change, "lower": change - half, "upper": change + half},
        "reconstructed": reconstructed, "floor": floor, "people": 11, "runs": 2100,
        "share_above_floor": removed.map(|value| {
            json!({"value": value, "lower": value - 0.1, "upper": value + 0.1})
        })})
    };
    let outcome = |metric: &str, margin: f64, before: f64, after: f64| {
        json!({"metric": metric, "margin": margin, "p_before": before, "p_after": after,
            "difference_before": 0.6 * margin, "difference_after": 0.3 * margin, "people": 11})
    };
    let people: Vec<Value> = (1..=11_u32)
        .map(|k| {
            let before = [12.0, 26.0, 39.0].map(|error| error + f64::from(k * 7 % 11));
            let after =
                [0.94, 0.92, 0.98].map(|share| share + 0.01 * (f64::from(k * 5 % 11) - 4.0));
            let after: Vec<f64> = before.iter().zip(after).map(|(b, share)| b * share).collect();
            json!({"person_id": format!("p{k:02}"), "days": 14, "mae_before": before,
                "mae_after": after})
        })
        .collect();
    json!({"horizons": [horizon(60, 14.5, -0.9, 0.3, false), horizon(300, 30.4, -2.5, 0.9, false),
            horizon(1440, 44.8, -1.1, 1.6, false), horizon(300, 30.4, -6.1, 1.2, true)],
        "outcomes": [outcome("tir", 5.0, 0.4, 0.01), outcome("tar", 5.0, 0.2, 0.03),
            outcome("tbr", 1.0, 0.3, 0.2), outcome("lbgi", 0.5, 0.02, 0.01),
            outcome("hbgi", 1.0, 0.3, 0.04), outcome("mg", 10.0, 0.01, 0.08)],
        "amplitudes": [{"effect": "dawn", "variants": [0], "sd": 0.3, "people": [1.1, 1.0],
            "mean": {"value": 1.05, "lower": 0.8, "upper": 1.3}}],
        "innovations": {"before": -410.0, "after": -395.5,
            "difference": {"value": 14.5, "lower": 8.1, "upper": 20.9}},
        "people": people,
        "notes": ["Held-out days are the last third of each person's record."]})
}

/// The gap through the day with strips of so many people.
fn hourly(people: u32) -> Value {
    let cell = |mean: f64, half: f64, people: u32| {
        json!({"mean_error_mg_dl": mean, "lower": mean - half, "upper": mean + half, "people": people,
            "runs": 84 * people})
    };
    let early = |part: u32| if part == 1 { 26.0 } else { 0.0 };
    let situations =
        [("all", 1.0, 0), ("after_meal", 0.3, 3), ("sleep", 1.2, 0), ("other", 0.8, 1)];
    let situations = situations.map(|(name, share, absent)| {
        let cells = (0..8_u32).map(|part| {
            let mean = share * early(part) - 2.0 + f64::from(part * 5 % 8) / 2.0;
            if part < absent { Value::Null } else { cell(mean, 6.0, 12) }
        });
        json!({"name": name, "cells": cells.collect::<Vec<_>>()})
    });
    let people = (1..=people).map(|k| {
        let cells = (0..8_u32).map(|part| {
            let mean = early(part) + f64::from((7 * k + 3 * part) % 25) - 12.0;
            cell(mean, 9.0, 1)
        });
        json!({"name": format!("p{k:02}"), "cells": cells.collect::<Vec<_>>()})
    });
    json!({"horizon_minutes": 300,
        "parts": ["00-03", "03-06", "06-09", "09-12", "12-15", "15-18", "18-21", "21-24"],
        "situations": situations, "people": people.collect::<Vec<_>>()})
}

fn cells() -> Value {
    let cell = |factor: &str, level: &str, mean: f64, half: f64, share: f64| {
        let p = if mean.abs() > half { 0.0005 } else { 0.42 };
        json!({"factor": factor, "level": level, "mean_error_mg_dl": mean, "lower": mean - half,
            "upper": mean + half, "p_adjusted": p, "share_of_gap": share, "horizon_minutes": 300,
            "people": 12, "runs": 900})
    };
    json!([
        cell("hour", "04-08", 31.0, 11.0, 0.21),
        cell("person", "p07", 28.0, 14.0, 0.08),
        cell("context", "after_exercise", -19.0, 9.0, 0.07),
        cell("hour", "20-24", -12.0, 10.0, 0.04),
        cell("context", "day_after_short_sleep", 9.0, 10.0, 0.02),
        cell("hour", "00-04", 6.0, 9.0, 0.01),
        cell("hour", "08-12", -4.0, 8.0, 0.01),
        cell("hour", "12-16", 1.0, 8.0, 0.0),
        cell("hour", "16-20", -3.0, 9.0, 0.0),
        cell("context", "after_meal", -5.0, 7.0, 0.01),
        cell("context", "sleep", 8.0, 6.0, 0.03),
        cell("context", "other", 0.5, 4.0, 0.0),
        cell("person", "p03", -7.0, 15.0, 0.01),
        cell("person", "a person with a very long identifier", 3.0, 12.0, 0.0),
        cell("glucose_band", "<70", -14.0, 6.0, 0.02),
        cell("glucose_band", "70-180", -2.0, 4.0, 0.01),
        cell("glucose_band", ">180", 17.0, 8.0, 0.05)
    ])
}
