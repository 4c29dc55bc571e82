//! What insulin does along a record, and the linear system that glucose then follows.

use ode_sim::{EgpMode, Integrator, OdeParameters, OdePlant, OdeState};
use physiology::Compartment::{Q1, Q2, X1, X2, X3};
use physiology::{MgPerDl, STEP, STEPS_PER_DAY, StepInput, Units, UnitsPerHour};

use crate::error::MealError;
use crate::signals::Signals;

/// Glucose at which the plant settles where there is no reading yet, mg/dL.
const BEFORE_ANY_READING: f64 = 140.0;

/// One step of glucose: (Q1, Q2) after it = `constant` + `transition` (Q1, Q2) + `gain` flux.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GlucoseStep {
    /// What is added whatever glucose is, mmol/kg.
    pub constant: [f64; 2],
    /// What becomes of both compartments, unitless.
    pub transition: [[f64; 2]; 2],
    /// What a constant flux into Q1 through the step leaves in both, min.
    pub gain: [f64; 2],
    /// Glucose that insulin moves out of Q1 or keeps in the liver, mmol/kg/min.
    pub moved: f64,
}

/// The effect of recorded insulin on a body, step by step.
#[derive(Debug, Clone, PartialEq)]
pub struct InsulinAction {
    /// The plant.
    pub plant: OdePlant,
    /// One entry a step.
    pub steps: Vec<GlucoseStep>,
    /// Q1 and Q2 of the plant at the start of the record, mmol/kg.
    pub first: [f64; 2],
}

impl InsulinAction {
    /// Runs the nominal plant, its sensitivities multiplied by `sensitivity`, along a record.
    ///
    /// It is linearised at the latest reading. A basal rate that is not recorded is the mean of
    /// those that are (of none: the rate that holds 140 mg/dL); a bolus that is not recorded is
    /// none. The plant has settled for a day under the mean rate before the record begins.
    ///
    /// # Errors
    /// [`MealError::Plant`] if the plant fails.
    pub fn along(signals: &Signals<'_>, sensitivity: f64) -> Result<Self, MealError> {
        let plant = OdePlant {
            parameters: OdeParameters::nominal().with_sensitivity_scaled(sensitivity),
            weight: signals.weight,
            integrator: Integrator::RungeKutta4 { substeps: 1 },
            egp: EgpMode::NonNegative,
        };
        let failed = |step| {
            move |source| MealError::Plant { person: signals.person.to_owned(), step, source }
        };
        let basal = match mean(signals.basal) {
            Some(mean) => mean,
            None => {
                let (p, w) = (&plant.parameters, plant.weight);
                let held = ode_sim::steady_state::at_glucose(p, w, MgPerDl(BEFORE_ANY_READING));
                held.map_err(failed(0))?.basal.0
            }
        };
        let mut glucose =
            signals.cgm.iter().flatten().next().copied().unwrap_or(BEFORE_ANY_READING);
        let at =
            |state: OdeState, glucose: f64| OdeState { q1: plant.q1_at(MgPerDl(glucose)), ..state };
        let settling = StepInput { basal: UnitsPerHour(basal), ..StepInput::default() };
        let mut state = OdeState::default();
        for _ in 0..STEPS_PER_DAY {
            state = plant.advance(&at(state, glucose), &settling, 0.0).map_err(failed(0))?;
        }
        state = at(state, glucose);
        let first = [state.q1, state.q2];
        let mut steps = Vec::with_capacity(signals.cgm.len());
        for step in 0..signals.cgm.len() {
            glucose = signals.cgm[step].unwrap_or(glucose);
            state = at(state, glucose);
            let input = StepInput {
                basal: UnitsPerHour(signals.basal[step].unwrap_or(basal)),
                bolus: Units(signals.bolus[step].unwrap_or(0.0)),
                ..StepInput::default()
            };
            let (after, slopes) = plant.linearised(&state, &input, 0.0).map_err(failed(step))?;
            let transition =
                [[slopes[(Q1, Q1)], slopes[(Q1, Q2)]], [slopes[(Q2, Q1)], slopes[(Q2, Q2)]]];
            let moved_on = |row: [f64; 2]| row[0] * state.q1 + row[1] * state.q2;
            let p = &plant.parameters;
            let x = state.vector();
            let disposed = x[X1] * x[Q1] * x[X2] / (p.k_12 + x[X2]).max(f64::MIN_POSITIVE);
            steps.push(GlucoseStep {
                constant: [after.q1 - moved_on(transition[0]), after.q2 - moved_on(transition[1])],
                transition,
                // Trapezoid of the response to a flux early and late in the step: off by less than
                // one in a hundred.
                gain: [0.5 * STEP.0 * (1.0 + transition[0][0]), 0.5 * STEP.0 * transition[1][0]],
                moved: disposed + p.egp_0 * x[X3].min(1.0),
            });
            state = after;
        }
        Ok(Self { plant, steps, first })
    }
}

/// The mean of what is recorded; `None` of nothing.
pub(crate) fn mean(values: &[Option<f64>]) -> Option<f64> {
    let (sum, n) = values.iter().flatten().fold((0.0, 0_usize), |(s, n), v| (s + v, n + 1));
    (n > 0).then(|| sum / n as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detect::plant::synthetic::person;

    #[test]
    fn the_linear_step_is_the_plants_at_the_reading_and_close_to_it_nearby() {
        let person = person(60, &[], &[(10, 3.0)]);
        let signals = Signals::of(&person).expect("values that can be");
        let action = InsulinAction::along(&signals, 1.0).expect("a plant that runs");
        // The same run by hand up to the step.
        let plant = action.plant;
        let mut state = OdeState { q1: action.first[0], q2: action.first[1], ..settled(&signals) };
        for step in 0..28 {
            let glucose = signals.cgm[step].expect("a reading");
            state.q1 = plant.q1_at(MgPerDl(glucose));
            let input = StepInput {
                basal: UnitsPerHour(signals.basal[step].expect("recorded")),
                bolus: Units(signals.bolus[step].expect("recorded")),
                ..StepInput::default()
            };
            // At the reading exactly; a tenth above it, with the curvature of X1 Q1 alone (none)
            // and kinks of uptake and clearance (not reached in these steps): rounding.
            for factor in [1.0, 1.1] {
                let moved = OdeState { q1: factor * state.q1, ..state };
                let expected = plant.advance(&moved, &input, 0.0).expect("a plant that runs");
                let linear = after(&action.steps[step], [moved.q1, moved.q2], 0.0);
                assert!((linear[0] - expected.q1).abs() < 1e-9, "step {step} {factor}");
                assert!((linear[1] - expected.q2).abs() < 1e-9, "step {step} {factor}");
            }
            let expected = plant.advance(&state, &input, 0.01).expect("a plant that runs");
            let linear = after(&action.steps[step], [state.q1, state.q2], 0.01);
            // 0.05 mmol/kg come in. The trapezoid leaves X1 (X1 + k12) h^3 / 12 of the flux: at
            // most one in a hundred for X1 of 0.05/min.
            assert!((linear[0] - expected.q1).abs() < 5e-4, "step {step}");
            assert!((linear[1] - expected.q2).abs() < 5e-4, "step {step}");
            state = plant.advance(&state, &input, 0.0).expect("a plant that runs");
        }
    }

    fn settled(signals: &Signals<'_>) -> OdeState {
        let action = InsulinAction::along(signals, 1.0).expect("a plant that runs");
        let input = StepInput {
            basal: UnitsPerHour(signals.basal[0].expect("recorded")),
            ..StepInput::default()
        };
        let mut state = OdeState::default();
        for _ in 0..STEPS_PER_DAY {
            let glucose = MgPerDl(signals.cgm[0].expect("a reading"));
            state.q1 = action.plant.q1_at(glucose);
            state = action.plant.advance(&state, &input, 0.0).expect("a plant that runs");
        }
        state
    }

    fn after(step: &GlucoseStep, q: [f64; 2], flux: f64) -> [f64; 2] {
        std::array::from_fn(|row| {
            let [one, two] = step.transition[row];
            step.constant[row] + one * q[0] + two * q[1] + step.gain[row] * flux
        })
    }

    #[test]
    fn more_insulin_or_sensitivity_moves_more_glucose() {
        let moved = |boluses: &[(usize, f64)], sensitivity: f64| {
            let person = person(40, &[], boluses);
            let signals = Signals::of(&person).expect("values that can be");
            let action = InsulinAction::along(&signals, sensitivity).expect("a plant that runs");
            action.steps[30].moved
        };
        assert!(moved(&[(5, 4.0)], 1.0) > 1.2 * moved(&[], 1.0));
        assert!(moved(&[], 1.5) > 1.2 * moved(&[], 1.0));
    }
}
