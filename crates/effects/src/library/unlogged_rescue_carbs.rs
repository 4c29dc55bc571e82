//! Rescue carbohydrate after a low, taken and not logged.

use super::prelude::*;

/// Carbohydrate of a rescue of size 1, g.
const GRAMS: f64 = 16.0;
/// Relative sizes and their weights: 8, 16 and 32 g.
const SIZES: [(f64, f64); 3] = [(0.5, 0.3), (1.0, 0.45), (2.0, 0.25)];
/// Time constants of absorption that are tried, min: glucose tablets and juice take 15 to 20, biscuits longer.
const TAUS: [f64; 3] = [17.0, 12.0, 28.0];
/// How long its absorption is followed, in time constants.
const FOLLOWED: f64 = 6.0;
/// Body weight that turns grams into flux, kg. Nothing here knows a person's own; the size takes it up.
const WEIGHT: f64 = 75.0;
/// Grams in a mmol of glucose.
const GRAMS_PER_MMOL: f64 = 0.18;
/// Share that reaches the blood (Hovorka et al. 2004, A_G).
const REACHES_BLOOD: f64 = 0.8;
/// Filtered glucose below which people treat, mg/dL: 70 on the meter, or what feels low.
const LOW: f64 = 76.0;
/// How long after it people still treat, min.
const REACTS: f64 = 30.0;
/// A log this close speaks for itself, min.
const LOGGED_WITHIN: f64 = 30.0;
/// Rescues a day that nobody logged.
const PER_DAY: f64 = 0.5;

/// See the module.
#[derive(Debug, Clone, Copy)]
pub(super) struct UnloggedRescueCarbs;

impl Effect for UnloggedRescueCarbs {
    fn card(&self) -> Card {
        Card {
            id: EffectId::UNLOGGED_RESCUE_CARBS,
            port: Port::GlucoseFlux,
            summary: "lows are treated with fast carbohydrate that nobody logged",
            size_at_one: "16 g a rescue (8 to 32 g), absorbed with a time constant of 12 to 28 min; one every other day",
            source: "15 to 20 g at each low: American Diabetes Association, Diabetes Care 2024;47:S111; time constant \
                     15 to 20 min of fast carbohydrate: Rashid et al., Comput Chem Eng 2019;130:106565",
            signature: "glucose under-predicted for an hour, starting at some of the lows without a log",
            channels: &[Channel::Glucose, Channel::Carbs],
            confusable_with: &[
                EffectId::COUNTER_REGULATION,
                EffectId::MISSED_MEALS,
                EffectId::COMPRESSION_LOWS,
                EffectId::SENSOR_LAG,
            ],
            relations: Relations { is_itself: &[Allowance::Defence], ..Relations::USUAL },
            prior: Prior { median: 1.0, log_sd: 0.5, largest: 4.0 },
        }
    }

    fn form(&self, course: &Course) -> Option<Form> {
        EventShape {
            field: Field::Flux,
            profiles: TAUS.map(flux).to_vec(),
            onsets: onsets(course),
            per_day: PER_DAY,
            sizes: SIZES.to_vec(),
        }
        .if_it_starts()
    }

    fn modulate(&self, _: usize, _: f64, _: &Course, _: &mut [Modulation]) {}
}

/// Steps in and shortly after lows with no log nearby.
fn onsets(course: &Course) -> Vec<usize> {
    let reacts = meals::steps(REACTS);
    let near = meals::near(course, LOGGED_WITHIN, LOGGED_WITHIN);
    let mut last_low = None;
    (0..course.len())
        .filter(|k| {
            if course.glucose[*k] < LOW {
                last_low = Some(*k);
            }
            last_low.is_some_and(|low| k - low <= reacts) && !near[*k]
        })
        .collect()
}

/// Glucose that a rescue of size 1 brings to the blood, mmol/kg/min, from two compartments in series.
fn flux(tau: f64) -> Vec<f64> {
    let dose = REACHES_BLOOD * GRAMS / GRAMS_PER_MMOL / WEIGHT;
    let left = |minutes: f64| (1.0 + minutes / tau) * (-minutes / tau).exp();
    (0..meals::steps(FOLLOWED * tau))
        .map(|k| {
            let start = k as f64 * STEP_MINUTES;
            dose * (left(start) - left(start + STEP_MINUTES)) / STEP_MINUTES
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{LOW as CROSSING, fortnight};

    #[test]
    fn all_that_is_eaten_arrives() {
        for tau in TAUS {
            let sum: f64 = flux(tau).iter().map(|value| value * STEP_MINUTES).sum();
            let grams = sum * GRAMS_PER_MMOL * WEIGHT / REACHES_BLOOD;
            // Six time constants: 1.7 % are still in the gut.
            assert!((grams / GRAMS - 1.0).abs() < 0.03, "{tau}: {grams}");
        }
    }

    #[test]
    fn a_rescue_starts_in_a_low_without_a_log() {
        let mut course = fortnight();
        assert!(course.glucose[CROSSING] < LOW);
        let before = onsets(&course);
        assert!(before.contains(&CROSSING) && !before.contains(&(CROSSING - 12)));
        assert!(
            before
                .iter()
                .all(|k| course.glucose[k.saturating_sub(6)..=*k].iter().any(|g| *g < LOW))
        );
        course.carbs[CROSSING + 3] = 15.0;
        assert!(!onsets(&course).contains(&CROSSING));
    }

    #[test]
    fn without_lows_there_is_no_form() {
        let mut course = fortnight();
        course.glucose.fill(120.0);
        assert_eq!(UnloggedRescueCarbs.form(&course), None);
    }
}
