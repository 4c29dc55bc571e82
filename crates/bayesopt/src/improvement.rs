//! Where an improvement is expected most.

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use statrs::distribution::{Continuous as _, ContinuousCDF as _, Normal};

use crate::error::SearchError;
use crate::gaussian_process::GaussianProcess;
use crate::hypercube::latin_hypercube;
use crate::pattern_search::climb;
use crate::range::Range;

/// Points at which the expected improvement is looked at, for each coordinate.
const LOOKS: usize = 128;
/// Points from which it is raised further.
const CLIMBS: usize = 4;
/// First and last step from there, in sides of the cube.
const STEPS: (f64, f64) = (0.05, 1e-4);

/// The point to evaluate next to find the least value, given the evaluations so far.
///
/// It has the greatest expected improvement less the expected value (Watson and Barnes 1995), which
/// looks less at far corners than the improvement alone where there are many coordinates.
///
/// # Errors
/// [`SearchError::Nothing`] without evaluations, [`SearchError::Evaluation`] for one that is not
/// finite or has another number of coordinates than there are ranges.
pub fn propose(
    tried: &[(Vec<f64>, f64)],
    ranges: &[Range],
    seed: u64,
) -> Result<Vec<f64>, SearchError> {
    if tried.is_empty() {
        return Err(SearchError::Nothing);
    }
    for (index, (point, value)) in tried.iter().enumerate() {
        let finite = value.is_finite() && point.iter().all(|x| x.is_finite());
        if !finite || point.len() != ranges.len() {
            return Err(SearchError::Evaluation {
                index,
                coordinates: point.len(),
                needed: ranges.len(),
                value: *value,
            });
        }
    }
    let points: Vec<Vec<f64>> = tried
        .iter()
        .map(|(point, _)| point.iter().zip(ranges).map(|(x, range)| range.share(*x)).collect())
        .collect();
    let values = standardised(tried.iter().map(|(_, value)| *value).collect());
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let process = GaussianProcess::fitted(&points, &values);
    let found = greatest(&points, &values, seed, |point| {
        let (mean, sd) = process.at(point);
        improvement((mean, sd), least) - mean
    });
    Ok(found.iter().zip(ranges).map(|(share, range)| range.at(*share)).collect())
}

/// Values with mean 0 and standard deviation 1; all 0 where they do not differ.
fn standardised(mut values: Vec<f64>) -> Vec<f64> {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    values.iter_mut().for_each(|value| *value -= mean);
    let sd = (values.iter().map(|value| value * value).sum::<f64>() / count).sqrt();
    if sd > 0.0 {
        values.iter_mut().for_each(|value| *value /= sd);
    }
    values
}

/// By how much a normal value is expected to lie below `least` (Jones et al. 1998, Eq. 15).
fn improvement((mean, sd): (f64, f64), least: f64) -> f64 {
    let below = least - mean;
    if sd <= 0.0 {
        return below.max(0.0);
    }
    let normal = Normal::standard();
    let z = below / sd;
    below * normal.cdf(z) + sd * normal.pdf(z)
}

/// The point of the unit cube with the greatest value: of points all over it and of points near the
/// best so far, the best few are raised further.
fn greatest(
    points: &[Vec<f64>],
    values: &[f64],
    seed: u64,
    value: impl Fn(&[f64]) -> f64,
) -> Vec<f64> {
    let coordinates = points[0].len();
    let cube = vec![Range::unit(); coordinates];
    let mut looked = latin_hypercube(&cube, LOOKS * coordinates, seed);
    let best = (0..points.len()).min_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(1);
    for point in best.map(|index| &points[index]).into_iter().cycle().take(LOOKS) {
        let near = |x: &f64| (x + 0.1 * (rng.random::<f64>() - 0.5)).clamp(0.0, 1.0);
        looked.push(point.iter().map(near).collect());
    }
    let mut found: Vec<(f64, Vec<f64>)> =
        looked.into_iter().map(|point| (value(&point), point)).collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.truncate(CLIMBS);
    for (top, point) in &mut found {
        *top = climb(point, (0.0, 1.0), STEPS, &value);
    }
    found.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)).map_or_else(Vec::new, |(_, point)| point)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_improvement_by_hand() {
        assert_eq!(improvement((1.0, 0.0), 3.0), 2.0);
        assert_eq!(improvement((3.0, 0.0), 1.0), 0.0);
        // At z = 0: sd / sqrt(2 pi).
        let expected = 2.0 / std::f64::consts::TAU.sqrt();
        assert!((improvement((1.0, 2.0), 1.0) - expected).abs() < 1e-12);
    }

    /// Three minima of 0.397887 (Branin 1972).
    fn branin(x: &[f64]) -> f64 {
        use std::f64::consts::PI;
        let (a, b) = (x[0], x[1]);
        let valley = b - 5.1 / (4.0 * PI * PI) * a * a + 5.0 / PI * a - 6.0;
        valley * valley + 10.0 * (1.0 - 1.0 / (8.0 * PI)) * a.cos() + 10.0
    }

    #[test]
    fn branins_minimum_is_found_in_forty_evaluations() {
        let ranges = [Range::new(-5.0, 10.0), Range::new(0.0, 15.0)].map(|r| r.expect("rises"));
        for seed in [1, 2, 3] {
            let mut tried: Vec<(Vec<f64>, f64)> = latin_hypercube(&ranges, 10, seed)
                .into_iter()
                .map(|point| {
                    let value = branin(&point);
                    (point, value)
                })
                .collect();
            let least =
                |tried: &[(Vec<f64>, f64)]| tried.iter().map(|t| t.1).fold(f64::INFINITY, f64::min);
            let explored = least(&tried);
            for number in 0..30 {
                let point = propose(&tried, &ranges, seed + number).expect("a proposal");
                let value = branin(&point);
                tried.push((point, value));
            }
            let found = least(&tried);
            assert!(found < 0.41 && found < explored, "seed {seed}: {found} after {explored}");
        }
    }

    #[test]
    fn what_cannot_be_modelled_is_said() {
        let ranges = [Range::new(0.0, 1.0).expect("rises")];
        assert!(matches!(propose(&[], &ranges, 1), Err(SearchError::Nothing)));
        let wrong = [(vec![0.1], 1.0), (vec![0.2], f64::NAN)];
        let refused = propose(&wrong, &ranges, 1);
        assert!(matches!(refused, Err(SearchError::Evaluation { index: 1, .. })), "{refused:?}");
        assert!(Range::new(1.0, 1.0).is_err() && Range::new(f64::NAN, 1.0).is_err());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn a_proposal_lies_in_its_ranges(
            values in prop::collection::vec(-1e6..1e6f64, 2..12), equal: bool, seed: u64,
        ) {
            let ranges = [Range::new(-2.0, 3.0), Range::new(4.0, 4.5)].map(|r| r.expect("rises"));
            let points = latin_hypercube(&ranges, values.len(), seed);
            let value = |own: f64| if equal { 7.0 } else { own };
            // The first point twice: what is known twice must not break the process.
            let mut tried: Vec<_> =
                points.into_iter().zip(values).map(|(p, v)| (p, value(v))).collect();
            tried.push(tried[0].clone());
            let found = propose(&tried, &ranges, seed).expect("a proposal");
            prop_assert!((-2.0..=3.0).contains(&found[0]) && (4.0..=4.5).contains(&found[1]));
            prop_assert_eq!(propose(&tried, &ranges, seed).expect("a proposal"), found);
        }
    }
}
