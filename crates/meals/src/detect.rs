//! Meals found in sensor and insulin alone.

use cohort::Person;
use physiology::Grams;

use crate::error::MealError;
use crate::signals::Signals;

pub mod grid;
pub mod plant;

pub use grid::GridSettings;
pub use plant::PlantSettings;

/// A meal that a detector claims.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detection {
    /// Step of the record at which it was eaten, as far as the detector can tell:
    /// [`Detector::Grid`] gives the step of its alarm.
    pub step: usize,
    /// Estimated carbohydrate; `None` where the detector estimates none.
    pub carbs: Option<Grams>,
    /// How strongly the readings speak for it; the numbers of one detector can be compared.
    /// [`Detector::Plant`] gives the logarithm of the likelihood with the meal over that without
    /// it, both at their best, nats; [`Detector::Grid`] the slope of the filtered readings over
    /// the standard deviation that the sensor's error alone gives such a slope, unitless.
    pub evidence: f64,
}

/// The meals found in one record, in order of their steps.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Detected {
    /// The meals.
    pub meals: Vec<Detection>,
    /// Insulin sensitivity over the nominal one that the record asked for; `None` where the
    /// detector knows no insulin.
    pub sensitivity: Option<f64>,
}

/// A way of finding meals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Detector {
    /// The published rate-of-rise detector, [`grid`].
    Grid(GridSettings),
    /// A matched filter behind a Kalman filter on the ODE plant, [`plant`].
    Plant(PlantSettings),
}

impl Detector {
    /// The name that files and the command line use.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Grid(_) => "grid",
            Self::Plant(_) => "plant",
        }
    }

    /// Finds the meals of a person. What they logged as carbohydrate is not looked at.
    ///
    /// # Errors
    /// [`MealError`] for values and settings that cannot be, and where the plant fails.
    pub fn detect(&self, person: &Person) -> Result<Detected, MealError> {
        let signals = Signals::of(person)?;
        match self {
            Self::Grid(settings) => grid::detect(&signals, settings),
            Self::Plant(settings) => plant::detect(&signals, settings),
        }
    }
}
