//! Worlds with two effects: precision, recall and F1 over names.

use serde::{Deserialize, Serialize};

use crate::answer::Verdict;
use crate::check::ScoredWorld;
use crate::error::BlindError;
use crate::label::Kind;
use crate::share::{Share, interval_over_worlds};

/// Names given in worlds with two effects against the names that act, over all such worlds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PairScore {
    /// Worlds with two effects.
    pub worlds: usize,
    /// Of the names given, those that act.
    pub precision: Share,
    /// Of the effects that act, those that were named.
    pub recall: Share,
    /// Worlds in which both, and nothing else, were named.
    pub both: Share,
    /// Harmonic mean of precision and recall; `None` without a world.
    pub f1: Option<f64>,
    /// Lower end of its 95 % bootstrap interval over worlds.
    pub f1_lower: Option<f64>,
    /// Upper end of its 95 % bootstrap interval over worlds.
    pub f1_upper: Option<f64>,
    /// F1 if a name whose set of confusable effects holds one that acts, and is not named itself,
    /// counts as that one.
    pub f1_counting_sets: Option<f64>,
    /// Worlds in which both effects move glucose by 5 mg/dL or more.
    pub worlds_at_5: usize,
    /// F1 over those worlds alone.
    pub f1_at_5: Option<f64>,
}

/// Names of one world.
#[derive(Debug, Clone, Copy, Default)]
struct Counts {
    right: usize,
    right_counting_sets: usize,
    named: usize,
    act: usize,
    smallest_shift: f64,
}

impl PairScore {
    /// Scores the worlds that have two effects; `seed` is that of the bootstrap.
    ///
    /// # Errors
    /// If an interval cannot be formed.
    pub fn of(worlds: &[ScoredWorld], seed: u64) -> Result<Self, BlindError> {
        let counts: Vec<Counts> =
            worlds.iter().filter(|w| w.label.kind == Kind::Pair).map(count).collect();
        let sum = |of: fn(&Counts) -> usize| counts.iter().map(of).sum::<usize>();
        let all: Vec<&Counts> = counts.iter().collect();
        let interval = interval_over_worlds(&counts, seed, |drawn| f1(drawn, |c| c.right))?;
        let some = !counts.is_empty();
        let at_5: Vec<&Counts> = counts.iter().filter(|c| c.smallest_shift >= 5.0).collect();
        Ok(Self {
            worlds: counts.len(),
            precision: Share::of(sum(|c| c.right), sum(|c| c.named))?,
            recall: Share::of(sum(|c| c.right), sum(|c| c.act))?,
            both: Share::among(&counts, |c| c.right == c.act && c.named == c.act)?,
            f1: some.then(|| f1(&all, |c| c.right)),
            f1_lower: interval.map(|ends| ends.0),
            f1_upper: interval.map(|ends| ends.1),
            f1_counting_sets: some.then(|| f1(&all, |c| c.right_counting_sets)),
            worlds_at_5: at_5.len(),
            f1_at_5: (!at_5.is_empty()).then(|| f1(&at_5, |c| c.right)),
        })
    }
}

fn count(world: &ScoredWorld) -> Counts {
    let found: &[_] =
        if world.answer.verdict == Verdict::Effect { &world.answer.found } else { &[] };
    let truth: Vec<&str> = world.label.effects.iter().map(|e| e.effect.as_str()).collect();
    let is_right = |name: &str| truth.contains(&name);
    let mut open: Vec<&str> =
        truth.iter().copied().filter(|name| found.iter().all(|f| f.effect != *name)).collect();
    let right = found.iter().filter(|f| is_right(&f.effect)).count();
    let mut by_set = 0;
    for name in found.iter().filter(|f| !is_right(&f.effect)) {
        let stands_for = open.iter().position(|open| name.set_holds(|other| other == *open));
        if let Some(place) = stands_for {
            open.remove(place);
            by_set += 1;
        }
    }
    let shifts = world.label.effects.iter().map(|e| e.achieved_mg_dl);
    Counts {
        right,
        right_counting_sets: right + by_set,
        named: found.len(),
        act: truth.len(),
        smallest_shift: shifts.fold(f64::INFINITY, f64::min),
    }
}

/// 2 right / (named + acting).
fn f1(worlds: &[&Counts], right: impl Fn(&Counts) -> usize) -> f64 {
    let sum = |of: &dyn Fn(&Counts) -> usize| worlds.iter().map(|c| of(c)).sum::<usize>() as f64;
    2.0 * sum(&right) / sum(&|c| c.named + c.act)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planted::{answer, world};

    #[test]
    fn names_are_counted_over_all_pairs() {
        let mut set = answer(&["alcohol"]);
        set.found[0].confusable_with = vec!["dawn".to_owned(), "exercise".to_owned()];
        let truth = ["dawn", "exercise"];
        let worlds = [
            world("1", Kind::Pair, &truth, answer(&["exercise", "dawn"])), // 2 right of 2
            world("2", Kind::Pair, &truth, answer(&["dawn", "alcohol"])),  // 1 right of 2
            world("3", Kind::Pair, &truth, set),                           // 0 of 1, one by its set
            world("4", Kind::Pair, &truth, crate::Answer::none()),         // 0 of 0
            world("5", Kind::Single, &["dawn"], answer(&["alcohol"])),     // no pair
        ];
        let score = PairScore::of(&worlds, 1).expect("countable");
        assert_eq!((score.precision.count, score.precision.of), (3, 5));
        assert_eq!((score.recall.count, score.recall.of), (3, 8));
        assert_eq!((score.both.count, score.both.of), (1, 4));
        assert_eq!(score.f1, Some(6.0 / 13.0));
        assert_eq!(score.f1_counting_sets, Some(8.0 / 13.0));
        assert_eq!((score.worlds_at_5, score.f1_at_5), (4, score.f1));
        let mut weaker = worlds.to_vec();
        weaker[3].label.effects[1].achieved_mg_dl = 1.5;
        let weaker = PairScore::of(&weaker, 1).expect("countable");
        assert_eq!((weaker.worlds_at_5, weaker.f1_at_5), (3, Some(6.0 / 11.0)));
        let (lower, upper) = (score.f1_lower.expect("ends"), score.f1_upper.expect("ends"));
        let f1 = 6.0 / 13.0;
        assert!((0.0..f1).contains(&lower) && f1 < upper && upper <= 1.0);
    }

    #[test]
    fn without_a_pair_there_is_no_score() {
        let score = PairScore::of(&[], 1).expect("countable");
        assert_eq!((score.worlds, score.f1, score.precision.value), (0, None, None));
    }
}
