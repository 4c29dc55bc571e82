//! Nights: when a person sleeps, how soundly, and which nights are short.

use physiology::STEPS_PER_HOUR;
use rand::{Rng, RngExt};

use super::habits::Habits;
use super::hours::Hours;
use crate::calendar::Calendar;
use crate::stream::standard_normal;

/// One night, named after the day on which it ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Night {
    /// Day of waking, counted from 0.
    pub day: usize,
    /// Step of falling asleep; negative when that was before the record.
    pub onset: i64,
    /// First step awake.
    pub wake: i64,
    /// Hours slept less than the person's habit; 0 for an ordinary night.
    pub hours_short: f64,
}

impl Night {
    /// Hours between falling asleep and waking.
    #[must_use]
    pub fn hours(&self) -> f64 {
        (self.wake - self.onset) as f64 / STEPS_PER_HOUR as f64
    }
}

/// Draws one night for each day of the calendar, and one more for its last evening.
///
/// Bed and wake times vary by 0.5 h and 0.35 h (SD) times the irregularity of the hours. On free
/// days (the nights to Saturday and Sunday) people go to bed 0.7 h later and rise 1.3 h later
/// (social jetlag of about an hour, Wittmann et al., Chronobiol Int 2006;23:497). A night is short
/// with the person's probability: 2 to 3.5 h later to bed with the same alarm. An evening with
/// alcohol (`late_evenings`, by the day on which it begins) delays bed by 0.8 h (assumed).
#[must_use]
pub(super) fn nights(
    habits: &Habits,
    hours: &Hours,
    calendar: &Calendar,
    late_evenings: &[usize],
    rng: &mut (impl Rng + ?Sized),
) -> Vec<Night> {
    let usual = 24.0 - habits.bed_hour + habits.wake_hour;
    let (later, irregular) = (hours.later(calendar), hours.irregularity);
    (0..=calendar.days())
        .map(|day| {
            let free = calendar.is_weekend(day);
            let (bed_draw, wake_draw) = (standard_normal(rng), standard_normal(rng));
            let short = rng.random::<f64>() < habits.short_night_probability;
            let delay = rng.random_range(2.0..3.5);
            let mut bed = habits.bed_hour - 24.0 + later[day] + irregular * 0.5 * bed_draw;
            let mut wake = habits.wake_hour + later[day] + irregular * 0.35 * wake_draw;
            if free {
                bed += 0.7;
                wake += 1.3;
            }
            if day > 0 && late_evenings.contains(&(day - 1)) {
                bed += 0.8;
            }
            if short {
                bed += delay;
            }
            let wake = wake.max(bed + 3.0); // nobody sleeps less than three hours
            Night {
                day,
                onset: calendar.signed_step(day, bed),
                wake: calendar.signed_step(day, wake),
                hours_short: (usual - (wake - bed)).max(0.0),
            }
        })
        .collect()
}

/// Share of each step asleep, 0 to 1: 0 awake, below 1 where the person lay awake for a while.
///
/// Awakenings are a two-state chain with a mean length of 10 min. It is entered at the rate that
/// gives the habit's sleep efficiency over the night.
#[must_use]
pub(super) fn efficiency(
    habits: &Habits,
    calendar: &Calendar,
    nights: &[Night],
    rng: &mut (impl Rng + ?Sized),
) -> Vec<f64> {
    let leave = 0.5; // per step: awakenings last two steps on average
    let enter = leave * (1.0 - habits.sleep_efficiency) / habits.sleep_efficiency;
    let mut share = vec![0.0; calendar.steps()];
    for night in nights {
        let mut awake = false;
        for step in night.onset..night.wake {
            let switch = rng.random::<f64>();
            let partial = rng.random_range(0.0..0.5);
            awake = if awake { switch >= leave } else { switch < enter };
            if let Some(slot) = usize::try_from(step).ok().and_then(|s| share.get_mut(s)) {
                *slot = if awake { partial } else { 1.0 };
            }
        }
    }
    share
}
