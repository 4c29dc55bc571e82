//! Ageing infusion sets: less of the insulin arrives from the second day on.

use super::prelude::*;

/// What a day more leaves of the bioavailability at amplitude 1, as a factor.
const A_DAY_MORE: f64 = 0.85;
/// Age from which it falls where changes are logged, days.
const FALLS_FROM: [f64; 2] = [1.0, 2.0];
/// Hour at which sets are taken to be changed where nobody says: the middle of the day awake.
const CHANGE_HOUR: f64 = 15.0;
/// Latent cycles that are tried, days, and their phases.
const CYCLES: [(usize, usize); 5] = [(3, 0), (3, 1), (3, 2), (2, 0), (2, 1)];
/// Most days that a set is believed to be worn.
const OLDEST: f64 = 5.0;

/// See the module.
#[derive(Debug, Clone, Copy)]
pub(super) struct SetAgeing;

impl Effect for SetAgeing {
    fn card(&self) -> Card {
        Card {
            id: EffectId::SET_AGEING,
            port: Port::InsulinInput,
            summary: "less and less of the insulin arrives as an infusion set ages",
            size_at_one: "15 % less for every day beyond the first",
            source: "glucose 123 mg/dL on day 2 and 164 on day 5 of a set: Thethi et al., J Diabetes Complications \
                     2010;24:73; change every 2 to 3 days: Heinemann & Krinelke, J Diabetes Sci Technol 2012;6:954",
            signature: "glucose under-predicted more on each day of a set, back to normal after the change",
            channels: &[Channel::SetChange, Channel::Insulin],
            confusable_with: &[
                EffectId::SET_FAILURE,
                EffectId::SENSOR_DRIFT,
                EffectId::SLEEP_LOSS,
                EffectId::INSULIN_ABSORPTION,
            ],
            relations: Relations::USUAL,
            prior: Prior { median: 1.0, log_sd: 0.5, largest: 3.0 },
        }
    }

    fn form(&self, course: &Course) -> Option<Form> {
        (!course.is_empty()).then_some(Form::Driven)
    }

    /// Logged changes take the first two: loss from the second day or from the third. Without a log five
    /// latent cycles are tried.
    fn variants(&self) -> usize {
        FALLS_FROM.len().max(CYCLES.len())
    }

    fn variants_for(&self, course: &Course) -> usize {
        if logged(course) { FALLS_FROM.len() } else { CYCLES.len() }
    }

    fn modulate(&self, variant: usize, amplitude: f64, course: &Course, into: &mut [Modulation]) {
        let worn = if logged(course) {
            beyond(&logged_ages(course), FALLS_FROM[variant % FALLS_FROM.len()])
        } else {
            beyond(&latent_ages(CYCLES[variant % CYCLES.len()], course), FALLS_FROM[0])
        };
        let centred = centre_within_clock_slots(course, &worn);
        for (worn, modulation) in centred.iter().zip(into) {
            modulation[Field::InsulinInput] *= (amplitude * A_DAY_MORE.ln() * worn).exp();
        }
    }
}

/// Whether set changes were logged.
fn logged(course: &Course) -> bool {
    course.set_changed.as_ref().is_some_and(|changed| changed.contains(&true))
}

/// Days beyond the age from which a set fails.
fn beyond(ages: &[Option<f64>], from: f64) -> Vec<Option<f64>> {
    ages.iter().map(|age| age.map(|age| (age.min(OLDEST) - from).max(0.0))).collect()
}

/// Age of the set in each step, days; unknown before the first logged change.
fn logged_ages(course: &Course) -> Vec<Option<f64>> {
    let mut age: Option<f64> = None;
    course
        .set_changed
        .iter()
        .flatten()
        .map(|changed| {
            age = if *changed { Some(0.0) } else { age.map(|days| days + STEP_MINUTES / 1440.0) };
            age
        })
        .collect()
}

/// Age of a set that is changed every so many days at the same hour, days.
fn latent_ages((cycle, phase): (usize, usize), course: &Course) -> Vec<Option<f64>> {
    let steps = course.day.iter().zip(&course.hour);
    let days = steps.map(|(day, hour)| (day + phase) as f64 + (hour - CHANGE_HOUR) / 24.0);
    days.map(|days| Some(days.rem_euclid(cycle as f64))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{DAY, fortnight, looks_only_back, modulated, zero_mean_by_slot};

    #[test]
    fn less_arrives_on_the_third_day_of_a_logged_set_than_on_the_first() {
        let course = fortnight();
        for variant in 0..SetAgeing.variants_for(&course) {
            let steps = modulated(&SetAgeing, variant, 1.0, &course);
            // Changed on day 3 at 15 h: noon of day 4 is its first day, noon of day 6 its third.
            let noon = |day: usize| steps[day * DAY + 144][Field::InsulinInput];
            assert!(noon(6) < noon(4), "variant {variant}");
            zero_mean_by_slot(&course, &steps, Field::InsulinInput);
        }
    }

    #[test]
    fn a_day_more_takes_what_was_published() {
        let course = fortnight();
        let steps = modulated(&SetAgeing, 0, 1.0, &course);
        // 14 h of days 5 and 6 share their slot's mean; the set is a day older on day 6.
        let ratio =
            steps[6 * DAY + 168][Field::InsulinInput] / steps[5 * DAY + 168][Field::InsulinInput];
        assert!((ratio - A_DAY_MORE).abs() < 1e-9, "{ratio}");
    }

    #[test]
    fn without_a_log_cycles_are_tried_and_the_true_one_is_among_them() {
        let with_log = fortnight();
        let without = Course { set_changed: None, ..fortnight() };
        assert_eq!(SetAgeing.variants_for(&without), 5);
        let known = modulated(&SetAgeing, 0, 1.0, &with_log);
        let guessed = modulated(&SetAgeing, 0, 1.0, &without);
        let late = 7 * DAY;
        let ratio = |steps: &[Modulation]| {
            steps[late + DAY][Field::InsulinInput] / steps[late][Field::InsulinInput]
        };
        // The first change is on day 0 at 15 h; before it the log knows nothing, so the means differ a little.
        assert!((ratio(&known) / ratio(&guessed) - 1.0).abs() < 0.02);
    }

    #[test]
    fn the_age_looks_only_back() {
        looks_only_back(logged_ages);
    }
}
