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
    person: &'a str,
    cgm: &'a [Option<f64>],
    basal: &'a [Option<f64>],
    bolus: &'a [Option<f64>],
    weight: Option<Kilograms>,
}

impl<'a> Signals<'a> {
    /// The signals of a person.
    ///
    /// # Errors
    /// [`MealError::Value`] for a reading that is not positive or insulin that is negative (or
    /// either not finite), [`MealError::Weight`] for a weight that is not positive.
    pub fn of(person: &'a Person) -> Result<Self, MealError> {
        let checked = |channel: Channel, fits: &dyn Fn(f64) -> bool, requirement| {
            let values = person.record.channel(channel);
            match values.iter().position(|v| v.is_some_and(|v| !(v.is_finite() && fits(v)))) {
                None => Ok(values),
                Some(step) => Err(MealError::Value {
                    person: person.id.clone(),
                    step,
                    column: channel.column(),
                    value: values[step].unwrap_or(f64::NAN),
                    requirement,
                }),
            }
        };
        if let Some(weight) = person.weight.filter(|w| !(w.0.is_finite() && w.0 > 0.0)) {
            return Err(MealError::Weight { person: person.id.clone(), value: weight.0 });
        }
        let dose = "a finite number of at least 0";
        Ok(Self {
            person: &person.id,
            cgm: checked(Channel::Cgm, &|v| v > 0.0, "a finite number above 0")?,
            basal: checked(Channel::Basal, &|v| v >= 0.0, dose)?,
            bolus: checked(Channel::Bolus, &|v| v >= 0.0, dose)?,
            weight: person.weight,
        })
    }

    /// The person's identifier.
    #[must_use]
    pub const fn person(&self) -> &'a str {
        self.person
    }

    /// Number of steps.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.cgm.len()
    }

    /// Whether there is no step.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.cgm.is_empty()
    }

    /// Sensor glucose, mg/dL.
    #[must_use]
    pub const fn cgm(&self) -> &'a [Option<f64>] {
        self.cgm
    }

    /// Basal rate, U/h.
    #[must_use]
    pub const fn basal(&self) -> &'a [Option<f64>] {
        self.basal
    }

    /// Bolus insulin, U.
    #[must_use]
    pub const fn bolus(&self) -> &'a [Option<f64>] {
        self.bolus
    }

    /// The body weight, [`ASSUMED_WEIGHT`] if it is not recorded.
    #[must_use]
    pub fn weight(&self) -> Kilograms {
        self.weight.unwrap_or(ASSUMED_WEIGHT)
    }

    /// The first `steps` steps.
    #[must_use]
    pub fn first(&self, steps: usize) -> Self {
        let end = steps.min(self.len());
        Self {
            cgm: &self.cgm[..end],
            basal: &self.basal[..end],
            bolus: &self.bolus[..end],
            ..self.clone()
        }
    }
}
