//! The people of a diagnosis: their data and their calibration.

/// Something doubtful about a person's data.
#[apply(strict!)]
pub struct DataQualityFinding {
    /// The check's name, e.g. `missing_channel`.
    pub check: String,
    /// The person.
    pub person_id: String,
    /// What was found.
    pub finding: String,
    /// A number that goes with it.
    pub estimate: Option<FindingEstimate>,
}

/// The number of a finding.
#[apply(strict!)]
pub struct FindingEstimate {
    /// The estimate.
    pub value: f64,
    /// Lower end of its interval.
    pub lower: f64,
    /// Upper end of its interval.
    pub upper: f64,
    /// Unit.
    pub unit: String,
}

/// One person of the cohort.
#[apply(strict!)]
pub struct PersonSummary {
    /// The person.
    pub person_id: String,
    /// Whole days of record.
    pub days: usize,
    /// Why the person is excluded; `None` for one who was diagnosed.
    pub excluded: Option<String>,
    /// The person's calibration; `None` for one who is excluded.
    pub calibration: Option<CalibrationSummary>,
}

/// A person's calibration in brief.
#[apply(strict!)]
pub struct CalibrationSummary {
    /// Factors on the population parameters.
    pub factors: Vec<FactorEstimate>,
    /// Whether the iteration met its tolerance.
    pub converged: bool,
    /// Iterations made.
    pub iterations: usize,
    /// Posterior covariance of the factors' logarithms, in their order.
    pub log_covariance: Vec<Vec<f64>>,
    /// How many times the variance of what the record says is what independent steps would make it, at least 1.
    pub dependence: f64,
    /// Standard deviation of the whitened normalised innovations: above 1 where the filter trusts
    /// plant and sensor too much.
    pub innovation_sd: f64,
    /// Coefficients of the autoregression that whitens them.
    pub autoregression: [f64; 2],
    /// Free runs that were scored, over all horizons.
    pub runs: usize,
    /// Readings at an end of the sensor's range (40 or 400 mg/dL), which are not scored as
    /// innovations.
    pub censored_readings: usize,
    /// Steps with a dose that is not on record.
    pub unrecorded_doses: usize,
    /// Body weight used, kg.
    pub weight_kg: f64,
    /// Whether that weight is an assumption.
    pub weight_assumed: bool,
}

/// One calibrated factor.
#[apply(strict!)]
pub struct FactorEstimate {
    /// Which parameter.
    pub factor: String,
    /// The factor on the population value.
    pub value: f64,
    /// Posterior standard deviation of its logarithm.
    pub log_sd: f64,
    /// Whether it ended at the bound of the calibration.
    pub at_bound: bool,
}
