//! Which effects act, where the makers of the cohort state it, beside what was found.

use super::words::{effect, list};
use crate::html::{Column, Html};
use crate::number::{ABSENT, count, ends, fixed, interval, optional, percent};
use contract::diagnosis::{FoundEffect, Standing};
use contract::truth::ActingEffect;
use contract::{Diagnosis, StatedTruth};

/// Columns that are always shown, on a terminal and on the page.
const SHOWN: usize = 5;

pub(super) fn body(html: &mut Html, (diagnosis, truth): (&Diagnosis, &StatedTruth)) {
    html.paragraph(&summary(diagnosis, truth));
    html.paragraph(&format!(
        "The people of this cohort are virtual, or effects were planted into their records: '{}' beside the \
         cohort folder states which. The diagnosis does not read it; it was opened when the diagnosis \
         was written.",
        truth.source
    ));
    let columns = [
        ("Effect", Column::Text),
        ("True size (range over people)", Column::Number),
        ("Answer", Column::Text),
        ("Size found (interval)", Column::Number),
        ("Its probability", Column::Number),
        ("Shifts glucose by, mg/dL", Column::Number),
        ("What a size of 1 does", Column::Text),
    ];
    // What the source does not state has no column.
    let rows = rows(diagnosis, truth);
    let stated = |column: usize| rows.iter().any(|(_, cells)| cells[column] != ABSENT);
    let shown: Vec<usize> =
        (0..columns.len()).filter(|column| *column < SHOWN || stated(*column)).collect();
    let columns: Vec<(&str, Column)> = shown.iter().map(|column| columns[*column]).collect();
    let row = |(named, cells): &Row| {
        (*named, shown.iter().map(|column| cells[*column].clone()).collect::<Vec<_>>())
    };
    html.table(
        "What acts, and what was found; bold: named. Sizes are multiples of the published one",
        &columns,
        rows.iter().map(row).collect(),
    );
}

/// The table as text for a terminal, with its summary.
pub(super) fn text(diagnosis: &Diagnosis, truth: &StatedTruth) -> String {
    let head = ["effect", "true size", "answer", "size found", "probability"].map(str::to_owned);
    let rows = rows(diagnosis, truth).into_iter().map(|(_, cells)| cells[..SHOWN].to_vec());
    let all: Vec<Vec<String>> = std::iter::once(head.to_vec()).chain(rows).collect();
    let letters = |cell: &String| cell.chars().count();
    let width = |column: usize| all.iter().map(|cells| letters(&cells[column])).max();
    let widths: [usize; SHOWN] = std::array::from_fn(|column| width(column).unwrap_or_default());
    let mut text = format!("{}\n\n", summary(diagnosis, truth));
    for cells in &all {
        let padded = cells.iter().zip(widths).map(|(cell, width)| {
            // A space is a space on a terminal, and padding counts letters, not bytes. A width in
            // the format string ends in a panic above 65,535.
            cell.replace('\u{a0}', " ") + &" ".repeat(width - letters(cell))
        });
        text.push_str(padded.collect::<Vec<_>>().join("  ").trim_end());
        text.push('\n');
    }
    text
}

/// How many of the effects that act are found, and whether any is named that does not act.
fn summary(diagnosis: &Diagnosis, truth: &StatedTruth) -> String {
    let acts = |named: &FoundEffect| truth.effects.iter().any(|one| one.effect == named.effect);
    let names = |of: &dyn Fn(&FoundEffect) -> bool| -> Vec<String> {
        let named = diagnosis.effects.iter().filter(|named| of(named));
        named.map(|named| effect(&named.effect)).collect()
    };
    let wrong = names(&|named| !acts(named));
    let found = names(&|named| acts(named) && named.standing() == Standing::Found);
    let suspected = names(&|named| acts(named) && named.standing() == Standing::Suspected);
    let mut text = match truth.effects.len() {
        0 => "No effect acts in this cohort.".to_owned(),
        n => {
            let verb = if n == 1 { "acts" } else { "act" };
            let part = |names: &[String], word: &str| match names {
                [] => format!("none is {word}"),
                _ => format!("{} {word}: {}", names.len(), list(names)),
            };
            let mut text = format!(
                "{} {verb} in this cohort; {}",
                count(n, "effect", "effects"),
                part(&found, "found")
            );
            if !suspected.is_empty() {
                text.push_str(&format!("; {}", part(&suspected, "suspected")));
            }
            let not = n.saturating_sub(found.len() + suspected.len());
            if not > 0 {
                text.push_str(&format!("; {not} not named"));
            }
            text + "."
        }
    };
    text.push_str(&match wrong.as_slice() {
        [] => " No effect is named that does not act.".to_owned(),
        names => format!(" Named although not acting: {}.", list(names)),
    });
    text
}

/// Whether an effect is named, and the cells of its row.
type Row = (bool, Vec<String>);

/// Effects that act, then those that are named and do not.
fn rows(diagnosis: &Diagnosis, truth: &StatedTruth) -> Vec<Row> {
    let acting = truth.effects.iter().map(|acting| row(diagnosis, &acting.effect, Some(acting)));
    let others = diagnosis
        .effects
        .iter()
        .filter(|named| truth.effects.iter().all(|acting| acting.effect != named.effect));
    acting.chain(others.map(|named| row(diagnosis, &named.effect, None))).collect()
}

fn row(diagnosis: &Diagnosis, name: &str, acting: Option<&ActingEffect>) -> Row {
    let named: Option<&FoundEffect> = diagnosis.effects.iter().find(|named| named.effect == name);
    let tried = diagnosis.candidates.iter().find(|candidate| candidate.effect == name);
    let untried = diagnosis.untried.iter().any(|untried| untried.effect == name);
    let size = acting.map_or_else(
        || "does not act".to_owned(),
        |acting| {
            let range = acting.lowest.zip(acting.highest).map(|(low, high)| ends(low, high, 2));
            format!("{}{}", fixed(acting.amplitude, 2), range.unwrap_or_default())
        },
    );
    let answer = match named.map(FoundEffect::standing) {
        Some(Standing::Found) => "found",
        Some(Standing::Suspected) => "suspected",
        None if untried => "not tried",
        None if tried.is_none() => "not in the library",
        None => "not named",
    };
    let probability = named.map(|n| n.probability).or_else(|| tried.map(|tried| tried.probability));
    let absent = || ABSENT.to_owned();
    let cells = vec![
        effect(name),
        size,
        answer.to_owned(),
        named.map_or_else(absent, |named| interval(named.amplitude, 2)),
        percent(probability),
        optional(acting.and_then(|acting| acting.shift_mg_dl), 1),
        acting.and_then(|acting| acting.says.clone()).unwrap_or_else(absent),
    ];
    (named.is_some(), cells)
}
