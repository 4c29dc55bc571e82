//! Truth against answer, by name.

use contract::blind_check::{Confusion, ConfusionRow, Kind, Verdict};

use std::collections::{BTreeMap, BTreeSet};

use crate::scored_world::ScoredWorld;

/// Counts the worlds.
pub(crate) fn confusion(worlds: &[ScoredWorld]) -> Confusion {
    let cells: Vec<((u8, String), (u8, String))> = worlds
        .iter()
        .filter(|world| world.label.kind != Kind::Pair)
        .map(|world| (truth(world), answer(world)))
        .collect();
    // An effect that is the truth of some world has a column even if no answer names it.
    let names = cells.iter().flat_map(|(truth, answer)| [truth, answer]);
    let effects = names.filter(|(rank, _)| *rank == EFFECT).cloned();
    let words = ["none", "unknown", "failed"].into_iter().zip(WORDS..);
    let words = words.map(|(word, rank)| (rank, word.to_owned()));
    let columns: BTreeSet<(u8, String)> = effects.chain(words).collect();
    let mut rows: BTreeMap<(u8, String), Vec<usize>> = BTreeMap::new();
    for (truth, answer) in cells {
        let counts = rows.entry(truth).or_insert_with(|| vec![0; columns.len()]);
        for (count, column) in counts.iter_mut().zip(&columns) {
            *count += usize::from(*column == answer);
        }
    }
    Confusion {
        answers: columns.into_iter().map(|(_, name)| name).collect(),
        rows: rows.into_iter().map(|((_, truth), counts)| ConfusionRow { truth, counts }).collect(),
    }
}

/// Effects come first, the words `none`, `unknown` and `failed` after them.
const EFFECT: u8 = 0;
const WORDS: u8 = 1;
const OUTSIDE: u8 = 4;

fn truth(world: &ScoredWorld) -> (u8, String) {
    match (world.label.kind, world.label.effects.first()) {
        (Kind::Outside, Some(effect)) => (OUTSIDE, format!("outside:{}", effect.effect)),
        (_, Some(effect)) => (EFFECT, effect.effect.clone()),
        (_, None) => (WORDS, "none".to_owned()),
    }
}

fn answer(world: &ScoredWorld) -> (u8, String) {
    let word = |place: u8, name: &str| (WORDS + place, name.to_owned());
    match (world.answer.verdict, world.answer.first()) {
        (Verdict::Effect, Some(effect)) => (EFFECT, effect.to_owned()),
        (Verdict::None, _) => word(0, "none"),
        // "Effect" without an effect names nothing.
        (Verdict::Unknown | Verdict::Effect, _) => word(1, "unknown"),
        (Verdict::Failed, _) => word(2, "failed"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::planted::{answer, world};
    use contract::blind_check::Answer;

    #[test]
    fn worlds_are_counted_where_they_belong() {
        let worlds = [
            world("1", Kind::Single, &["dawn"], answer(&["dawn"])),
            world("2", Kind::Single, &["dawn"], answer(&["alcohol", "dawn"])),
            world("3", Kind::Single, &["exercise"], Answer::none()),
            world("4", Kind::Null, &[], Answer::failed("killed", 0.0)),
            world("5", Kind::Outside, &["occlusion"], answer(&["dawn"])),
            world("6", Kind::Pair, &["dawn", "exercise"], answer(&["dawn"])),
        ];
        let confusion = confusion(&worlds);
        assert_eq!(confusion.answers, ["alcohol", "dawn", "exercise", "none", "unknown", "failed"]);
        let rows: Vec<(&str, &[usize])> =
            confusion.rows.iter().map(|r| (r.truth.as_str(), r.counts.as_slice())).collect();
        assert_eq!(
            rows,
            [
                ("dawn", &[1, 1, 0, 0, 0, 0][..]),
                ("exercise", &[0, 0, 0, 1, 0, 0]),
                ("none", &[0, 0, 0, 0, 0, 1]),
                ("outside:occlusion", &[0, 1, 0, 0, 0, 0]),
            ]
        );
    }
}
