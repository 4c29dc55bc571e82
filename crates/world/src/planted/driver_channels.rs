//! Channels that signal a driver, removed or taken from other days.
//!
//! The reverse of planting: the channel no longer shows what the body did, so an effect whose
//! evidence came from it must lose it.

use cohort::{Channel, Record};
use physiology::STEPS_PER_DAY;

/// What signals exercise.
pub(super) const EXERCISE: [Channel; 2] = [Channel::HeartRate, Channel::Steps];
/// What signals sleep.
pub(super) const SLEEP: [Channel; 1] = [Channel::SleepEfficiency];

/// As if the channels had never been recorded.
pub(super) fn strike(record: &mut Record, channels: &[Channel]) {
    for channel in channels {
        record.channel_mut(*channel).fill(None);
    }
}

/// Moves the channels by half of the record's whole days, the end to the beginning. Hours of the
/// clock stay, days change, and channels that are moved together stay together.
pub(super) fn move_days(record: &mut Record, channels: &[Channel]) {
    let days = record.len() / STEPS_PER_DAY;
    let whole = days * STEPS_PER_DAY;
    let half = days / 2 * STEPS_PER_DAY;
    for channel in channels {
        record.channel_mut(*channel)[..whole].rotate_right(half);
    }
}
