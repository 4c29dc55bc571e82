//! Rescue carbohydrate after a low, taken and not logged.

use crate::card::{Card, Channel, Prior};
use crate::course::{Course, STEP_MINUTES};
use crate::effect::{Effect, Form};
use crate::meals;
use crate::modulation::{Field, Modulation};
use crate::port::Port;

/// Carbohydrate of one rescue at amplitude 1, g.
const GRAMS: f64 = 16.0;
/// Time constant of its absorption, min: glucose tablets and juice, 15 to 20.
const TAU: f64 = 17.0;
/// Body weight that turns grams into flux, kg. Nothing here knows a person's own; the amplitude takes it up.
const WEIGHT: f64 = 75.0;
/// Grams in a mmol of glucose.
const GRAMS_PER_MMOL: f64 = 0.18;
/// Share that reaches the blood (Hovorka et al. 2004, A_G).
const REACHES_BLOOD: f64 = 0.8;
/// Glucose below which people treat, mg/dL.
const LOW: f64 = 70.0;
/// A low that lasts is treated again after so many minutes: the rule says 15, people wait longer.
const AGAIN: f64 = 30.0;
/// A log this close speaks for itself, min.
const LOGGED_WITHIN: f64 = 30.0;
/// Share of a rescue that is too little to go on counting.
const ALL_ARRIVED: f64 = 1e-9;
/// Delays from the crossing that are tried, min.
const DELAYS: [f64; 3] = [0.0, 10.0, 20.0];

/// See the module.
#[derive(Debug, Clone, Copy)]
pub(super) struct UnloggedRescueCarbs;

impl Effect for UnloggedRescueCarbs {
    fn card(&self) -> Card {
        Card {
            name: "unlogged_rescue_carbs",
            port: Port::GlucoseFlux,
            summary: "lows are treated with fast carbohydrate that nobody logged",
            size_at_one: "16 g absorbed with a time constant of 17 min after every low without a log (75 kg)",
            source: "15 to 20 g at each low: American Diabetes Association, Diabetes Care 2024;47:S111; time constant \
                     15 to 20 min of fast carbohydrate: Rashid et al., Comput Chem Eng 2019;130:106565",
            signature: "glucose under-predicted from 10 to 60 minutes after filtered glucose falls below 70 mg/dL",
            channels: &[Channel::Glucose, Channel::Carbs],
            confusable_with: &[
                "counter_regulation",
                "missed_meals",
                "compression_lows",
                "sensor_lag",
            ],
            prior: Prior { median: 1.0, log_sd: 0.5, largest: 4.0 },
        }
    }

    fn form(&self, course: &Course) -> Option<Form> {
        course.glucose.iter().any(|glucose| *glucose < LOW).then_some(Form::Driven)
    }

    fn variants(&self) -> usize {
        DELAYS.len()
    }

    fn modulate(&self, variant: usize, amplitude: f64, course: &Course, into: &mut [Modulation]) {
        let delay = meals::steps(DELAYS[variant % DELAYS.len()]);
        let (reach, again) = (meals::steps(LOGGED_WITHIN), meals::steps(AGAIN));
        let keep = (-STEP_MINUTES / TAU).exp();
        let dose = REACHES_BLOOD * GRAMS / GRAMS_PER_MMOL / WEIGHT;
        // Two compartments in series, exact over a step; what is left in the gut, and the last treatment.
        let (mut first, mut second) = (0.0_f64, 0.0_f64);
        let mut due: Option<usize> = None;
        let mut noticed: Option<usize> = None;
        let mut since_log = usize::MAX;
        for (k, (glucose, modulation)) in course.glucose.iter().zip(into).enumerate() {
            since_log =
                if meals::logged(course, k) > 0.0 { 0 } else { since_log.saturating_add(1) };
            if *glucose < LOW && noticed.is_none_or(|step| k >= step + again) {
                noticed = Some(k);
                due = Some(k + delay);
            }
            if since_log == 0 && noticed.is_some_and(|step| k <= step + delay + reach) {
                // The rescue was logged after all: what was still to come does not.
                (first, second, due) = (0.0, 0.0, None);
            }
            if due == Some(k) {
                due = None;
                if since_log > reach {
                    first += dose;
                }
            }
            let left = first + second;
            if left < ALL_ARRIVED * dose {
                (first, second) = (0.0, 0.0);
                continue;
            }
            second = (second + first * STEP_MINUTES / TAU) * keep;
            first *= keep;
            modulation[Field::Flux] += amplitude * (left - first - second) / STEP_MINUTES;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{LOW as CROSSING, fortnight, modulated};

    #[test]
    fn all_that_is_eaten_arrives_after_the_crossing_and_none_before() {
        let course = fortnight();
        assert!(course.glucose[CROSSING] < LOW && course.glucose[CROSSING - 1] >= LOW);
        for (variant, delay) in DELAYS.into_iter().enumerate() {
            let steps = modulated(&UnloggedRescueCarbs, variant, 1.0, &course);
            let start = CROSSING + meals::steps(delay);
            assert!(steps[start - 1].is_neutral());
            assert!(steps[start][Field::Flux] > 0.0, "variant {variant}");
            let sum: f64 =
                steps[start..start + 100].iter().map(|m| m[Field::Flux] * STEP_MINUTES).sum();
            let grams = sum * GRAMS_PER_MMOL * WEIGHT / REACHES_BLOOD;
            let doses = (grams / GRAMS).round();
            // 500 minutes are 29 time constants.
            assert!(doses >= 1.0 && (grams - doses * GRAMS).abs() < 1e-6, "{grams}");
        }
    }

    #[test]
    fn a_low_with_a_log_nearby_is_not_unlogged() {
        let mut course = fortnight();
        course.carbs[CROSSING - 3] = 15.0;
        let steps = modulated(&UnloggedRescueCarbs, 0, 1.0, &course);
        assert!(steps[CROSSING].is_neutral());
        course.carbs[CROSSING - 3] = 0.0;
        course.carbs[CROSSING + 3] = 15.0;
        let steps = modulated(&UnloggedRescueCarbs, 0, 1.0, &course);
        assert!(steps[CROSSING + 2][Field::Flux] > 0.0, "not yet known");
        assert!(steps[CROSSING + 3].is_neutral(), "now it is");
    }

    #[test]
    fn without_lows_there_is_no_form() {
        let mut course = fortnight();
        course.glucose.fill(120.0);
        assert_eq!(UnloggedRescueCarbs.form(&course), None);
    }
}
