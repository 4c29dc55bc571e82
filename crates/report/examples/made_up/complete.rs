//! Adds the keys that the made-up JSON leaves out, so that it matches its schema.

use report::Part;
use serde_json::{Value, json};

/// Adds every missing key.
fn fill(value: &mut Value, defaults: Value) {
    let (Some(map), Value::Object(defaults)) = (value.as_object_mut(), defaults) else { return };
    for (key, default) in defaults {
        map.entry(key).or_insert(default);
    }
}

/// Adds every missing key to each entry of the list at `pointer`.
fn fill_each(value: &mut Value, pointer: &str, defaults: &Value) {
    let entries = value.pointer_mut(pointer).and_then(Value::as_array_mut);
    for entry in entries.into_iter().flatten() {
        fill(entry, defaults.clone());
    }
}

/// Shares have Wilson's interval beside the exact one.
fn fill_shares(value: &mut Value) {
    match value {
        Value::Object(map) => {
            if map.contains_key("count") && map.contains_key("of") {
                for (wilson, exact) in [("wilson_lower", "lower"), ("wilson_upper", "upper")] {
                    let exact = map.entry(exact).or_insert(json!(0.0)).clone();
                    map.insert(wilson.to_owned(), exact);
                }
            }
            map.values_mut().for_each(fill_shares);
        }
        Value::Array(list) => list.iter_mut().for_each(fill_shares),
        _ => {}
    }
}

/// The part with every key of its schema.
pub(crate) fn completed(part: Part, mut value: Value) -> Value {
    match part {
        Part::Manifest => fill(&mut value, json!({"outputs": []})),
        Part::Diagnosis => complete_diagnosis(&mut value),
        Part::Conformance => {
            fill(&mut value, json!({"schema": "conformance/2"}));
            let row =
                json!({"grounds": null, "engine": "branch_and_bound", "nodes": 812, "stop": "gap"});
            fill_each(&mut value, "/rows", &row);
        }
        Part::BlindCheck => complete_blind_check(&mut value),
        Part::Outcomes => complete_outcomes(&mut value),
        Part::Training => {
            fill(
                &mut value,
                json!({"config": {}, "kept_epoch": 0, "validation_loss_is": "balanced error over three groups of windows, each weighted alike, mg/dL"}),
            );
            fill(&mut value["data"], json!({"simulated_days": 420}));
            let epoch = json!({"steps": 60, "validation_rmse_by_group_mg_dl": [9.0, null, 11.0]});
            fill_each(&mut value, "/epochs", &epoch);
        }
        Part::Twins => {
            fill_each(&mut value, "/people", &json!({"windows_train": 0, "windows_test": 0}));
        }
        Part::ExampleDay => fill(&mut value, json!({"schema": "example-day/2"})),
        Part::Agp => fill(&mut value, json!({"schema": "agp/1", "windows": 412})),
        _ => {}
    }
    value
}

fn complete_diagnosis(value: &mut Value) {
    let interval = json!({"value": 1.0, "lower": 0.5, "upper": 1.5});
    fill(
        value,
        json!({"schema": "diagnosis/3", "verdict": "none", "effects": [], "candidates": [], "untried": [],
            "ports": [], "evidence": {"person_days": 84.0, "gains": {}}, "where": [],
            "how_far": {}, "baseline": [], "data_quality": [], "people": [], "plant": "ode", "seed": 1,
            "config": null}),
    );
    fill(
        &mut value["how_far"],
        json!({"horizons": [], "outcomes": [], "amplitudes": [], "innovations": null, "people": [],
            "notes": []}),
    );
    let port = json!({"gain_nats": 0.0, "probability": 0.0, "confusable_with": [], "unit": "factor",
        "course": []});
    let outcome = json!({"difference_before": 1.0, "difference_after": 0.5, "people": 12});
    for (list, defaults) in [
        ("/effects", effect()),
        ("/candidates", json!({"gain_nats": 0.0, "probability": 0.0})),
        ("/ports", port),
        ("/where", json!({"horizon_minutes": 300, "people": 12, "runs": 900, "innovation": null})),
        ("/baseline", json!({"people": 12, "runs": 900})),
        ("/people", json!({"calibration": null})),
        ("/how_far/horizons", json!({"reconstructed": false, "people": 12, "runs": 900})),
        ("/how_far/outcomes", outcome),
        ("/how_far/amplitudes", json!({"variants": [0], "mean": interval})),
        ("/how_far/people", json!({"mae_reconstructed": []})),
    ] {
        fill_each(value, list, &defaults);
    }
}

fn effect() -> Value {
    json!({"port": "egp", "gain_nats": 3.0, "probability": 0.9,
        "amplitude": {"value": 1.0, "lower": 0.5, "upper": 1.5}, "confusable_with": [],
        "people": [], "questioned": []})
}

fn complete_blind_check(value: &mut Value) {
    fill_shares(value);
    let truth =
        json!({"in_library": true, "amplitude": 1.0, "target_mg_dl": 5.0, "at_limit": false});
    let world = json!({"top_candidates": [], "top_ports": [], "wrong_name": false});
    fill(value, json!({"by_hand": []}));
    fill_each(value, "/worlds", &world);
    for index in 0..value["worlds"].as_array().map_or(0, Vec::len) {
        fill_each(value, &format!("/worlds/{index}/truth"), &truth);
        fill_each(value, &format!("/worlds/{index}/found"), &effect());
    }
    fill(&mut value["pairs"], json!({"worlds_at_5": 0}));
}

fn complete_outcomes(value: &mut Value) {
    let method = json!({"starts_not_at_rest": 0});
    fill_each(value, "/methods", &method);
    fill_each(value, "/ablation", &method);
    for index in 0..value["scenarios"].as_array().map_or(0, Vec::len) {
        fill_each(value, &format!("/scenarios/{index}/methods"), &method);
    }
}
