//! Steps of simulated weeks: where a network is used, and how little its signals move.

use nn_statespace::{PopulationModel, Signal};
use ode_sim::development_set::Subset;
use ode_sim::{DevelopmentPlan, DevelopmentSet};
use physiology::{Compartment, STEP, States, StepInput};

use crate::error::DevelopmentError;
use crate::trajectory_cost::drawn_weeks;

/// Smallest changes of an input that a step is long (paper).
const SMALLEST_CHANGES: f64 = 10.0;
/// Weeks of training days that are simulated.
const WEEKS: usize = 20;

/// Training weeks of the development set, drawn from all of it.
pub struct SimulatedSteps {
    /// The steps of each week.
    weeks: Vec<Vec<(States, StepInput)>>,
}

impl SimulatedSteps {
    /// Draws the weeks with this seed.
    ///
    /// # Errors
    /// A week that cannot be simulated.
    pub fn new(seed: u64) -> Result<Self, DevelopmentError> {
        let set = DevelopmentSet::new(DevelopmentPlan::paper(seed))?;
        let mut weeks = Vec::with_capacity(WEEKS);
        for week in drawn_weeks(&set, Subset::Train, WEEKS, seed)? {
            let states = set.run(&week)?.report(set.plant());
            weeks.push(states.into_iter().zip(week.inputs).collect());
        }
        Ok(Self { weeks })
    }

    /// What the network of a compartment sees, scaled, a row a step.
    pub fn seen_by(&self, model: &PopulationModel, compartment: Compartment) -> Vec<Vec<f64>> {
        let scaler = model.scaler();
        self.weeks
            .iter()
            .flatten()
            .map(|(states, input)| {
                model.seen_by(compartment, &scaler.scale(states), scaler.scale_input(input))
            })
            .collect()
    }

    /// The paper's step of an input, scaled as the model does it: ten times the smallest change.
    #[must_use]
    pub fn paper_step(&self, model: &PopulationModel, input: Signal) -> Option<f64> {
        let change = self.smallest_change(input)?;
        Some(SMALLEST_CHANGES * change / model.scaler().of(input).scale)
    }

    /// The smallest change of a signal over the length of a step, physical units per minute.
    #[must_use]
    pub fn smallest_rate(&self, signal: Signal) -> Option<f64> {
        Some(self.smallest_change(signal)? / STEP.0)
    }

    /// The smallest change of a signal between two steps that single precision tells from none at the signal's largest value,
    /// in its physical unit: the paper's "minimum change possible". Without that floor it would be whatever is left of
    /// an exponential after days.
    fn smallest_change(&self, signal: Signal) -> Option<f64> {
        let value = |(states, input): &(States, StepInput)| match signal {
            Signal::State(state) => states[state],
            Signal::Insulin => input.insulin().0,
            Signal::Carbs => input.carbs.0,
        };
        let largest = self.weeks.iter().flatten().map(|row| value(row).abs()).fold(0.0, f64::max);
        let floor = largest * f64::from(f32::EPSILON);
        self.weeks
            .iter()
            .flat_map(|week| week.windows(2))
            .map(|rows| (value(&rows[1]) - value(&rows[0])).abs())
            .filter(|change| *change > floor)
            .min_by(f64::total_cmp)
    }
}
