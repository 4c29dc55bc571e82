//! Signatures: what a small change of the model would do to the filter's innovations.
//!
//! With the gains frozen, the filter is a smooth map from the model to the innovations. This is its
//! derivative along any number of directions at once: a perturbation of the state is carried along by
//! the transition of each step, corrected by the same gains as the state, and fed by the direction.
//! With the innovation e = y - h x and the correction x + K e, a perturbation dx gives
//! de = -h dx - (direct change of the reading), dx <- dx + K de, dx <- A dx + B m.
//!
//! What a step does is worked out once, in double precision; directions then pass over the record a few at a
//! time, side by side in the processor's registers, in single precision. Perturbations fade, so that rounding does
//! not add up: it stays near a millionth of a signature.

mod step_slopes;

use effects::{FIELDS, Field};
use ode_sim::{OdeParameters, slot};
use physiology::Compartment;

use self::step_slopes::StepSlopes;
use crate::augmented::{AugmentedModel, GLUCOSE_FLOOR, INTERSTITIAL, Narrow, SENSOR, STATES};
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

/// Size of the differences along a field and along a parameter's logarithm where slopes are not written down:
/// far above rounding, far below the curvature of a step.
const SPACING: f64 = 1e-4;
/// Directions that are carried along together: as many numbers as the registers in use hold.
pub(crate) const LANES: usize = 8;
/// One number a direction.
pub(crate) type Lanes = [f32; LANES];

/// A perturbation of the state along [`LANES`] directions.
type States = [Lanes; STATES];

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
    let mut out = vec![Vec::new(); directions.len()];
    few_at_a_time(model, record, frozen, directions, |members, rows| {
        for (lane, member) in members.iter().enumerate() {
            out[*member] = rows.iter().map(|row| f64::from(row[lane])).collect();
        }
    })?;
    Ok(out)
}

/// As [`signatures`], of at most [`LANES`] directions at a time: `taken` is told which, and gets a row a step.
pub(crate) fn few_at_a_time(
    model: &AugmentedModel,
    record: &Observations,
    frozen: &Filtered,
    directions: &[Direction],
    mut taken: impl FnMut(&[usize], &[Lanes]),
) -> Result<(), GapError> {
    let steps = Steps::of(model, record, frozen, directions)?;
    let arch = pulp::Arch::new();
    let mut rows = vec![[0.0; LANES]; record.len()];
    for (place, members) in in_order(directions).chunks(LANES).enumerate() {
        let block = Block::of(&steps, place, members, directions, record.len());
        arch.dispatch(Passing { steps: &steps, block: &block, rows: &mut rows });
        taken(members, &rows);
    }
    Ok(())
}

/// Parameters first, as they were asked for; then courses, those of the same fields beside each other.
fn in_order(directions: &[Direction]) -> Vec<usize> {
    let mut places: Vec<usize> = (0..directions.len()).collect();
    places.sort_by_key(|place| match &directions[*place] {
        Direction::Parameter(_) => Vec::new(),
        Direction::Course(fields) => {
            std::iter::once(1).chain(fields.iter().map(|(field, _)| 2 + *field as usize)).collect()
        }
    });
    places
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

/// What one step does to perturbations, whatever their direction.
struct Step {
    transition: Narrow,
    /// 0 where the filter only predicted.
    gain: [f32; STATES],
    /// What a reading gains per mg/dL of interstitial glucose.
    sensor_gain: f32,
    /// Interstitial glucose as expected before the reading, mg/dL.
    expected: f32,
    scored: bool,
    /// Whether the correction was cut off at the lowest glucose.
    floored: bool,
}

/// What the steps of a record do.
struct Steps {
    each: Vec<Step>,
    /// For each field that is asked for, the derivative of the states it reaches, step by step; 0 where
    /// no course asks.
    fields: [Vec<f32>; FIELDS],
    /// The parameters that are asked for, [`LANES`] at a time.
    parameters: Vec<Parameters>,
}

/// The derivative of the start and of each step by some parameters.
struct Parameters {
    begin: States,
    steps: Vec<States>,
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
        let mut steps = Self {
            each: Vec::with_capacity(n),
            fields: std::array::from_fn(|_| Vec::new()),
            parameters: Vec::new(),
        };
        for some in neighbours.chunks(LANES) {
            let mut lanes = [[0.0; LANES]; STATES];
            for (lane, (parameter, above)) in some.iter().enumerate() {
                let below = model.with_parameters(|p| parameter.raised(p, -SPACING));
                let [above, below] = [above, &below].map(|m| start(m, record).0.vector());
                let central = slope(&above, &below).map(|twice| 0.5 * twice);
                set(&mut lanes, lane, &central);
            }
            steps.parameters.push(Parameters { begin: lanes, steps: Vec::with_capacity(n) });
        }
        let floor = model.plant().q1_at(GLUCOSE_FLOOR);
        for step in 0..n {
            let (state, input) = (&frozen.states[step], &record.inputs[step]);
            let modulation = record.modulation(step);
            let failed = |_| GapError::FilterNotFinite { person: record.person.clone(), step };
            let (following, transition) =
                model.linearised(state, input, modulation).map_err(failed)?;
            let gain = frozen.gains[step].as_ref();
            steps.each.push(Step {
                transition: transition.narrowed(),
                gain: gain.map_or([0.0; STATES], |gain| gain.gain.map(|k| k as f32)),
                sensor_gain: modulation[Field::SensorGain] as f32,
                expected: gain.map_or(0.0, |gain| expected(frozen, gain, step)) as f32,
                scored: frozen.innovations[step].is_some(),
                floored: gain.is_some() && state.body.q1 <= floor,
            });
            let base = following.vector();
            let known = StepSlopes::of(model, state, input, modulation, &following);
            for field in Field::ALL {
                let asked = &asked[field as usize];
                if asked.is_empty() {
                    continue;
                }
                let slopes = &mut steps.fields[field as usize];
                if !asked[step] {
                    slopes.extend(reached(field).iter().map(|_| 0.0));
                } else if let Some(known) = &known {
                    let slope = known.by_field(field);
                    slopes.extend(reached(field).iter().map(|k| slope[*k] as f32));
                } else {
                    let mut changed = *modulation;
                    changed[field] += SPACING;
                    let moved = model.step(state, input, &changed).map_err(failed)?.vector();
                    let slope = |k: &usize| ((moved[*k] - base[*k]) / SPACING) as f32;
                    slopes.extend(reached(field).iter().map(slope));
                }
            }
            for (some, parameters) in neighbours.chunks(LANES).zip(&mut steps.parameters) {
                let mut lanes = [[0.0; LANES]; STATES];
                for (lane, (parameter, neighbour)) in some.iter().enumerate() {
                    let slopes = match &known {
                        Some(known) => known.by_parameter(*parameter),
                        None => {
                            let moved = neighbour.step(state, input, modulation).map_err(failed)?;
                            slope(&moved.vector(), &base)
                        }
                    };
                    set(&mut lanes, lane, &slopes);
                }
                parameters.steps.push(lanes);
            }
        }
        Ok(steps)
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

/// Courses of one field, side by side.
struct Courses<'a> {
    field: Field,
    /// One row a step.
    rows: Vec<Lanes>,
    /// The derivatives of the states that the field reaches, step by step.
    slopes: &'a [f32],
}

/// What feeds at most [`LANES`] directions.
struct Block<'a> {
    parameters: Option<&'a Parameters>,
    /// Courses that change the state.
    feeding: Vec<Courses<'a>>,
    /// Courses that change the reading.
    read: Vec<Courses<'a>>,
}

impl<'a> Block<'a> {
    /// The block at `place` of the directions [`in_order`].
    fn of(
        steps: &'a Steps,
        place: usize,
        members: &[usize],
        directions: &[Direction],
        n: usize,
    ) -> Self {
        let mut block =
            Self { parameters: steps.parameters.get(place), feeding: Vec::new(), read: Vec::new() };
        for (lane, member) in members.iter().enumerate() {
            let Direction::Course(courses) = &directions[*member] else { continue };
            for (field, course) in courses {
                let all = if reads_only(*field) { &mut block.read } else { &mut block.feeding };
                let known = all.iter().position(|courses| courses.field == *field);
                let known = known.unwrap_or_else(|| {
                    let slopes = steps.fields[*field as usize].as_slice();
                    all.push(Courses { field: *field, rows: vec![[0.0; LANES]; n], slopes });
                    all.len() - 1
                });
                for (row, value) in all[known].rows.iter_mut().zip(course) {
                    row[lane] += *value as f32;
                }
            }
        }
        block
    }
}

/// Carries the directions of a block over the record: `rows` become the derivatives of the innovations.
///
/// Compiled for the instructions of the machine it runs on. Products and sums are rounded one by one on all
/// of them, so that they agree bit for bit.
struct Passing<'a> {
    steps: &'a Steps,
    block: &'a Block<'a>,
    rows: &'a mut [Lanes],
}

impl pulp::NullaryFnOnce for Passing<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { steps, block, rows } = self;
        let mut x = block.parameters.map_or([[0.0; LANES]; STATES], |p| p.begin);
        for (step, (of, row)) in steps.each.iter().zip(rows).enumerate() {
            let mut change = [0.0; LANES];
            for lane in 0..LANES {
                change[lane] = -of.sensor_gain * x[INTERSTITIAL][lane] - x[SENSOR][lane];
            }
            for read in &block.read {
                let factor = if read.field == Field::SensorGain { of.expected } else { 1.0 };
                let course = read.rows[step];
                for lane in 0..LANES {
                    change[lane] -= factor * course[lane];
                }
            }
            *row = if of.scored { change } else { [0.0; LANES] };
            for (row, k) in x.iter_mut().zip(of.gain) {
                *row = std::array::from_fn(|lane| row[lane] + k * change[lane]);
            }
            if of.floored {
                x[slot(Compartment::Q1)] = [0.0; LANES];
            }
            of.transition.carry(&mut x);
            for courses in &block.feeding {
                let reached = reached(courses.field);
                let slopes = &courses.slopes[step * reached.len()..][..reached.len()];
                let course = courses.rows[step];
                for (place, slope) in reached.iter().zip(slopes) {
                    let row = &mut x[*place];
                    *row = std::array::from_fn(|lane| row[lane] + slope * course[lane]);
                }
            }
            if let Some(parameters) = block.parameters {
                for (row, fed) in x.iter_mut().zip(&parameters.steps[step]) {
                    *row = std::array::from_fn(|lane| row[lane] + fed[lane]);
                }
            }
        }
    }
}

/// Interstitial glucose as expected before the reading: the state after it holds part of the innovation.
fn expected(frozen: &Filtered, gain: &Gain, step: usize) -> f64 {
    let correction = frozen.innovations[step].map_or(0.0, |i| gain.gain[INTERSTITIAL] * i.value);
    frozen.states[step].interstitial.0 - correction
}
