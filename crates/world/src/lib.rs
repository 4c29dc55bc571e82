//! Free-living cohorts made from people, behaviour, body, sensor and pump.
//!
//! A world draws people whose bodies differ from the nominal parameters that any twin starts from,
//! lets them live (meals, sleep, exercise, mistakes), and records what a study would see of it. The
//! simulated body is richer than the plants under test: its parameters change from minute to minute
//! under a stated set of [effects](Effect). The effects are written here; they are not read from a
//! formula that a diagnosis fits.
//!
//! ```no_run
//! let (cohort, info) = world::embedded_cohort(world::EMBEDDED_SEED)?;
//! assert_eq!(cohort.people.len(), 6);
//! assert_eq!(info.people.len(), 6);
//! # Ok::<(), world::WorldError>(())
//! ```

mod background;
mod behaviour;
pub mod blind;
mod body;
mod calendar;
mod devices;
mod effects;
mod embedded;
mod error;
mod everyday;
mod generator;
pub mod hovorka;
mod living;
mod logging;
pub mod minimal;
pub mod padova;
mod physique;
pub mod planted;
pub mod plausibility;
mod reactions;
pub mod saturating;
mod shift;
mod stream;
mod therapy;
pub mod true_gap;
mod virtual_person;
mod warp;
mod wear;
mod world_info;

pub use background::Background;
pub use behaviour::{
    BolusTiming, Drinking, Habits, Hours, InfusionSets, Life, Meal, MealKind, Night, Session,
    Shift, Sport, Wearable,
};
pub use body::{Body, BodyModel, BodyState, Compartments};
pub use calendar::Calendar;
pub use effects::{
    AbsorptionForm, AfterExerciseForm, AlcoholForm, CircadianForm, CompressionForm, DawnForm,
    DriftForm, ExerciseForm, Forms, LagForm, LowForm, MiscountForm, MissedForm, RenalForm,
    SetAgeingForm, SetFailureForm, SleepLossForm, SlowMealsForm, UnloggedForm,
};
pub use effects::{
    Amplitudes, CircadianPattern, Compression, Condition, Drift, Effect, Event, Events, Happenings,
    Kidneys, LowTrace, OutsideEffect, Port, Sensing, SetFailure, Shapes, Spreads, Variability,
    conditions, sensing,
};
pub use embedded::{
    EMBEDDED_DAYS, EMBEDDED_PEOPLE, EMBEDDED_SEED, embedded_cohort, embedded_people,
};
pub use error::WorldError;
pub use everyday::{
    DailyPattern, Everyday, EverydayLogs, LogHabit, MealPace, Noise, Rescues, SensorKind, Sites,
};
pub use generator::Generator;
pub use physique::Physique;
pub use shift::Counterfactual;
pub use stream::{Concept, WORLD, stream};
pub use therapy::{Aid, Depot, Observation, Order, Pen, Regime, TherapySettings};
pub use virtual_person::{LivedDays, VirtualPerson};
pub use warp::{Warp, Warps};
pub use wear::SensorWear;
pub use world_info::{PersonInfo, WorldInfo};
