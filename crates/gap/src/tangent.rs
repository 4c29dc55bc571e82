//! Signatures: what a small change of the model would do to the filter's innovations.
//!
//! With the gains frozen, the filter is a smooth map from the model to the innovations. This is its
//! derivative along any number of directions at once: a perturbation of the state is carried along by
//! the transition of each step, corrected by the same gains as the state, and fed by the direction.
//! With the innovation e = y - h x and the correction x + K e, a perturbation dx gives
//! de = -h dx - (direct change of the reading), dx <- dx + K de, dx <- A dx + B m.
//!
//! What a step does is worked out once; directions then pass over the record a few at a time, so that what
//! they share stays near the processor.

use effects::{FIELDS, Field};
use ode_sim::equations::{endogenous_production, non_insulin_uptake};
use ode_sim::exercise::ExerciseMemory;
use ode_sim::gut::glucose_dose;
use ode_sim::{EgpMode, OdeParameters, OdeState, slot};
use physiology::{Compartment, MG_PER_DL_PER_MMOL_PER_L, STEP, StepInput};

use crate::augmented::{
    AugmentedModel, AugmentedState, GLUCOSE_FLOOR, INTERSTITIAL, SENSOR, STATES, Transition,
};
use crate::covariance::Gain;
use crate::error::GapError;
use crate::filter::{Filtered, start};
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
/// filter ran on, modulations included. A parameter also changes where the filter starts.
///
/// # Errors
/// [`GapError::FilterNotFinite`] with the step.
pub fn signatures(
    model: &AugmentedModel,
    record: &Observations,
    frozen: &Filtered,
    directions: &[Direction],
) -> Result<Vec<Vec<f64>>, GapError> {
    let steps = Steps::of(model, record, frozen, directions)?;
    let mut out = Vec::with_capacity(directions.len());
    for block in directions.chunks(LANES) {
        out.append(&mut carried_along(&steps, record, frozen, block));
    }
    Ok(out)
}

/// Whether a field changes the reading and not the state.
fn reads_only(field: Field) -> bool {
    matches!(field, Field::SensorGain | Field::SensorOffset)
}

/// The states that a field changes within a step.
fn reached(field: Field) -> &'static [usize] {
    const S1: usize = slot(Compartment::S1);
    const S2: usize = slot(Compartment::S2);
    const I: usize = slot(Compartment::I);
    const X1: usize = slot(Compartment::X1);
    const X2: usize = slot(Compartment::X2);
    const X3: usize = slot(Compartment::X3);
    const Q1: usize = slot(Compartment::Q1);
    const C1: usize = slot(Compartment::C1);
    const C2: usize = slot(Compartment::C2);
    match field {
        Field::InsulinInput => &[S1],
        Field::InsulinTime => &[S1, S2, I],
        Field::Action => &[X1, X2],
        Field::LiverAction => &[X3],
        Field::GutTime => &[Q1, C1, C2, INTERSTITIAL],
        Field::CarbAmount | Field::ExtraCarbs => &[C1, C2],
        Field::Production
        | Field::Flux
        | Field::LowGlucoseProduction
        | Field::RenalRate
        | Field::RenalThreshold => &[Q1, INTERSTITIAL],
        Field::SensorLag => &[INTERSTITIAL],
        Field::SensorGain | Field::SensorOffset => &[],
    }
}

/// What a step of the record does to perturbations, whatever their direction.
struct Steps {
    transitions: Vec<Transition>,
    /// For each field that is asked for, the derivative of the states it reaches, step by step; 0 where
    /// no course asks.
    fields: [Vec<f64>; FIELDS],
    /// For each parameter that is asked for, the derivative of the start and of each step.
    parameters: Vec<(Parameter, [f64; STATES], Vec<[f64; STATES]>)>,
    /// Whether the correction of a step was cut off at the lowest glucose.
    floored: Vec<bool>,
}

impl Steps {
    fn of(
        model: &AugmentedModel,
        record: &Observations,
        frozen: &Filtered,
        directions: &[Direction],
    ) -> Result<Self, GapError> {
        let n = record.len();
        let mut asked: [Vec<bool>; FIELDS] = std::array::from_fn(|_| Vec::new());
        let mut neighbours = Vec::new();
        for direction in directions {
            match direction {
                Direction::Course(courses) => {
                    for (field, course) in courses.iter().filter(|(field, _)| !reads_only(*field)) {
                        let asked = &mut asked[*field as usize];
                        asked.resize(n, false);
                        for (asked, value) in asked.iter_mut().zip(course) {
                            *asked |= *value != 0.0;
                        }
                    }
                }
                Direction::Parameter(parameter) => {
                    neighbours.push((
                        *parameter,
                        model.with_parameters(|p| parameter.raised(p, SPACING)),
                    ));
                }
            }
        }
        let begin = start(model, record).0.vector();
        let mut steps = Self {
            transitions: Vec::with_capacity(n),
            fields: std::array::from_fn(|_| Vec::new()),
            parameters: neighbours
                .iter()
                .map(|(parameter, neighbour)| {
                    let moved = start(neighbour, record).0.vector();
                    (*parameter, slope(&moved, &begin), Vec::with_capacity(n))
                })
                .collect(),
            floored: Vec::with_capacity(n),
        };
        let floor = model.plant().q1_at(GLUCOSE_FLOOR);
        for step in 0..n {
            let (state, input) = (&frozen.states[step], &record.inputs[step]);
            let modulation = record.modulation(step);
            let failed = |_| GapError::FilterNotFinite { person: record.person.clone(), step };
            let (following, transition) =
                model.linearised(state, input, modulation).map_err(failed)?;
            steps.transitions.push(transition);
            steps.floored.push(frozen.gains[step].is_some() && state.body.q1 <= floor);
            let base = following.vector();
            for field in Field::ALL {
                let asked = &asked[field as usize];
                if asked.is_empty() {
                    continue;
                }
                let slopes = &mut steps.fields[field as usize];
                if asked[step] {
                    let mut changed = *modulation;
                    changed[field] += SPACING;
                    let moved = model.step(state, input, &changed).map_err(failed)?.vector();
                    slopes.extend(reached(field).iter().map(|k| (moved[*k] - base[*k]) / SPACING));
                } else {
                    slopes.extend(reached(field).iter().map(|_| 0.0));
                }
            }
            let plain =
                modulation.is_neutral().then(|| PlainStep::of(model, state, input)).flatten();
            for ((parameter, neighbour), (_, _, slopes)) in
                neighbours.iter().zip(&mut steps.parameters)
            {
                if let Some(known) = plain.as_ref().and_then(|plain| plain.slope(*parameter)) {
                    slopes.push(known);
                    continue;
                }
                let moved = neighbour.step(state, input, modulation).map_err(failed)?.vector();
                slopes.push(slope(&moved, &base));
            }
        }
        Ok(steps)
    }
}

fn slope(moved: &[f64; STATES], base: &[f64; STATES]) -> [f64; STATES] {
    std::array::from_fn(|k| (moved[k] - base[k]) / SPACING)
}

/// A step without modulation, exercise and rescue carbohydrate, whose derivatives by the calibrated
/// parameters are written down: they are asked for in every iteration of a calibration.
struct PlainStep<'a> {
    p: &'a OdeParameters,
    body: &'a OdeState,
    egp: EgpMode,
    /// What is eaten, mmol/kg.
    meal: f64,
    /// Share of the gut's content that stays through the step.
    left: f64,
    /// What interstitial glucose gains per Q1 gained, mg/dL per mmol/kg.
    share: f64,
}

impl<'a> PlainStep<'a> {
    fn of(model: &'a AugmentedModel, state: &'a AugmentedState, input: &StepInput) -> Option<Self> {
        let (plant, body) = (model.plant(), &state.body);
        let moving = body.exercise != ExerciseMemory::Rest || input.exercise.is_some();
        if moving || !body.rescue.is_empty() || input.rescue.amount.0 != 0.0 {
            return None;
        }
        let p = &plant.parameters;
        Some(Self {
            p,
            body,
            egp: plant.egp,
            meal: p.a_g * glucose_dose(input.carbs, plant.weight),
            left: (-STEP.0 / p.t_max_g).exp(),
            share: 0.5 * (1.0 - model.lag_decay()) * MG_PER_DL_PER_MMOL_PER_L / p.v_g,
        })
    }

    /// The derivative of the state after the step by the logarithm of a parameter, `None` where it is not
    /// written down. By the equations of [`ode_sim::equations::derivative`] and the gut's exact flow.
    fn slope(&self, parameter: Parameter) -> Option<[f64; STATES]> {
        use Compartment::{C1, C2, I, Q1, S1, S2, X1, X2, X3};
        let (p, x) = (self.p, self.body);
        let mut slope = [0.0; STATES];
        match parameter {
            Parameter::Action => {
                slope[slot(X1)] = STEP.0 * p.k_a1 * p.s_f1 * x.i;
                slope[slot(X2)] = STEP.0 * p.k_a2 * p.s_f2 * x.i;
                slope[slot(X3)] = STEP.0 * p.k_a3 * p.s_f3 * x.i;
            }
            Parameter::Egp0 => {
                slope[slot(Q1)] = STEP.0 * endogenous_production(x.x3, p.egp_0, self.egp);
            }
            Parameter::F01 => {
                slope[slot(Q1)] = -STEP.0 * non_insulin_uptake(x.q1 / p.v_g, p.f_01);
            }
            Parameter::TMaxI => {
                slope[slot(S1)] = STEP.0 * x.s1 / p.t_max_i;
                slope[slot(S2)] = STEP.0 * (x.s2 - x.s1) / p.t_max_i;
                slope[slot(I)] = -STEP.0 * x.s2 / (p.t_max_i * p.v_i);
            }
            Parameter::AG => {
                slope[slot(C1)] = self.left * self.meal;
                slope[slot(C2)] = self.left * self.meal * STEP.0 / p.t_max_g;
            }
            Parameter::TMaxG => {
                let (turns, fed) = (STEP.0 / p.t_max_g, x.meals.c1 + self.meal);
                slope[slot(Q1)] = -turns * x.meals.c2;
                slope[slot(C1)] = self.left * turns * fed;
                slope[slot(C2)] = self.left * turns * (x.meals.c2 + fed * turns - fed);
            }
            _ => return None,
        }
        slope[INTERSTITIAL] = self.share * slope[slot(Q1)];
        Some(slope)
    }
}

/// What feeds one direction: courses with the slopes of their fields, or the slopes of a parameter.
enum Source<'a> {
    Courses(Vec<(&'a [f64], &'static [usize], &'a [f64])>),
    Parameter(&'a [[f64; STATES]]),
}

/// Derivatives of the innovations along at most [`LANES`] directions.
fn carried_along(
    steps: &Steps,
    record: &Observations,
    frozen: &Filtered,
    directions: &[Direction],
) -> Vec<Vec<f64>> {
    let n = record.len();
    let mut out: Vec<Vec<f64>> = directions.iter().map(|_| vec![0.0; n]).collect();
    let mut lanes: Lanes = [[0.0; LANES]; STATES];
    let mut sources = Vec::with_capacity(LANES);
    // Direct changes of the reading: lane, field, course.
    let mut read = Vec::new();
    for (lane, direction) in directions.iter().enumerate() {
        match direction {
            Direction::Course(courses) => {
                let mut feeding = Vec::new();
                for (field, course) in courses {
                    if reads_only(*field) {
                        read.push((lane, *field, course.as_slice()));
                    } else {
                        let slopes = steps.fields[*field as usize].as_slice();
                        feeding.push((course.as_slice(), reached(*field), slopes));
                    }
                }
                sources.push(Source::Courses(feeding));
            }
            Direction::Parameter(parameter) => {
                let known = steps.parameters.iter().find(|known| known.0 == *parameter);
                if let Some((_, begin, slopes)) = known {
                    for (row, value) in lanes.iter_mut().zip(begin) {
                        row[lane] = *value;
                    }
                    sources.push(Source::Parameter(slopes));
                }
            }
        }
    }
    for step in 0..n {
        if let Some(gain) = &frozen.gains[step] {
            let sensor_gain = record.modulation(step)[Field::SensorGain];
            let mut change = [0.0; LANES];
            for lane in 0..LANES {
                change[lane] = -sensor_gain * lanes[INTERSTITIAL][lane] - lanes[SENSOR][lane];
            }
            for (lane, field, course) in &read {
                change[*lane] -= match field {
                    Field::SensorGain => course[step] * expected(frozen, gain, step),
                    _ => course[step],
                };
            }
            if frozen.innovations[step].is_some() {
                for (out, change) in out.iter_mut().zip(change) {
                    out[step] = change;
                }
            }
            for (row, k) in lanes.iter_mut().zip(gain.gain) {
                for (value, change) in row.iter_mut().zip(change) {
                    *value += k * change;
                }
            }
            if steps.floored[step] {
                lanes[slot(Compartment::Q1)] = [0.0; LANES];
            }
        }
        steps.transitions[step].carry(&mut lanes);
        for (lane, source) in sources.iter().enumerate() {
            match source {
                Source::Courses(courses) => {
                    for (course, reached, slopes) in courses {
                        let value = course[step];
                        if value != 0.0 {
                            let slopes = &slopes[step * reached.len()..][..reached.len()];
                            for (row, slope) in reached.iter().zip(slopes) {
                                lanes[*row][lane] += slope * value;
                            }
                        }
                    }
                }
                Source::Parameter(slopes) => {
                    for (row, slope) in lanes.iter_mut().zip(slopes[step]) {
                        row[lane] += slope;
                    }
                }
            }
        }
    }
    out
}

/// Interstitial glucose as expected before the reading: the state after it holds part of the innovation.
fn expected(frozen: &Filtered, gain: &Gain, step: usize) -> f64 {
    let correction = frozen.innovations[step].map_or(0.0, |i| gain.gain[INTERSTITIAL] * i.value);
    frozen.states[step].interstitial.0 - correction
}
