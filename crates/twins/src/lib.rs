//! Digital twins: the residual network of one person, its training and replay, and the ODE baselines

mod cohort_training;
mod error;
mod exclusion;
mod file;
mod fingerprint;
mod gradient;
mod graph;
mod heart_rate;
mod import;
mod inputs;
mod loss;
mod prepared;
mod protocol;
mod residual;
mod start;
mod training;
mod twin;

pub use cohort_training::{BuiltTwin, PersonTwin, TwinRecipe, build_twin, build_twins};
pub use error::TwinError;
pub use exclusion::{Exclusion, Part};
pub use fingerprint::{population_fingerprint, windows_fingerprint};
pub use graph::{ResidualVariables, graph_loss};
pub use heart_rate::HeartRateScaler;
pub use import::published_twin;
pub use inputs::{INPUTS, InputSet, MissingContext, PERSONAL_INPUTS, STATE_INPUTS};
pub use loss::{HIGH, LOW, Penalty, ScaledLoss, TwinLoss};
pub use prepared::PreparedWindow;
pub use protocol::{PersonWindows, Protocol};
pub use residual::{HIDDEN, PARAMETERS, ResidualNetwork};
pub use start::{AtRest, Startable, Starts, WindowStart, settled, window_starts};
pub use training::{
    Epoch, KeptEpoch, Trained, TrainingPlan, batch_gradient, train, window_loss,
};
pub use twin::{Twin, TwinCard};
