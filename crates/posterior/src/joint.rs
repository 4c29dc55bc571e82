//! What is missing: nothing, one effect, two, or something outside the library.
//!
//! With log odds a_i of each effect and of each kind of thing outside the library, beside nothing, and one number c for
//! pairs,
//!
//! ```text
//! P(S) = exp(sum of a_i over S + c [S is a pair]) / Z:
//! ```
//!
//! two effects act independently but for how often two do, and what is outside the library stands alone. It is unknown
//! with the sum of the probabilities of its kinds.

/// Largest size of log odds: two such still multiply to a finite number.
const LARGEST_ODDS: f64 = 40.0;

/// The factor of log odds.
fn weight(odds: f64) -> f64 {
    odds.clamp(-LARGEST_ODDS, LARGEST_ODDS).exp()
}

/// Probabilities under log odds and a number for pairs.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Joint {
    /// That nothing is missing.
    pub(crate) nothing: f64,
    /// Of each effect, alone or beside another, and then of each kind outside the library.
    pub(crate) each: Vec<f64>,
    /// Of two effects together.
    pub(crate) two: f64,
    effects: usize,
}

impl Joint {
    /// `odds` of so many `effects` and then of each kind outside the library; `pair` is c.
    pub(crate) fn of(odds: &[f64], effects: usize, pair: f64) -> Self {
        let weights: Vec<f64> = odds.iter().map(|odds| weight(*odds)).collect();
        let (library, outside) = weights.split_at(effects);
        let all: f64 = library.iter().sum();
        let partners = weight(pair);
        let beside: Vec<f64> = (0..effects)
            .map(|index| {
                let others = library.iter().enumerate().filter(|(other, _)| *other != index);
                library[index] * partners * others.map(|(_, weight)| weight).sum::<f64>()
            })
            .collect();
        let two = 0.5 * beside.iter().sum::<f64>();
        let z = 1.0 + all + two + outside.iter().sum::<f64>();
        let library = library.iter().zip(&beside).map(|(alone, beside)| (alone + beside) / z);
        let outside = outside.iter().map(|alone| alone / z);
        Self { nothing: 1.0 / z, each: library.chain(outside).collect(), two: two / z, effects }
    }

    /// Of something outside the library.
    pub(crate) fn unknown(&self) -> f64 {
        self.each[self.effects..].iter().sum()
    }

    /// Slopes of minus the log probability that these are missing and nothing else: by the odds, and by the number for pairs.
    pub(crate) fn slopes(&self, missing: &[bool]) -> (Vec<f64>, f64) {
        let acts = |is: bool| f64::from(u8::from(is));
        let by_odds = self.each.iter().zip(missing).map(|(p, is)| p - acts(*is)).collect();
        (by_odds, self.two - acts(is_pair(missing)))
    }
}

/// Whether two are missing.
pub(crate) fn is_pair(missing: &[bool]) -> bool {
    missing.iter().filter(|is| **is).count() == 2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probabilities_are_those_of_all_sets_written_down() {
        let (odds, pair) = ([0.7_f64, -1.2, 0.1, -0.4, 0.9], 0.5_f64);
        let mut sets: Vec<Vec<usize>> = vec![vec![], vec![0], vec![1], vec![2], vec![3], vec![4]];
        sets.extend([vec![0, 1], vec![0, 2], vec![1, 2]]);
        let weight = |set: &Vec<usize>| {
            let extra = if set.len() == 2 { pair } else { 0.0 };
            (set.iter().map(|i| odds[*i]).sum::<f64>() + extra).exp()
        };
        let z: f64 = sets.iter().map(weight).sum();
        let share = |of: &dyn Fn(&Vec<usize>) -> bool| {
            sets.iter().filter(|set| of(set)).map(weight).sum::<f64>() / z
        };
        let joint = Joint::of(&odds, 3, pair);
        assert!((joint.unknown() - share(&|set| set.iter().any(|i| *i > 2))).abs() < 1e-12);
        assert!((joint.nothing - share(&|set| set.is_empty())).abs() < 1e-12);
        assert!((joint.two - share(&|set| set.len() == 2)).abs() < 1e-12);
        for (index, found) in joint.each.iter().enumerate() {
            assert!((found - share(&|set| set.contains(&index))).abs() < 1e-12, "{index}");
        }
    }

    #[test]
    fn slopes_are_differences_of_the_log_probability() {
        let (odds, pair, step) = ([0.3, -0.8, 1.1, 0.2], -0.6, 1e-5);
        let missing = [true, false, true, false];
        let log = |odds: &[f64], pair: f64| {
            Joint::of(odds, 3, pair).nothing.ln() + odds[0] + odds[2] + pair
        };
        let (by_odds, by_pair) = Joint::of(&odds, 3, pair).slopes(&missing);
        for (index, slope) in by_odds.iter().enumerate() {
            let at = |sign: f64| {
                let mut moved = odds;
                moved[index] += sign * step;
                log(&moved, pair)
            };
            assert!((slope + (at(1.0) - at(-1.0)) / (2.0 * step)).abs() < 1e-8, "{index}");
        }
        let by_difference = (log(&odds, pair + step) - log(&odds, pair - step)) / (2.0 * step);
        assert!((by_pair + by_difference).abs() < 1e-8);
    }

    #[test]
    fn the_largest_odds_stay_finite() {
        let joint = Joint::of(&[1e9; 19], 18, 0.0);
        assert!(joint.each[..18].iter().all(|p| (p - 2.0 / 18.0).abs() < 1e-9), "{joint:?}");
    }
}
