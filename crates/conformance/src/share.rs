//! How much of a region, or of a simulation, a property fails on.
//!
//! A largest slope says how bad the worst place is; a share says how much of the place is bad.

use contract::conformance::Share;
use rand::Rng;

use crate::error::{ConformanceError, require};
use crate::network::{OneHiddenLayer, check_point};
use crate::property::Property;
use crate::region::Region;
use crate::slope::SlopeSum;

/// The share of the region's volume on which the property fails, from `points` uniform draws over its box.
///
/// # Errors
/// What [`crate::verify()`] refuses about network, property and region; [`ConformanceError::Limit`]
/// for no points.
pub fn share_of_region(
    network: &OneHiddenLayer,
    property: &Property,
    region: &Region,
    points: usize,
    rng: &mut impl Rng,
) -> Result<Share, ConformanceError> {
    let (region, tested) = property.box_in(network, region)?;
    let sum = SlopeSum::new(network, tested, property.direction);
    let (mut failed, mut inside) = (0, 0);
    for _ in 0..points {
        let point = region.drawn(rng);
        if region.contains(&point) {
            inside += 1;
            failed += usize::from(sum.fails_at(&point));
        }
    }
    wilson(failed, inside)
}

/// The share of `points` (scaled, one value per input of the network) at which the property fails.
///
/// The interval treats the points as independent draws; steps of one simulation are not, so read it
/// as the interval of the sampled states, not of people.
///
/// # Errors
/// [`ConformanceError::WrongNetwork`], [`ConformanceError::UnknownInput`],
/// [`ConformanceError::Point`], [`ConformanceError::Limit`] for no points.
pub fn share_of_points<'a>(
    network: &OneHiddenLayer,
    property: &Property,
    points: impl IntoIterator<Item = &'a [f64]>,
) -> Result<Share, ConformanceError> {
    let sum = SlopeSum::new(network, property.tested_in(network)?, property.direction);
    let (mut failed, mut count) = (0, 0);
    for point in points {
        check_point(network.output(), network.inputs().len(), point, count)?;
        failed += usize::from(sum.fails_at(point));
        count += 1;
    }
    wilson(failed, count)
}

/// Wilson's score interval at 95 % (Wilson 1927), which stays inside 0 to 1 at either end.
fn wilson(failed: usize, points: usize) -> Result<Share, ConformanceError> {
    require(points > 0, "points", 0.0, "at least one point is needed")?;
    // 97.5 % quantile of the normal distribution.
    const Z: f64 = 1.959_963_984_540_054;
    let n = points as f64;
    let share = failed as f64 / n;
    let centre = share + Z * Z / (2.0 * n);
    let half = Z * (share * (1.0 - share) / n + Z * Z / (4.0 * n * n)).sqrt();
    let scale = 1.0 + Z * Z / n;
    Ok(Share {
        value: share,
        lower: ((centre - half) / scale).max(0.0).min(share),
        upper: ((centre + half) / scale).min(1.0).max(share),
        points,
    })
}
