//! Tidy tables of results, one observation a row: what spreadsheets and notebooks read without knowing our JSON.

use std::path::Path;

use anyhow::Result;
use cohort::{Csv, CsvCell as Cell};
use contract::Diagnosis;
use contract::diagnosis::{CandidateEffect, CellGap, FoundEffect, Standing};
use evaluation::Evaluation;
use stats::{Outcome, Outcomes};

/// Outcomes: person, method (`actual` is the sensor), metric, unit, value.
pub(crate) const OUTCOMES: &str = "outcomes.csv";
/// Every effect that was weighed, with the size of those that are named.
pub(crate) const EFFECTS: &str = "effects.csv";
/// Every cell of the gap.
pub(crate) const WHERE: &str = "where.csv";

/// Writes [`OUTCOMES`] into a folder.
pub(crate) fn write_outcomes(folder: &Path, evaluation: &Evaluation) -> Result<()> {
    let mut table =
        Csv::new(folder, OUTCOMES, &["person_id", "method", "metric", "unit", "value"])?;
    for person in &evaluation.people {
        let mut row = |method: &str, metric: &str, unit: &str, value: f64| {
            let words = [person.person_id.as_str(), method, metric, unit].map(Cell::Text);
            table.row(words.into_iter().chain([Cell::Number(Some(value))]))
        };
        let mut rows: Vec<(&str, &Outcomes)> = vec![("actual", &person.actual)];
        rows.extend(person.methods.iter().map(|found| (found.method.name(), &found.outcomes)));
        for (method, outcomes) in rows {
            for outcome in Outcome::ALL {
                row(method, outcome.key(), outcome.unit(), outcomes.get(outcome))?;
            }
        }
        for found in &person.methods {
            row(found.method.name(), "rmse_5h", "mg/dL", found.rmse)?;
        }
    }
    Ok(table.finish()?)
}

/// A column of [`WHERE`], and what it says of a cell.
type WhereColumn = (&'static str, fn(&CellGap) -> Cell<'_>);

/// Writes [`EFFECTS`] and [`WHERE`] into a folder.
pub(crate) fn write_diagnosis(folder: &Path, diagnosis: &Diagnosis) -> Result<()> {
    write_effects(folder, &diagnosis.effects, &diagnosis.candidates)?;
    let columns: [WhereColumn; 11] = [
        ("factor", |cell| Cell::Text(cell.factor.name())),
        ("level", |cell| Cell::Text(&cell.level)),
        ("mean_error_mg_dl", |cell| Cell::Number(Some(cell.mean_error_mg_dl))),
        ("lower", |cell| Cell::Number(Some(cell.lower))),
        ("upper", |cell| Cell::Number(Some(cell.upper))),
        ("p_adjusted", |cell| Cell::Number(Some(cell.p_adjusted))),
        ("share_of_gap", |cell| Cell::Number(Some(cell.share_of_gap))),
        ("expected_mg_dl", |cell| Cell::Number(cell.expected_mg_dl)),
        ("horizon_minutes", |cell| Cell::Number(Some(f64::from(cell.horizon_minutes)))),
        ("people", |cell| Cell::Number(Some(cell.people as f64))),
        ("runs", |cell| Cell::Number(Some(cell.runs as f64))),
    ];
    let mut table = Csv::new(folder, WHERE, &columns.map(|(name, _)| name))?;
    for cell in &diagnosis.cells {
        table.row(columns.iter().map(|(_, of)| of(cell)))?;
    }
    Ok(table.finish()?)
}

fn write_effects(
    folder: &Path,
    named: &[FoundEffect],
    candidates: &[CandidateEffect],
) -> Result<()> {
    let header = [
        "effect",
        "answer",
        "probability",
        "gain_nats",
        "port",
        "size",
        "size_lower",
        "size_upper",
    ];
    let mut table = Csv::new(folder, EFFECTS, &header)?;
    for candidate in candidates {
        let named = named.iter().find(|effect| effect.effect == candidate.effect);
        let answer = named.map_or("not named", |named| match named.standing() {
            Standing::Found => "found",
            Standing::Suspected => "suspected",
        });
        let size = named.map(|named| named.amplitude);
        table.row([
            Cell::Text(&candidate.effect),
            Cell::Text(answer),
            Cell::Number(Some(named.map_or(candidate.probability, |named| named.probability))),
            Cell::Number(Some(named.map_or(candidate.gain_nats, |named| named.gain_nats))),
            Cell::Text(named.map_or("", |named| &named.port)),
            Cell::Number(size.map(|size| size.value)),
            Cell::Number(size.map(|size| size.lower)),
            Cell::Number(size.map(|size| size.upper)),
        ])?;
    }
    Ok(table.finish()?)
}

#[cfg(test)]
mod tests {
    use contract::WithInterval;
    use contract::diagnosis::PersonAmplitude;

    use super::*;

    #[test]
    fn every_effect_that_was_weighed_has_one_row() {
        let candidate = |effect: &str, probability: f64| CandidateEffect {
            effect: effect.to_owned(),
            gain_nats: 2.0,
            probability,
            not_named: None,
        };
        let people = ["a", "b"].map(|id| PersonAmplitude {
            person_id: id.to_owned(),
            amplitude: 1.0,
            lower: 0.5,
            upper: 1.5,
            gain_nats: 4.0,
        });
        let dawn = FoundEffect {
            effect: "dawn".to_owned(),
            port: "egp".to_owned(),
            gain_nats: 8.0,
            probability: 0.9,
            amplitude: WithInterval { value: 1.0, lower: 0.5, upper: 1.5 },
            confusable_with: Vec::new(),
            people: people.to_vec(),
            questioned: Vec::new(),
        };
        let folder = tempfile::tempdir().expect("a folder");
        let candidates = [candidate("dawn", 0.9), candidate("alcohol", 0.1)];
        write_effects(folder.path(), &[dawn], &candidates).expect("writable");
        let text = std::fs::read_to_string(folder.path().join(EFFECTS)).expect("written");
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 3, "{text}");
        assert_eq!(lines[1], "dawn,found,0.9,8,egp,1,0.5,1.5");
        assert_eq!(lines[2], "alcohol,not named,0.1,2,,,,");
    }
}
