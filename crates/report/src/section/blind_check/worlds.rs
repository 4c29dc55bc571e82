//! Every world, and how its labels were sealed.

use std::collections::BTreeMap;

use super::super::words::{outcome, plain, short_effect};
use crate::html::{Column, Html};
use crate::number::{count, fixed, percent};
use contract::BlindCheck;
use contract::blind_check::{Kind, Outcome, Seal, SealedWorld, Verdict, WorldRow};

pub(in super::super) fn body(html: &mut Html, (check, seal): (&BlindCheck, Option<&Seal>)) {
    html.paragraph(&match check.seeds.as_slice() {
        [] => format!("All worlds were drawn from master seed {}.", check.master_seed),
        seeds => {
            let seeds: Vec<String> = seeds.iter().map(u64::to_string).collect();
            let seeds = seeds.join(", ");
            format!(
                "The worlds of {} checks are scored together, drawn from master seeds {seeds}.",
                check.seeds.len()
            )
        }
    });
    composition(html, check);
    if !check.worlds.is_empty() {
        let all = count(check.worlds.len(), "world", "worlds");
        html.folded(&format!("Truth and answer of {all}"), |html| every_world(html, &check.worlds));
    }
    let Some(seal) = seal else {
        html.absent(
            "The seal is not in this folder, so the hashes of the labels are not shown here.",
        );
        return;
    };
    // Hashes, so that nobody has to trust the labels.
    let hashes = count(seal.worlds.len(), "hash", "hashes");
    let hash = |world: &SealedWorld| (false, vec![world.id.clone(), world.sha256.clone()]);
    html.folded(&format!("The seal: {hashes}"), |html| {
        html.table(
            &format!("Hashes of the labels: {}", seal.hash),
            &[("World", Column::Text), ("SHA-256", Column::Text)],
            seal.worlds.iter().map(hash).collect(),
        );
    });
}

/// How many worlds of each kind and simulator there are.
fn composition(html: &mut Html, check: &BlindCheck) {
    if check.worlds.is_empty() {
        html.absent("No world was made.");
    }
    // Worlds, and those that were answered correctly.
    let mut counts: BTreeMap<(Kind, &str), (usize, usize)> = BTreeMap::new();
    for world in &check.worlds {
        let (all, correct) = counts.entry((world.kind, world.generator.as_str())).or_default();
        *all += 1;
        *correct += usize::from(world.outcome == Outcome::Correct);
    }
    let truth = |kind: Kind| match kind {
        Kind::Null => "nothing acts",
        Kind::Single => "one effect of the library",
        Kind::Pair => "two effects of the library",
        Kind::Outside => "an effect outside the library",
    };
    html.rows(
        "Worlds by truth and simulator",
        &counts.into_iter().collect::<Vec<_>>(),
        &[
            ("Truth", Column::Text, &|((kind, _), _)| truth(*kind).to_owned()),
            ("Simulator", Column::Text, &|((_, generator), _)| plain(generator)),
            ("Worlds", Column::Number, &|(_, (all, _))| all.to_string()),
            ("Answered correctly", Column::Number, &|(_, (_, correct))| correct.to_string()),
        ],
    );
}

fn every_world(html: &mut Html, worlds: &[WorldRow]) {
    let or_word = |words: Vec<String>, word: &str| match words.is_empty() {
        true => plain(word),
        false => words.join(", "),
    };
    let truth = |world: &WorldRow| {
        let effects = world.truth.iter();
        let effects =
            effects.map(|t| format!("{} ({})", plain(&t.effect), fixed(t.achieved_mg_dl, 1)));
        or_word(effects.collect(), "none")
    };
    let answer = |world: &WorldRow| {
        let named = world.found.iter();
        let named =
            named.map(|f| format!("{} ({})", short_effect(&f.effect), percent(f.probability)));
        let verdict = match world.verdict {
            Verdict::None => "none",
            Verdict::Effect => "effect",
            Verdict::Unknown => "unknown",
            Verdict::Failed => "failed",
        };
        or_word(named.collect(), verdict)
    };
    html.marked_rows(
        "Every world; bold: not answered correctly",
        worlds,
        |world| world.outcome != Outcome::Correct,
        &[
            ("World", Column::Text, &|world| world.id.clone()),
            ("Truth (shift, mg/dL)", Column::Text, &truth),
            ("Answer (probability)", Column::Text, &answer),
            ("Outcome", Column::Text, &|world| match &world.failure {
                Some(failure) => format!("{}: {failure}", outcome(world.outcome)),
                None => outcome(world.outcome).to_owned(),
            }),
            ("Simulator", Column::Text, &|world| plain(&world.generator)),
            ("Insulin", Column::Text, &|world| plain(&world.regime).replace(' ', "\u{a0}")),
            ("People \u{d7} days", Column::Text, &|world| {
                format!("{}\u{a0}\u{d7}\u{a0}{}", world.people, world.days)
            }),
            ("Done to the record", Column::Text, &|world| world.nuisances.join("; ")),
            ("Seconds", Column::Number, &|world| fixed(world.seconds, 1)),
        ],
    );
}
