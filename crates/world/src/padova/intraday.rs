//! How insulin action changes within and between the days of a Padova body.
//!
//! The T1D simulator gives each meal of the day its own sensitivity (Visentin et al., J Diabetes
//! Sci Technol 2018;12:273). Here each third of each day has one, drawn independently, so there is
//! no pattern by the clock: such a pattern is an effect, not chance.

use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};
use rand::{Rng, RngExt};

use crate::calendar::Calendar;
use crate::effects::Spreads;
use crate::stream::standard_normal;

/// Spread (log) of the action of a day, and of a third of a day about it. They are assumed so that
/// their sum is that of the other generator.
const BETWEEN_DAYS: f64 = 0.14;
const WITHIN_DAYS: f64 = 0.14;
/// Thirds of a day.
const PARTS: usize = 3;
/// Width of the transition from one part to the next, steps.
const PASSAGE: f64 = 2.0 * STEPS_PER_HOUR as f64;

/// Logarithm of the factor on insulin action, per step.
///
/// The parts of a day change at about 6:00, 14:00 and 22:00, each boundary moved by up to two hours
/// either way.
#[must_use]
pub(crate) fn action_within_days(
    calendar: &Calendar,
    spreads: &Spreads,
    rng: &mut (impl Rng + ?Sized),
) -> Vec<f64> {
    // Relative to those of the embedded cohort's people.
    let narrow = Spreads::NARROW;
    let between = BETWEEN_DAYS * (spreads.action_between_days / narrow.action_between_days);
    let within = WITHIN_DAYS * (spreads.action_within_days.0 / narrow.action_within_days.0);
    let fresh = (1.0 - spreads.memory * spreads.memory).sqrt();
    let mut last: Option<f64> = None;
    let mut ends = Vec::with_capacity(PARTS * (calendar.days() + 1));
    let mut values = Vec::with_capacity(PARTS * (calendar.days() + 1) + 1);
    for day in 0..=calendar.days() {
        let drawn = standard_normal(rng);
        let unit = last.map_or(drawn, |before| spreads.memory * before + fresh * drawn);
        last = Some(unit);
        let of_day = between * unit;
        for part in 0..PARTS {
            let hour = 6.0 + 8.0 * part as f64 + rng.random_range(-2.0..2.0);
            ends.push(day as f64 * STEPS_PER_DAY as f64 + hour * STEPS_PER_HOUR as f64);
            values.push(of_day + within * standard_normal(rng));
        }
    }
    let mut part = 0;
    (0..calendar.steps())
        .map(|step| {
            let at = step as f64;
            while part + 2 < values.len() && at > ends[part] + 0.5 * PASSAGE {
                part += 1;
            }
            let share = ((at - ends[part]) / PASSAGE + 0.5).clamp(0.0, 1.0);
            let smooth = share * share * (3.0 - 2.0 * share);
            values[part] + smooth * (values[part + 1] - values[part])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::{Concept, stream};
    use chrono::NaiveDate;

    #[test]
    fn the_spread_is_the_stated_one_and_the_clock_has_no_part_in_it() {
        let start = NaiveDate::from_ymd_opt(2024, 1, 8).expect("a date");
        let calendar = Calendar::new(start, 400);
        let action = action_within_days(
            &calendar,
            &Spreads::NARROW,
            &mut stream(1, 0, Concept::Variability),
        );
        for hour in [2, 10, 18] {
            let at: Vec<f64> =
                action.iter().skip(12 * hour).step_by(STEPS_PER_DAY).copied().collect();
            let mean = at.iter().sum::<f64>() / 400.0;
            let sd = (at.iter().map(|v| v * v).sum::<f64>() / 400.0).sqrt();
            let expected = BETWEEN_DAYS.hypot(WITHIN_DAYS);
            // 400 independent days: standard errors of 5 % (mean) and 3.5 % (spread), four of them.
            assert!(mean.abs() < 0.2 * expected, "{hour} h: mean {mean}");
            assert!((sd / expected - 1.0).abs() < 0.14, "{hour} h: spread {sd}");
        }
        let largest = action.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
        assert!(largest < 0.06, "{largest}"); // 1.5/24 of a change of at most 0.9
    }
}
