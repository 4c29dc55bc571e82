//! What can go wrong in this crate.

use effects::EffectId;
use physiology::SimulationError;

/// Errors of the diagnosis.
///
/// A person who cannot be diagnosed is not an error: she is excluded by name and reason, and the
/// diagnosis says so ([`PersonSummary::excluded`](crate::PersonSummary)).
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GapError {
    /// A setting cannot be.
    #[error("setting {name} is {value}; it must be {requirement}")]
    Setting {
        /// The setting's name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What would be accepted.
        requirement: &'static str,
    },
    /// Two effects of the library have the same name.
    #[error("the library holds two effects named {effect}; give one of them another name")]
    EffectTwice {
        /// Their name.
        effect: EffectId,
    },
    /// Two effects of the library are both what sensor lags show.
    #[error("the likelihoods of sensor lags show {first} and {second}; leave one of them out")]
    TwoLags {
        /// The first.
        first: EffectId,
        /// The second.
        second: EffectId,
    },
    /// The output uses the name of an effect for something else.
    #[error(
        "an effect is named '{effect}'; the names none and unknown, names with a slash and empty ones are taken"
    )]
    EffectName {
        /// Its name.
        effect: EffectId,
    },
    /// Nobody in the cohort can be diagnosed.
    #[error(
        "nobody of {people} can be diagnosed; the first, {person}, is excluded because of {reason}"
    )]
    NobodyLeft {
        /// People in the cohort.
        people: usize,
        /// The first of them.
        person: String,
        /// Why that person is excluded.
        reason: String,
    },
    /// The cohort is empty.
    #[error("the cohort holds no people; import one first")]
    EmptyCohort,
    /// Two people have one record.
    #[error(
        "{one} and {other} have the same readings and are one person; leave one of them out of people.csv and \
         of the records"
    )]
    IdenticalPeople {
        /// The first.
        one: String,
        /// The second.
        other: String,
    },
    /// The list of data in use was made for another cohort.
    #[error(
        "nothing says what is used of {person}; make the list of data in use from the same cohort"
    )]
    Unjudged {
        /// The person.
        person: String,
    },
    /// A recorded value is not a finite number.
    #[error("person {person}, step {step}: {channel} is {value}; leave a missing value empty")]
    Value {
        /// The person.
        person: String,
        /// The step, counted from the first of the person's record.
        step: usize,
        /// The channel.
        channel: &'static str,
        /// The value.
        value: f64,
    },
    /// The filter left the finite numbers.
    #[error(
        "person {person}, step {step}: the filter is not finite; check doses, weight and the noise \
         settings"
    )]
    FilterNotFinite {
        /// The person.
        person: String,
        /// The step, counted from the first of the person's record.
        step: usize,
    },
    /// The linear system of a calibration step has no solution.
    #[error("person {person}: the calibration's normal equations are singular; check the priors")]
    Singular {
        /// The person.
        person: String,
    },
    /// A free run stopped.
    #[error("person {person}, free run from step {start}: {source}")]
    FreeRun {
        /// The person.
        person: String,
        /// The step from which the run started.
        start: usize,
        /// What the simulation said.
        source: SimulationError,
    },
    /// An exact course does not lie along the records of a cohort.
    #[error(
        "the exact course of {effect} has {found} entries where {needed} are needed; give a list a \
         person and an entry a step"
    )]
    Course {
        /// The effect.
        effect: effects::EffectId,
        /// Lists, or entries of one person's list.
        found: usize,
        /// People, or steps of that person's record.
        needed: usize,
    },
    /// The posterior failed.
    #[error("the posterior: {0}")]
    Posterior(String),
    /// The baseline errors could not be resampled.
    #[error(transparent)]
    Statistics(#[from] stats::StatsError),
}

/// Refuses a setting that does not hold what is required of it.
pub(crate) fn require(
    holds: bool,
    name: &'static str,
    value: f64,
    requirement: &'static str,
) -> Result<(), GapError> {
    if holds { Ok(()) } else { Err(GapError::Setting { name, value, requirement }) }
}
