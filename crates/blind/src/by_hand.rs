//! The figures of a check by hand: by the generator of the worlds that are judged.
//!
//! The diagnosis that answers a world never saw the hand that made it: whatever is fitted was
//! fitted on the other hands. So a row says what the diagnosis does on people whom nobody here has
//! drawn.

use crate::localisation::where_score;
use crate::pairs::pair_score;
use crate::reliability::reliability;
use crate::share::{among, share};
use crate::unknown::unknown_score;
use contract::blind_check::{HandRow, Kind, Share, Verdict};

use std::collections::BTreeSet;

use crate::error::BlindError;
use crate::scored_world::ScoredWorld;

fn hand_row(hand: Option<&str>, worlds: &[ScoredWorld], seed: u64) -> Result<HandRow, BlindError> {
    let of_kind = |kind| worlds.iter().filter(move |w| w.label.kind == kind);
    let first = |w: &ScoredWorld| w.answer.first().is_some_and(|name| w.label.has(name));
    let named_from = |from: f64| {
        let moved = of_kind(Kind::Single).filter(|w| w.label.largest_shift() >= from);
        among(moved, |w| first(w))
    };
    let is_named = |w: &&ScoredWorld| w.answer.verdict == Verdict::Effect;
    let unknown = unknown_score(worlds)?;
    let found = where_score(worlds)?;
    let after_an_hour = found.context.into_iter().next();
    Ok(HandRow {
        hand: hand.map(str::to_owned),
        worlds: worlds.len(),
        named: named_from(0.0)?,
        named_from_5: named_from(5.0)?,
        named_from_10: named_from(10.0)?,
        another_named: among(of_kind(Kind::Single), |w| {
            w.answer.found.iter().any(|found| !w.label.has(&found.effect))
        })?,
        nulls_with_alarm: among(of_kind(Kind::Null), |w| w.answer.raises_alarm())?,
        nulls_with_name: among(of_kind(Kind::Null), is_named)?,
        unknown: unknown.recalled,
        right_port: unknown.right_port,
        outside_named: among(of_kind(Kind::Outside), is_named)?,
        pairs_f1: pair_score(worlds, seed)?.f1,
        calibration_error: reliability(worlds, seed)?.expected_calibration_error,
        where_by_chance: after_an_hour.as_ref().and_then(|context| context.chance),
        where_hit: after_an_hour.map_or_else(|| share(0, 0), |context| Ok(context.hit))?,
    })
}

/// A row per hand, by name, and one of all hands together.
pub(crate) fn by_hand(worlds: &[ScoredWorld], seed: u64) -> Result<Vec<HandRow>, BlindError> {
    let hands: BTreeSet<&str> = worlds.iter().map(|w| w.label.generator.as_str()).collect();
    let mut rows = Vec::with_capacity(hands.len() + 1);
    for hand in hands {
        let own: Vec<ScoredWorld> =
            worlds.iter().filter(|w| w.label.generator == hand).cloned().collect();
        rows.push(hand_row(Some(hand), &own, seed)?);
    }
    rows.push(hand_row(None, worlds, seed)?);
    Ok(rows)
}

/// The head of a column, and what it shows of a hand.
type Column = (&'static str, fn(&HandRow) -> String);

/// The rows as a table of text, one line per hand.
#[must_use]
pub fn hand_table(rows: &[HandRow]) -> String {
    let columns: [Column; 15] = [
        ("hand", |row| row.hand.clone().unwrap_or_else(|| "all".to_owned())),
        ("worlds", |row| row.worlds.to_string()),
        ("named", |row| share_in_words(&row.named)),
        ("from 5", |row| share_in_words(&row.named_from_5)),
        ("from 10", |row| share_in_words(&row.named_from_10)),
        ("another", |row| share_in_words(&row.another_named)),
        ("alarms", |row| share_in_words(&row.nulls_with_alarm)),
        ("with name", |row| share_in_words(&row.nulls_with_name)),
        ("unknown", |row| share_in_words(&row.unknown)),
        ("its port", |row| share_in_words(&row.right_port)),
        ("misnamed", |row| share_in_words(&row.outside_named)),
        ("pairs F1", |row| figure(row.pairs_f1)),
        ("calibration", |row| figure(row.calibration_error)),
        ("where", |row| share_in_words(&row.where_hit)),
        ("by chance", |row| figure(row.where_by_chance)),
    ];
    let mut lines = vec![columns.iter().map(|(name, _)| (*name).to_owned()).collect::<Vec<_>>()];
    for row in rows {
        lines.push(columns.iter().map(|(_, of)| of(row)).collect());
    }
    crate::text_table::aligned(&lines)
}

fn share_in_words(share: &Share) -> String {
    let in_words = |value: f64| format!("{value:.2} ({}/{})", share.count, share.of);
    share.value.map_or_else(|| "-".to_owned(), in_words)
}

fn figure(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.2}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::planted::{answer, label};
    use contract::blind_check::Answer;

    fn world(hand: &str, kind: Kind, truth: &[&str], shift: f64, answer: Answer) -> ScoredWorld {
        let mut label = label("w", kind, truth, shift);
        label.generator = hand.to_owned();
        ScoredWorld { label, answer }
    }

    #[test]
    fn each_hand_is_counted_by_itself_and_all_together() {
        let worlds = [
            world("a", Kind::Single, &["dawn"], 12.0, answer(&["dawn", "alcohol"])),
            world("a", Kind::Null, &[], 0.0, answer(&["dawn"])),
            world("b", Kind::Single, &["dawn"], 6.0, Answer::none()),
            world("b", Kind::Single, &["dawn"], 2.5, answer(&["dawn"])),
            world("b", Kind::Null, &[], 0.0, Answer::none()),
        ];
        let rows = by_hand(&worlds, 1).expect("countable");
        let [a, b, all] = &rows[..] else { panic!("three rows: {rows:?}") };
        assert_eq!((a.hand.as_deref(), a.worlds), (Some("a"), 2));
        assert_eq!((a.named.count, a.named.of), (1, 1));
        assert_eq!((a.another_named.count, a.nulls_with_name.count), (1, 1));
        assert_eq!(
            (b.named.count, b.named.of, b.named_from_5.count, b.named_from_5.of),
            (1, 2, 0, 1)
        );
        assert_eq!((b.nulls_with_alarm.count, b.named_from_10.of), (0, 0));
        assert_eq!((all.hand.as_deref(), all.named.count, all.named.of), (None, 2, 3));
        let table = hand_table(&rows);
        assert_eq!(table.lines().count(), 4);
        assert!(table.contains("0.67 (2/3)"), "{table}");
    }
}
