//! Planted labels and answers for the tests.

use contract::WithInterval;
use contract::blind_check::{Answer, Kind, Label, TrueCell, TrueEffect, TrueWhere, Verdict};
use contract::diagnosis::{CellFactor, CellGap, FoundEffect};

use crate::ScoredWorld;

/// A label whose effects each cause a shift of `shift` mg/dL.
pub(crate) fn label(id: &str, kind: Kind, effects: &[&str], shift: f64) -> Label {
    let effects = effects
        .iter()
        .map(|effect| TrueEffect {
            effect: (*effect).to_owned(),
            port: (kind == Kind::Outside).then(|| "egp".to_owned()),
            in_library: kind != Kind::Outside,
            amplitude: 1.0,
            target_mg_dl: shift,
            achieved_mg_dl: shift,
            at_limit: false,
            form: None,
        })
        .collect();
    Label { kind, effects, ..Label::null(id, "hovorka", "aid", 5, 14) }
}

/// An answer that names these effects with probability 0.9.
pub(crate) fn answer(effects: &[&str]) -> Answer {
    let found = effects
        .iter()
        .map(|effect| FoundEffect {
            effect: (*effect).to_owned(),
            port: "egp".to_owned(),
            gain_nats: 20.0,
            probability: 0.9,
            amplitude: WithInterval { value: 1.0, lower: 0.5, upper: 1.5 },
            confusable_with: Vec::new(),
            people: Vec::new(),
            questioned: Vec::new(),
        })
        .collect();
    Answer { verdict: Verdict::Effect, found, ..Answer::none() }
}

/// An answer that names one effect with a probability.
pub(crate) fn with_probability(effect: &str, probability: f64) -> Answer {
    let mut planted = answer(&[effect]);
    planted.found[0].probability = probability;
    planted
}

/// A cell of an answer whose mean error is `mean`, with an interval of 1 mg/dL to either side.
pub(crate) fn cell(factor: CellFactor, level: &str, mean: f64) -> CellGap {
    CellGap {
        factor,
        level: level.to_owned(),
        mean_error_mg_dl: mean,
        lower: mean - 1.0,
        upper: mean + 1.0,
        p_adjusted: 0.5,
        share_of_gap: 0.1,
        expected_mg_dl: None,
        horizon_minutes: 60,
        people: 5,
        runs: 100,
        innovation: None,
    }
}

/// A world whose effects cause a shift of 5 mg/dL.
pub(crate) fn world(id: &str, kind: Kind, effects: &[&str], answer: Answer) -> ScoredWorld {
    ScoredWorld { label: label(id, kind, effects, 5.0), answer }
}

/// A truth of `size` mg/dL from 3 to 8 h, half of it while asleep, and of nothing elsewhere.
pub(crate) fn morning(size: f64) -> TrueWhere {
    let cell = |factor: &str, level: String, share: f64, mean: f64| TrueCell {
        factor: factor.to_owned(),
        level,
        share,
        mean_mg_dl: [Some(mean); 3],
    };
    let hours = (0..24).map(|hour| {
        let mean = if (3..8).contains(&hour) { size } else { 0.0 };
        cell("hour", format!("{hour:02}"), 1.0 / 24.0, mean)
    });
    let contexts = [("sleep", 0.3, 0.5 * size), ("exercise", 0.02, 0.0), ("sensor_late", 0.0, 0.0)];
    let contexts =
        contexts.map(|(level, share, mean)| cell("context", level.to_owned(), share, mean));
    TrueWhere {
        mean_mg_dl: [size * 5.0 / 24.0; 3],
        mean_absolute_mg_dl: [size.abs() * 5.0 / 24.0; 3],
        cells: hours.chain(contexts).collect(),
        ports: Vec::new(),
    }
}
