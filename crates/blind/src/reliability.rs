//! Whether stated probabilities come true.

use contract::blind_check::{Kind, Reliability, ReliabilityBin, Verdict};

use crate::error::BlindError;
use crate::scored_world::ScoredWorld;
use crate::share::{among, interval_over_worlds};

/// Number of bins between 0 and 1.
const BINS: usize = 10;

#[derive(Debug, Clone, Copy)]
struct Stated {
    probability: f64,
    came_true: bool,
    counting_sets: bool,
}

/// Compares probabilities with what acts; `seed` is that of the bootstrap.
///
/// # Errors
/// If an interval cannot be formed.
pub(crate) fn reliability(worlds: &[ScoredWorld], seed: u64) -> Result<Reliability, BlindError> {
    let by_world: Vec<Vec<Stated>> =
        worlds.iter().map(stated).filter(|stated| !stated.is_empty()).collect();
    let all: Vec<&Vec<Stated>> = by_world.iter().collect();
    let interval = interval_over_worlds(&by_world, seed, |drawn| error(drawn, |s| s.came_true))?;
    let some = !by_world.is_empty();
    let mut bins = Vec::new();
    for bin in 0..BINS {
        let within: Vec<&Stated> =
            by_world.iter().flatten().filter(|s| bin_of(s.probability) == bin).collect();
        if within.is_empty() {
            continue;
        }
        let sum: f64 = within.iter().map(|s| s.probability).sum();
        bins.push(ReliabilityBin {
            from: bin as f64 / BINS as f64,
            to: (bin + 1) as f64 / BINS as f64,
            mean_probability: sum / within.len() as f64,
            came_true: among(within, |s| s.came_true)?,
        });
    }
    Ok(Reliability {
        bins,
        probabilities: by_world.iter().map(Vec::len).sum(),
        expected_calibration_error: some.then(|| error(&all, |s| s.came_true)),
        lower: interval.map(|ends| ends.0),
        upper: interval.map(|ends| ends.1),
        error_if_calibrated: some.then(|| error_if_calibrated(&all)),
        error_counting_sets: some.then(|| error(&all, |s| s.counting_sets)),
    })
}

fn stated(world: &ScoredWorld) -> Vec<Stated> {
    let ScoredWorld { label, answer } = world;
    let right = match answer.verdict {
        Verdict::Effect => {
            return answer
                .found
                .iter()
                .map(|f| Stated {
                    probability: f.probability,
                    came_true: label.has(&f.effect),
                    counting_sets: label.has(&f.effect) || f.set_holds(|other| label.has(other)),
                })
                .collect();
        }
        Verdict::None => label.kind == Kind::Null,
        Verdict::Unknown => label.kind == Kind::Outside,
        Verdict::Failed => return Vec::new(),
    };
    let of = |probability| Stated { probability, came_true: right, counting_sets: right };
    answer.probability_of_verdict().map(of).into_iter().collect()
}

fn bin_of(probability: f64) -> usize {
    ((probability * BINS as f64) as usize).min(BINS - 1)
}

fn error(worlds: &[&Vec<Stated>], came_true: impl Fn(&Stated) -> bool) -> f64 {
    let mut sums = [(0.0_f64, 0.0_f64); BINS];
    let mut count = 0;
    for stated in worlds.iter().copied().flatten() {
        let (probability, truth) = &mut sums[bin_of(stated.probability)];
        *probability += stated.probability;
        *truth += f64::from(u8::from(came_true(stated)));
        count += 1;
    }
    sums.iter().map(|(probability, truth)| (probability - truth).abs()).sum::<f64>()
        / f64::from(count.max(1))
}

/// The mean of [`error`] if each probability is true, independently of the others: in each bin, of the distance between
/// a sum of Bernoulli variables and its mean, by their exact distribution.
fn error_if_calibrated(worlds: &[&Vec<Stated>]) -> f64 {
    let mut bins: [Vec<f64>; BINS] = Default::default();
    for stated in worlds.iter().copied().flatten() {
        bins[bin_of(stated.probability)].push(stated.probability);
    }
    let count: usize = bins.iter().map(Vec::len).sum();
    let distance = |bin: &Vec<f64>| -> f64 {
        let mean: f64 = bin.iter().sum();
        let came_true = number_true(bin).into_iter().enumerate();
        came_true.map(|(number, chance)| chance * (number as f64 - mean).abs()).sum()
    };
    bins.iter().map(distance).sum::<f64>() / count.max(1) as f64
}

/// The distribution of how many of some probabilities come true.
fn number_true(probabilities: &[f64]) -> Vec<f64> {
    let mut chances = vec![1.0];
    for p in probabilities {
        chances.push(0.0);
        for number in (0..chances.len()).rev() {
            let one_less = if number == 0 { 0.0 } else { chances[number - 1] };
            chances[number] = (1.0 - p) * chances[number] + p * one_less;
        }
    }
    chances
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::planted::{answer, with_probability, world};
    use contract::blind_check::Answer;
    use contract::diagnosis::CandidateEffect;

    #[test]
    fn the_error_is_the_mean_distance_of_the_bins() {
        let right = |p| world("a", Kind::Single, &["dawn"], with_probability("dawn", p));
        let wrong = |p| world("b", Kind::Single, &["dawn"], with_probability("alcohol", p));
        // Bin 0.9-1: 0.95, 0.95, 0.95, 0.95 with three true: |3.8 - 3| = 0.8.
        // Bin 0.5-0.6: 0.55 true: |0.55 - 1| = 0.45. Together 1.25 of five.
        let worlds = [right(0.95), right(0.95), right(0.95), wrong(0.95), right(0.55)];
        let found = reliability(&worlds, 1).expect("countable");
        let error = found.expected_calibration_error.expect("probabilities");
        assert!((error - 0.25).abs() < 1e-12); // rounding
        assert_eq!(found.bins.len(), 2);
        assert_eq!((found.bins[1].came_true.count, found.bins[1].came_true.of), (3, 4));
    }

    #[test]
    fn true_probabilities_have_an_error_by_chance() {
        let stated = |p| Stated { probability: p, came_true: true, counting_sets: true };
        // One of .5 is off by .5 either way; of two, by 1 in half of the cases; one of 1 never.
        assert_eq!(error_if_calibrated(&[&vec![stated(0.5)]]), 0.5);
        assert_eq!(error_if_calibrated(&[&vec![stated(0.5), stated(0.5)]]), 0.25);
        assert_eq!(error_if_calibrated(&[&vec![stated(0.5)], &vec![stated(1.0)]]), 0.25);
        assert_eq!(error_if_calibrated(&[]), 0.0);
        let chances = number_true(&[0.2, 0.5]);
        for (chance, expected) in chances.into_iter().zip([0.4, 0.5, 0.1]) {
            assert!((chance - expected).abs() < 1e-15); // rounding
        }
        // Many are off by the mean absolute deviation of a normal variable.
        let error = error_if_calibrated(&[&vec![stated(0.55); 400]]);
        let normal = (2.0 / std::f64::consts::PI * 0.55 * 0.45 / 400.0).sqrt();
        assert!((error / normal - 1.0).abs() < 0.01, "{error} {normal}");
    }

    #[test]
    fn none_counts_where_its_probability_is_stated() {
        let mut none = Answer::none();
        assert_eq!(stated(&world("a", Kind::Null, &[], none.clone())).len(), 0);
        none.candidates.push(CandidateEffect {
            effect: "none".to_owned(),
            gain_nats: 0.0,
            probability: 0.8,
            not_named: None,
        });
        let of_null = stated(&world("a", Kind::Null, &[], none.clone()));
        assert!(of_null[0].came_true && of_null[0].probability == 0.8);
        assert!(!stated(&world("a", Kind::Single, &["dawn"], none))[0].came_true);
        assert_eq!(stated(&world("a", Kind::Null, &[], answer(&["dawn", "alcohol"]))).len(), 2);
    }

    #[test]
    fn ends_of_the_scale_have_bins() {
        assert_eq!((bin_of(0.0), bin_of(0.1), bin_of(1.0)), (0, 1, 9));
    }
}
