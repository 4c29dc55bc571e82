//! Twins without a network: parameters of the ODE model fitted to a person's training days.
//!
//! What the paper compares its twins with, on the same windows and under the same loss: the
//! [closest](closest()) of a virtual population and the sensitivities that
//! [Bayesian optimisation](search_sensitivities) finds; and what a modeller would set beside them:
//! six factors at their [most probable values](maximum_a_posteriori) under priors, and the
//! [posterior](sample_posterior) around these by a No-U-Turn sampler, with diagnostics.
//!
//! The crate opens no files and prints nothing; randomness comes from explicit seeds, and results do
//! not depend on the number of threads.
//!
//! ```
//! use ode_sim::OdeParameters;
//! use ode_twins::with_sensitivities;
//!
//! let resistant = with_sensitivities([0.5, 0.5, 0.5]);
//! assert_eq!(resistant.s_f1, 0.5 * OdeParameters::nominal().s_f1);
//! ```

mod closest;
mod density;
mod error;
mod fits;
mod posterior;
mod sensitivities;
mod windows;

pub use closest::{Candidate, Closest, closest};
pub use error::OdeTwinError;
pub use fits::{
    FitRecipe, Fitted, OdeFits, PosteriorSummary, fit_person, plant_of, posterior_plants,
};
pub use posterior::{
    ChainDiagnostics, MaximumAPosteriori, Posterior, Sampling, maximum_a_posteriori,
    sample_posterior,
};
pub use sensitivities::{
    FoundSensitivities, SensitivitySearch, search_sensitivities, with_sensitivities,
};
pub use windows::FitWindows;
