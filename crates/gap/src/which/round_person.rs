//! One person in one round of naming.

use effects::EffectId;

use super::lag;
use super::random_effects::UnitSums;
use super::statistics::TestStatistics;
use crate::design::EventBank;
use crate::units::PersonUnits;

/// One person in one round: the model with what has been named so far.
pub(super) struct RoundPerson {
    /// Effects that the record cannot show.
    pub(super) untried: Vec<EffectId>,
    pub(super) statistics: TestStatistics,
    pub(super) units: Vec<UnitSums>,
    pub(super) events: Vec<EventBank>,
    /// Likelihoods of sensor lags; `None` once the lag is named.
    pub(super) lags: Option<lag::Likelihoods>,
    /// What natural units show, until something is named.
    pub(super) natural: Option<PersonUnits>,
}
