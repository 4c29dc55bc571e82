//! How insulin is given: settings derived from the body, a pump that follows its profile, automated
//! delivery, and injections.

mod aid;
mod depot;
mod injections;
mod settings;

pub use aid::Aid;
pub use depot::Depot;
pub use injections::Pen;
pub use settings::TherapySettings;

pub(crate) use settings::{LEAST_FALL, fall_by_a_unit};

use physiology::{Grams, MgPerDl, Units, UnitsPerHour};
use serde::Serialize;

named::named_in_json! {
    /// How a person's basal insulin is decided.
    #[derive(Serialize)]
    Regime {
        /// The programmed profile, with a lower temporary rate in exercise.
        OpenLoopPump: "open_loop_pump",
        /// Automated insulin delivery.
        Aid: "aid",
        /// Long-acting insulin and boluses by pen.
        Mdi: "mdi",
    }
}

/// What a controller knows at the start of a step. It never sees the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// Hour of the day, 0 to below 24.
    pub hour: f64,
    /// The latest reading; `None` if there was none in the last 20 min.
    pub glucose: Option<MgPerDl>,
    /// Its change, mg/dL per minute; 0 if unknown.
    pub trend: f64,
    /// Insulin delivered beyond the programmed profile and still to act; negative after
    /// suspensions.
    pub insulin_on_board: Units,
    /// Announced carbohydrate still to be absorbed.
    pub carbs_on_board: Grams,
    /// Whether the person exercises.
    pub exercising: bool,
}

/// What a controller orders for a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Order {
    /// Basal rate.
    pub basal: UnitsPerHour,
    /// Automatic bolus.
    pub bolus: Units,
}
