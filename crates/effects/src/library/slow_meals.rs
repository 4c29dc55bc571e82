//! Slow meals: fat and protein delay the absorption of some dinners for hours.
//!
//! No log tells which dinners are rich in fat and protein. Each is slow with some probability: a hidden event
//! that starts with it.

use super::prelude::*;

/// Time of absorption of a slow dinner at size 1, as a factor.
const SLOWER: f64 = 1.4;
/// For how long absorption is slow, min; the commonest first.
const ABSORBING: [f64; 3] = [360.0, 180.0, 540.0];
/// Relative sizes and their weights.
const SIZES: [(f64, f64); 4] = [(0.5, 0.25), (1.0, 0.35), (2.0, 0.25), (3.5, 0.15)];
/// Hours between which a meal is dinner.
const DINNER: (f64, f64) = (17.0, 23.0);
/// Least carbohydrate of a dinner, g.
const GRAMS: f64 = 15.0;
/// Slow dinners a day.
const PER_DAY: f64 = 0.5;

/// See the module.
#[derive(Debug, Clone, Copy)]
pub(super) struct SlowMeals;

impl Effect for SlowMeals {
    fn card(&self) -> Card {
        Card {
            id: EffectId::SLOW_MEALS,
            port: Port::GutAbsorption,
            summary: "meals rich in fat and protein, dinners above all, are absorbed slowly",
            size_at_one: "every other dinner: time of absorption 1.4 times as long for 3 to 9 h",
            source: "Wolpert et al., Diabetes Care 2013;36:810; Bell et al., Diabetes Care 2015;38:1008; Smart et al., \
                     Diabetes Care 2013;36:3897",
            signature: "glucose over-predicted in the first hour or two after dinner, under-predicted from three \
                        hours into the night",
            channels: &[Channel::Carbs],
            confusable_with: &[
                EffectId::CARB_MISCOUNT,
                EffectId::CIRCADIAN_SENSITIVITY,
                EffectId::MISSED_MEALS,
            ],
            relations: Relations::USUAL,
            prior: Prior { median: 1.0, log_sd: 0.5, largest: 4.0 },
        }
    }

    fn form(&self, course: &Course) -> Option<Form> {
        let grams = meals::so_far(course);
        let is_dinner = |step: &usize| {
            grams[*step] >= GRAMS && (DINNER.0..DINNER.1).contains(&course.hour[*step])
        };
        EventShape {
            field: Field::GutTime,
            profiles: ABSORBING.map(|minutes| vec![SLOWER - 1.0; meals::steps(minutes)]).to_vec(),
            onsets: (0..course.len()).filter(is_dinner).collect(),
            per_day: PER_DAY,
            sizes: SIZES.to_vec(),
        }
        .if_it_starts()
    }

    fn modulate(&self, _: usize, _: f64, _: &Course, _: &mut [Modulation]) {}
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::fortnight;

    #[test]
    fn dinners_may_be_slow_and_breakfasts_not() {
        let course = fortnight();
        let Some(Form::Events(events)) = SlowMeals.form(&course) else {
            panic!("the sample logs dinners");
        };
        let dinner = |step: &usize| (DINNER.0..DINNER.1).contains(&course.hour[*step]);
        assert!(events.onsets.iter().all(|step| course.carbs[*step] > 0.0 && dinner(step)));
        assert!(events.onsets.contains(&(19 * 12)));
        assert_eq!(events.profiles.len(), ABSORBING.len());
        assert!(events.profiles.iter().flatten().all(|slower| *slower == SLOWER - 1.0));
    }

    #[test]
    fn without_logged_dinners_there_is_no_form() {
        let mut course = fortnight();
        for (carbs, hour) in course.carbs.iter_mut().zip(&course.hour) {
            if *hour >= DINNER.0 {
                *carbs = 0.0;
            }
        }
        assert_eq!(SlowMeals.form(&course), None);
    }
}
