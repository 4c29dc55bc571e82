//! What a person tends to do; the days vary around it.

use rand::{Rng, RngExt};
use serde::Serialize;

use crate::stream::standard_normal;

/// Habits of one person. Hours are clock hours of a weekday.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Habits {
    /// Hour of falling asleep; values above 24 are past midnight.
    pub bed_hour: f64,
    /// Hour of waking.
    pub wake_hour: f64,
    /// Share of the night asleep, 0 to 1.
    pub sleep_efficiency: f64,
    /// Probability that a night is cut short.
    pub short_night_probability: f64,
    /// Scale of all meal sizes, 1 on average.
    pub appetite: f64,
    /// Snacks a day, on average.
    pub snacks_per_day: f64,
    /// Probability that a main meal's bolus is given late.
    pub late_bolus_probability: f64,
    /// Probability that a main meal's bolus is forgotten.
    pub missed_bolus_probability: f64,
    /// Exercise sessions a week, on average.
    pub sessions_per_week: f64,
    /// What the person does for exercise.
    pub sport: Sport,
    /// Evenings with alcohol a week, on average.
    pub alcohol_evenings_per_week: f64,
    /// Longest days of wear of an infusion set, on average; [`InfusionSets`](super::InfusionSets) are changed half a
    /// day earlier on average.
    pub set_change_days: f64,
    /// Heart rate at rest and awake, 1/min.
    pub resting_heart_rate: f64,
    /// Highest heart rate, 1/min.
    pub maximal_heart_rate: f64,
    /// Steps in an ordinary hour awake without exercise.
    pub steps_per_waking_hour: f64,
}

/// Kind of endurance exercise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Sport {
    /// Brisk walking.
    Walking,
    /// Running.
    Running,
    /// Cycling: exercise without steps.
    Cycling,
}

impl Habits {
    /// Draws the habits of one person.
    ///
    /// Bed and wake times: about 23:00 to 7:00, spread 0.6 h, sleep efficiency 0.90 (SD 0.03;
    /// adults, Ohayon et al., Sleep 2004;27:1255). Missed boluses 2 to 10 % and late ones 12 to 32
    /// % of main meals: youths with a raised HbA1c miss 4 to 5 a week (Chase et al., Diabetes Care
    /// 2006;29:1012), and these people are better kept adults. Sessions: 3 to 4 a week, as asked of
    /// the T1DEXI cohort (Riddell et al., Diabetes Care 2023;46:704). Sets are worn for
    /// about 3 days at most, the labelled wear time. Highest heart rate 208 - 0.7 age (Tanaka et al., J Am Coll
    /// Cardiol 2001;37:153) with ages uniform from 22 to 60. Walking 450 steps a waking hour gives
    /// about 7,000 a day (Tudor-Locke et al., Int J Behav Nutr Phys Act 2011;8:79). The spread
    /// between people of appetite, snacks and alcohol is assumed.
    #[must_use]
    pub fn sample(rng: &mut (impl Rng + ?Sized)) -> Self {
        let age: f64 = rng.random_range(22.0..60.0);
        let wake_hour = 6.9 + 0.5 * standard_normal(rng);
        Self {
            wake_hour,
            bed_hour: wake_hour + 16.2 + 0.4 * standard_normal(rng),
            sleep_efficiency: (0.90 + 0.03 * standard_normal(rng)).clamp(0.80, 0.97),
            short_night_probability: rng.random_range(0.08..0.16),
            appetite: (0.15 * standard_normal(rng)).clamp(-0.3, 0.3).exp(),
            snacks_per_day: rng.random_range(0.6..1.6),
            late_bolus_probability: rng.random_range(0.12..0.32),
            missed_bolus_probability: rng.random_range(0.02..0.10),
            sessions_per_week: rng.random_range(3.0..4.0),
            sport: match rng.random_range(0..3_u8) {
                0 => Sport::Walking,
                1 => Sport::Running,
                _ => Sport::Cycling,
            },
            alcohol_evenings_per_week: rng.random_range(0.2..1.5),
            set_change_days: rng.random_range(2.7..3.3),
            resting_heart_rate: (64.0 + 6.0 * standard_normal(rng)).clamp(50.0, 80.0),
            maximal_heart_rate: 208.0 - 0.7 * age,
            steps_per_waking_hour: 450.0 * (0.25 * standard_normal(rng)).clamp(-0.5, 0.5).exp(),
        }
    }
}
