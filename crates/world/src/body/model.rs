//! What tells one kind of body from another: its parameters, their spread and its equations.

use std::fmt::Debug;

use ode_sim::OdeError;
use physiology::{Kilograms, MgPerDl, NonFinite, States, StepInput, UnitsPerHour};
use rand::Rng;

use super::Body;
use crate::effects::{Amplitudes, Condition};
use crate::error::WorldError;

/// Basal needs that are accepted, U/h: with basal near half of the daily insulin these lie around
/// 20 to 70 U a day (Resalat et al. 2019: mean 42.3 U).
const BASAL_RANGE: (f64, f64) = (0.45, 1.35);
/// Draws after which the search for an acceptable body ends; about one in two is accepted.
const MAX_DRAWS: usize = 200;
/// Glucose at which the basal need of a body is judged.
const REFERENCE_GLUCOSE: MgPerDl = MgPerDl(115.0);

/// A kind of body: the parameters of one person, with the equations that they belong to.
pub trait BodyModel: Copy {
    /// The compartments, and what past meals and exercise still do.
    type State: Debug + Copy + PartialEq;

    /// One draw around the nominal adult, accepted or not.
    #[must_use]
    fn draw(rng: &mut (impl Rng + ?Sized)) -> Self;

    /// Whether treatment with insulin works in this body.
    #[must_use]
    fn responds_to_insulin(&self) -> bool {
        true
    }

    /// Body weight.
    #[must_use]
    fn weight(&self) -> Kilograms;

    /// The state that a constant basal rate holds at a glucose concentration, and that rate.
    ///
    /// # Errors
    /// [`OdeError::NoBasal`] where glucose stays below the target even without insulin,
    /// [`OdeError::SteadyState`] where no insulin holds it, [`OdeError::Argument`] for an
    /// impossible glucose and [`OdeError::Parameter`] for an impossible parameter.
    fn at_rest(&self, glucose: MgPerDl) -> Result<(Self::State, UnitsPerHour), OdeError>;

    /// The state five minutes later. The condition is that at the body's glucose, the exercise of
    /// the input that which muscle feels.
    ///
    /// # Errors
    /// If a compartment is not finite.
    fn advance(
        &self,
        state: &Self::State,
        input: &StepInput,
        condition: &Condition,
        amplitudes: &Amplitudes,
    ) -> Result<Self::State, NonFinite>;

    /// Plasma glucose.
    #[must_use]
    fn glucose(&self, state: &Self::State) -> MgPerDl;

    /// The compartments with the nearest meaning.
    #[must_use]
    fn report(&self, state: &Self::State) -> States;

    /// Draws the body of a person.
    ///
    /// A body is accepted if its basal need at 115 mg/dL lies between 0.45 and 1.35 U/h and it
    /// responds to insulin.
    ///
    /// # Errors
    /// [`WorldError::NoBody`] if no draw is accepted, [`WorldError::Body`] if the model fails.
    fn sample(person: usize, rng: &mut (impl Rng + ?Sized)) -> Result<Self, WorldError> {
        let (lowest, highest) = BASAL_RANGE;
        for _ in 0..MAX_DRAWS {
            let model = Self::draw(rng);
            match Body::undisturbed(model).at_rest(REFERENCE_GLUCOSE) {
                Ok((_, basal)) if (lowest..=highest).contains(&basal.0) => {
                    if model.responds_to_insulin() {
                        return Ok(model);
                    }
                }
                Ok(_) | Err(OdeError::NoBasal { .. } | OdeError::SteadyState { .. }) => {}
                Err(source) => return Err(WorldError::Body { person, source }),
            }
        }
        Err(WorldError::NoBody { person, draws: MAX_DRAWS, lowest, highest })
    }
}
