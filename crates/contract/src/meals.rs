//! `meals.json`: logs of carbohydrate reconciled with the meals that sensors show.

use std::collections::BTreeMap;

/// What became of every meal of a cohort.
#[apply(strict!)]
pub struct Meals {
    /// `meals/1`.
    pub schema: String,
    /// The detector.
    pub detector: String,
    /// How a log and detections become one log.
    pub rule: Rule,
    /// Time within which two events belong together, min.
    pub window_min: f64,
    /// Smallest bolus that counts as one, U.
    pub smallest_bolus_u: f64,
    /// Events by fate, of everybody.
    pub fates: BTreeMap<String, usize>,
    /// One entry a person, in the order of the cohort.
    pub people: Vec<PersonMeals>,
    /// Every event, by person, then by time and kind.
    pub events: Vec<MealEvent>,
}

/// One person's meals.
#[apply(strict!)]
pub struct PersonMeals {
    /// The person's identifier.
    pub person_id: String,
    /// Whether the plant had to take the population's mean weight.
    pub weight_assumed: bool,
    /// Insulin sensitivity over the nominal one.
    pub sensitivity: Option<f64>,
    /// By what estimated sizes were multiplied before they were added.
    pub size_scale: f64,
    /// Logged carbohydrate before, g.
    pub carbs_before_g: f64,
    /// Logged carbohydrate after, g.
    pub carbs_after_g: f64,
    /// Events by fate.
    pub fates: BTreeMap<String, usize>,
}

/// One event and what became of it.
#[apply(strict!)]
pub struct MealEvent {
    /// The person's identifier.
    pub person_id: String,
    /// Start of the event's step, local wall clock, `YYYY-MM-DDTHH:MM:SS`.
    pub time: String,
    /// What it is.
    pub kind: EventKind,
    /// g of carbohydrate or U of insulin; null for a detection without a size.
    pub size: Option<f64>,
    /// Strength of a detection's evidence, nats or standard deviations; null for other events.
    pub evidence: Option<f64>,
    /// What became of it.
    pub fate: Fate,
    /// Time of the event that decided its fate, as `time`.
    pub partner: Option<String>,
}

/// How a log and detections become one log.
#[apply(word!)]
pub enum Rule {
    /// The paper's three passes.
    Published,
    /// Every report stays; detections far from any report are added.
    Additive,
}

/// What kind of event a row is about.
#[apply(word!)]
#[derive(PartialOrd, Ord)]
pub enum EventKind {
    /// A meal that the detector claims; its size is in g.
    Detection,
    /// Carbohydrate that was logged; its size is in g.
    Report,
    /// A bolus; its size is in U.
    Bolus,
}

named::named_in_json! {
    /// What became of an event.
    #[derive(serde::Serialize, serde::Deserialize)]
    #[cfg_attr(test, derive(schemars::JsonSchema))]
    Fate {
        /// A detection is a meal at the time of its partner, a bolus.
        MealAtBolus: "meal_at_bolus",
        /// A detection is a meal of the size of its partner, a report.
        MealOfReportedSize: "meal_of_reported_size",
        /// A detection is a meal by itself ([`Rule::Additive`] only).
        MealAdded: "meal_added",
        /// A detection tells what its partner, a report, tells ([`Rule::Additive`] only).
        AlreadyReported: "already_reported",
        /// A detection that neither bolus nor report supports is discarded.
        UnsupportedDetection: "unsupported_detection",
        /// A detection by a bolus is discarded because nobody knows its size.
        UnknownSize: "unknown_size",
        /// A report is replaced by the meal of its partner, a detection.
        ReplacedByDetection: "replaced_by_detection",
        /// A report is moved to the time of its partner, a detection.
        MovedToDetection: "moved_to_detection",
        /// A report stays, supported by its partner, a bolus.
        KeptWithBolus: "kept_with_bolus",
        /// A report stays ([`Rule::Additive`] only).
        KeptAsLogged: "kept_as_logged",
        /// A report that neither detection nor bolus supports is discarded.
        UnsupportedReport: "unsupported_report",
        /// A bolus tells when its partner, a detection, was eaten.
        GivesTime: "gives_time",
        /// A bolus supports its partner, a report.
        SupportsReport: "supports_report",
        /// A bolus without a meal, such as a correction.
        NoMeal: "no_meal",
    }
}

/// How well meals agree. Shares are from 0 to 1; null is a share of nothing.
#[apply(strict!)]
pub struct Score {
    /// Claimed meals.
    pub claimed: usize,
    /// By size of the eaten meal.
    pub classes: Vec<ClassScore>,
    /// Days of all people.
    pub days: f64,
    /// Meals that were eaten.
    pub eaten: usize,
    /// Share of the eaten carbohydrate that is claimed at its time: the smaller of both sizes, summed over the
    /// meals that belong together.
    pub explained: Option<f64>,
    /// Claimed meals that were not eaten, a day.
    pub false_per_day: Option<f64>,
    /// Claimed carbohydrate that was not eaten, as a share of what was.
    pub invented: Option<f64>,
    /// Eaten and claimed meals that belong together.
    pub matched: usize,
    /// Mean absolute difference between the carbohydrate on board that the claims and that the truth bring
    /// about, g: one number for time, size, what is missing and what is invented.
    pub on_board_error_g: Option<f64>,
    /// Share of claimed meals that were eaten.
    pub precision: Option<f64>,
    /// Share of eaten meals that are claimed.
    pub sensitivity: Option<f64>,
    /// How much, of those that belong together and whose size is claimed.
    pub size: Option<SizeError>,
    /// When, of those that belong together.
    pub time: Option<TimeError>,
}

/// Sensitivity for meals of one class of size.
#[apply(strict!)]
#[derive(Copy)]
pub struct ClassScore {
    /// Meals that were eaten.
    pub eaten: usize,
    /// Least size, g; the class ends where the next begins.
    pub from_g: f64,
    /// Share of them that are claimed.
    pub sensitivity: Option<f64>,
}

/// Errors of time, min; positive is late.
#[apply(strict!)]
#[derive(Copy)]
pub struct TimeError {
    /// Share of meals that are claimed too late.
    pub late: f64,
    /// Lower quartile, min.
    pub lower_quartile: f64,
    /// Median, min.
    pub median: f64,
    /// Median of the absolute errors, min.
    pub median_absolute: f64,
    /// Upper quartile, min.
    pub upper_quartile: f64,
}

/// Errors of size; positive is too large.
#[apply(strict!)]
#[derive(Copy)]
pub struct SizeError {
    /// Mean error, g.
    pub bias_g: f64,
    /// Mean absolute error, g.
    pub mean_absolute_g: f64,
    /// Mean absolute error as a percentage of the mean size eaten.
    pub mean_absolute_percent: f64,
    /// Meals with a size.
    pub meals: usize,
}
