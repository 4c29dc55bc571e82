//! Every world, and how its labels were sealed.

use super::super::words::{outcome as in_words, plain, short_effect};
use crate::ReportError;
use crate::html::{Column, Html};
use crate::number::{count, fixed, percent};
use contract::BlindCheck;
use contract::blind_check::{Kind, Outcome, Seal, Verdict, WorldRow};

pub(in super::super) fn body(check: &BlindCheck, seal: Option<&Seal>) -> Result<Html, ReportError> {
    let mut html = Html::default();
    html.paragraph(&format!("All worlds were drawn from master seed {}.", check.master_seed));
    composition(&mut html, check);
    let mut table = Html::default();
    let rows: Vec<(bool, Vec<String>)> = check.worlds.iter().map(row).collect();
    table.table(
        "Every world; bold: not answered correctly",
        &[
            ("World", Column::Text),
            ("Truth (shift, mg/dL)", Column::Text),
            ("Answer (probability)", Column::Text),
            ("Outcome", Column::Text),
            ("Simulator", Column::Text),
            ("Insulin", Column::Text),
            ("People \u{d7} days", Column::Text),
            ("Done to the record", Column::Text),
            ("Seconds", Column::Number),
        ],
        &rows,
    );
    if !check.worlds.is_empty() {
        let all = count(check.worlds.len(), "world", "worlds");
        html.folded(&format!("Truth and answer of {all}"), &table);
    }
    match seal {
        Some(seal) => sealed(&mut html, seal),
        None => {
            html.absent(
                "The seal is not in this folder, so the hashes of the labels are not shown here.",
            );
        }
    }
    Ok(html)
}

/// How many worlds of each kind and simulator there are.
fn composition(html: &mut Html, check: &BlindCheck) {
    if check.worlds.is_empty() {
        html.absent("No world was made.");
        return;
    }
    let mut counts: Vec<((Kind, &str), usize, usize)> = Vec::new();
    for world in &check.worlds {
        let key = (world.kind, world.generator.as_str());
        let right = usize::from(world.outcome == Outcome::Correct);
        match counts.iter_mut().find(|(known, ..)| *known == key) {
            Some((_, all, correct)) => {
                *all += 1;
                *correct += right;
            }
            None => counts.push((key, 1, right)),
        }
    }
    counts.sort();
    let truth = |kind: Kind| match kind {
        Kind::Null => "nothing acts",
        Kind::Single => "one effect of the library",
        Kind::Pair => "two effects of the library",
        Kind::Outside => "an effect outside the library",
    };
    html.rows(
        "Worlds by truth and simulator",
        &counts,
        |_| false,
        &[
            ("Truth", Column::Text, &|((kind, _), ..)| truth(*kind).to_owned()),
            ("Simulator", Column::Text, &|((_, generator), ..)| plain(generator)),
            ("Worlds", Column::Number, &|(_, all, _)| all.to_string()),
            ("Answered correctly", Column::Number, &|(.., correct)| correct.to_string()),
        ],
    );
}

fn row(world: &WorldRow) -> (bool, Vec<String>) {
    let truth: Vec<String> = world
        .truth
        .iter()
        .map(|t| format!("{} ({})", plain(&t.effect), fixed(t.achieved_mg_dl, 1)))
        .collect();
    let answer: Vec<String> = world
        .found
        .iter()
        .map(|f| format!("{} ({})", short_effect(&f.effect), percent(f.probability)))
        .collect();
    let or_word = |words: Vec<String>, word: &str| match words.is_empty() {
        true => plain(word),
        false => words.join(", "),
    };
    let outcome = match &world.failure {
        Some(failure) => format!("{}: {failure}", in_words(world.outcome)),
        None => in_words(world.outcome).to_owned(),
    };
    let cells = vec![
        world.id.clone(),
        or_word(truth, "none"),
        or_word(answer, verdict(world.verdict)),
        outcome,
        plain(&world.generator),
        plain(&world.regime).replace(' ', "\u{a0}"),
        format!("{}\u{a0}\u{d7}\u{a0}{}", world.people, world.days),
        world.nuisances.join("; "),
        fixed(world.seconds, 1),
    ];
    (world.outcome != Outcome::Correct, cells)
}

/// The answer where no effect is named.
const fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::None => "none",
        Verdict::Effect => "effect",
        Verdict::Unknown => "unknown",
        Verdict::Failed => "failed",
    }
}

/// Hashes, so that nobody has to trust the labels.
fn sealed(html: &mut Html, seal: &Seal) {
    let mut table = Html::default();
    let rows: Vec<(bool, Vec<String>)> = seal
        .worlds
        .iter()
        .map(|world| (false, vec![world.id.clone(), world.sha256.clone()]))
        .collect();
    table.table(
        &format!("Hashes of the labels: {}", seal.hash),
        &[("World", Column::Text), ("SHA-256", Column::Text)],
        &rows,
    );
    html.folded(&format!("The seal: {}", count(seal.worlds.len(), "hash", "hashes")), &table);
}
