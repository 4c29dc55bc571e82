//! Differences from person to person, day to day, meal to meal and sensor to sensor in everybody,
//! whether an effect acts or not.
//!
//! Each part has a narrow value, as in the embedded cohort, and a wide prior for the worlds of a
//! blind check, in nulls and effects alike. What the people of a world share (a kind of sensor, a
//! way to keep a log, how far bodies differ from their published forms) is drawn by world; the rest
//! is drawn by person about it. `docs/worlds.md` has all ranges in one table.

mod course;
mod daily_pattern;
mod log_habit;
mod meal_pace;
mod rescues;
mod sensor_kind;
mod sites;

pub use course::EverydayLogs;
pub use daily_pattern::DailyPattern;
pub use log_habit::LogHabit;
pub use meal_pace::MealPace;
pub use rescues::Rescues;
pub use sensor_kind::{Noise, SensorKind};
pub use sites::Sites;

use rand::{Rng, RngExt};

use crate::background::Background;
use crate::behaviour::{Habits, Hours};
use crate::effects::Spreads;
use crate::generator::Generator;
use crate::stream::{Concept, WORLD, standard_normal, stream};
use crate::therapy::Pen;
use crate::warp::Warps;

/// The everyday variation of one person.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Everyday {
    /// How the functions of the body differ from published ones.
    pub warps: Warps,
    /// How insulin action, gut and insulin absorption differ from day to day.
    pub spreads: Spreads,
    /// A small pattern by the clock.
    pub pattern: DailyPattern,
    /// How meals differ in speed.
    pub pace: MealPace,
    /// How infusion or injection sites differ.
    pub sites: Sites,
    /// What kind of sensor is worn.
    pub sensor: SensorKind,
    /// How the log is kept.
    pub log: LogHabit,
    /// How lows are treated.
    pub rescues: Rescues,
    /// How regular the hours of the day are.
    pub hours: Hours,
    /// How insulin is injected, for people who inject.
    pub pen: Pen,
}

impl Everyday {
    /// As for the people of the embedded cohort.
    pub const NARROW: Self = Self {
        warps: Warps::NONE,
        spreads: Spreads::NARROW,
        pattern: DailyPattern::NONE,
        pace: MealPace::NONE,
        sites: Sites::ALIKE,
        sensor: SensorKind::PUBLISHED,
        log: LogHabit::EXACT,
        rescues: Rescues::ADVISED,
        hours: Hours::REGULAR,
        pen: Pen::USUAL,
    };

    /// Draws that of person `person` of the world with this seed, for the hand of a generator.
    ///
    /// Warps 10 to 25 % by world. The rest is described at the parts.
    #[must_use]
    pub fn sample(hand: Generator, seed: u64, person: usize) -> Self {
        let mut world = stream(seed, WORLD, Concept::Everyday);
        let mut own = stream(seed, person, Concept::Everyday);
        let size = world.random_range(0.10..0.25);
        Self {
            warps: Warps::sample(size, &mut stream(seed, person, Concept::Warps)),
            spreads: spreads(&mut world, &mut own),
            pattern: DailyPattern::sample(&mut own),
            pace: MealPace::sample(&mut world, &mut own),
            sites: Sites::sample(&mut world, &mut own),
            sensor: SensorKind::sample(hand, &mut world, &mut own),
            log: LogHabit::sample(hand, &mut world, &mut own),
            rescues: Rescues::sample(&mut own),
            hours: Hours::sample(&mut own),
            pen: Pen::sample(&mut own),
        }
    }

    /// Whether nothing varies beyond the embedded cohort's people.
    #[must_use]
    pub fn is_narrow(&self) -> bool {
        *self == Self::NARROW
    }
}

/// Draws the spreads between days: those of the world, and a person's within a quarter of them.
///
/// Insulin action 3 to 20 % between days with a correlation of 0 to 0.8 from one to the next, and 2
/// to 12 % within days over 2 to 12 h. The insulin that closed loops gave varied by 20 to 30 %
/// between days, food included (Ruan et al., Diabetes Care 2016;39:830), and clamps repeated on
/// other days differ by 8 to 25 % (Heinemann, Diabetes Technol Ther 2002;4:673). The gut as a whole
/// 3 to 15 %, insulin absorption 0 to 12 % (same source: 10 to 25 % for all of it; the rest is the
/// effect's).
fn spreads(world: &mut impl Rng, own: &mut impl Rng) -> Spreads {
    let (action, memory) = (world.random_range(0.03..0.20), world.random_range(0.0..0.8));
    let (within, hours) = (world.random_range(0.02..0.12), world.random_range(2.0..12.0));
    let (gut, insulin) = (world.random_range(0.03..0.15), world.random_range(0.0..0.12));
    let mut about = |value: f64| value * (0.25 * standard_normal(own)).clamp(-0.5, 0.5).exp();
    Spreads {
        action_between_days: about(action),
        memory,
        action_within_days: (about(within), hours),
        insulin_time_between_days: Spreads::NARROW.insulin_time_between_days,
        gut_time_between_days: about(gut),
        insulin_time_always: about(insulin),
    }
}

/// Draws how a person counts carbohydrate: a coefficient of variation of 10 to 45 % by world, a
/// person's within a fifth of it. Means of absolute errors of 15 to 30 % and single ones beyond 50
/// % are reported (Brazeau et al., Diabetes Res Clin Pract 2013;99:19; Roversi et al., Diabetes
/// Technol Ther 2020;22:749).
pub(crate) fn background(seed: u64, person: usize) -> Background {
    let shared: f64 = stream(seed, WORLD, Concept::LogHabits).random_range(0.10..0.45);
    let mut own = stream(seed, person, Concept::LogHabits);
    let factor = (0.2 * standard_normal(&mut own)).clamp(-0.4, 0.4).exp();
    Background::Unbiased { cv: (shared * factor).clamp(0.08, 0.5) }
}

/// Widens the habits of person `person` of the world with this seed.
///
/// Late boluses 5 to 50 % and missed ones 0 to 15 % of main meals (Chase et al., Diabetes Care
/// 2006;29:1012; Robinson et al., Diabetes Technol Ther 2021;23:395 have 12 to 27 % missed or
/// late), snacks 0.3 to 2.5 a day, sessions 0.5 to 6 a week, alcohol on 0.1 to 2.5 evenings a week,
/// sets changed every 2 to 4 days, short nights 4 to 25 %, appetite 0.25 to 1.3 times the usual
/// (diets from low to high in carbohydrate). A third of each range is between worlds, the rest
/// between people.
pub(crate) fn habits(narrow: Habits, seed: u64, person: usize) -> Habits {
    let mut world = stream(seed, WORLD, Concept::WideHabits);
    let mut own = stream(seed, person, Concept::WideHabits);
    let mut within = |low: f64, high: f64| {
        let (shared, alone) = (world.random::<f64>(), own.random::<f64>());
        low + (high - low) * (shared / 3.0 + alone * 2.0 / 3.0)
    };
    Habits {
        appetite: narrow.appetite * within(0.25, 1.3),
        late_bolus_probability: within(0.05, 0.50),
        missed_bolus_probability: within(0.0, 0.15),
        snacks_per_day: within(0.3, 2.5),
        sessions_per_week: within(0.5, 6.0),
        alcohol_evenings_per_week: within(0.1, 2.5),
        set_change_days: within(2.0, 4.0),
        short_night_probability: within(0.04, 0.25),
        ..narrow
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_draw_is_its_seed_and_the_people_of_a_world_share_what_they_should() {
        for hand in Generator::ALL {
            let draw = |seed, person| Everyday::sample(hand, seed, person);
            assert_eq!(draw(3, 1), draw(3, 1));
            assert_ne!(draw(3, 1), draw(3, 2));
            assert_eq!(draw(3, 1).sensor.noise, draw(3, 2).sensor.noise);
            assert_eq!(draw(3, 1).spreads.memory, draw(3, 2).spreads.memory);
            assert!(!draw(3, 1).is_narrow() && Everyday::NARROW.is_narrow());
        }
    }

    #[test]
    fn hands_have_weights_of_their_own() {
        use std::collections::BTreeMap;
        let mut seen: BTreeMap<String, [usize; 4]> = BTreeMap::new();
        for (index, hand) in Generator::ALL.into_iter().enumerate() {
            for seed in 0..200 {
                let noise = Everyday::sample(hand, seed, 0).sensor.noise;
                seen.entry(format!("{noise:?}")).or_default()[index] += 1;
            }
        }
        assert!(seen.len() >= 4, "{seen:?}");
        // Each family is absent from some hand and frequent in another.
        for (family, by_hand) in seen {
            assert!(by_hand.contains(&0), "{family}: {by_hand:?}");
            assert!(by_hand.iter().any(|n| *n > 50), "{family}: {by_hand:?}");
        }
    }
}
