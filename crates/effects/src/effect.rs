//! What an effect has to say of itself.

use std::fmt::Debug;

use crate::card::Card;
use crate::course::Course;
use crate::modulation::{Field, Modulation};

/// How an effect acts in time.
#[derive(Debug, Clone, PartialEq)]
pub enum Form {
    /// Its time course follows from the record: [`Effect::modulate`] writes it.
    Driven,
    /// Hidden events of one or a few shapes that start anywhere in a set of steps.
    Events(EventShape),
    /// A random factor with mean 1, drawn anew for every unit.
    Random {
        /// The factor.
        field: Field,
        /// For what it is drawn anew.
        unit: RandomUnit,
        /// Standard deviation of its logarithm at amplitude 1.
        log_sd: f64,
    },
}

/// For what a random factor is drawn anew.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RandomUnit {
    /// Every calendar day.
    Day,
    /// Every logged meal; it acts on the step of the meal.
    Meal,
}

/// A hidden event.
#[derive(Debug, Clone, PartialEq)]
pub struct EventShape {
    /// What it changes.
    pub field: Field,
    /// What an event of amplitude 1 adds to the field (to the neutral value), per step from its onset: one or more
    /// courses that are equally likely.
    pub profiles: Vec<Vec<f64>>,
    /// Steps at which an event may start.
    pub onsets: Vec<usize>,
    /// Events a day at the published frequency.
    pub per_day: f64,
    /// Relative sizes of events and their prior weights, which add up to 1.
    pub sizes: Vec<(f64, f64)>,
}

impl EventShape {
    /// The form of these events; `None` where they can start nowhere.
    pub(crate) fn if_it_starts(self) -> Option<Form> {
        (!self.onsets.is_empty()).then_some(Form::Events(self))
    }
}

/// An effect of the library.
pub trait Effect: Debug + Send + Sync {
    /// What it is.
    fn card(&self) -> Card;

    /// How it acts in time for this person; `None` if the record lacks what signals it.
    fn form(&self, course: &Course) -> Option<Form>;

    /// Number of alternative shapes (phases, peak times); one of them is chosen on training days.
    fn variants(&self) -> usize {
        1
    }

    /// Number of alternative shapes that differ for this record, at most [`variants`](Self::variants).
    ///
    /// Where a log settles what would otherwise be guessed (when sets were changed, how old a sensor is)
    /// only the first few are worth trying.
    fn variants_for(&self, course: &Course) -> usize {
        let _ = course;
        self.variants()
    }

    /// Adds the effect of an amplitude to each step: factors multiply what is there, additions add.
    ///
    /// Only for [`Form::Driven`]; `into` has one entry a step of `course`. `variant` is below
    /// [`variants`](Self::variants). At amplitude 0 nothing changes.
    fn modulate(&self, variant: usize, amplitude: f64, course: &Course, into: &mut [Modulation]);
}
