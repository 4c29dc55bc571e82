//! Numbers with their uncertainty.

/// Mean and standard deviation over two people or more.
#[apply(strict!)]
#[derive(Copy)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Sample standard deviation.
    pub sd: f64,
}

/// Number, mean and standard deviation of values.
#[apply(strict!)]
#[derive(Copy)]
pub struct Summary {
    /// Number of values.
    pub n: usize,
    /// Mean.
    pub mean: f64,
    /// Sample standard deviation; null for a single value.
    pub sd: Option<f64>,
}

/// A number with the ends of its interval.
#[apply(strict!)]
#[derive(Copy)]
pub struct WithInterval {
    /// The estimate.
    pub value: f64,
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}
