//! Which effects are missing, given that at least one is: a set of any number of them.
//!
//! Worlds lack two effects at most, and so whether anything is missing, and the odds, are learned with sets of one and two
//! ([`crate::joint`]). People lack more. Where only two could be missing, two would take the probability of every
//! third. With the same log odds a_i and the same number c, for every effect beyond the first,
//!
//! ```text
//! P(S | S is not empty) = exp(sum of a_i over S + c (|S| - 1)) / sum of the same over all sets but the empty one:
//! ```
//!
//! effects act independently with odds exp(a_i + c), given that one does (decision 0048).

/// Largest size of log odds: effects that are all as improbable as this still have a sum that is not 0.
const LARGEST_ODDS: f64 = 35.0;

/// Sets of any number of effects, given that one is missing at least.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AnyNumber {
    /// Log odds of each effect, with the number for further effects.
    odds: Vec<f64>,
    /// Log of the sum over all sets but the empty one.
    log_sum: f64,
    /// Probability that one is missing at least, were effects independent with these odds.
    at_least_one: f64,
}

impl AnyNumber {
    /// `odds` of the effects, beside nothing, and the number for every effect beyond the first.
    pub(crate) fn of(odds: &[f64], further: f64) -> Self {
        let bounded = |odds: &f64| (odds + further).clamp(-LARGEST_ODDS, LARGEST_ODDS);
        let odds: Vec<f64> = odds.iter().map(bounded).collect();
        let all: f64 = odds.iter().map(|odds| odds.exp().ln_1p()).sum();
        let at_least_one = -(-all).exp_m1();
        Self { odds, log_sum: all + at_least_one.ln(), at_least_one }
    }

    /// Probability of each effect, alone or beside others.
    pub(crate) fn each(&self) -> Vec<f64> {
        let one = |odds: &f64| (1.0 / (1.0 + (-odds).exp()) / self.at_least_one).min(1.0);
        self.odds.iter().map(one).collect()
    }

    /// The `most` most probable sets with their probabilities, most probable first.
    pub(crate) fn sets(&self, most: usize) -> Vec<(Vec<usize>, f64)> {
        // The best set holds what is likelier than not. Others leave it by as little as they can: by those effects whose
        // odds are smallest in size, one more of them than sets, as the empty set is none.
        let mut order: Vec<usize> = (0..self.odds.len()).collect();
        order.sort_by(|a, b| self.odds[*a].abs().total_cmp(&self.odds[*b].abs()));
        let best: Vec<bool> = self.odds.iter().map(|odds| *odds > 0.0).collect();
        let mut sets = vec![(best, 0.0)];
        for effect in order.into_iter().take(most + 1) {
            let left = sets.clone().into_iter().map(|(mut set, loss): (Vec<bool>, f64)| {
                set[effect] = !set[effect];
                (set, loss + self.odds[effect].abs())
            });
            sets.extend(left);
            sets.sort_by(|a, b| a.1.total_cmp(&b.1));
            sets.truncate(most + 1);
        }
        let probable = |(set, _): (Vec<bool>, f64)| -> Option<(Vec<usize>, f64)> {
            let set: Vec<usize> = (0..set.len()).filter(|index| set[*index]).collect();
            let log = set.iter().map(|index| self.odds[*index]).sum::<f64>() - self.log_sum;
            (!set.is_empty()).then(|| (set, log.exp()))
        };
        sets.into_iter().filter_map(probable).take(most).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ODDS: [f64; 5] = [0.7, -1.2, 0.1, -0.3, -2.4];

    /// Every set but the empty one with its probability, most probable first.
    fn written_down(odds: &[f64], c: f64) -> Vec<(Vec<usize>, f64)> {
        let of = |bits: usize| -> Vec<usize> {
            (0..odds.len()).filter(|i| bits >> i & 1 == 1).collect()
        };
        let weight = |set: &Vec<usize>| {
            (set.iter().map(|i| odds[*i]).sum::<f64>() + c * (set.len() - 1) as f64).exp()
        };
        let sets = (1..1 << odds.len()).map(of);
        let mut sets: Vec<(Vec<usize>, f64)> =
            sets.map(|set| (set.clone(), weight(&set))).collect();
        let sum: f64 = sets.iter().map(|(_, weight)| weight).sum();
        sets.iter_mut().for_each(|(_, weight)| *weight /= sum);
        sets.sort_by(|a, b| b.1.total_cmp(&a.1));
        sets
    }

    #[test]
    fn probabilities_are_those_of_all_sets_written_down() {
        for c in [-0.6, 0.5] {
            let sets = written_down(&ODDS, c);
            for (index, found) in AnyNumber::of(&ODDS, c).each().into_iter().enumerate() {
                let with = sets.iter().filter(|(set, _)| set.contains(&index));
                assert!((found - with.map(|(_, p)| p).sum::<f64>()).abs() < 1e-12, "{index}");
            }
        }
    }

    #[test]
    fn the_most_probable_sets_are_those_of_all_sets_written_down() {
        for c in [-3.0, -0.6, 0.5] {
            for most in [1, 3, 5, 40] {
                let found = AnyNumber::of(&ODDS, c).sets(most);
                assert_eq!(found.len(), most.min(31));
                for ((set, p), (expected, of)) in found.iter().zip(&written_down(&ODDS, c)) {
                    assert_eq!(set, expected);
                    assert!((p - of).abs() < 1e-12, "{set:?}");
                }
            }
        }
    }

    /// The odds of one effect do not depend on those of the others once one of them acts.
    #[test]
    fn a_certain_effect_leaves_the_others_their_odds() {
        let (certain, c) = (20.0, -0.4);
        let each = AnyNumber::of(&[certain, certain, 0.9], c).each();
        let alone = (0.9_f64 + c).exp();
        assert!((each[2] - alone / (1.0 + alone)).abs() < 1e-6, "{each:?}");
    }

    #[test]
    fn the_largest_odds_stay_finite() {
        for (odds, c, expected) in [(1e9, 0.0, 1.0), (-1e9, 0.0, 1.0 / 18.0), (1e9, -1e9, 0.5)] {
            let any = AnyNumber::of(&[odds; 18], c);
            assert!(any.each().iter().all(|p| (p - expected).abs() < 1e-5), "{odds} {any:?}");
            assert!(any.sets(5).iter().all(|(_, p)| (0.0..=1.0).contains(p)));
        }
    }
}
