//! What can go wrong in a statistical computation.

/// Why a statistic could not be computed. The caller knows the file and the person; positions here
/// are indices into the slice that was passed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StatsError {
    /// Fewer values than the computation needs.
    #[error("{what}: {n} given, at least {needed} needed")]
    TooFew {
        /// What was counted, e.g. `glucose samples`.
        what: &'static str,
        /// How many were given.
        n: usize,
        /// How many are needed.
        needed: usize,
    },
    /// A glucose value on which the risk function is undefined: not finite, or below 1 mg/dL.
    #[error(
        "glucose sample {index}: {value} mg/dL is not a glucose concentration; pass only the \
         samples that are present, each at least 1 mg/dL"
    )]
    NotAGlucose {
        /// Position in the samples passed.
        index: usize,
        /// The offending value, mg/dL.
        value: f64,
    },
    /// A value that is NaN or infinite.
    #[error("{what} {index}: {value} is not finite")]
    NonFinite {
        /// What the values are, e.g. `simulated`.
        what: &'static str,
        /// Position among them.
        index: usize,
        /// The offending value.
        value: f64,
    },
    /// Two slices that should pair up have different lengths.
    #[error("{left} values cannot be paired with {right}; pass one value a person in both")]
    Unpaired {
        /// Length of the first slice.
        left: usize,
        /// Length of the second slice.
        right: usize,
    },
    /// A setting outside its domain.
    #[error("{name} = {value}: expected {expected}")]
    OutOfDomain {
        /// Name of the setting.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The domain in words.
        expected: &'static str,
    },
    /// A statistic that is NaN or infinite on a resample.
    #[error(
        "statistic {column} is {value} on bootstrap replicate {replicate}; write it as a ratio of \
         totals, or leave it out where few people contribute"
    )]
    UndefinedReplicate {
        /// Which replicate.
        replicate: usize,
        /// Which statistic.
        column: usize,
        /// Its value.
        value: f64,
    },
    /// The statistic returned a different number of values on a resample.
    #[error("bootstrap replicate {replicate}: {found} statistics, {expected} on the full sample")]
    RaggedReplicate {
        /// Which replicate.
        replicate: usize,
        /// How many values it has.
        found: usize,
        /// How many the full sample has.
        expected: usize,
    },
}

/// Checks that there are enough values.
pub(crate) fn at_least(needed: usize, what: &'static str, n: usize) -> Result<(), StatsError> {
    if n < needed { Err(StatsError::TooFew { what, n, needed }) } else { Ok(()) }
}

/// Checks that every value is finite.
pub(crate) fn finite(what: &'static str, values: &[f64]) -> Result<(), StatsError> {
    match values.iter().position(|v| !v.is_finite()) {
        Some(index) => Err(StatsError::NonFinite { what, index, value: values[index] }),
        None => Ok(()),
    }
}

/// Checks that two slices pair up and that there are at least two pairs of finite values.
pub(crate) fn pairs(
    left: (&'static str, &[f64]),
    right: (&'static str, &[f64]),
) -> Result<(), StatsError> {
    if left.1.len() != right.1.len() {
        return Err(StatsError::Unpaired { left: left.1.len(), right: right.1.len() });
    }
    at_least(2, "pairs", left.1.len())?;
    finite(left.0, left.1)?;
    finite(right.0, right.1)
}

/// Checks that a level or a probability lies strictly between 0 and 1.
pub(crate) fn open_unit(name: &'static str, value: f64) -> Result<(), StatsError> {
    domain(value > 0.0 && value < 1.0, name, value, "a number between 0 and 1")
}

/// Refuses a setting that is not inside its domain.
pub(crate) fn domain(
    inside: bool,
    name: &'static str,
    value: f64,
    expected: &'static str,
) -> Result<(), StatsError> {
    if inside { Ok(()) } else { Err(StatsError::OutOfDomain { name, value, expected }) }
}
