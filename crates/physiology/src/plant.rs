//! The interface between a model of a body and everything that drives or judges it.

use crate::compartment::{Compartment, States};
use crate::input::StepInput;
use crate::units::MgPerDl;

/// A model of glucose dynamics that advances in steps of five minutes.
///
/// Implementers bring equations and, if they wish, an integrator; the loop over steps is
/// [`simulate`](crate::simulate) and nothing else.
pub trait Plant {
    /// The plant's own state, in its own units.
    type State: Clone;

    /// The state one step later, given what acted during the step.
    ///
    /// # Errors
    /// If a compartment leaves the finite numbers.
    fn step(&self, state: &Self::State, input: &StepInput) -> Result<Self::State, NonFinite>;

    /// Glucose concentration of a state.
    fn glucose(&self, state: &Self::State) -> MgPerDl;

    /// A state in the reporting units of [`States`].
    fn report(&self, state: &Self::State) -> States;
}

/// A compartment took a value that is not a finite number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{compartment} is not a finite number")]
pub struct NonFinite {
    /// The compartment at fault.
    pub compartment: Compartment,
}

impl<P: Plant + ?Sized> Plant for &P {
    type State = P::State;

    fn step(&self, state: &Self::State, input: &StepInput) -> Result<Self::State, NonFinite> {
        (**self).step(state, input)
    }

    fn glucose(&self, state: &Self::State) -> MgPerDl {
        (**self).glucose(state)
    }

    fn report(&self, state: &Self::State) -> States {
        (**self).report(state)
    }
}
