//! Insulin that is absorbed faster on some days than on others: recorded insulin moved by day.
//!
//! Each day's insulin acts `N(0, size)` minutes later than recorded; the record moves the other
//! way. The delay is exact. Real variation of absorption changes a time constant, of which this is
//! the mean delay.

use cohort::{Channel, Record};
use physiology::STEPS_PER_DAY;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

use super::meals::move_earlier;

/// Largest delay in units of `size`.
const MOST: f64 = 2.0;

/// Moves boluses and the basal profile of each day.
pub(super) fn plant(record: &mut Record, size: f64, rng: &mut ChaCha8Rng) {
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
