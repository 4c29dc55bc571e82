//! Plantings in the recorded insulin.

use cohort::{Channel, Record};
use physiology::STEPS_PER_DAY;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

use super::Happenings;
use super::moved::move_earlier;

/// Share that arrives through a failed set, and for how many steps nobody notices: 8 h.
const ARRIVES: f64 = 0.4;
const LASTS: usize = 96;
/// Days of a set where its change is not recorded, and those without a loss.
const WORN: f64 = 3.0;
const GOOD: f64 = 1.0;
/// Least share that arrives, however long a set is worn.
const LEAST_SHARE: f64 = 0.3;
/// Largest delay of a day's insulin in units of `size`.
const MOST: f64 = 2.0;
/// Least bolus that is moved, U: a controller gives micro-boluses and logs them itself.
const LEAST_BOLUS: f64 = 0.5;

/// Raises basal rate and boluses of every step by the inverse of the share that arrives there,
/// above 0.
///
/// The body received what was recorded. A record of `dose / share`, of which `share` arrives, has
/// the same result in the same body.
fn raise(record: &mut Record, share: &[f64]) {
    for channel in [Channel::Basal, Channel::Bolus] {
        for (dose, share) in record.channel_mut(channel).iter_mut().zip(share) {
            *dose = dose.map(|dose| dose / share);
        }
    }
}

/// Infusion sets that fail: each day a failure begins with probability `size`, at any time.
pub(super) fn fail_sets(record: &mut Record, size: f64, rng: &mut ChaCha8Rng) -> Happenings {
    let mut count = 0;
    let mut share = vec![1.0; record.len()];
    for day in 0..record.len() / STEPS_PER_DAY {
        let (fails, step) = (rng.random::<f64>() < size, rng.random_range(0..STEPS_PER_DAY));
        let from = day * STEPS_PER_DAY + step;
        let until = (from + LASTS).min(record.len());
        if fails {
            share[from..until].fill(ARRIVES);
            count += 1;
        }
    }
    raise(record, &share);
    Happenings { count, places: record.len() / LASTS }
}

/// Infusion sets that age: after its first day a set loses a share `size` of the insulin per day.
/// They are changed as recorded, or every three days from a drawn phase.
pub(super) fn age_sets(record: &mut Record, size: f64, rng: &mut ChaCha8Rng) {
    let phase = rng.random_range(0.0..WORN);
    let days = |steps: usize| steps as f64 / STEPS_PER_DAY as f64;
    let mut since: Option<usize> = None;
    let changes = record.set_change().iter().enumerate();
    let share: Vec<f64> = changes
        .map(|(k, change)| {
            if *change == Some(1.0) {
                since = Some(k);
            }
            // Before the first recorded change, and where none is ever recorded, by the phase.
            let age = since.map_or((days(k) + phase) % WORN, |from| days(k - from));
            (1.0 - size * (age - GOOD).max(0.0)).max(LEAST_SHARE)
        })
        .collect();
    raise(record, &share);
}

/// Insulin that is absorbed faster on some days than on others: boluses and the basal profile moved
/// by day.
///
/// Each day's insulin acts `N(0, size)` minutes later than recorded; the record moves the other
/// way. The delay is exact. Real variation of absorption changes a time constant, of which this is
/// the mean delay.
pub(super) fn vary_absorption(record: &mut Record, size: f64, rng: &mut ChaCha8Rng) {
    let days = record.len().div_ceil(STEPS_PER_DAY);
    let earlier: Vec<isize> = (0..days)
        .map(|_| {
            let delay: f64 = StandardNormal.sample(rng);
            (size * delay.clamp(-MOST, MOST) / 5.0).round() as isize
        })
        .collect();
    let old = record.basal().to_vec();
    for (k, rate) in record.channel_mut(Channel::Basal).iter_mut().enumerate() {
        let day = k / STEPS_PER_DAY;
        let last = ((day + 1) * STEPS_PER_DAY).min(old.len()) - 1;
        // Within the day: at its ends the rate continues unchanged.
        let from = k.saturating_add_signed(earlier[day]).clamp(day * STEPS_PER_DAY, last);
        *rate = rate.and(old[from]).or(*rate);
    }
    move_earlier(record, Channel::Bolus, |k| earlier[k / STEPS_PER_DAY]);
}

/// Boluses given later than recorded: moves every other bolus by `size` minutes, rounded to steps,
/// to the earlier.
///
/// This is a habit of logging, not an effect of a plant. A diagnosis may call it unknown, or name
/// insulin's clock.
pub(super) fn delay_boluses(record: &mut Record, size: f64) {
    let steps = (size / 5.0).round() as isize;
    let mut other = false;
    let moved: Vec<bool> = record
        .bolus()
        .iter()
        .map(|dose| {
            let large = dose.is_some_and(|dose| dose >= LEAST_BOLUS);
            other ^= large;
            large && other
        })
        .collect();
    move_earlier(record, Channel::Bolus, |k| if moved[k] { steps } else { 0 });
}
