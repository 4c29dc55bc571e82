//! `twins.json`: the twin of every person.

/// `twins.json`: the twin of every person.
#[apply(strict!)]
pub struct TwinsTable {
    /// `twins/1`.
    pub schema: String,
    /// One entry a person, in the order of the cohort.
    pub people: Vec<TwinRow>,
}

/// One person's twin, or why there is none.
#[apply(strict!)]
#[derive(Default)]
pub struct TwinRow {
    /// The person's identifier.
    pub person_id: String,
    /// Complete training windows.
    pub windows_train: usize,
    /// Complete test windows.
    pub windows_test: usize,
    /// Why there is no twin; null where there is one.
    pub excluded: Option<String>,
    /// Training loss before the first epoch: of the population model, of the earlier twin where training went on
    /// from one, or of the fitted rate where doses are scaled.
    pub loss_first: Option<f64>,
    /// Training loss of the kept network.
    pub loss_last: Option<f64>,
    /// Epochs behind the kept network; 0 if none improved on what training began with.
    pub epoch_kept: Option<usize>,
    /// Training steps without a heart rate, read as the training median.
    pub steps_without_heart_rate: Option<usize>,
    /// Training steps without a sleep efficiency, read as awake.
    pub steps_without_sleep: Option<usize>,
    /// Error of the population model on the test windows, mg/dL.
    pub rmse_population: Option<f64>,
    /// Error of the twin on the test windows, mg/dL.
    pub rmse_twin: Option<f64>,
}

impl TwinRow {
    /// The row of a person of whom nothing was used.
    #[must_use]
    pub fn left_out(person_id: String, reason: String) -> Self {
        Self { person_id, excluded: Some(reason), ..Self::default() }
    }
}
