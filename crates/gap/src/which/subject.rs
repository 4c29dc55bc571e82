//! One person in one round of naming.

use super::by_unit::UnitSums;
use super::lag;
use super::statistics::Person as Statistics;
use crate::design::{Design, EventBank};
use crate::units::PersonUnits;

/// One person in one round: the model with what has been named so far.
pub(super) struct Subject {
    pub(super) design: Design,
    pub(super) statistics: Statistics,
    pub(super) units: Vec<UnitSums>,
    pub(super) events: Vec<EventBank>,
    /// Likelihoods of sensor lags; `None` once the lag is named.
    pub(super) lags: Option<lag::Likelihoods>,
    /// What natural units show, until something is named.
    pub(super) natural: Option<PersonUnits>,
}
