//! What a detector may look at: sensor, insulin and weight. The carbohydrate that a person logged
//! is not part of it, so that no detector can lean on what it is to check.

use cohort::{Channel, Person};
use physiology::Kilograms;

use crate::error::MealError;

/// Weight of a person whose weight is not recorded: the population's mean (Resalat et al. 2019).
pub const ASSUMED_WEIGHT: Kilograms = Kilograms(76.3);

/// The signals of one person's record, one value a step, without what was eaten.
#[derive(Debug, Clone, PartialEq)]
pub struct Signals<'a> {
    /// The person's identifier.
    pub(crate) person: &'a str,
    /// Sensor glucose, mg/dL.
    pub(crate) cgm: &'a [Option<f64>],
    /// Basal rate, U/h.
    pub(crate) basal: &'a [Option<f64>],
    /// Bolus insulin, U.
    pub(crate) bolus: &'a [Option<f64>],
    /// The body weight, [`ASSUMED_WEIGHT`] if it is not recorded.
    pub(crate) weight: Kilograms,
}

impl<'a> Signals<'a> {
    /// The signals of a person.
    ///
    /// # Errors
    /// [`MealError::Value`] for a reading that is not positive or insulin that is negative (or
    /// either not finite), [`MealError::Weight`] for a weight that is not positive.
    pub fn of(person: &'a Person) -> Result<Self, MealError> {
        if let Some(weight) = person.weight.filter(|w| !(w.0.is_finite() && w.0 > 0.0)) {
            return Err(MealError::Weight { person: person.id.clone(), value: weight.0 });
        }
        let reads = "a finite number above 0";
        Ok(Self {
            person: &person.id,
            cgm: checked(person, Channel::Cgm, |glucose| glucose > 0.0, reads)?,
            basal: doses(person, Channel::Basal)?,
            bolus: doses(person, Channel::Bolus)?,
            weight: person.weight.unwrap_or(ASSUMED_WEIGHT),
        })
    }

    /// The first `steps` steps.
    pub(crate) fn first(&self, steps: usize) -> Self {
        let end = steps.min(self.cgm.len());
        Self {
            cgm: &self.cgm[..end],
            basal: &self.basal[..end],
            bolus: &self.bolus[..end],
            ..self.clone()
        }
    }
}

/// A channel of insulin or of carbohydrate, none of whose values is negative or not finite.
pub(crate) fn doses(person: &Person, channel: Channel) -> Result<&[Option<f64>], MealError> {
    checked(person, channel, |dose| dose >= 0.0, "a finite number of at least 0")
}

fn checked<'a>(
    person: &'a Person,
    channel: Channel,
    fits: fn(f64) -> bool,
    requirement: &'static str,
) -> Result<&'a [Option<f64>], MealError> {
    let values = person.record.channel(channel);
    let unfit = |value: &f64| !(value.is_finite() && fits(*value));
    let mut steps = values.iter().enumerate();
    match steps.find_map(|(step, value)| Some((step, value.filter(unfit)?))) {
        None => Ok(values),
        Some((step, value)) => Err(MealError::Value {
            person: person.id.clone(),
            step,
            column: channel.name(),
            value,
            requirement,
        }),
    }
}
