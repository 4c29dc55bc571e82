//! What the steps of a record do to perturbations.

use effects::{FIELDS, Field};

use super::step_slopes::{StepSlopes, changed, reached};
use super::{Direction, LANES, Parameter, States, reads_only};
use crate::error::GapError;
use crate::filter::augmented::{AugmentedModel, GLUCOSE_FLOOR};
use crate::filter::kalman::{FilterStep, Filtered, start};
use crate::filter::observations::Observations;
use crate::filter::state::STATES;
use crate::filter::transition::Transition;

/// Size of the differences along a field and along a parameter's logarithm where slopes are not written down:
/// far above rounding, far below the curvature of a step.
const SPACING: f64 = 1e-4;

/// What one step does to perturbations, whatever their direction.
pub(super) struct Step {
    pub(super) transition: Transition<f32>,
    /// 0 where the filter only predicted.
    pub(super) gain: [f32; STATES],
    /// What a reading gains per mg/dL of interstitial glucose.
    pub(super) sensor_gain: f32,
    /// Interstitial glucose as expected before the reading, mg/dL.
    pub(super) expected: f32,
    pub(super) scored: bool,
    /// Whether the correction was cut off at the lowest glucose.
    pub(super) floored: bool,
}

/// What successive steps of a record do.
pub(super) struct Steps<'a> {
    model: &'a AugmentedModel,
    pub(super) record: &'a Observations,
    /// For each field, the steps in which a course asks for it; empty where none does.
    nonzero: [Vec<bool>; FIELDS],
    /// Number of the first step that is held.
    pub(super) first: usize,
    pub(super) each: Vec<Step>,
    /// For each field that is asked for, the derivative of the states it reaches, step by step; 0 where
    /// no course asks.
    pub(super) fields: [Vec<f32>; FIELDS],
    /// The parameters that are asked for, [`LANES`] at a time.
    pub(super) parameters: Vec<Parameters>,
}

/// The derivative of the start and of each step by some parameters.
pub(super) struct Parameters {
    /// Each with the model of a neighbour.
    members: Vec<(Parameter, AugmentedModel)>,
    pub(super) begin: States,
    pub(super) steps: Vec<States>,
}

impl<'a> Steps<'a> {
    /// None yet, with space for `capacity` of them.
    pub(super) fn new(
        model: &'a AugmentedModel,
        record: &'a Observations,
        directions: &[Direction],
        capacity: usize,
    ) -> Self {
        let n = record.len();
        let mut nonzero: [Vec<bool>; FIELDS] = std::array::from_fn(|_| Vec::new());
        let mut asked_parameters = Vec::new();
        for direction in directions {
            if let Direction::Parameter(parameter) = direction {
                asked_parameters.push(*parameter);
            }
            direction.additions(n, |field, first, values| {
                if !reads_only(field) {
                    let nonzero = &mut nonzero[field as usize];
                    nonzero.resize(n, false);
                    for (nonzero, value) in nonzero[first..].iter_mut().zip(values) {
                        *nonzero |= *value != 0.0;
                    }
                }
            });
        }
        let fields = std::array::from_fn(|field| {
            let reached =
                if nonzero[field].is_empty() { 0 } else { reached(Field::ALL[field]).len() };
            Vec::with_capacity(reached * capacity)
        });
        let parameters = asked_parameters
            .chunks(LANES)
            .map(|some| Parameters::of(model, record, some, capacity))
            .collect();
        Self {
            model,
            record,
            nonzero,
            first: 0,
            each: Vec::with_capacity(capacity),
            fields,
            parameters,
        }
    }

    /// What all steps of a run that is over do.
    ///
    /// # Errors
    /// [`GapError::FilterNotFinite`] with the step.
    pub(super) fn of_run(
        model: &'a AugmentedModel,
        record: &'a Observations,
        frozen: &Filtered,
        directions: &[Direction],
    ) -> Result<Self, GapError> {
        let n = record.len();
        let mut steps = Self::new(model, record, directions, n);
        let mut expected = start(model, record).0.interstitial.0;
        for step in 0..n {
            let (state, input) = (&frozen.states[step], &record.inputs[step]);
            let (following, transition) = model
                .linearised(state, input, record.modulation(step))
                .map_err(|_| record.not_finite(step))?;
            steps.push(&FilterStep {
                step,
                input,
                expected,
                state,
                innovation: frozen.innovations[step],
                gain: frozen.gains[step],
                following: &following,
                transition: &transition,
            })?;
            expected = following.interstitial.0;
        }
        Ok(steps)
    }

    /// Forgets the steps held.
    pub(super) fn clear(&mut self) {
        self.clear_before(self.first + self.each.len());
    }

    /// Forgets the steps held; the next is `first`.
    pub(super) fn clear_before(&mut self, first: usize) {
        self.first = first;
        self.each.clear();
        self.fields.iter_mut().for_each(Vec::clear);
        self.parameters.iter_mut().for_each(|some| some.steps.clear());
    }

    /// Appends what the filter saw of the next step.
    ///
    /// # Errors
    /// [`GapError::FilterNotFinite`] with the step.
    #[inline]
    pub(super) fn push(&mut self, made: &FilterStep<'_>) -> Result<(), GapError> {
        let Self { model, record, .. } = *self;
        let (step, state) = (made.step, made.state);
        let (input, modulation) = (made.input, record.modulation(step));
        let failed = |_| record.not_finite(step);
        let floor = model.person().q1_at(GLUCOSE_FLOOR);
        self.each.push(Step {
            transition: made.transition.narrowed(),
            gain: made.gain.map_or([0.0; STATES], |applied| applied.gain.map(|k| k as f32)),
            sensor_gain: modulation[Field::SensorGain] as f32,
            expected: made.expected as f32,
            scored: made.innovation.is_some(),
            floored: made.gain.is_some() && state.body.q1 <= floor,
        });
        let mut scratch = None;
        let known = StepSlopes::of(model, state, input, modulation, made.following, &mut scratch);
        for field in Field::ALL {
            let Some(nonzero) = self.nonzero[field as usize].get(step) else { continue };
            let slopes = &mut self.fields[field as usize];
            let reached = reached(field);
            if !nonzero {
                slopes.extend(reached.iter().map(|_| 0.0));
            } else if let Some(known) = &known {
                slopes.extend(known.by_field(field)[..reached.len()].iter().map(|s| *s as f32));
            } else {
                let mut raised = *modulation;
                raised[field] += SPACING;
                let moved = model.step(state, input, &raised).map_err(failed)?.vector();
                let slope = slope(&moved, &made.following.vector());
                slopes.extend(reached.iter().map(|k| slope[*k] as f32));
            }
        }
        for parameters in &mut self.parameters {
            let index = parameters.steps.len();
            parameters.steps.resize(index + 1, [[0.0; LANES]; STATES]);
            let lanes = &mut parameters.steps[index];
            for (lane, (parameter, neighbour)) in parameters.members.iter().enumerate() {
                if let Some(known) = &known {
                    let slopes = known.by_parameter(*parameter);
                    for (k, slope) in changed(*parameter).iter().zip(slopes) {
                        lanes[*k][lane] = slope as f32;
                    }
                } else {
                    let moved = neighbour.step(state, input, modulation).map_err(failed)?;
                    set(lanes, lane, &slope(&moved.vector(), &made.following.vector()));
                }
            }
        }
        Ok(())
    }
}

impl Parameters {
    /// At most [`LANES`] parameters, with space for the steps.
    fn of(
        model: &AugmentedModel,
        record: &Observations,
        some: &[Parameter],
        capacity: usize,
    ) -> Self {
        let mut begin = [[0.0; LANES]; STATES];
        let mut members = Vec::with_capacity(some.len());
        for (lane, parameter) in some.iter().enumerate() {
            let neighbour = |by: f64| model.with_parameters(|p| parameter.raised(p, by));
            let (above, below) = (neighbour(SPACING), neighbour(-SPACING));
            let [high, low] = [&above, &below].map(|m| start(m, record).0.vector());
            set(&mut begin, lane, &slope(&high, &low).map(|twice| 0.5 * twice));
            members.push((*parameter, above));
        }
        Self { members, begin, steps: Vec::with_capacity(capacity) }
    }
}

/// Writes the numbers of one direction.
fn set(lanes: &mut States, lane: usize, values: &[f64; STATES]) {
    for (row, value) in lanes.iter_mut().zip(values) {
        row[lane] = *value as f32;
    }
}

fn slope(moved: &[f64; STATES], base: &[f64; STATES]) -> [f64; STATES] {
    std::array::from_fn(|k| (moved[k] - base[k]) / SPACING)
}
