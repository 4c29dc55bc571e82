//! A short night lowers insulin action on the following day.

use super::forms::SleepLossForm;
use crate::behaviour::Night;

/// Loss of action for each hour of sleep missed, as a share: one night of four hours in place of
/// about eight lowers it by 14 to 21 % (Donga et al., Diabetes Care 2010;33:1573).
const LOSS_PER_HOUR: f64 = 0.045;
/// Hours missed beyond which nothing more is lost.
const MOST_HOURS: f64 = 5.0;

/// Factor on the action of insulin in the periphery (not in the liver) on the day after `night`.
///
/// An hour less than usual is within everyday variation and has no effect. `before` are the two
/// nights before, `hours_awake` the time since waking.
#[must_use]
pub(super) fn action_factor(
    form: SleepLossForm,
    night: &Night,
    before: &[Night],
    hours_awake: f64,
    amplitude: f64,
) -> f64 {
    let missed = |night: &Night| {
        if night.hours_short > 1.0 { night.hours_short.min(MOST_HOURS) } else { 0.0 }
    };
    let hours = match form {
        SleepLossForm::NextDay => missed(night),
        SleepLossForm::Threshold if night.hours_short > 2.0 => 3.5,
        SleepLossForm::Threshold => 0.0,
        SleepLossForm::Morning => 2.0 * missed(night) * (-hours_awake.max(0.0) / 6.0).exp(),
        SleepLossForm::Cumulative => {
            let nights = before.iter().chain([night]);
            1.5 * nights.map(missed).sum::<f64>() / 3.0
        }
    };
    (1.0 - amplitude * LOSS_PER_HOUR * hours).max(0.3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_night_of_four_hours_costs_what_was_measured() {
        let night = |hours_short| Night { day: 1, onset: 0, wake: 48, hours_short };
        let action_factor = |night: &Night, amplitude| {
            action_factor(SleepLossForm::NextDay, night, &[], 0.0, amplitude)
        };
        let loss = 1.0 - action_factor(&night(4.0), 1.0);
        assert!((0.14..=0.21).contains(&loss), "{loss}");
        assert_eq!(action_factor(&night(0.8), 1.0), 1.0);
        assert_eq!(action_factor(&night(4.0), 0.0), 1.0);
    }
}
