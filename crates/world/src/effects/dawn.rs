//! The dawn phenomenon: endogenous glucose production rises before waking.

use super::rise;

/// Rise of the production at its height, as a share: the insulin need before breakfast exceeds that
/// after midnight by about a fifth (of the order of Perriello et al., Diabetologia 1991;34:21).
const HEIGHT: f64 = 0.22;

/// Factor on endogenous glucose production at an hour of the day for a person who usually wakes
/// at `wake_hour`.
///
/// The rise begins about three hours before waking and ends two hours after it.
#[must_use]
pub(super) fn production_factor(hour: f64, wake_hour: f64, amplitude: f64) -> f64 {
    let onset = rise(hour, wake_hour - 2.5, 0.5);
    let end = 1.0 - rise(hour, wake_hour + 1.6, 0.4);
    1.0 + amplitude * HEIGHT * onset * end
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rise_lies_in_the_morning() {
        let at = |hour| production_factor(hour, 7.0, 1.0) - 1.0;
        assert!(at(6.5) > 0.9 * HEIGHT);
        // The tails of the smooth steps are below a hundredth of the height.
        for hour in [0.0, 1.5, 11.0, 18.0, 23.9] {
            assert!(at(hour) < 0.01 * HEIGHT, "{hour}");
        }
        assert_eq!(production_factor(6.0, 7.0, 0.0), 1.0);
    }
}
