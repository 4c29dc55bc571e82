//! Alcohol in the evening: the liver makes less glucose through the night and morning.

use std::collections::BTreeMap;

use super::prelude::*;

/// Production at the deepest of an evening of size 1, as a factor less 1.
const LESS: f64 = -0.4;
/// When production has fallen, begins to recover and is back, min after the first drink: 6 to 14 h in all.
const COURSES: [(f64, f64, f64); 3] =
    [(60.0, 480.0, 720.0), (60.0, 300.0, 420.0), (90.0, 600.0, 840.0)];
/// Hours between which people start to drink.
const EVENING: (f64, f64) = (19.0, 24.0);
/// Onsets are tried this far apart, min, before a free day and before a working day. As all onsets are equally
/// likely, this makes the evenings before Saturday and Sunday twice as likely.
const ONSETS_APART: (f64, f64) = (45.0, 90.0);
/// Evenings with alcohol a day.
const PER_DAY: f64 = 0.15;
/// Relative sizes and their weights: production down by 20, 40 and 56 %.
const SIZES: [(f64, f64); 3] = [(0.5, 0.35), (1.0, 0.45), (1.4, 0.2)];

/// See the module.
#[derive(Debug, Clone, Copy)]
pub(super) struct Alcohol;

impl Effect for Alcohol {
    fn card(&self) -> Card {
        Card {
            id: EffectId::ALCOHOL,
            port: Port::Egp,
            summary: "after alcohol in the evening the liver makes less glucose through the night and next morning",
            size_at_one: "production 40 % lower for 7 h and back after 12, on about one evening a week",
            source: "late lows 10 to 12 h after drinking: Turner et al., Diabetes Care 2001;24:1888; gluconeogenesis 45 % \
                     lower: Siler et al., Am J Physiol 1998;275:E897",
            signature: "glucose over-predicted from late evening to late morning on single nights, more before free \
                        days",
            channels: &[Channel::Clock],
            confusable_with: &[EffectId::POST_EXERCISE_SENSITIVITY, EffectId::COMPRESSION_LOWS],
            relations: Relations::USUAL,
            prior: Prior { median: 1.0, log_sd: 0.3, largest: 1.7 },
        }
    }

    fn form(&self, course: &Course) -> Option<Form> {
        EventShape {
            field: Field::Production,
            profiles: COURSES.map(profile).to_vec(),
            onsets: onsets(course),
            per_day: PER_DAY,
            sizes: SIZES.to_vec(),
        }
        .if_it_starts()
    }

    fn modulate(&self, _: usize, _: f64, _: &Course, _: &mut [Modulation]) {}
}

/// What an evening of size 1 does to production.
fn profile(course: (f64, f64, f64)) -> Vec<f64> {
    let minutes = |k: usize| (k as f64 + 0.5) * STEP_MINUTES;
    (0..meals::steps(course.2)).map(|k| LESS * depth(minutes(k), course)).collect()
}

/// Share of the deepest fall so many minutes after the first drink.
fn depth(minutes: f64, (fallen, recovers, back): (f64, f64, f64)) -> f64 {
    (minutes / fallen).min((back - minutes) / (back - recovers)).clamp(0.0, 1.0)
}

/// Evening steps, denser before a Saturday or Sunday.
fn onsets(course: &Course) -> Vec<usize> {
    let free: BTreeMap<&usize, &bool> = course.day.iter().zip(&course.weekend).collect();
    let tomorrow_is_free = |day: usize| free.get(&(day + 1)).is_some_and(|weekend| **weekend);
    let evening = course.hour.iter().zip(&course.day).enumerate();
    evening
        .filter(|(_, (hour, day))| {
            let apart = if tomorrow_is_free(**day) { ONSETS_APART.0 } else { ONSETS_APART.1 };
            let since = ((**hour - EVENING.0) * 60.0 / STEP_MINUTES).round();
            (EVENING.0..EVENING.1).contains(*hour)
                && (since as usize).is_multiple_of(meals::steps(apart))
        })
        .map(|(step, _)| step)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{DAY, fortnight};

    #[test]
    fn production_falls_after_evenings_and_more_often_before_free_days() {
        let course = fortnight();
        let Some(Form::Events(events)) = Alcohol.form(&course) else {
            panic!("there are evenings")
        };
        let on = |day: usize| events.onsets.iter().filter(|k| **k / DAY == day).count();
        // Days 5 and 6 are the weekend: the evenings of days 4 and 5 come before a free day.
        assert_eq!((on(3), on(4), on(5), on(6)), (4, 7, 7, 4));
        assert!(events.onsets.iter().all(|k| course.hour[*k] >= 19.0));
        assert!(events.profiles.iter().flatten().all(|p| (LESS..=0.0).contains(p)));
        assert!((events.profiles[0][50] - LESS).abs() < 1e-12);
        let deepest = LESS * SIZES[2].0 * Alcohol.card().prior.largest;
        assert!(1.0 + deepest > 0.0, "production stays positive");
    }
}
