//! What can go wrong in this crate.

/// Errors in making a world.
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    /// The body's model refused a value or failed; carries the person's index.
    #[error("person {person}: {source}")]
    Body {
        /// Index of the person, counted from 0.
        person: usize,
        /// What the model said.
        source: ode_sim::OdeError,
    },
    /// No drawn body had a basal need within the accepted range.
    #[error(
        "person {person}: none of {draws} drawn bodies needs between {lowest} and {highest} U/h of \
         basal insulin; check the ranges of the parameters"
    )]
    NoBody {
        /// Index of the person, counted from 0.
        person: usize,
        /// Draws made.
        draws: usize,
        /// Lowest accepted basal rate, U/h.
        lowest: f64,
        /// Highest accepted basal rate, U/h.
        highest: f64,
    },
    /// Trials on the drawn body gave settings that no clinic would believe.
    #[error(
        "person {person}: trials on the drawn body give settings beyond the usual; draw another"
    )]
    NoSettings {
        /// Index of the person, counted from 0.
        person: usize,
    },
    /// The simulated record did not make a valid cohort.
    #[error("person {person}: {source}")]
    Record {
        /// Index of the person, counted from 0.
        person: usize,
        /// What the cohort's rules said.
        source: Box<cohort::CohortError>,
    },
}
