//! Labels of cohorts by another hand, in the schema `blind_labels/1`.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use contract::blind_check::{Kind, Label, TrueCell, TrueEffect, TrueWhere};
use serde::Deserialize;

use crate::files::read_bytes;

/// The schema that is read.
const SCHEMA: &str = "blind_labels/1";
/// Contexts that mean the same there and here.
const CONTEXTS: [(&str, &str); 10] = [
    ("post_meal_0_4h", "after_meal"),
    ("post_dinner_0_5h", "after_dinner"),
    ("exercise_0_1h", "exercise"),
    ("post_exercise_1_12h", "after_exercise"),
    ("sleep", "sleep"),
    ("day_after_short_sleep", "day_after_short_sleep"),
    ("after_low_0_3h", "after_low"),
    ("set_day_3plus", "set_day_3_plus"),
    ("sensor_last_third", "sensor_late"),
    ("fast_change", "fast_change"),
];

#[derive(Deserialize)]
struct File {
    schema: String,
    cohorts: Vec<OfCohort>,
}

#[derive(Deserialize)]
struct OfCohort {
    id: String,
    kind: String,
    effects: Vec<OfEffect>,
    n_people: usize,
    days: Vec<usize>,
    #[serde(rename = "where")]
    place: Option<Place>,
}

#[derive(Deserialize)]
struct OfEffect {
    effect: String,
    in_library: bool,
    amplitude: f64,
    target_shift: f64,
    actual_shift: f64,
    ports: Vec<String>,
}

/// The shift of glucose over runs as long as the record, mg/dL.
#[derive(Deserialize)]
struct Place {
    hour: Hours,
    context: BTreeMap<String, Context>,
}

#[derive(Deserialize)]
struct Hours {
    signed: Vec<f64>,
}

#[derive(Deserialize)]
struct Context {
    share_of_time: f64,
    signed: f64,
}

/// Reads a file of labels. `hand` is what their maker is called here.
///
/// # Errors
/// For a file of another schema, or a kind of cohort that is not known.
pub(crate) fn read(file: &Path, hand: &str) -> Result<Vec<Label>> {
    of_text(&read_bytes(file)?, hand).with_context(|| format!("'{}'", file.display()))
}

fn of_text(text: &[u8], hand: &str) -> Result<Vec<Label>> {
    let file: File = serde_json::from_slice(text)?;
    ensure!(file.schema == SCHEMA, "the schema is '{}', not '{SCHEMA}'", file.schema);
    file.cohorts.into_iter().map(|cohort| cohort.label(hand)).collect()
}

impl OfCohort {
    fn label(self, hand: &str) -> Result<Label> {
        let days = self.days.iter().copied().max().unwrap_or(0);
        let mut label = Label::null(&self.id, hand, "", self.n_people, days);
        label.kind = match self.kind.as_str() {
            "null" => Kind::Null,
            "single" => Kind::Single,
            "pair" => Kind::Pair,
            "ool" => Kind::Outside,
            other => anyhow::bail!("cohort '{}' is of the kind '{other}'", self.id),
        };
        label.effects = self.effects.into_iter().map(OfEffect::effect).collect();
        label.gap = self.place.filter(|_| label.kind != Kind::Null).map(Place::gap);
        Ok(label)
    }
}

impl OfEffect {
    fn effect(self) -> TrueEffect {
        TrueEffect {
            port: self.ports.into_iter().next().filter(|_| !self.in_library),
            effect: self.effect,
            in_library: self.in_library,
            amplitude: self.amplitude,
            target_mg_dl: self.target_shift,
            achieved_mg_dl: self.actual_shift,
            at_limit: false,
            form: None,
        }
    }
}

impl Place {
    /// Of free runs alone: nothing is stated after one hour and after five.
    fn gap(self) -> TrueWhere {
        let cell = |factor: &str, level: String, share: f64, mean: f64| TrueCell {
            factor: factor.to_owned(),
            level,
            share,
            mean_mg_dl: [None, None, Some(mean)],
        };
        let hours = self.hour.signed.iter().enumerate();
        let mut cells: Vec<TrueCell> = hours
            .map(|(hour, mean)| cell("hour", format!("{hour:02}"), 1.0 / 24.0, *mean))
            .collect();
        cells.extend(CONTEXTS.iter().filter_map(|(theirs, ours)| {
            let found = self.context.get(*theirs)?;
            Some(cell("context", (*ours).to_owned(), found.share_of_time, found.signed))
        }));
        TrueWhere { mean_mg_dl: [0.0; 3], mean_absolute_mg_dl: [0.0; 3], cells, ports: Vec::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_of_another_hand_become_ours() {
        let hours = vec!["1.5"; 24].join(",");
        let text = format!(
            r#"{{"schema":"blind_labels/1","cohorts":[
              {{"id":"a","kind":"null","effects":[],"n_people":4,"days":[10,12]}},
              {{"id":"b","kind":"ool","n_people":4,"days":[10],
                "effects":[{{"effect":"caffeine","in_library":false,"amplitude":1,"target_shift":6,
                  "actual_shift":5,"ports":["egp","insulin_action"]}}],
                "where":{{"hour":{{"signed":[{hours}]}},
                  "context":{{"sleep":{{"share_of_time":0.3,"signed":2.0}}}}}}}}]}}"#
        );
        let labels = of_text(text.as_bytes(), "another").expect("labels");
        assert_eq!(
            (labels[0].kind, labels[0].days, labels[0].gap.is_none()),
            (Kind::Null, 12, true)
        );
        assert_eq!(labels[1].effects[0].port.as_deref(), Some("egp"));
        let cells = &labels[1].gap.as_ref().expect("a place").cells;
        assert_eq!((cells.len(), cells[24].mean_mg_dl[2]), (25, Some(2.0)));
        let other = text.replace("blind_labels/1", "blind_labels/9");
        assert!(of_text(other.as_bytes(), "another").is_err());
        assert!(of_text(text.replace("\"ool\"", "\"odd\"").as_bytes(), "another").is_err());
    }
}
