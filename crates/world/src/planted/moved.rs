//! What is recorded, moved in time or removed.

use cohort::{Channel, Record};
use physiology::STEPS_PER_DAY;

/// Moves recorded doses of a channel `earlier` steps back. There they add to what is recorded. A
/// dose stays if its new step lies before the record, or if the channel is not recorded there.
pub(super) fn move_earlier(
    record: &mut Record,
    channel: Channel,
    earlier: impl Fn(usize) -> isize,
) {
    let old = record.channel(channel).to_vec();
    let new = record.channel_mut(channel);
    for (step, dose) in old.iter().enumerate() {
        let Some(dose) = dose.filter(|dose| *dose > 0.0) else { continue };
        let to = step.checked_add_signed(-earlier(step));
        let Some(to) = to.filter(|to| *to != step && matches!(old.get(*to), Some(Some(_)))) else {
            continue;
        };
        new[step] = new[step].map(|left| (left - dose).max(0.0));
        new[to] = new[to].map(|there| there + dose);
    }
}

/// Removes channels that signal a driver, as if they had never been recorded.
///
/// The reverse of planting: the channels no longer show what the body did, so an effect whose
/// evidence came from them must lose it.
pub(super) fn strike(record: &mut Record, channels: &[Channel]) {
    for channel in channels {
        record.channel_mut(*channel).fill(None);
    }
}

/// As [`strike`], by moving the channels by half of the record's whole days, the end to the
/// beginning. Hours of the clock stay, days change, and channels that are moved together stay
/// together.
pub(super) fn move_days(record: &mut Record, channels: &[Channel]) {
    let days = record.len() / STEPS_PER_DAY;
    let whole = days * STEPS_PER_DAY;
    let half = days / 2 * STEPS_PER_DAY;
    for channel in channels {
        record.channel_mut(*channel)[..whole].rotate_right(half);
    }
}
