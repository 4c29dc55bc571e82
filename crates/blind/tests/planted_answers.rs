//! Planted answers get the scores that can be computed by hand.

use blind::{ScoredWorld, score};
use contract::WithInterval;
use contract::blind_check::{Answer, BlindCheck, Kind, Label, Outcome, TrueEffect, Verdict};
use contract::diagnosis::{FoundEffect, PortEvidence};

const EFFECTS: [&str; 3] = ["dawn", "exercise", "alcohol"];

/// Nine single worlds of 2.5, 5 and 10 mg/dL, three pairs, three outside the library, five nulls.
fn labels() -> Vec<Label> {
    let effect = |name: &str, shift: f64, in_library: bool| TrueEffect {
        effect: name.to_owned(),
        port: (!in_library).then(|| "egp".to_owned()),
        in_library,
        amplitude: shift / 5.0,
        target_mg_dl: shift,
        achieved_mg_dl: shift,
        at_limit: false,
        form: None,
    };
    let mut truths = Vec::new();
    for (index, name) in EFFECTS.into_iter().enumerate() {
        for shift in [2.5, 5.0, 10.0] {
            truths.push((Kind::Single, vec![effect(name, shift, true)]));
        }
        let other = EFFECTS[(index + 1) % 3];
        truths.push((Kind::Pair, vec![effect(name, 5.0, true), effect(other, 5.0, true)]));
        truths.push((Kind::Outside, vec![effect("fever", 10.0, false)]));
    }
    truths.extend((0..5).map(|_| (Kind::Null, Vec::new())));
    truths
        .into_iter()
        .enumerate()
        .map(|(index, (kind, effects))| Label {
            kind,
            effects,
            ..Label::null(&format!("world_{:04}", index + 1), "hovorka", "aid", 5, 14)
        })
        .collect()
}

fn naming(effects: &[&str], probability: f64, value: f64) -> Answer {
    let found = effects.iter().map(|effect| FoundEffect {
        effect: (*effect).to_owned(),
        port: "egp".to_owned(),
        gain_nats: 30.0,
        probability,
        amplitude: WithInterval { value, lower: 0.0, upper: 9.0 },
        confusable_with: Vec::new(),
        people: Vec::new(),
        questioned: Vec::new(),
    });
    Answer { verdict: Verdict::Effect, found: found.collect(), ..Answer::none() }
}

fn unknown_at(port: &str) -> Answer {
    let evidence = |port: &str, gain_nats| PortEvidence {
        port: port.to_owned(),
        gain_nats,
        probability: 0.5,
        confusable_with: Vec::new(),
        unit: String::new(),
        course: Vec::new(),
    };
    let ports = vec![evidence("sensor", 1.0), evidence(port, 8.0)];
    Answer { verdict: Verdict::Unknown, ports, ..Answer::none() }
}

/// What an oracle would say.
fn perfect(label: &Label) -> Answer {
    let names: Vec<&str> = label.effects.iter().map(|e| e.effect.as_str()).collect();
    match label.kind {
        Kind::Null => Answer::none(),
        Kind::Outside => unknown_at("egp"),
        Kind::Single | Kind::Pair => naming(&names, 1.0, label.effects[0].amplitude),
    }
}

fn check(answer: impl Fn(&Label) -> Answer) -> BlindCheck {
    let worlds: Vec<ScoredWorld> =
        labels().into_iter().map(|label| ScoredWorld { answer: answer(&label), label }).collect();
    score(7, &worlds).expect("countable")
}

fn values(check: &BlindCheck) -> Vec<(&str, Option<f64>, Option<bool>)> {
    check.targets.iter().map(|t| (t.name.as_str(), t.value, t.met)).collect()
}

#[test]
fn the_perfect_answer_meets_every_target_but_the_limit_that_five_nulls_cannot_give() {
    let check = check(perfect);
    let limit = 1.0 - 0.05_f64.powf(0.2); // no alarm in five
    let found = values(&check);
    assert!((found[4].1.expect("nulls") - limit).abs() < 1e-9); // iterated quantile
    let mut others = found;
    others.remove(4);
    assert_eq!(
        others,
        [
            ("named_at_5", Some(1.0), Some(true)),
            ("named_at_10", Some(1.0), Some(true)),
            ("wrong_names", Some(0.0), Some(true)),
            ("false_alarms", Some(0.0), Some(true)),
            ("unknown_recalled", Some(1.0), Some(true)),
            ("right_port", Some(1.0), Some(true)),
            ("calibration_error", Some(0.0), Some(true)),
            ("pairs_f1", Some(1.0), Some(true)),
            ("failed", Some(0.0), Some(true)),
        ]
    );
    assert_eq!(check.target("false_alarms_limit").and_then(|t| t.met), Some(false));
    assert!((check.amplitudes.rank_correlation.expect("three a name") - 1.0).abs() < 1e-12);
    assert!(check.worlds.iter().all(|row| row.outcome == Outcome::Correct && !row.wrong_name));
    assert_eq!(check.target("named_at_5").map(|t| t.of), Some(6));
    assert_eq!(check.target("named_at_10").map(|t| t.of), Some(3));
}

#[test]
fn to_say_none_always_raises_no_alarm_and_finds_nothing() {
    let check = check(|_| Answer::none());
    let found = values(&check);
    assert_eq!(found[0], ("named_at_5", Some(0.0), Some(false)));
    assert_eq!(found[2], ("wrong_names", Some(0.0), Some(true)));
    assert_eq!(found[3], ("false_alarms", Some(0.0), Some(true)));
    assert_eq!(found[5], ("unknown_recalled", Some(0.0), Some(false)));
    // Nothing was called unknown and no probability was stated: not tested, and so not met.
    assert_eq!(found[6], ("right_port", None, None));
    assert_eq!(found[7], ("calibration_error", None, None));
    assert_eq!(found[8], ("pairs_f1", Some(0.0), Some(false)));
    assert_eq!((check.pairs.recall.count, check.pairs.recall.of), (0, 6));
    assert!(check.power.iter().all(|row| row.detected.count == 0 && row.named.count == 0));
}

#[test]
fn to_name_a_wrong_effect_always_fails_everything() {
    let check = check(|_| naming(&["renal_threshold"], 1.0, 1.0));
    for (name, value, met) in values(&check) {
        let worst = match name {
            "failed" => continue,
            "right_port" => None,
            "named_at_5" | "named_at_10" | "unknown_recalled" | "pairs_f1" => Some(0.0),
            _ => Some(1.0),
        };
        assert_eq!(value, worst, "{name}");
        assert_eq!(met, worst.map(|_| false), "{name}");
    }
    assert!(check.worlds.iter().all(|row| row.outcome == Outcome::Wrong && row.wrong_name));
    let column = check.confusion.answers.iter().position(|a| a == "renal_threshold");
    let column = column.expect("a column for what was answered");
    let counted: usize = check.confusion.rows.iter().map(|row| row.counts[column]).sum();
    assert_eq!(counted, labels().len() - 3); // all but the pairs
}

#[test]
fn an_answer_that_failed_is_never_right_and_never_dropped() {
    let check = check(|label| match label.kind {
        Kind::Null | Kind::Single => Answer::failed("no such file", 0.1),
        _ => perfect(label),
    });
    assert_eq!((check.failed.count, check.failed.of), (14, 20));
    assert_eq!(check.target("failed").and_then(|t| t.met), Some(false));
    assert_eq!(check.target("named_at_5").and_then(|t| t.value), Some(0.0));
    assert_eq!(check.false_alarms.of, 5);
    assert_eq!(check.worlds.iter().filter(|w| w.failure.is_some()).count(), 14);
}

#[test]
fn the_port_counts_only_where_unknown_is_right() {
    let elsewhere = check(|label| match label.kind {
        Kind::Outside | Kind::Null => unknown_at("sensor_gain"),
        _ => perfect(label),
    });
    assert_eq!((elsewhere.unknown.recalled.count, elsewhere.unknown.right_port.count), (3, 0));
    assert_eq!(elsewhere.unknown.right_port.of, 3);
    assert_eq!(elsewhere.false_alarms.count, 5);
    let in_set = check(|label| {
        let mut answer = unknown_at("sensor_gain");
        answer.ports[1].confusable_with.push("egp".to_owned());
        if label.kind == Kind::Outside { answer } else { perfect(label) }
    });
    assert_eq!(in_set.unknown.right_port.count, 0);
    assert_eq!(in_set.unknown.right_port_or_in_set.count, 3);
}

#[test]
fn power_is_told_by_name_and_by_shift() {
    let check = check(|label| {
        let small = label.largest_shift() < 4.0;
        if label.kind == Kind::Single && small { Answer::none() } else { perfect(label) }
    });
    let all: Vec<(f64, usize, usize)> = check
        .power
        .iter()
        .filter(|row| row.effect.is_none())
        .map(|row| (row.from_mg_dl, row.named.count, row.named.of))
        .collect();
    assert_eq!(all, [(0.0, 0, 3), (3.75, 3, 3), (7.5, 3, 3)]);
    let dawn = check.power.iter().filter(|row| row.effect.as_deref() == Some("dawn"));
    assert_eq!(dawn.map(|row| row.named.of).collect::<Vec<_>>(), [1, 1, 1]);
}

#[test]
fn a_check_reads_back_as_it_was_written() {
    let before = check(perfect);
    let text = serde_json::to_string(&before).expect("JSON");
    assert_eq!(serde_json::from_str::<BlindCheck>(&text).expect("its own layout"), before);
}

#[test]
fn an_answer_is_the_part_of_a_diagnosis_that_is_scored() {
    let text = r#"{"schema": "diagnosis/3", "verdict": "effect",
        "effects": [{"effect": "dawn", "port": "egp", "gain_nats": 31.2, "probability": 0.97,
                     "amplitude": {"value": 1.1, "lower": 0.7, "upper": 1.5}, "confusable_with": [],
                     "people": [], "questioned": []}],
        "candidates": [{"effect": "dawn", "gain_nats": 31.2, "probability": 0.97}], "untried": [],
        "ports": [{"port": "egp", "gain_nats": 30.0, "probability": 0.9, "confusable_with": [],
                   "unit": "factor", "course": []}],
        "posterior": {"something": 0.1, "sets": [], "speaks_from": 0.75, "names_from": 0.5, "source": "made up"},
        "evidence": {"person_days": 7, "gains": {}}, "where": [],
        "how_far": {"horizons": [], "outcomes": [], "amplitudes": [], "innovations": null,
                    "people": [], "notes": []},
        "baseline": [], "data_quality": [], "people": [], "plant": "ode", "seed": 1, "config": null}"#;
    let diagnosis: contract::Diagnosis = contract::read(text.as_bytes()).expect("its schema");
    let answer = blind::answer(diagnosis, 2.0);
    assert_eq!(answer.first(), Some("dawn"));
    assert_eq!(answer.best_port().map(|p| p.port.as_str()), Some("egp"));
    assert_eq!((answer.verdict, answer.seconds), (Verdict::Effect, 2.0));
}
