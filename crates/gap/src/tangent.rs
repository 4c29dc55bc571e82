//! Signatures: what a small change of the model would do to the filter's innovations.
//!
//! With the gains frozen, the filter is a smooth map from the model to the innovations. This is its
//! derivative along any number of directions at once: a perturbation of the state is carried along by
//! the transition of each step, corrected by the same gains as the state, and fed by the direction.
//! With the innovation e = y - h x and the correction x + K e, a perturbation dx gives
//! de = -h dx - (direct change of the reading), dx <- dx + K de, dx <- A dx + B m.
//!
//! One pass over the record serves all directions; nothing is stored but the result.

use effects::{FIELDS, Field, Modulation};
use ode_sim::OdeParameters;
use physiology::StepInput;

use crate::augmented::{AugmentedModel, AugmentedState, INTERSTITIAL, SENSOR, STATES, Transition};
use crate::error::GapError;
use crate::filter::Filtered;
use crate::observations::Observations;

/// A direction in which the model is changed.
#[derive(Debug, Clone)]
pub enum Direction {
    /// Time courses of modulation fields, one value a step: what is added to the field per unit of amplitude.
    Course(Vec<(Field, Vec<f64>)>),
    /// A parameter of the plant, for good: its logarithm is raised by the amplitude.
    Parameter(Parameter),
}

/// A parameter of the plant as a direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "the paper's symbols; see OdeParameters")]
pub enum Parameter {
    Action,
    Egp0,
    TMaxG,
    TMaxI,
    AG,
    F01,
    KA1,
    KA2,
    KA3,
    K12,
    KE,
    VG,
}

impl Parameter {
    /// The parameters with this one's logarithm raised by `by`.
    #[must_use]
    pub fn raised(self, p: &OdeParameters, by: f64) -> OdeParameters {
        let factor = by.exp();
        match self {
            Self::Action => p.with_sensitivity_scaled(factor),
            Self::Egp0 => OdeParameters { egp_0: p.egp_0 * factor, ..*p },
            Self::TMaxG => OdeParameters { t_max_g: p.t_max_g * factor, ..*p },
            Self::TMaxI => OdeParameters { t_max_i: p.t_max_i * factor, ..*p },
            Self::AG => OdeParameters { a_g: p.a_g * factor, ..*p },
            Self::F01 => OdeParameters { f_01: p.f_01 * factor, ..*p },
            Self::KA1 => OdeParameters { k_a1: p.k_a1 * factor, ..*p },
            Self::KA2 => OdeParameters { k_a2: p.k_a2 * factor, ..*p },
            Self::KA3 => OdeParameters { k_a3: p.k_a3 * factor, ..*p },
            Self::K12 => OdeParameters { k_12: p.k_12 * factor, ..*p },
            Self::KE => OdeParameters { k_e: p.k_e * factor, ..*p },
            Self::VG => OdeParameters { v_g: p.v_g * factor, ..*p },
        }
    }
}

/// Size of the differences along a field and along a parameter's logarithm: far above rounding, far below
/// the curvature of a step.
const SPACING: f64 = 1e-4;
/// Directions that are carried along together.
const LANES: usize = 8;

/// A perturbation of the state along [`LANES`] directions.
type Lanes = [[f64; LANES]; STATES];

/// Derivatives of the innovations along each direction, mg/dL per unit of amplitude.
///
/// One list a direction, one entry a step; 0 where `frozen` has no innovation. `record` is the one the
/// filter ran on, modulations included.
///
/// # Errors
/// [`GapError::FilterNotFinite`] with the step.
pub fn signatures(
    model: &AugmentedModel,
    record: &Observations,
    frozen: &Filtered,
    directions: &[Direction],
) -> Result<Vec<Vec<f64>>, GapError> {
    let n = record.len();
    let mut out = vec![vec![0.0; n]; directions.len()];
    let mut lanes: Vec<Lanes> = vec![[[0.0; LANES]; STATES]; directions.len().div_ceil(LANES)];
    let neighbours: Vec<Option<AugmentedModel>> = directions
        .iter()
        .map(|direction| match direction {
            Direction::Course(_) => None,
            Direction::Parameter(parameter) => {
                Some(model.with_parameters(|p| parameter.raised(p, SPACING)))
            }
        })
        .collect();
    for step in 0..n {
        let modulation = record.modulation(step);
        let state = &frozen.states[step];
        observe(step, modulation, state, frozen, directions, &mut lanes, &mut out);
        let input = &record.inputs[step];
        let failed = |_| GapError::FilterNotFinite { person: record.person.clone(), step };
        let (following, transition) = model.linearised(state, input, modulation).map_err(failed)?;
        for block in &mut lanes {
            *block = carried(&transition, block);
        }
        let base = following.vector();
        let mut slopes = Slopes { model, state, input, modulation, base, known: [None; FIELDS] };
        for (place, direction) in directions.iter().enumerate() {
            let (block, lane) = (&mut lanes[place / LANES], place % LANES);
            match direction {
                Direction::Course(courses) => {
                    for (field, course) in courses {
                        let value = course[step];
                        if value != 0.0 && !reads_only(*field) {
                            let slope = slopes.along(*field).map_err(failed)?;
                            for (row, slope) in block.iter_mut().zip(slope) {
                                row[lane] += slope * value;
                            }
                        }
                    }
                }
                Direction::Parameter(_) => {
                    if let Some(neighbour) = &neighbours[place] {
                        let moved =
                            neighbour.step(state, input, modulation).map_err(failed)?.vector();
                        for ((row, moved), base) in block.iter_mut().zip(moved).zip(base) {
                            row[lane] += (moved - base) / SPACING;
                        }
                    }
                }
            }
        }
    }
    Ok(out)
}

/// Whether a field changes the reading and not the state.
fn reads_only(field: Field) -> bool {
    matches!(field, Field::SensorGain | Field::SensorOffset)
}

/// The reading of a step: what each direction does to the innovation, and the gain's answer.
fn observe(
    step: usize,
    modulation: &Modulation,
    state: &AugmentedState,
    frozen: &Filtered,
    directions: &[Direction],
    lanes: &mut [Lanes],
    out: &mut [Vec<f64>],
) {
    let Some(gain) = &frozen.gains[step] else { return };
    let scored = frozen.innovations[step].is_some();
    // What was expected before the reading: the state after it holds part of the innovation itself.
    let correction = frozen.innovations[step].map_or(0.0, |i| gain.gain[INTERSTITIAL] * i.value);
    let expected = state.interstitial.0 - correction;
    for (block, (lanes, directions)) in lanes.iter_mut().zip(directions.chunks(LANES)).enumerate() {
        let mut change = [0.0; LANES];
        for lane in 0..LANES {
            change[lane] =
                -modulation[Field::SensorGain] * lanes[INTERSTITIAL][lane] - lanes[SENSOR][lane];
        }
        for (lane, direction) in directions.iter().enumerate() {
            if let Direction::Course(courses) = direction {
                for (field, course) in courses {
                    match field {
                        Field::SensorGain => change[lane] -= course[step] * expected,
                        Field::SensorOffset => change[lane] -= course[step],
                        _ => {}
                    }
                }
            }
            if scored {
                out[block * LANES + lane][step] = change[lane];
            }
        }
        for (row, k) in lanes.iter_mut().zip(gain.gain) {
            for (value, change) in row.iter_mut().zip(change) {
                *value += k * change;
            }
        }
    }
}

/// Perturbations one step later.
fn carried(transition: &Transition, lanes: &Lanes) -> Lanes {
    let mut following = [[0.0; LANES]; STATES];
    for (row, values) in following.iter_mut().enumerate() {
        for column in Transition::NONZERO[row] {
            let a = transition.get(row, *column);
            for (value, before) in values.iter_mut().zip(lanes[*column]) {
                *value += a * before;
            }
        }
    }
    following
}

/// Derivatives of one step along the fields, taken when first asked for.
struct Slopes<'a> {
    model: &'a AugmentedModel,
    state: &'a AugmentedState,
    input: &'a StepInput,
    modulation: &'a Modulation,
    base: [f64; STATES],
    known: [Option<[f64; STATES]>; FIELDS],
}

impl Slopes<'_> {
    fn along(&mut self, field: Field) -> Result<[f64; STATES], ode_sim::OdeError> {
        if let Some(known) = self.known[field as usize] {
            return Ok(known);
        }
        let mut moved = *self.modulation;
        moved[field] += SPACING;
        let after = self.model.step(self.state, self.input, &moved)?.vector();
        let slope = std::array::from_fn(|k| (after[k] - self.base[k]) / SPACING);
        self.known[field as usize] = Some(slope);
        Ok(slope)
    }
}
