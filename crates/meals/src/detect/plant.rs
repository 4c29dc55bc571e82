//! Meals as impulses into the gut of the ODE plant: a matched filter behind a Kalman filter.
//!
//! 1. *What insulin does is known.* The plant (nominal parameters, the person's weight, three
//!    sensitivities scaled by one factor of the person's own) is run along the record with each
//!    reading put in the place of glucose ([`insulin`]). From step to step glucose then follows a
//!    linear system that no meal changes.
//! 2. *What is left is noise.* A Kalman filter ([`filter`]) over the two glucose compartments, the
//!    interstitium, a quick and a slow flux of unknown origin (Ornstein-Uhlenbeck) and the
//!    sensor's error turns readings into innovations, which are white where nothing was eaten.
//! 3. *A meal has a signature.* Carbohydrate eaten at a step, sent through the plant's two gut
//!    compartments and through the filter, gives the course by which innovations shift, in
//!    proportion to the grams ([`signature`]). Least squares on whitened innovations give the
//!    size, and the fall of their sum of squares twice the logarithm of the likelihood ratio.
//! 4. *Meals are taken greedily* ([`search`]): the strongest first, sizes of all fitted anew after
//!    each, none within a pause of another, until none is left above a threshold.
//! 5. *Two numbers are the person's own*, from the first two weeks: the sensitivity, which comes
//!    from the daily insulin and from the readings, meals included; and the scale of all noise, so
//!    that a nat is worth the same behind a quiet sensor and behind a restless one.
//!
//! Nothing is asked of the future that a study does not have when its records are complete: this is
//! for logs that are mended afterwards, not for an alarm.

use physiology::{Grams, STEPS_PER_DAY};

use crate::detect::{Detected, Detection};
use crate::error::{MealError, require};
use crate::signals::Signals;

pub mod filter;
pub mod insulin;
pub mod search;
mod sensitivity;
pub mod signature;
#[cfg(test)]
pub(crate) mod synthetic;

use filter::Innovations;
use insulin::InsulinAction;
use search::{Found, Search};

/// Settings of the detector on the plant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlantSettings {
    /// What the Kalman filter takes for noise.
    pub noise: FilterNoise,
    /// Least logarithm of the likelihood ratio of a meal, nats.
    pub threshold: f64,
    /// By how much a bolus near a step lowers that threshold there, nats: the logarithm of how
    /// much more often people eat about a bolus than at another time.
    pub bolus_bonus: f64,
    /// Least steps between two meals.
    pub pause: usize,
    /// Steps after eating over which a signature is followed.
    pub horizon: usize,
    /// Smallest and largest meal, g.
    pub sizes: (f64, f64),
}

/// What the Kalman filter takes for noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilterNoise {
    /// Standard deviation of the quick flux into Q1, mmol/kg/min, where insulin does nothing.
    pub flux_sd: f64,
    /// Its correlation time, min.
    pub flux_time: f64,
    /// What is added to that standard deviation, as a share of the glucose that insulin moves.
    pub insulin_share: f64,
    /// Standard deviation of the slow flux, mmol/kg/min: what the person's balance is off, and
    /// how it swings over the day.
    pub slow_sd: f64,
    /// Its correlation time, min.
    pub slow_time: f64,
    /// Standard deviation of the noise on Q1 per step, mmol/kg.
    pub glucose_sd: f64,
    /// Time constant between plasma and interstitial glucose, min.
    pub interstitial_lag: f64,
    /// Standard deviation of the sensor's error, an autoregression of order two, mg/dL.
    pub sensor_sd: f64,
    /// Its coefficients on the errors one and two readings before.
    pub sensor_phi: [f64; 2],
    /// Standard deviation of the white part of a reading, mg/dL.
    pub reading_sd: f64,
}

impl PlantSettings {
    /// The settings in use (`docs/decisions/0020-meals-are-detected-on-the-plant.md`).
    #[must_use]
    pub const fn working() -> Self {
        Self {
            noise: FilterNoise::working(),
            threshold: 3.0, // nats: least error of carbohydrate on board, calibration worlds
            bolus_bonus: 1.5, // nats: people eat 4.5 times as often about a bolus; as above
            pause: 12,      // an hour
            horizon: 36,    // three hours: by then most of a meal has appeared
            sizes: (5.0, 200.0), // g: less does not show, more is not eaten at once
        }
    }

    fn validated(&self) -> Result<(), MealError> {
        let n = &self.noise;
        for (name, value) in [
            ("threshold", self.threshold),
            ("flux_time", n.flux_time),
            ("slow_time", n.slow_time),
            ("interstitial_lag", n.interstitial_lag),
            ("reading_sd", n.reading_sd),
            ("smallest meal", self.sizes.0),
            ("largest meal over the smallest", self.sizes.1 - self.sizes.0),
            ("pause", self.pause as f64),
            ("horizon", self.horizon as f64),
        ] {
            require(value.is_finite() && value > 0.0, name, value, "positive and finite")?;
        }
        for (name, value) in [
            ("flux_sd", n.flux_sd),
            ("slow_sd", n.slow_sd),
            ("insulin_share", n.insulin_share),
            ("glucose_sd", n.glucose_sd),
            ("sensor_sd", n.sensor_sd),
            ("bolus_bonus", self.bolus_bonus),
        ] {
            require(value.is_finite() && value >= 0.0, name, value, "finite and not negative")?;
        }
        let [first, second] = n.sensor_phi;
        let stationary = second.abs() < 1.0 && first.abs() < 1.0 - second;
        require(stationary, "sensor_phi", first, "the coefficient of a stationary autoregression")
    }
}

impl FilterNoise {
    /// The settings in use.
    #[must_use]
    pub const fn working() -> Self {
        Self {
            flux_sd: 0.004,                // mmol/kg/min: a quarter of nominal EGP0
            flux_time: 40.0,               // min: as a meal's, or the two could not be told apart
            insulin_share: 0.2,            // absorption and action vary by a fifth from day to day
            slow_sd: 0.001,                // mmol/kg/min: a sixteenth of nominal EGP0
            slow_time: 720.0,              // min: half a day
            glucose_sd: 0.01,              // mmol/kg: 1.1 mg/dL
            interstitial_lag: 8.0,         // min: 6 to 12 in published sensor models
            sensor_sd: 8.0,                // mg/dL (Vettoretti et al., Sensors 2019;19:5320)
            sensor_phi: [1.2204, -0.3308], // per reading (Vettoretti et al. 2019, Dexcom G6)
            reading_sd: 0.3,               // mg/dL: rounding to whole mg/dL gives 0.29
        }
    }
}

/// Days from which a person's sensitivity is found.
const SENSITIVITY_DAYS: usize = 14;
/// Fewest readings from which anything is found: two hours.
const FEWEST_READINGS: usize = 24;

/// Finds the meals of a record.
///
/// # Errors
/// [`MealError::Setting`] for settings that cannot be, [`MealError::Plant`] if the plant fails.
pub fn detect(signals: &Signals<'_>, settings: &PlantSettings) -> Result<Detected, MealError> {
    settings.validated()?;
    let enough = |signals: &Signals<'_>| signals.cgm.iter().flatten().count() >= FEWEST_READINGS;
    if !enough(signals) {
        return Ok(Detected::default());
    }
    let first = signals.first(SENSITIVITY_DAYS * STEPS_PER_DAY);
    let training = if enough(&first) { &first } else { signals };
    let scale = sensitivity::noise_scale(training, settings)?;
    let sensitivity = sensitivity::calibrate(training, settings, scale)?;
    let found = meals_at(signals, settings, sensitivity, scale)?;
    let meals = found.meals.iter().map(|meal| Detection {
        step: meal.step,
        carbs: Some(Grams(meal.grams)),
        evidence: meal.nats,
    });
    Ok(Detected { meals: meals.collect(), sensitivity: Some(sensitivity) })
}

/// The meals of a record in a body of this sensitivity (1 is nominal), read by a sensor and moved
/// by fluxes whose noise is `scale` times the usual one.
fn meals_at(
    signals: &Signals<'_>,
    settings: &PlantSettings,
    sensitivity: f64,
    scale: f64,
) -> Result<Found, MealError> {
    let action = InsulinAction::along(signals, sensitivity)?;
    let innovations = Innovations::of(signals, &action, &settings.noise).with_noise_scaled(scale);
    Ok(Search::new(signals, &action, &innovations, settings).run())
}

#[cfg(test)]
mod tests {
    use cohort::{Channel, Person};

    use super::synthetic::person;
    use super::*;

    fn found(person: &Person) -> Vec<(usize, f64)> {
        let signals = Signals::of(person).expect("values that can be");
        let found = detect(&signals, &PlantSettings::working()).expect("settings that can be");
        found.meals.iter().map(|m| (m.step, m.carbs.map_or(0.0, |g| g.0))).collect()
    }

    /// Two days with three meals, one of them without its bolus.
    fn eating() -> Person {
        person(576, &[(100, 60.0), (250, 45.0), (400, 30.0)], &[(100, 3.0), (250, 2.5)])
    }

    #[test]
    fn meals_of_the_plant_are_found_where_and_as_large_as_they_were() {
        let found = found(&eating());
        assert_eq!(found.len(), 3, "{found:?}");
        for ((step, grams), (eaten_at, eaten)) in
            found.iter().zip([(100, 60.0), (250, 45.0), (400, 30.0)])
        {
            // The sensor of these records is 10 min late where the filter expects 8 and rounds;
            // the sensitivity is only known within 15 %, which a bolus hands on to its meal.
            assert!(step.abs_diff(eaten_at) <= 3, "{found:?}");
            assert!((grams / eaten - 1.0).abs() < 0.35, "{found:?}");
        }
    }

    #[test]
    fn nothing_is_found_where_nothing_was_eaten() {
        assert!(found(&person(576, &[], &[])).is_empty());
        // A bolus alone makes glucose fall; no meal explains a fall.
        assert!(found(&person(576, &[], &[(300, 1.5)])).is_empty());
    }

    #[test]
    fn no_meal_is_claimed_where_nothing_was_read() {
        let mut blind = eating();
        // From half an hour before the second meal to three hours after it.
        blind.record.channel_mut(Channel::Cgm)[244..286].fill(None);
        let found = found(&blind);
        assert!(found.iter().all(|(step, _)| !(241..286).contains(step)), "{found:?}");
        assert_eq!(found.iter().filter(|(step, _)| *step < 241 || *step > 300).count(), 2);
        blind.record.channel_mut(Channel::Cgm).fill(None);
        let signals = Signals::of(&blind).expect("values that can be");
        let none = detect(&signals, &PlantSettings::working()).expect("settings that can be");
        assert_eq!(none, Detected::default());
    }

    #[test]
    fn insulin_that_is_not_recorded_is_not_an_error() {
        let mut without = person(576, &[(100, 60.0)], &[]);
        without.record.channel_mut(Channel::Basal).fill(None);
        without.record.channel_mut(Channel::Bolus).fill(None);
        without.weight = None;
        let found = found(&without);
        assert!(found.iter().any(|(step, _)| step.abs_diff(100) <= 3), "{found:?}");
    }

    #[test]
    fn settings_that_cannot_be_are_named() {
        let working = PlantSettings::working();
        let noise = working.noise;
        let cases = [
            (PlantSettings { threshold: 0.0, ..working }, "threshold"),
            (PlantSettings { bolus_bonus: f64::NAN, ..working }, "bolus_bonus"),
            (PlantSettings { sizes: (20.0, 10.0), ..working }, "largest meal over the smallest"),
            (PlantSettings { horizon: 0, ..working }, "horizon"),
            (
                PlantSettings { noise: FilterNoise { reading_sd: 0.0, ..noise }, ..working },
                "reading_sd",
            ),
            (
                PlantSettings {
                    noise: FilterNoise { sensor_phi: [1.5, -0.3], ..noise },
                    ..working
                },
                "sensor_phi",
            ),
        ];
        let flat = person(30, &[], &[]);
        let signals = Signals::of(&flat).expect("values that can be");
        for (settings, expected) in cases {
            let error = detect(&signals, &settings).expect_err(expected);
            assert!(
                matches!(error, MealError::Setting { name, .. } if name == expected),
                "{error}"
            );
        }
    }
}
