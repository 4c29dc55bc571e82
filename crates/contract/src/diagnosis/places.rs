//! Where the gap lies: in situations, through the day and at ports.

/// Evidence that something is missing at a port.
#[apply(strict!)]
pub struct PortEvidence {
    /// The port's name.
    pub port: String,
    /// Held-out evidence, nats.
    pub gain_nats: f64,
    /// Probability among the ports.
    pub probability: f64,
    /// Ports whose changes look alike, or whose evidence is about as good.
    pub confusable_with: Vec<String>,
    /// Unit of the course: `factor` for the change of a factor of 1, else that of the flux, the carbohydrate or the reading.
    pub unit: String,
    /// What the model lacks there through the day, beyond its mean over the day, which calibration takes.
    pub course: Vec<CoursePart>,
}

/// What is lacking at a port in a part of the day.
#[apply(strict!)]
pub struct CoursePart {
    /// `HH-HH`.
    pub hours: String,
    /// Estimate, in the unit of the course.
    pub value: f64,
    /// Lower end of the interval; those of a port hold all parts in 95 of 100.
    pub lower: f64,
    /// Upper end of the interval.
    pub upper: f64,
}

named::named_in_json! {
    /// By what a cell of `where` is set apart.
    #[derive(serde::Serialize, serde::Deserialize)]
    #[cfg_attr(test, derive(schemars::JsonSchema))]
    CellFactor {
        /// Part of the day, `HH-HH`.
        Hour: "hour",
        /// A situation, e.g. `after_meal`.
        Context: "context",
        /// Filtered glucose, mg/dL.
        GlucoseBand: "glucose_band",
        /// One person.
        Person: "person",
        /// Length of the free run, min.
        Horizon: "horizon",
    }
}

/// The gap in one cell.
#[apply(strict!)]
pub struct CellGap {
    /// By what the cell is set apart.
    pub factor: CellFactor,
    /// Which part of it this is.
    pub level: String,
    /// Mean error of free runs, observed minus predicted, mg/dL: positive where the plant
    /// under-predicts glucose. Runs of the horizon in
    /// the settings of the localisation, except for `horizon` cells, which have
    /// their own. The mean over people of each person's mean. Runs start from the filtered
    /// state without its unexplained flux, except for cells that are set apart by glucose (bands,
    /// `after_low`, `fast_change`): the flux goes with glucose, so they keep it.
    pub mean_error_mg_dl: f64,
    /// Lower end of the simultaneous interval.
    pub lower: f64,
    /// Upper end of the simultaneous interval.
    pub upper: f64,
    /// p-value adjusted for every cell and both layers.
    pub p_adjusted: f64,
    /// The cell's share of the gap that the posterior expects of what is missing, as squared sizes of hours,
    /// contexts and glucose bands; 0 for persons and horizons.
    pub share_of_gap: f64,
    /// The mean that the posterior expects of what is missing, mg/dL, in runs of whole days from midnight;
    /// shrunken towards 0, as it is a mean over everything that may be missing. `None` for persons and horizons.
    pub expected_mg_dl: Option<f64>,
    /// Length of the free runs, min.
    pub horizon_minutes: u32,
    /// People who contribute.
    pub people: usize,
    /// Free runs that contribute.
    pub runs: usize,
    /// The other layer: one-step errors of the filter. `None` for persons and horizons.
    pub innovation: Option<InnovationGap>,
}

/// Mean whitened innovation of a cell.
#[apply(strict!)]
#[derive(Copy)]
pub struct InnovationGap {
    /// Mean, in standard deviations of a whitened innovation; positive where the filter
    /// under-predicts.
    pub mean_sd: f64,
    /// Lower end of the simultaneous interval.
    pub lower: f64,
    /// Upper end of the simultaneous interval.
    pub upper: f64,
    /// p-value adjusted for every cell and both layers.
    pub p_adjusted: f64,
}

impl CoursePart {
    /// First hour of the part, and the hour at which it ends; `None` where `hours` is not `HH-HH`.
    #[must_use]
    pub fn ends(&self) -> Option<(u32, u32)> {
        let (from, to) = self.hours.split_once('-')?;
        Some((from.parse().ok()?, to.parse().ok()?))
    }

    /// Whether the interval leaves 0 out.
    #[must_use]
    pub fn is_certain(&self) -> bool {
        self.lower > 0.0 || self.upper < 0.0
    }
}

/// The gap by time of day, crossed with situations and with people.
///
/// It is there to be looked at: the verdict, `where` and their family-wise error rate do not depend on it.
#[apply(strict!)]
pub struct HourlyGap {
    /// Length of the free runs, min.
    pub horizon_minutes: u32,
    /// Parts of the day, `HH-HH`, by the clock halfway through a run.
    pub parts: Vec<String>,
    /// `all`, the cells of `where`, then each situation that anybody was in. Intervals of situations hold for all of them
    /// together in 95 of 100, those of `all` with the rest of `where`.
    pub situations: Vec<HourlyRow>,
    /// Each person who was diagnosed, in the order of the cohort. Intervals hold for all people together in 95 of 100.
    pub people: Vec<HourlyRow>,
}

/// One situation or person through the day.
#[apply(strict!)]
pub struct HourlyRow {
    /// The situation, e.g. `after_meal`, or the person.
    pub name: String,
    /// One entry a part of the day; `None` where too few runs lie in it.
    pub cells: Vec<Option<HourlyCell>>,
}

/// The gap in one part of the day.
#[apply(strict!)]
#[derive(Copy)]
pub struct HourlyCell {
    /// Mean error of free runs, observed minus predicted, mg/dL: positive where the plant under-predicts glucose. The
    /// mean over people of each person's mean.
    pub mean_error_mg_dl: f64,
    /// Lower end of the simultaneous interval.
    pub lower: f64,
    /// Upper end of the simultaneous interval.
    pub upper: f64,
    /// People who contribute.
    pub people: usize,
    /// Free runs that contribute.
    pub runs: usize,
}

impl HourlyCell {
    /// Whether the interval leaves 0 out.
    #[must_use]
    pub fn is_certain(&self) -> bool {
        self.lower > 0.0 || self.upper < 0.0
    }
}
