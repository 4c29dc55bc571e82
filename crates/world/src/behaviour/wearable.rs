//! Heart rate and step counts, as a wearable reports them.

use physiology::STEPS_PER_DAY;
use rand::{Rng, RngExt};

use super::exercise::Session;
use super::habits::{Habits, Sport};
use crate::calendar::Calendar;
use crate::stream::standard_normal;

/// Channels of the wearable, one value a step; `None` while it is not worn.
#[derive(Debug, Clone, PartialEq)]
pub struct Wearable {
    /// Mean heart rate over the step, 1/min.
    pub heart_rate: Vec<Option<f64>>,
    /// Steps counted over the step.
    pub steps: Vec<Option<f64>>,
}

/// Draws both channels from one course of activity.
///
/// At rest the heart rate has a day-night rhythm of 5/min, is 2/min above the resting value on
/// average (lowest near 4:00) and 5/min lower asleep (Degaute et al., Hypertension 1991;18:199, of
/// the order of). Everyday activity comes in bouts and raises it by up to 25/min. In exercise the
/// share of the heart-rate reserve equals that of VO2max (Swain and Leutholtz, Med Sci Sports Exerc
/// 1997;29:410), reached with a time constant of a step; recovery takes about 15 min. Cadence
/// 110/min for walking and 160/min for running (Tudor-Locke et al., Int J Behav Nutr Phys Act
/// 2011;8:79). Noise is autoregressive. The device is off for about an hour on two days in three
/// and for one whole night in fifteen (assumed).
#[must_use]
pub(super) fn wearable(
    habits: &Habits,
    calendar: &Calendar,
    asleep: &[f64],
    sessions: &[Session],
    rng: &mut (impl Rng + ?Sized),
) -> Wearable {
    let worn = worn(calendar, rng);
    let reserve = habits.maximal_heart_rate - habits.resting_heart_rate;
    let mut heart_rate = Vec::with_capacity(calendar.steps());
    let mut steps = Vec::with_capacity(calendar.steps());
    let (mut bout, mut effort, mut noise) = (0.0_f64, 0.0_f64, 0.0_f64);
    for step in 0..calendar.steps() {
        let (chance, size) = (rng.random::<f64>(), rng.random::<f64>());
        let (jitter, cadence_draw) = (standard_normal(rng), standard_normal(rng));
        let awake = 1.0 - asleep.get(step).copied().unwrap_or(0.0);
        let session = sessions.iter().find(|s| s.covers(step));

        // Everyday bouts begin once in 40 min and last 15 min on average.
        bout = match (awake < 0.5, bout > 0.0) {
            (true, _) => 0.0,
            (false, true) if chance < 1.0 / 3.0 => 0.0,
            (false, false) if chance < 1.0 / 8.0 => 0.2 + 0.8 * size,
            (false, _) => bout,
        };
        let wanted = session.map_or(0.0, |s| s.exercise.vo2max_percent / 100.0);
        let pace = if wanted > effort { 0.6 } else { 0.28 }; // per step: rise, recovery
        effort += pace * (wanted - effort);
        noise = 0.8 * noise + 1.8 * jitter;

        let phase = std::f64::consts::TAU * (calendar.hour(step) - 16.0) / 24.0;
        let rest = habits.resting_heart_rate + 5.0 * (phase.cos() + 0.4) - 5.0 * (1.0 - awake);
        let rate = rest + 25.0 * bout * (1.0 - effort) + effort * reserve + noise;
        let walked = match session.map(|s| s.sport) {
            Some(Sport::Walking) => 5.0 * (110.0 + 5.0 * cadence_draw),
            Some(Sport::Running) => 5.0 * (160.0 + 5.0 * cadence_draw),
            Some(Sport::Cycling) => 0.0,
            None => bout * habits.steps_per_waking_hour * 0.43 * (1.0 + 0.3 * cadence_draw),
        };
        let on = worn.get(step).copied().unwrap_or(true);
        heart_rate.push(on.then(|| rate.clamp(38.0, habits.maximal_heart_rate)));
        steps.push(on.then(|| walked.max(0.0).round()));
    }
    Wearable { heart_rate, steps }
}

/// Whether the device is worn, per step.
fn worn(calendar: &Calendar, rng: &mut (impl Rng + ?Sized)) -> Vec<bool> {
    let mut worn = vec![true; calendar.steps()];
    for day in 0..calendar.days() {
        let (charges, night_off) = (rng.random_bool(2.0 / 3.0), rng.random_bool(1.0 / 15.0));
        let (hour, length) = (rng.random_range(7.0..22.0), rng.random_range(8..18_usize));
        let mut off = |from: usize, steps: usize| {
            worn.iter_mut().skip(from).take(steps).for_each(|w| *w = false);
        };
        if let Some(step) = calendar.step_at(day, hour).filter(|_| charges) {
            off(step, length);
        }
        if night_off {
            off(day * STEPS_PER_DAY, 7 * physiology::STEPS_PER_HOUR);
        }
    }
    worn
}
