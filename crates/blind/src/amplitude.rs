//! Whether a larger effect gets a larger estimate.

use crate::outcome::outcome;
use contract::blind_check::{AmplitudeRecovery, Kind, Outcome};

use std::collections::BTreeMap;

use crate::scored_world::ScoredWorld;

/// Fewest worlds of an effect for which ranks are meaningful.
const FEWEST: usize = 3;

/// Ranks the worlds.
pub(crate) fn amplitude_recovery(worlds: &[ScoredWorld]) -> AmplitudeRecovery {
    let mut by_effect: BTreeMap<&str, Vec<(f64, f64)>> = BTreeMap::new();
    for world in worlds {
        let correct = outcome(&world.label, &world.answer) == Outcome::Correct;
        let pair = world.label.effects.first().zip(world.answer.found.first());
        if let (Kind::Single, true, Some((truth, found))) = (world.label.kind, correct, pair) {
            let amplitudes = (truth.amplitude, found.amplitude.value);
            by_effect.entry(&truth.effect).or_default().push(amplitudes);
        }
    }
    let mut ranked: Vec<(f64, f64)> = Vec::new();
    for pairs in by_effect.values().filter(|pairs| pairs.len() >= FEWEST) {
        let (truth, found): (Vec<f64>, Vec<f64>) = pairs.iter().copied().unzip();
        ranked.extend(centred_ranks(&truth).into_iter().zip(centred_ranks(&found)));
    }
    let sum = |of: fn(&(f64, f64)) -> f64| ranked.iter().map(of).sum::<f64>();
    let scale = (sum(|r| r.0 * r.0) * sum(|r| r.1 * r.1)).sqrt();
    AmplitudeRecovery {
        worlds: ranked.len(),
        rank_correlation: (scale > 0.0).then(|| sum(|r| r.0 * r.1) / scale),
    }
}

/// Ranks with mean 0, averaged over ties, as a share of their number.
fn centred_ranks(values: &[f64]) -> Vec<f64> {
    let n = values.len() as f64;
    values
        .iter()
        .map(|value| {
            let below = values.iter().filter(|other| *other < value).count() as f64;
            let above = values.iter().filter(|other| *other > value).count() as f64;
            0.5 * (below - above) / n
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planted::{answer, world};

    #[test]
    fn ranks_are_compared_within_effects() {
        let of = |effect: &str, truth: f64, estimate: f64| {
            let mut planted = world("w", Kind::Single, &[effect], answer(&[effect]));
            planted.label.effects[0].amplitude = truth;
            planted.answer.found[0].amplitude.value = estimate;
            planted
        };
        // The second effect's amplitudes lie on another scale, which must not matter; the third has
        // too few worlds.
        let mut worlds = vec![of("dawn", 1.0, 0.1), of("dawn", 2.0, 0.2), of("dawn", 3.0, 0.9)];
        worlds.extend([
            of("alcohol", 0.1, 70.0),
            of("alcohol", 0.2, 80.0),
            of("alcohol", 0.3, 90.0),
        ]);
        worlds.push(of("exercise", 1.0, 1.0));
        let recovery = amplitude_recovery(&worlds);
        assert_eq!(recovery.worlds, 6);
        assert!((recovery.rank_correlation.expect("varies") - 1.0).abs() < 1e-12); // rounding
        worlds.truncate(3);
        worlds[2].answer.found[0].amplitude.value = 0.0;
        // Ranks 1 2 3 against 2 3 1: 1 - 6 (1 + 1 + 4) / 24.
        let correlation = amplitude_recovery(&worlds).rank_correlation.expect("varies");
        assert!((correlation + 0.5).abs() < 1e-12);
    }

    #[test]
    fn nothing_correct_says_nothing() {
        let wrong = [world("w", Kind::Single, &["dawn"], answer(&["alcohol"]))];
        let recovery = amplitude_recovery(&wrong);
        assert_eq!((recovery.worlds, recovery.rank_correlation), (0, None));
    }
}
