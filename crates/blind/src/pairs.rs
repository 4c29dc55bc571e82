//! Worlds with two effects: precision, recall and F1 over names.

use contract::blind_check::{Kind, PairScore, Verdict};

use crate::error::BlindError;
use crate::scored_world::ScoredWorld;
use crate::share::{among, interval_over_worlds, share};

/// Names of one world.
#[derive(Debug, Clone, Copy, Default)]
struct Counts {
    right: usize,
    right_counting_sets: usize,
    named: usize,
    act: usize,
    smallest_shift: f64,
}

/// Scores the worlds that have two effects; `seed` is that of the bootstrap.
///
/// # Errors
/// If an interval cannot be formed.
pub(crate) fn pair_score(worlds: &[ScoredWorld], seed: u64) -> Result<PairScore, BlindError> {
    let counts: Vec<Counts> =
        worlds.iter().filter(|w| w.label.kind == Kind::Pair).map(count).collect();
    let sum = |of: fn(&Counts) -> usize| counts.iter().map(of).sum::<usize>();
    let all: Vec<&Counts> = counts.iter().collect();
    let interval = interval_over_worlds(&counts, seed, |drawn| f1(drawn, |c| c.right))?;
    let some = !counts.is_empty();
    let at_5: Vec<&Counts> = counts.iter().filter(|c| c.smallest_shift >= 5.0).collect();
    Ok(PairScore {
        worlds: counts.len(),
        precision: share(sum(|c| c.right), sum(|c| c.named))?,
        recall: share(sum(|c| c.right), sum(|c| c.act))?,
        both: among(&counts, |c| c.right == c.act && c.named == c.act)?,
        f1: some.then(|| f1(&all, |c| c.right)),
        f1_lower: interval.map(|ends| ends.0),
        f1_upper: interval.map(|ends| ends.1),
        f1_counting_sets: some.then(|| f1(&all, |c| c.right_counting_sets)),
        worlds_at_5: at_5.len(),
        f1_at_5: (!at_5.is_empty()).then(|| f1(&at_5, |c| c.right)),
    })
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
    use contract::blind_check::Answer;

    #[test]
    fn names_are_counted_over_all_pairs() {
        let mut set = answer(&["alcohol"]);
        set.found[0].confusable_with = vec!["dawn".to_owned(), "exercise".to_owned()];
        let truth = ["dawn", "exercise"];
        let worlds = [
            world("1", Kind::Pair, &truth, answer(&["exercise", "dawn"])), // 2 right of 2
            world("2", Kind::Pair, &truth, answer(&["dawn", "alcohol"])),  // 1 right of 2
            world("3", Kind::Pair, &truth, set),                           // 0 of 1, one by its set
            world("4", Kind::Pair, &truth, Answer::none()),                // 0 of 0
            world("5", Kind::Single, &["dawn"], answer(&["alcohol"])),     // no pair
        ];
        let score = pair_score(&worlds, 1).expect("countable");
        assert_eq!((score.precision.count, score.precision.of), (3, 5));
        assert_eq!((score.recall.count, score.recall.of), (3, 8));
        assert_eq!((score.both.count, score.both.of), (1, 4));
        assert_eq!(score.f1, Some(6.0 / 13.0));
        assert_eq!(score.f1_counting_sets, Some(8.0 / 13.0));
        assert_eq!((score.worlds_at_5, score.f1_at_5), (4, score.f1));
        let mut weaker = worlds.to_vec();
        weaker[3].label.effects[1].achieved_mg_dl = 1.5;
        let weaker = pair_score(&weaker, 1).expect("countable");
        assert_eq!((weaker.worlds_at_5, weaker.f1_at_5), (3, Some(6.0 / 11.0)));
        let (lower, upper) = (score.f1_lower.expect("ends"), score.f1_upper.expect("ends"));
        let f1 = 6.0 / 13.0;
        assert!((0.0..f1).contains(&lower) && f1 < upper && upper <= 1.0);
    }

    #[test]
    fn without_a_pair_there_is_no_score() {
        let score = pair_score(&[], 1).expect("countable");
        assert_eq!((score.worlds, score.f1, score.precision.value), (0, None, None));
    }
}
