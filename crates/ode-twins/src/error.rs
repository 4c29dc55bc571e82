//! What can go wrong in a fit.

/// Why a person's parameters could not be fitted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OdeTwinError {
    /// Windows or starts that cannot be.
    #[error(transparent)]
    Windows(#[from] twins::TwinError),
    /// A fit was asked for without windows.
    #[error("no training windows; a person without any is left out before fits are made")]
    NoWindows,
    /// No candidate could be simulated on all windows.
    #[error("none of {tried} candidates can be simulated on every training window: {last}")]
    NoCandidate {
        /// Candidates tried.
        tried: usize,
        /// Why the last one failed.
        last: String,
    },
    /// The search refuses its range or its evaluations.
    #[error("the search for sensitivities: {0}")]
    Search(bayesopt::SearchError),
    /// The sampler gave up.
    #[error("the sampler, chain {chain}: {reason}")]
    Sampler {
        /// Which chain.
        chain: usize,
        /// Its own words.
        reason: String,
    },
    /// The information matrix of the fit is not positive definite.
    #[error("the fit's information matrix is not positive definite")]
    Information,
    /// A setting that cannot be.
    #[error("{setting} = {value} must be {requirement}")]
    Setting {
        /// The setting.
        setting: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        requirement: &'static str,
    },
    /// A statistic of the chains could not be computed.
    #[error(transparent)]
    Stats(#[from] stats::StatsError),
}
