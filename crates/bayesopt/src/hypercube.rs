//! Points spread over a box.

use rand::seq::SliceRandom as _;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use crate::range::Range;

/// Points of which each coordinate has one in each equal part of its range (McKay et al. 1979).
#[must_use]
pub fn latin_hypercube(ranges: &[Range], points: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut drawn = vec![Vec::with_capacity(ranges.len()); points];
    for range in ranges {
        let mut parts: Vec<usize> = (0..points).collect();
        parts.shuffle(&mut rng);
        for (point, part) in drawn.iter_mut().zip(parts) {
            let share = (part as f64 + rng.random::<f64>()) / points as f64;
            point.push(range.at(share));
        }
    }
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_coordinate_has_one_point_in_each_part() {
        let ranges = [Range::new(0.0, 10.0), Range::new(-3.0, -1.0)].map(|r| r.expect("rises"));
        let points = latin_hypercube(&ranges, 10, 4);
        for (coordinate, range) in ranges.iter().enumerate() {
            let mut parts: Vec<usize> =
                points.iter().map(|p| (10.0 * range.share(p[coordinate])) as usize).collect();
            parts.sort_unstable();
            assert_eq!(parts, (0..10).collect::<Vec<_>>());
        }
        assert_eq!(points, latin_hypercube(&ranges, 10, 4));
        assert_ne!(points, latin_hypercube(&ranges, 10, 5));
    }
}
