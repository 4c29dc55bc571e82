//! A made-up blind check.

use serde_json::{Value, json};

/// Effects with the shift at which half are found, mg/dL, and the effect that each is confused
/// with.
const EFFECTS: [(&str, f64, usize); 14] = [
    ("alcohol", 7.0, 2),
    ("carb_miscount", 6.0, 9),
    ("circadian_sensitivity", 4.0, 3),
    ("dawn", 3.0, 2),
    ("exercise", 3.5, 7),
    ("insulin_absorption", 6.0, 11),
    ("missed_meals", 3.0, 12),
    ("post_exercise_sensitivity", 4.0, 4),
    ("renal_threshold", 8.0, 9),
    ("sensor_drift", 4.0, 10),
    ("sensor_lag", 3.0, 9),
    ("set_ageing", 4.0, 5),
    ("slow_meals", 4.5, 6),
    ("unlogged_rescue_carbs", 3.0, 6),
];
/// Bins of the shift, mg/dL: lower end, upper end, mean, worlds of each effect.
const BINS: [(f64, Option<f64>, f64, usize); 4] = [
    (0.0, Some(3.75), 2.4, 4),
    (3.75, Some(7.5), 5.2, 5),
    (7.5, Some(12.5), 9.8, 5),
    (12.5, None, 15.3, 4),
];

/// `count` of `of` with an approximate interval.
fn share(count: usize, of: usize) -> Value {
    let (k, n) = (count as f64, of as f64);
    // Agresti and Coull (1998).
    let (n_, p_) = (n + 4.0, (k + 2.0) / (n + 4.0));
    let half = 2.0 * (p_ * (1.0 - p_) / n_).sqrt();
    json!({"count": count, "of": of, "value": if of > 0 { json!(k / n) } else { Value::Null },
        "lower": (p_ - half).max(0.0), "upper": (p_ + half).min(1.0)})
}

/// How many of the worlds of an effect are named, and how many are found at all.
fn found(half: f64, shift: f64, worlds: usize) -> (usize, usize) {
    let power = 1.0 / (1.0 + (shift / half).powi(-4));
    let all = worlds as f64;
    ((power * all).round() as usize, ((power + 0.15) * all).round().min(all) as usize)
}

pub(crate) fn blind_check() -> Value {
    json!({"schema": "blind-check/4", "master_seed": 20_261_121_u64,
        "worlds": worlds(), "confusion": confusion(), "power": power(),
        "false_alarms": share(3, 150), "wrong_names": share(5, 252),
        "unknown": {"recalled": share(31, 36), "right_port": share(25, 31),
            "right_port_or_in_set": share(28, 31)},
        "pairs": {"worlds": 40, "precision": share(66, 71), "recall": share(66, 80),
            "both": share(27, 40), "f1": 0.874, "f1_lower": 0.81, "f1_upper": 0.93},
        "reliability": reliability(),
        "amplitudes": {"worlds": 190, "rank_correlation": 0.71},
        "failed": share(0, 478), "ceiling": ceiling(), "targets": targets()})
}

fn ceiling() -> Value {
    let at = |bar: f64, from_5: usize, from_10: usize, unknown: usize| {
        json!({"bar_nats": bar, "named_at_5": from_5, "named_at_10": from_10,
            "unknown": unknown})
    };
    json!({"bar_nats": 14.3, "at_lower_bar": at(6.1, 190, 119, 34),
        "at_upper_bar": at(22.8, 171, 112, 29), "named": share(213, 252),
        "named_at_5": share(184, 196), "answered_at_5": share(163, 196),
        "named_at_10": share(117, 126), "answered_at_10": share(113, 126),
        "unknown": share(33, 36), "answered_unknown": share(31, 36),
        "false_alarms": share(9, 450), "courses": []})
}

pub(crate) fn seal() -> Value {
    let worlds: Vec<Value> = (1..=6_u64)
        .map(|k| {
            let hash = format!("{:016x}", k.wrapping_mul(0x9e37_79b9_7f4a_7c15)).repeat(4);
            json!({"id": format!("world_{k:04}"), "sha256": hash})
        })
        .collect();
    json!({"schema": "seal/1", "hash": "SHA-256 of salt, line feed (0x0a), label",
        "worlds": worlds})
}

fn confusion() -> Value {
    let mut answers: Vec<&str> = EFFECTS.iter().map(|(name, ..)| *name).collect();
    answers.extend(["none", "unknown", "failed"]);
    let (none, unknown) = (EFFECTS.len(), EFFECTS.len() + 1);
    let mut rows: Vec<Value> = Vec::new();
    for (index, (name, half, taken_for)) in EFFECTS.into_iter().enumerate() {
        let mut counts = vec![0; answers.len()];
        for (_, _, shift, worlds) in BINS {
            let (named, detected) = found(half, shift, worlds);
            counts[index] += named;
            counts[taken_for] += (detected - named) / 2;
            counts[unknown] += detected - named - (detected - named) / 2;
            counts[none] += worlds - detected;
        }
        rows.push(json!({"truth": name, "counts": counts}));
    }
    let mut nulls = vec![0; answers.len()];
    (nulls[none], nulls[unknown], nulls[3]) = (147, 2, 1);
    rows.push(json!({"truth": "none", "counts": nulls}));
    for (name, right) in [("outside:injection_site", 15), ("outside:caffeine", 16)] {
        let mut counts = vec![0; answers.len()];
        (counts[unknown], counts[none], counts[11]) = (right, 17 - right, 1);
        rows.push(json!({"truth": name, "counts": counts}));
    }
    json!({"answers": answers, "rows": rows})
}

fn power() -> Value {
    let row = |effect: Value, bin: usize, named: usize, detected: usize, of: usize| {
        let (from, to, mean, _) = BINS[bin];
        let in_set = named + (detected - named) / 2;
        json!({"effect": effect, "from_mg_dl": from, "to_mg_dl": to, "mean_shift_mg_dl": mean,
            "named": share(named, of), "named_or_in_set": share(in_set, of),
            "detected": share(detected, of)})
    };
    let mut rows: Vec<Value> = Vec::new();
    for (bin, (_, _, shift, worlds)) in BINS.into_iter().enumerate() {
        let (mut named, mut detected) = (0, 0);
        for (_, half, _) in EFFECTS {
            let (n, d) = found(half, shift, worlds);
            named += n;
            detected += d;
        }
        rows.push(row(Value::Null, bin, named, detected, worlds * EFFECTS.len()));
    }
    for (name, half, _) in EFFECTS {
        for (bin, (_, _, shift, worlds)) in BINS.into_iter().enumerate() {
            let (named, detected) = found(half, shift, worlds);
            rows.push(row(json!(name), bin, named, detected, worlds));
        }
    }
    json!(rows)
}

fn reliability() -> Value {
    let bins: Vec<Value> = [
        (0.45, 4, 9),
        (0.55, 8, 15),
        (0.66, 12, 20),
        (0.75, 22, 29),
        (0.86, 41, 48),
        (0.97, 205, 213),
    ]
    .iter()
    .map(|(stated, true_, of)| {
        let from = (stated * 10.0_f64).floor() / 10.0;
        json!({"from": from, "to": from + 0.1, "mean_probability": stated,
                "came_true": share(*true_, *of)})
    })
    .collect();
    json!({"bins": bins, "probabilities": 334, "expected_calibration_error": 0.021,
        "lower": 0.014, "upper": 0.043, "error_if_calibrated": 0.031, "error_counting_sets": 0.019})
}

/// Measured values with their intervals, and what is measured if sets count.
fn targets() -> Value {
    json!([
        {"name": "named_at_5", "bound": "at_least", "target": 0.9, "of": 168, "met": false,
            "says": "one effect that moves glucose by 5 mg/dL or more is named",
            "value": 0.886, "lower": 0.83, "upper": 0.93, "value_counting_sets": 0.931},
        {"name": "named_at_10", "bound": "at_least", "target": 0.97, "of": 103, "met": true,
            "says": "one effect that moves glucose by 10 mg/dL or more is named",
            "value": 0.981, "lower": 0.93, "upper": 1.0, "value_counting_sets": 1.0},
        {"name": "wrong_names", "bound": "at_most", "target": 0.02, "of": 252, "met": true,
            "says": "with one effect, another is named that cannot be confused with it",
            "value": 0.0198, "lower": 0.006, "upper": 0.046, "value_counting_sets": null},
        {"name": "false_alarms", "bound": "at_most", "target": 0.05, "of": 150, "met": true,
            "says": "nothing acts, and the answer is not \"none\"",
            "value": 0.02, "lower": 0.004, "upper": 0.057, "value_counting_sets": null},
        {"name": "false_alarms_limit", "bound": "at_most", "target": 0.08, "of": 150, "met": true,
            "says": "one-sided exact 95 % upper limit of the false alarms",
            "value": 0.051, "lower": null, "upper": null, "value_counting_sets": null},
        {"name": "unknown_recalled", "bound": "at_least", "target": 0.8, "of": 36, "met": true,
            "says": "an effect outside the library is called unknown",
            "value": 0.861, "lower": 0.71, "upper": 0.95, "value_counting_sets": null},
        {"name": "right_port", "bound": "at_least", "target": 0.85, "of": 31, "met": false,
            "says": "what is rightly called unknown is placed at its port",
            "value": 0.806, "lower": 0.63, "upper": 0.93, "value_counting_sets": 0.903},
        {"name": "calibration_error", "bound": "at_most", "target": 0.05, "of": 334, "met": true,
            "says": "expected calibration error of the stated probabilities",
            "value": 0.021, "lower": 0.014, "upper": 0.043, "value_counting_sets": 0.019},
        {"name": "shrinkage", "bound": "at_least", "target": 0.9, "of": 0, "met": null,
            "says": "shrinkage is within 10 % of the oracle's",
            "value": null, "lower": null, "upper": null, "value_counting_sets": null},
        {"name": "pairs_f1", "bound": "at_least", "target": 0.8, "of": 40, "met": true,
            "says": "F1 of the names in worlds with two effects",
            "value": 0.874, "lower": 0.81, "upper": 0.93, "value_counting_sets": 0.9}])
}

fn worlds() -> Value {
    let rows: Vec<Value> = (0..60_usize)
        .map(|k| {
            let (name, ..) = EFFECTS[k % EFFECTS.len()];
            let kind = ["single", "single", "null", "single", "pair", "outside"][k % 6];
            let truth = match kind {
                "null" => json!([]),
                "outside" => json!([{"effect": "injection_site", "achieved_mg_dl": 9.7}]),
                "pair" => json!([{"effect": name, "achieved_mg_dl": 5.3},
                    {"effect": "dawn", "achieved_mg_dl": 10.2}]),
                _ => json!([{"effect": name, "achieved_mg_dl": 2.5 + (k % 4) as f64 * 4.1}]),
            };
            let right = k % 9 != 4;
            let (verdict, outcome) = match (kind, right) {
                ("null", true) => ("none", "correct"),
                ("outside", true) => ("unknown", "correct"),
                (_, true) => ("effect", "correct"),
                ("pair", false) => ("effect", "partial"),
                ("null", false) => ("unknown", "unknown"),
                _ => ("none", "missed"),
            };
            let found: Vec<Value> = if verdict == "effect" {
                let named = if outcome == "partial" { 1 } else { 2 };
                let named = truth.as_array().into_iter().flatten().take(named);
                named.map(|t| json!({"effect": t["effect"], "probability": 0.94})).collect()
            } else {
                Vec::new()
            };
            let generator = ["hovorka", "padova"][k % 2];
            let regime = ["open_loop_pump", "aid"][k / 2 % 2];
            let (people, days) = ([3, 5, 10][k % 3], [7, 14, 28][k / 3 % 3]);
            json!({"id": format!("world_{:04}", k + 1), "kind": kind,
                "generator": generator, "regime": regime, "people": people, "days": days,
                "nuisances": if k % 4 == 0 { json!(["2 people without heart rate"]) } else { json!([]) },
                "truth": truth, "verdict": verdict, "found": found, "outcome": outcome,
                "seconds": 1.4 + (k % 7) as f64 / 5.0, "failure": null})
        })
        .collect();
    json!(rows)
}
