//! Meals that were eaten and not logged.

use super::prelude::*;

/// Carbohydrate of an event of size 1, g.
const GRAMS: f64 = 25.0;
/// Relative sizes and their weights: 15, 25, 40 and 60 g.
const SIZES: [(f64, f64); 4] = [(0.6, 0.3), (1.0, 0.35), (1.6, 0.25), (2.4, 0.1)];
/// Missed meals a day.
const PER_DAY: f64 = 0.4;
/// No meal is missed so shortly before a log, min: it speaks for itself.
const BEFORE_A_LOG: f64 = 60.0;
/// No meal is missed so soon after a log, min: what comes late of the logged meal cannot be told from another (decision
/// 0043).
const AFTER_A_LOG: f64 = 180.0;
/// Share of a step asleep from which nothing is eaten.
const ASLEEP: f64 = 0.8;

/// See the module.
#[derive(Debug, Clone, Copy)]
pub(super) struct MissedMeals;

impl Effect for MissedMeals {
    fn card(&self) -> Card {
        Card {
            id: EffectId::MISSED_MEALS,
            port: Port::CarbAmount,
            summary: "meals and snacks are eaten that nobody logged",
            size_at_one: "25 g an event (15 to 60 g), 0.4 events a day",
            source: "0.2 to 1 a day: Burdick et al., Pediatrics 2004;113:e221; Samadi et al., Diabetes Technol Ther \
                     2018;20:235 (snacks among unannounced meals)",
            signature: "glucose under-predicted for two to four hours from moments without any log, at changing times \
                        of day",
            channels: &[Channel::Carbs],
            confusable_with: &[
                EffectId::UNLOGGED_RESCUE_CARBS,
                EffectId::CARB_MISCOUNT,
                EffectId::SLOW_MEALS,
                EffectId::SET_FAILURE,
            ],
            relations: Relations::USUAL,
            prior: Prior { median: 1.0, log_sd: 0.3, largest: 2.5 },
        }
    }

    fn form(&self, course: &Course) -> Option<Form> {
        if !meals::any(course) {
            return None;
        }
        let near = meals::near(course, BEFORE_A_LOG, AFTER_A_LOG);
        let asleep = |k| value_at(course.asleep.as_ref(), k).is_some_and(|share| share >= ASLEEP);
        Some(Form::Events(EventShape {
            field: Field::ExtraCarbs,
            profiles: vec![vec![GRAMS]],
            onsets: (0..course.len()).filter(|k| !near[*k] && !asleep(*k)).collect(),
            per_day: PER_DAY,
            sizes: SIZES.to_vec(),
        }))
    }

    fn modulate(&self, _: usize, _: f64, _: &Course, _: &mut [Modulation]) {}
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{DAY, fortnight};

    #[test]
    fn onsets_are_awake_and_away_from_logged_meals() {
        let course = fortnight();
        let Some(Form::Events(events)) = MissedMeals.form(&course) else {
            panic!("the sample logs meals");
        };
        let meals: Vec<usize> = (0..DAY).filter(|k| course.carbs[*k] > 0.0).collect();
        let lunch = meals[1];
        assert!(events.onsets.contains(&(lunch - 13)) && events.onsets.contains(&(lunch + 37)));
        assert!(!events.onsets.contains(&(lunch - 12)) && !events.onsets.contains(&(lunch + 36)));
        assert!(!events.onsets.contains(&(DAY + 24)), "asleep at 02 h");
        assert!(events.profiles[0].iter().all(|grams| *grams > 0.0));
    }

    #[test]
    fn where_nothing_is_ever_logged_no_meal_was_missed() {
        let mut course = fortnight();
        course.carbs.fill(0.0);
        assert_eq!(MissedMeals.form(&course), None);
    }
}
