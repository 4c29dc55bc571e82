//! Only a share of the recorded insulin arrives: the record is raised so that this share of it is
//! what was given.
//!
//! The body received what was recorded. A record of `dose / share`, of which `share` arrives, has
//! the same result in the same body.

use cohort::{Channel, Record};

/// Raises basal rate and boluses of every step by the inverse of the share that arrives there,
/// above 0.
pub(super) fn raise(record: &mut Record, share: &[f64]) {
    for channel in [Channel::Basal, Channel::Bolus] {
        for (dose, share) in record.channel_mut(channel).iter_mut().zip(share) {
            *dose = dose.map(|dose| dose / share);
        }
    }
}
