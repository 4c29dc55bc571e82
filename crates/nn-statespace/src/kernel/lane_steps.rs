//! Single steps of some states, for many samples at a time.

use physiology::Compartment;

use super::block::{BLOCK, PARTS, Row};
use super::forward::{PlainStep, Step, confine};
use super::instructions::Instructions;
use super::layout::ParameterLayout;
use super::real::Real;
use super::units::Networks;
use crate::error::ModelError;
use crate::per_compartment::PerCompartment;
use crate::population::{GlucoseClamp, PopulationModel};
use crate::signal::Signal;
use crate::training::windows::SIGNALS;

/// Samples that step together.
pub const LANES: usize = BLOCK;

/// The signals of [`LANES`] samples, shape (12, lanes), in the rows of [`Signal::row`]; all scaled.
pub type Signals<T> = [[T; LANES]; SIGNALS];

/// Steps of some states of the population model (paper Eq. 2), with what is added to them, if
/// anything, coming from elsewhere: a twin's residual network adds to the step of Q1.
///
/// A sample's step is the same whatever stands in the other lanes.
#[derive(Debug, Clone)]
pub struct LaneSteps<T> {
    networks: Networks<T>,
    /// The networks' slopes in the last step, one after the other.
    slopes: Vec<Row<T>>,
    activity: Vec<u16>,
    glucose_range: Option<(T, T)>,
    instructions: Instructions,
}

impl<T: Real> LaneSteps<T> {
    /// Steps of these states of a model, on the machine's fastest instructions.
    ///
    /// # Errors
    /// [`ModelError::NotFinite`] if a weight cannot be held in this precision.
    pub fn new(model: &PopulationModel, states: &[Compartment]) -> Result<Self, ModelError> {
        let layout = ParameterLayout::new(model.wiring(), &model.widths());
        let of_model = PerCompartment::from_fn(|c| model.network(c).clone());
        let mut networks = Networks::new(model.wiring());
        networks.set(&layout, &layout.flatten::<T>(&of_model)?)?;
        networks.each.retain(|network| states.contains(&network.compartment));
        let (lowest, highest) = model.scaled_glucose_range();
        let range = (T::of(lowest), T::of(highest));
        let glucose_range = (model.clamp() == GlucoseClamp::Reproduction).then_some(range);
        Ok(Self {
            slopes: vec![[T::ZERO; BLOCK]; networks.slopes],
            activity: vec![0; PARTS * networks.units],
            networks,
            glucose_range,
            instructions: Instructions::best(),
        })
    }

    /// The same on these instructions; on the portable ones if the machine does not have them.
    #[must_use]
    pub fn with_instructions(mut self, instructions: Instructions) -> Self {
        self.instructions = instructions;
        self
    }

    /// Writes the chosen states after a step to `next` and leaves its other rows alone. Q1 is not
    /// confined: see [`Self::confine_glucose`].
    pub fn step(&mut self, now: &Signals<T>, next: &mut Signals<T>) {
        let Self { networks, slopes, activity, instructions, .. } = self;
        T::dispatch(*instructions, Step { networks, now, next, slopes, activity });
    }

    /// The same as [`Self::step`] up to rounding, without keeping slopes: faster.
    pub fn step_without_slopes(&mut self, now: &Signals<T>, next: &mut Signals<T>) {
        T::dispatch(self.instructions, PlainStep { networks: &self.networks, now, next });
    }

    /// The slope of a state's last step by a signal, without the state itself; `None` if its
    /// network does not see the signal or was not asked for.
    #[must_use]
    pub fn slope(&self, of: Compartment, by: Signal) -> Option<&[T; LANES]> {
        let network = self.networks.each.iter().find(|network| network.compartment == of)?;
        let seen = &network.signals[..network.seen];
        let column = seen.iter().position(|row| *row == by.row())?;
        Some(&self.slopes[network.first_slope + column])
    }

    /// Confines finite values of Q1 as the model does; says of which lanes it did.
    pub fn confine_glucose(&self, next: &mut Signals<T>) -> [bool; LANES] {
        let mut confined = [false; LANES];
        if let Some((lowest, highest)) = self.glucose_range {
            let row = &mut next[Compartment::Q1 as usize];
            let before = *row;
            confine(row, lowest, highest);
            for ((confined, before), after) in confined.iter_mut().zip(before).zip(row) {
                // A value that is not a number compares with nothing, and nothing was done to it.
                let order = before.partial_cmp(after);
                *confined = order.is_some_and(std::cmp::Ordering::is_ne);
            }
        }
        confined
    }
}
