//! Writes a `blind_check.json` of made-up answers to the named file, as test data for the report.
//!
//! `cargo run -p blind --example made_up_check -- blind_check.json`

use std::error::Error;

use blind::{ScoredWorld, score};
use contract::WithInterval;
use contract::blind_check::{Answer, Kind, Label, TrueEffect, Verdict};
use contract::diagnosis::{CandidateEffect, FoundEffect, PortEvidence};

const EFFECTS: [(&str, &str); 6] = [
    ("dawn", "egp"),
    ("exercise", "glucose_flux"),
    ("slow_meals", "gut_absorption"),
    ("set_ageing", "insulin_input"),
    ("alcohol", "egp"),
    ("sensor_lag", "sensor"),
];
const SHIFTS: [f64; 4] = [2.5, 5.0, 10.0, 15.0];

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("name the file to write")?;
    let mut worlds = Vec::new();
    for round in 0..2 {
        for (index, effect) in EFFECTS.into_iter().enumerate() {
            for (size, shift) in SHIFTS.into_iter().enumerate() {
                let other = EFFECTS[(index + 1) % EFFECTS.len()];
                // Small ones are missed, and now and then one is confused.
                let answer = match (size, (index + size + round) % 9) {
                    (0, k) if k % 2 == 0 => none(0.7),
                    (1, 3) => unknown(effect.1),
                    (_, 5) => named(&[(other, 0.6)], &[effect.0]),
                    (_, 7) => named(&[(other, 0.5)], &[]),
                    _ => named(&[(effect, 0.8 + 0.05 * size as f64)], &[]),
                };
                worlds.push((Kind::Single, vec![(effect, shift)], answer));
            }
        }
    }
    for (index, effect) in EFFECTS.into_iter().enumerate() {
        let other = EFFECTS[(index + 2) % EFFECTS.len()];
        let found: &[((&str, &str), f64)] =
            if index % 3 == 0 { &[(effect, 0.9)] } else { &[(other, 0.95), (effect, 0.85)] };
        worlds.push((Kind::Pair, vec![(effect, 5.0), (other, 10.0)], named(found, &[])));
        let outside = ("injection_site", effect.1);
        let answer = if index == 4 { named(&[(effect, 0.6)], &[]) } else { unknown(effect.1) };
        worlds.push((Kind::Outside, vec![(outside, 10.0)], answer));
    }
    for index in 0..20 {
        let answer = match index {
            7 => named(&[(EFFECTS[0], 0.55)], &[]),
            11 => Answer::failed("killed after 1800 s", 1800.0),
            _ => none(0.9),
        };
        worlds.push((Kind::Null, Vec::new(), answer));
    }
    let scored: Vec<ScoredWorld> = worlds
        .into_iter()
        .enumerate()
        .map(|(index, (kind, effects, answer))| ScoredWorld {
            label: label(index, kind, &effects),
            answer,
        })
        .collect();
    let check = score(20_241_121, &scored)?;
    std::fs::write(path, serde_json::to_string_pretty(&check)? + "\n")?;
    Ok(())
}

fn label(index: usize, kind: Kind, effects: &[((&str, &str), f64)]) -> Label {
    let effects = effects
        .iter()
        .map(|((effect, port), shift)| TrueEffect {
            effect: (*effect).to_owned(),
            port: (kind == Kind::Outside).then(|| (*port).to_owned()),
            in_library: kind != Kind::Outside,
            amplitude: 0.2 * shift,
            target_mg_dl: *shift,
            achieved_mg_dl: shift * (0.92 + 0.04 * (index % 5) as f64),
            at_limit: false,
            form: None,
        })
        .collect();
    Label {
        kind,
        effects,
        nuisances: vec!["2 people without heart rate".to_owned()],
        ..Label::null(
            &format!("world_{:04}", index + 1),
            ["hovorka", "padova"][index % 2],
            ["open_loop_pump", "aid"][index / 2 % 2],
            [3, 5, 10][index % 3],
            [7, 14, 28][index / 3 % 3],
        )
    }
}

fn named(effects: &[((&str, &str), f64)], confusable_with: &[&str]) -> Answer {
    let found: Vec<FoundEffect> = effects
        .iter()
        .map(|((effect, port), probability)| FoundEffect {
            effect: (*effect).to_owned(),
            port: (*port).to_owned(),
            gain_nats: 40.0 * probability,
            probability: *probability,
            amplitude: WithInterval { value: 1.1, lower: 0.7, upper: 1.5 },
            confusable_with: confusable_with.iter().map(|name| (*name).to_owned()).collect(),
            people: Vec::new(),
            questioned: Vec::new(),
        })
        .collect();
    let candidates = found
        .iter()
        .map(|f| candidate(&f.effect, f.gain_nats, f.probability))
        .chain([candidate("none", 0.0, 0.02), candidate("unknown", 1.0, 0.05)])
        .collect();
    let ports = found.iter().map(|f| port(&f.port, f.gain_nats)).collect();
    let answer = Answer { verdict: Verdict::Effect, found, candidates, ports, ..Answer::none() };
    Answer { seconds: 1.7, ..answer }
}

fn none(probability: f64) -> Answer {
    Answer { candidates: vec![candidate("none", 0.0, probability)], seconds: 1.2, ..Answer::none() }
}

fn unknown(at: &str) -> Answer {
    Answer {
        verdict: Verdict::Unknown,
        candidates: vec![candidate("unknown", 9.0, 0.8)],
        ports: vec![port(at, 12.0), port("glucose_flux", 3.0)],
        seconds: 1.4,
        ..Answer::none()
    }
}

fn candidate(effect: &str, gain_nats: f64, probability: f64) -> CandidateEffect {
    CandidateEffect { effect: effect.to_owned(), gain_nats, probability, not_named: None }
}

fn port(port: &str, gain_nats: f64) -> PortEvidence {
    PortEvidence {
        port: port.to_owned(),
        gain_nats,
        probability: 0.8,
        confusable_with: Vec::new(),
        unit: String::new(),
        course: Vec::new(),
    }
}
