//! Exercise sessions.

use physiology::Exercise;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, LogNormal};

use super::habits::{Habits, Sport};
use super::hours::Hours;
use super::sleep::Night;
use crate::calendar::Calendar;
use crate::stream::standard_normal;

/// One session at constant intensity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Session {
    /// First step.
    pub start: usize,
    /// Number of steps.
    pub steps: usize,
    /// Kind of exercise.
    pub sport: Sport,
    /// Intensity and active muscle share.
    pub exercise: Exercise,
}

impl Session {
    /// Whether a step lies within the session.
    #[must_use]
    pub fn covers(&self, step: usize) -> bool {
        (self.start..self.start + self.steps).contains(&step)
    }
}

/// Draws the sessions, at most one a day.
///
/// Each day has a session with a seventh of the weekly rate (a little more at weekends). Half of
/// the weekday sessions follow work (17:30, SD 0.8 h), the others are around noon; weekend ones are
/// at 10:30 (SD 1.2 h), after waking. Length log-normal with median 42 min, 20 to 100 min (T1DEXI
/// sessions were about 30 min of structured exercise plus what people added, Riddell et al.,
/// Diabetes Care 2023;46:704). Intensity in % of VO2max: walking 40, cycling 58, running 65 (SD 6;
/// ACSM's moderate to vigorous range). Active muscle share 0.35 to 0.6.
#[must_use]
pub(super) fn sessions(
    habits: &Habits,
    hours: &Hours,
    calendar: &Calendar,
    nights: &[Night],
    rng: &mut (impl Rng + ?Sized),
) -> Vec<Session> {
    let (later, irregular) = (hours.later(calendar), hours.irregularity);
    let length = LogNormal::new(42.0_f64.ln(), 0.35).expect("a positive spread");
    (0..calendar.days())
        .filter_map(|day| {
            let chance = rng.random::<f64>();
            let (clock, after_work) = (standard_normal(rng), rng.random::<bool>());
            let minutes = length.sample(rng).clamp(20.0, 100.0);
            let intensity = standard_normal(rng);
            let share = rng.random_range(0.35..0.6);
            let weekend = calendar.is_weekend(day);
            let weight = if weekend { 1.2 } else { 0.92 };
            if chance >= weight * habits.sessions_per_week / 7.0 {
                return None;
            }
            let hour = match (weekend, after_work) {
                (true, _) => 10.5 + later[day] + irregular * 1.2 * clock,
                (false, true) => 17.5 + later[day] + irregular * 0.8 * clock,
                (false, false) => 12.0 + later[day] + irregular * 0.7 * clock,
            };
            let awake = nights.get(day).map_or(0, |n| n.wake + 6); // half an hour after waking
            let start = calendar.signed_step(day, hour).max(awake);
            let start = usize::try_from(start).ok().filter(|s| *s < calendar.steps())?;
            let mean = match habits.sport {
                Sport::Walking => 40.0,
                Sport::Cycling => 58.0,
                Sport::Running => 65.0,
            };
            let exercise = Exercise {
                vo2max_percent: (mean + 6.0 * intensity).clamp(25.0, 85.0),
                active_muscle_share: share,
            };
            let steps = (minutes / 5.0).round() as usize;
            Some(Session { start, steps, sport: habits.sport, exercise })
        })
        .collect()
}
