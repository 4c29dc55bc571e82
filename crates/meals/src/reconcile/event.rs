//! The events that are reconciled, and what became of each.

use chrono::NaiveDateTime;
use serde::{Serialize, Serializer};

/// What kind of event a row is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// A meal that the detector claims; its size is in g.
    Detection,
    /// Carbohydrate that was logged; its size is in g.
    Report,
    /// A bolus; its size is in U.
    Bolus,
}

/// What became of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fate {
    /// A detection is a meal at the time of its partner, a bolus.
    MealAtBolus,
    /// A detection is a meal of the size of its partner, a report.
    MealOfReportedSize,
    /// A detection is a meal by itself ([`Rule::Additive`](super::Rule::Additive) only).
    MealAdded,
    /// A detection tells what its partner, a report, tells ([`Rule::Additive`](super::Rule::Additive) only).
    AlreadyReported,
    /// A detection that neither bolus nor report supports is discarded.
    UnsupportedDetection,
    /// A detection by a bolus is discarded because nobody knows its size.
    UnknownSize,
    /// A report is replaced by the meal of its partner, a detection.
    ReplacedByDetection,
    /// A report is moved to the time of its partner, a detection.
    MovedToDetection,
    /// A report stays, supported by its partner, a bolus.
    KeptWithBolus,
    /// A report stays ([`Rule::Additive`](super::Rule::Additive) only).
    KeptAsLogged,
    /// A report that neither detection nor bolus supports is discarded.
    UnsupportedReport,
    /// A bolus tells when its partner, a detection, was eaten.
    GivesTime,
    /// A bolus supports its partner, a report.
    SupportsReport,
    /// A bolus without a meal, such as a correction.
    NoMeal,
}

impl Fate {
    /// Every fate, in the order in which counts are listed.
    pub const ALL: [Self; 14] = [
        Self::MealAtBolus,
        Self::MealOfReportedSize,
        Self::MealAdded,
        Self::AlreadyReported,
        Self::UnsupportedDetection,
        Self::UnknownSize,
        Self::ReplacedByDetection,
        Self::MovedToDetection,
        Self::KeptWithBolus,
        Self::KeptAsLogged,
        Self::UnsupportedReport,
        Self::GivesTime,
        Self::SupportsReport,
        Self::NoMeal,
    ];

    /// The name that files use.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::MealAtBolus => "meal_at_bolus",
            Self::MealOfReportedSize => "meal_of_reported_size",
            Self::MealAdded => "meal_added",
            Self::AlreadyReported => "already_reported",
            Self::UnsupportedDetection => "unsupported_detection",
            Self::UnknownSize => "unknown_size",
            Self::ReplacedByDetection => "replaced_by_detection",
            Self::MovedToDetection => "moved_to_detection",
            Self::KeptWithBolus => "kept_with_bolus",
            Self::KeptAsLogged => "kept_as_logged",
            Self::UnsupportedReport => "unsupported_report",
            Self::GivesTime => "gives_time",
            Self::SupportsReport => "supports_report",
            Self::NoMeal => "no_meal",
        }
    }
}

/// One event and what became of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EventRow {
    /// The person's identifier.
    pub person_id: String,
    /// Start of the event's step, local wall clock.
    #[serde(serialize_with = "as_iso")]
    pub time: NaiveDateTime,
    /// What it is.
    pub kind: EventKind,
    /// g of carbohydrate or U of insulin; `None` for a detection without a size.
    pub size: Option<f64>,
    /// Strength of a detection's evidence, nats or standard deviations; `None` for other events.
    pub evidence: Option<f64>,
    /// What became of it.
    pub fate: Fate,
    /// Time of the event that decided its fate.
    #[serde(serialize_with = "as_iso_if_any")]
    pub partner: Option<NaiveDateTime>,
}

/// How often each fate befell an event; fates that befell none are left out.
#[must_use]
pub fn count_fates<'a>(events: impl IntoIterator<Item = &'a EventRow>) -> Vec<(Fate, usize)> {
    let mut counts = [0_usize; Fate::ALL.len()];
    for event in events {
        counts[event.fate as usize] += 1;
    }
    Fate::ALL.into_iter().zip(counts).filter(|(_, count)| *count > 0).collect()
}

/// A local time as cohort folders write it.
fn as_iso<S: Serializer>(time: &NaiveDateTime, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(&time.format("%Y-%m-%dT%H:%M:%S"))
}

fn as_iso_if_any<S: Serializer>(
    time: &Option<NaiveDateTime>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    match time {
        Some(time) => as_iso(time, serializer),
        None => serializer.serialize_none(),
    }
}
