//! `held-out.json`: population networks on days that none was trained on, beside the ODE.

use crate::{Equivalence, Summary};

/// Errors and outcomes of networks on held-out days.
#[apply(strict!)]
pub struct HeldOut {
    /// Names of the groups of windows, in the order of errors by group.
    pub groups: [String; 3],
    /// The scores.
    pub parts: HeldOutParts,
    /// `held_out/1`.
    pub schema: String,
    /// SHA-256 of the data that trained each model; null where the model does not say.
    pub training_data_sha256: Vec<Option<String>>,
    /// What the tests of equivalence take as independent, in words.
    pub unit_of_equivalence: String,
    /// Length of a window, min.
    pub window_minutes: u32,
}

/// Scores over all held-out weeks and over a part of them; one entry a model.
#[apply(strict!)]
pub struct HeldOutParts {
    /// Of every held-out week.
    pub all: Vec<ModelScores>,
    /// Without the weeks that were added for low or high glucose.
    pub combinations: Vec<ModelScores>,
}

/// The scores of one model.
#[apply(strict!)]
pub struct ModelScores {
    /// Its file, with the folder.
    pub model: String,
    /// What is told of it.
    pub told: Told,
}

/// What is told of a model beside the ODE.
#[apply(strict!)]
pub struct Told {
    /// Equivalence over meal weeks; a row an outcome. Weeks share a meal day only where a subset has fewer days than they
    /// need.
    pub equivalence: Vec<Equivalence>,
    /// Error of glucose over the samples of a window, by group.
    pub errors: GroupErrors,
    /// Of windows that start without carbohydrate on its way, so that no start of C1 is needed.
    pub errors_fasting: GroupErrors,
    /// Samples below 1 mg/dL, which count as 1.
    pub samples_below_1_mg_dl: usize,
    /// Outcomes of windows, in the paper's order: those of the ODE, then those of the model.
    pub windows: [(Summary, Summary); 6],
    /// Windows in which glucose left the finite numbers.
    pub windows_broken: usize,
}

/// Error of simulated glucose by group of windows: in range, low, other.
#[apply(strict!)]
#[derive(Copy)]
pub struct GroupErrors {
    /// Root mean square error, mg/dL; null where the group is empty.
    pub rmse_mg_dl: [Option<f64>; 3],
    /// Windows in each group.
    pub windows: [usize; 3],
}
