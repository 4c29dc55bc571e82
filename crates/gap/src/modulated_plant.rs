//! A plant on which effects act: the step index goes along with the state.

use effects::Modulation;
use ode_sim::OdeError;
use physiology::{Compartment, MgPerDl, NonFinite, Plant, States, StepInput};

use crate::filter::augmented::AugmentedModel;
use crate::filter::observations::within_sensor_range;
use crate::filter::state::AugmentedState;

/// The filter's model under the modulations of a record.
///
/// Step `k` of the record acts under `modulations[k]`; where the list ends nothing is changed.
#[derive(Debug, Clone, Copy)]
pub struct ModulatedPlant<'a> {
    model: &'a AugmentedModel,
    modulations: &'a [Modulation],
}

/// A state and the step of the record at whose start it holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModulatedState {
    /// The step.
    pub step: usize,
    /// The state.
    pub state: AugmentedState,
}

impl<'a> ModulatedPlant<'a> {
    /// `model` under `modulations`, one entry a step of the record.
    #[must_use]
    pub fn new(model: &'a AugmentedModel, modulations: &'a [Modulation]) -> Self {
        Self { model, modulations }
    }

    /// What a sensor would show, mg/dL, within its range.
    #[must_use]
    pub fn reading(&self, state: &ModulatedState) -> f64 {
        within_sensor_range(self.model.reading(&state.state, self.modulation(state.step)))
    }

    /// A start of a free run: what the filter believes, without the flux and the sensor error that it
    /// cannot explain.
    #[must_use]
    pub fn start(step: usize, filtered: &AugmentedState) -> ModulatedState {
        let AugmentedState { body, interstitial, .. } = *filtered;
        let state = AugmentedState { body, interstitial, ..AugmentedState::default() };
        ModulatedState { step, state }
    }

    fn modulation(&self, step: usize) -> &Modulation {
        self.modulations.get(step).unwrap_or(Modulation::unchanged())
    }
}

impl Plant for ModulatedPlant<'_> {
    type State = ModulatedState;

    fn step(&self, state: &ModulatedState, input: &StepInput) -> Result<ModulatedState, NonFinite> {
        let modulation = self.modulation(state.step);
        let following = self.model.step(&state.state, input, modulation).map_err(not_finite)?;
        Ok(ModulatedState { step: state.step + 1, state: following })
    }

    /// Plasma glucose.
    fn glucose(&self, state: &ModulatedState) -> MgPerDl {
        self.model.person().glucose(&state.state.body)
    }

    fn report(&self, state: &ModulatedState) -> States {
        self.model.report(&state.state)
    }
}

/// The Euler step has no other way to fail than a state that is not finite.
fn not_finite(error: OdeError) -> NonFinite {
    match error {
        OdeError::NonFinite { compartment } => NonFinite { compartment },
        _ => NonFinite { compartment: Compartment::Q1 },
    }
}

#[cfg(test)]
mod tests {
    use effects::Field;
    use ode_sim::OdeParameters;
    use physiology::{Kilograms, OpenLoop, UnitsPerHour, simulate};

    use super::*;
    use crate::filter::noise::NoiseModel;

    #[test]
    fn a_modulation_acts_in_its_own_step_of_the_record() {
        let noise = NoiseModel::working();
        let weight = Kilograms(76.3);
        let model = AugmentedModel::new(OdeParameters::nominal(), weight, noise);
        let (rest, _) = model.start(UnitsPerHour(1.0), MgPerDl(120.0));
        let inputs = [StepInput { basal: UnitsPerHour(1.0), ..StepInput::default() }; 4];
        let mut modulations = [Modulation::NEUTRAL; 12];
        modulations[8][Field::ExtraCarbs] = 30.0;
        modulations[9][Field::SensorOffset] = 7.0;
        let run = |modulations: &[Modulation]| {
            let plant = ModulatedPlant::new(&model, modulations);
            let start = ModulatedPlant::start(6, &rest);
            let run = simulate(&plant, start, &mut OpenLoop::new(&inputs), 4).expect("finite");
            run.states
                .iter()
                .map(|s| (s.state.body.meals.c1, plant.reading(s)))
                .collect::<Vec<(f64, f64)>>()
        };
        let (with, without) = (run(&modulations), run(&[]));
        // Step 8 of the record is the third of the run: its end is the fourth state.
        assert_eq!(with[..3], without[..3]);
        assert!(with[3].0 > without[3].0);
        // An offset is seen in its step; glucose has hardly moved by then.
        let change = with[3].1 - without[3].1;
        assert!((7.0..8.0).contains(&change), "{change}");
    }
}
