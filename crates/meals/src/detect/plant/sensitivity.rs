//! What is a person's own: insulin sensitivity and the scale of the noise, from sensor and insulin.
//!
//! Meals and insulin pull on glucose in opposite directions, so that the same readings come from a
//! sensitive person who eats much and from a resistant one who eats little: without the log,
//! readings tell the sensitivity poorly. Insulin tells it better. Whoever needs half the insulin
//! for their weight answers to it about twice as strongly, which is what clinical rules (1700 over
//! the daily insulin) rest on. The sensitivity is therefore the nominal one times the nominal over
//! the person's daily insulin for each kilogram, give or take 15 %, and the readings decide within
//! that.

use physiology::{STEP, STEPS_PER_DAY, UnitsPerHour};

use crate::detect::plant::filter::Innovations;
use crate::detect::plant::insulin::{InsulinAction, mean};
use crate::detect::plant::{PlantSettings, meals_at};
use crate::error::MealError;
use crate::signals::{ASSUMED_WEIGHT, Signals};

/// Daily insulin of the nominal body of [`ASSUMED_WEIGHT`], U (Resalat et al. 2019).
const NOMINAL_DAILY_INSULIN: f64 = 42.3;
/// Spread of the logarithm of the sensitivity about what daily insulin says (chosen on calibration
/// worlds, decision 0020).
const PRIOR_SD: f64 = 0.15;
/// Logarithms about the centre that are tried.
const TRIED: [f64; 5] = [0.0, -0.15, 0.15, -0.3, 0.3];
/// Range of the centre: no body is further from the nominal one, but a record without its basal
/// insulin may seem so.
const CENTRE: (f64, f64) = (0.3, 3.0);

/// Range of the scale of the noise: sensors differ by less, and a record that was drawn and not
/// measured must not make every wiggle a meal.
const SCALES: (f64, f64) = (0.5, 2.0);

/// The scale of the noise of a record, in a body of the sensitivity that its daily insulin tells.
///
/// # Errors
/// [`MealError::Plant`] if the plant fails.
pub(crate) fn noise_scale(
    signals: &Signals<'_>,
    settings: &PlantSettings,
) -> Result<f64, MealError> {
    let action = InsulinAction::along(signals, from_daily_insulin(signals))?;
    let scale = Innovations::of(signals, &action, &settings.noise).scale();
    Ok(scale.clamp(SCALES.0, SCALES.1))
}

/// The sensitivity over the nominal one under which the readings are most likely, with the meals
/// that are found under it and less the threshold of each.
///
/// # Errors
/// [`MealError::Plant`] if the plant fails.
pub(crate) fn calibrate(
    signals: &Signals<'_>,
    settings: &PlantSettings,
    scale: f64,
) -> Result<f64, MealError> {
    let centre = from_daily_insulin(signals);
    let mut best = (f64::NEG_INFINITY, centre);
    for distance in TRIED {
        let sensitivity = centre * distance.exp();
        let found = meals_at(signals, settings, sensitivity, scale)?;
        let charged = settings.threshold * found.meals.len() as f64;
        let prior = 0.5 * (distance / PRIOR_SD).powi(2);
        let worth = found.log_likelihood - charged - prior;
        if worth > best.0 {
            best = (worth, sensitivity);
        }
    }
    Ok(best.1)
}

/// The sensitivity over the nominal one that the daily insulin tells of; 1 if no basal insulin is
/// recorded, since then the daily insulin is not known.
fn from_daily_insulin(signals: &Signals<'_>) -> f64 {
    let Some(rate) = mean(signals.basal).map(UnitsPerHour) else { return 1.0 };
    let days = signals.cgm.len() as f64 / STEPS_PER_DAY as f64;
    let boluses: f64 = signals.bolus.iter().flatten().sum();
    let daily = rate.during(STEP).0 * STEPS_PER_DAY as f64 + boluses / days;
    let nominal = NOMINAL_DAILY_INSULIN / ASSUMED_WEIGHT.0;
    (nominal / (daily / signals.weight.0)).clamp(CENTRE.0, CENTRE.1)
}

#[cfg(test)]
mod tests {
    use cohort::Channel;

    use super::*;
    use crate::detect::plant::synthetic::{WEIGHT, person};

    #[test]
    fn half_the_insulin_is_twice_the_sensitivity() {
        // 42.3 U a day for 76.3 kg are nominal: 1 U/h and 18.3 U of boluses.
        let mut nominal = person(288, &[], &[]);
        nominal.record.channel_mut(Channel::Basal).fill(Some(1.0));
        nominal.record.channel_mut(Channel::Bolus)[100] = Some(18.3);
        let of = |person: &cohort::Person| {
            from_daily_insulin(&Signals::of(person).expect("values that can be"))
        };
        assert!((of(&nominal) - 1.0).abs() < 1e-9); // rounding of a sum over a day
        let mut half = nominal.clone();
        half.record.channel_mut(Channel::Basal).fill(Some(0.5));
        half.record.channel_mut(Channel::Bolus)[100] = Some(9.15);
        assert!((of(&half) - 2.0).abs() < 1e-9);
        half.weight = Some(physiology::Kilograms(0.5 * WEIGHT.0));
        assert!((of(&half) - 1.0).abs() < 1e-9);
        half.record.channel_mut(Channel::Basal).fill(None);
        assert_eq!(of(&half), 1.0, "half of the daily insulin is not known");
        nominal.record.channel_mut(Channel::Basal).fill(Some(20.0));
        assert_eq!(of(&nominal), CENTRE.0);
    }

    #[test]
    fn readings_move_the_sensitivity_towards_the_truth() {
        // Meals and boluses of a nominal body; a weight that is said too low or too high makes the
        // daily insulin tell another sensitivity.
        let events: Vec<usize> = (0..14).map(|k| 60 + 72 * k).collect();
        let meals: Vec<_> = events.iter().map(|step| (*step, 45.0)).collect();
        let boluses: Vec<_> = events.iter().map(|step| (*step, 3.0)).collect();
        let person = person(4 * 288, &meals, &boluses);
        let signals = Signals::of(&person).expect("values that can be");
        let centre = from_daily_insulin(&signals);
        let settings = PlantSettings::working();
        let found = calibrate(&signals, &settings, 1.0).expect("a plant that runs");
        assert!(found.ln().abs() <= centre.ln().abs() + 1e-12, "{found} {centre}");
        assert!((0.7..1.4).contains(&found), "{found}"); // two steps of the search
    }
}
