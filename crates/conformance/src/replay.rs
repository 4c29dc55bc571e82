//! Re-evaluation of a witness through the network itself, without rounding.
//!
//! The engines reason about slopes; this module knows nothing of slopes or switches. It evaluates
//! the network's formula in exact arithmetic at two points that differ in the tested input only,
//! and a violation is reported only if the output really moves against the property.

use contract::conformance::Direction;
use std::cmp::Ordering;

use crate::exact::Dyadic;
use crate::network::OneHiddenLayer;

/// Two points along the tested input and what the output does between them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Replay {
    /// The tested input at the first point, scaled.
    pub(crate) from: f64,
    /// The tested input at the second point, scaled, above `from`.
    pub(crate) to: f64,
    /// `s (N(to) - N(from))`, rounded down from its exact value; scaled output per minute.
    pub(crate) rise: f64,
    /// Whether the exact rise is above zero: the property is violated between the two points.
    pub(crate) violates: bool,
}

/// Replays the step from `point` to `point` with the input at position `tested` set to `to`.
pub(crate) fn replay(
    network: &OneHiddenLayer,
    point: &[f64],
    tested: usize,
    to: f64,
    direction: Direction,
) -> Replay {
    let rise = exact_rise(network, point, tested, to, direction);
    Replay {
        from: point[tested],
        to,
        rise: rise.round_down(),
        violates: rise.sign() == Ordering::Greater,
    }
}

/// Looks for a second point to the right of `point`, not beyond `limit`, over which the mean slope
/// against the property is at least `slope`; the longest of the steps tried, each half the last.
///
/// `None` if none of 200 steps qualifies, or no number lies between: then `slope` is not attained
/// at `point`, or only over a distance too short to be written down.
pub(crate) fn longest_step(
    network: &OneHiddenLayer,
    point: &[f64],
    tested: usize,
    limit: f64,
    direction: Direction,
    slope: f64,
) -> Option<Replay> {
    let from = point[tested];
    let mut to = limit;
    for _ in 0..200 {
        if to <= from {
            return None;
        }
        let rise = exact_rise(network, point, tested, to, direction);
        let run = Dyadic::new(to).minus(&Dyadic::new(from));
        if rise.minus(&run.times(&Dyadic::new(slope))).sign() != Ordering::Less {
            return Some(replay(network, point, tested, to, direction));
        }
        to = from + (to - from) / 2.0;
    }
    None
}

fn exact_rise(
    network: &OneHiddenLayer,
    point: &[f64],
    tested: usize,
    to: f64,
    direction: Direction,
) -> Dyadic {
    let mut moved = point.to_vec();
    moved[tested] = to;
    let rise = exact_value(network, &moved).minus(&exact_value(network, point));
    rise.times(&Dyadic::new(direction.against()))
}

/// `N(x)` without rounding.
fn exact_value(network: &OneHiddenLayer, point: &[f64]) -> Dyadic {
    (0..network.hidden()).fold(Dyadic::new(network.output_bias()), |sum, j| {
        let a = Dyadic::affine(network.hidden_biases()[j], network.input_weights(j), point);
        match a.sign() {
            Ordering::Greater => sum.plus(&a.times(&Dyadic::new(network.output_weights()[j]))),
            _ => sum,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sees_a_violation_and_its_absence() {
        // y = max(0, a) - 2 max(0, a - 1): up to a = 1, then down.
        let inputs = vec!["a".to_owned()];
        let network =
            OneHiddenLayer::new("y", inputs, vec![1.0, 1.0], vec![0.0, -1.0], vec![1.0, -2.0], 0.0)
                .expect("valid network");
        let up = replay(&network, &[0.0], 0, 1.0, Direction::Decreasing);
        assert_eq!((up.rise, up.violates), (1.0, true));
        let flat = replay(&network, &[0.0], 0, 2.0, Direction::Decreasing);
        assert_eq!((flat.rise, flat.violates), (0.0, false));
        let down = replay(&network, &[0.0], 0, 4.0, Direction::Increasing);
        assert_eq!((down.rise, down.violates), (2.0, true));

        let step = longest_step(&network, &[0.5], 0, 4.5, Direction::Decreasing, 1.0)
            .expect("slope 1 holds up to a = 1");
        // Halvings of 4.0: 2.0, 1.0, 0.5.
        assert_eq!((step.from, step.to, step.rise), (0.5, 1.0, 0.5));
        assert_eq!(longest_step(&network, &[0.5], 0, 4.5, Direction::Decreasing, 1.5), None);
    }
}
