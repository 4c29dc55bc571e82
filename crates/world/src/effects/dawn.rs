//! The dawn phenomenon: endogenous glucose production rises before waking.

use super::forms::DawnForm;
use super::{between, rise};

/// Rise of the production at its height, as a share: the insulin need before breakfast exceeds that
/// after midnight by about a fifth (of the order of Perriello et al., Diabetologia 1991;34:21).
const HEIGHT: f64 = 0.22;

/// Factor on endogenous glucose production at an hour of the day for a person who usually wakes
/// at `wake_hour`.
///
/// Typically the rise begins about three hours before waking and ends two hours after it.
#[must_use]
pub(super) fn production_factor(form: DawnForm, hour: f64, wake_hour: f64, amplitude: f64) -> f64 {
    let course = match form {
        DawnForm::AboutWaking => between(hour, (wake_hour - 2.5, 0.5), (wake_hour + 1.6, 0.4)),
        DawnForm::Plateau => between(hour, (3.0, 0.3), (9.0, 0.3)),
        DawnForm::Ramp => {
            let climbed = ((hour - 2.0) / (wake_hour - 2.0).max(1.0)).clamp(0.0, 1.0);
            1.3 * climbed * (1.0 - rise(hour, (wake_hour + 0.8, 0.25)))
        }
        DawnForm::AfterWaking => between(hour, (wake_hour + 0.2, 0.15), (wake_hour + 3.2, 0.3)),
    };
    1.0 + amplitude * HEIGHT * course
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rise_lies_in_the_morning() {
        let at = |hour| production_factor(DawnForm::AboutWaking, hour, 7.0, 1.0) - 1.0;
        assert!(at(6.5) > 0.9 * HEIGHT);
        // The tails of the smooth steps are below a hundredth of the height.
        for hour in [0.0, 1.5, 11.0, 18.0, 23.9] {
            assert!(at(hour) < 0.01 * HEIGHT, "{hour}");
        }
        for form in DawnForm::ALL {
            assert_eq!(production_factor(form, 6.0, 7.0, 0.0), 1.0);
            assert!(production_factor(form, 8.0, 7.5, 1.0) > 1.1, "{form:?}");
            assert!(production_factor(form, 16.0, 7.5, 1.0) < 1.01, "{form:?}");
        }
    }
}
