//! Signatures: what a small change of the model would do to the filter's innovations.
//!
//! With the gains frozen, the filter is a smooth map from the model to the innovations. This is its
//! derivative along any number of directions at once: a perturbation of the state is carried along by
//! the transition of each step, corrected by the same gains as the state, and fed by the direction.
//! With the innovation e = y - h x and the correction x + K e, a perturbation dx gives
//! de = -h dx - (direct change of the reading), dx <- dx + K de, dx <- A dx + B m.
//!
//! What a step does is worked out once, in double precision, by the filter itself where directions are known
//! before it runs; directions then pass over the record a few at a time, side by side in the processor's
//! registers, in single precision. Perturbations fade, so that rounding does
//! not add up: it stays near a millionth of a signature.

mod adjoint;
mod pass;
mod step_slopes;
mod steps;

use effects::Field;
use ode_sim::{OdeParameters, Scalar};

pub(crate) use self::adjoint::course_scores;
use self::pass::passes;
use self::steps::Steps;
use crate::error::GapError;
use crate::filter::augmented::AugmentedModel;
use crate::filter::kalman::{Begin, Filtered, Innovation, run_from};
use crate::filter::observations::Observations;
use crate::filter::state::STATES;

/// A direction in which the model is changed.
#[derive(Debug, Clone)]
pub enum Direction {
    /// Time courses of modulation fields, one value a step: what is added to the field per unit of amplitude.
    Course(Vec<(Field, Vec<f64>)>),
    /// One field in pulses of height 1, some steps long, from a first step on and again every so many steps.
    Pulses {
        /// The field.
        field: Field,
        /// Step at which the first pulse starts.
        first: usize,
        /// Steps from one start to the next; at least one.
        every: usize,
        /// Steps that a pulse lasts.
        length: usize,
    },
    /// A parameter of the plant, for good: its logarithm is raised by the amplitude.
    Parameter(Parameter),
}

impl Direction {
    /// Visits what is added to fields in a record of `n` steps: a field, a first step, and a value for each step from there
    /// on. A parameter adds nothing.
    fn additions(&self, n: usize, mut visit: impl FnMut(Field, usize, &[f64])) {
        match self {
            Self::Course(courses) => {
                courses.iter().for_each(|(field, course)| visit(*field, 0, course));
            }
            Self::Pulses { field, first, every, length } => {
                let pulse = vec![1.0; (*length).min(n)];
                for start in (*first..n).step_by((*every).max(1)) {
                    visit(*field, start, &pulse[..pulse.len().min(n - start)]);
                }
            }
            Self::Parameter(_) => {}
        }
    }
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
        self.times(p, by.exp())
    }

    /// The parameters with this one multiplied by a factor.
    fn times<T: Scalar>(self, p: &OdeParameters<T>, factor: T) -> OdeParameters<T> {
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

/// Directions that are carried along together: as many numbers as the registers in use hold.
pub(crate) const LANES: usize = 8;
/// One number a direction.
pub(crate) type Lanes = [f32; LANES];

/// A perturbation of the state along [`LANES`] directions.
type States = [Lanes; STATES];

/// Steps that are worked out before directions pass over them while the filter runs: few enough to stay in
/// the processor's nearest memory.
const AT_ONCE: usize = 16;

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

/// As [`signatures`], of at most [`LANES`] directions at a time: `taken` gets their indices and a row a step.
pub(crate) fn few_at_a_time(
    model: &AugmentedModel,
    record: &Observations,
    frozen: &Filtered,
    directions: &[Direction],
    mut taken: impl FnMut(&[usize], &[Lanes]),
) -> Result<(), GapError> {
    let steps = Steps::of_run(model, record, frozen, directions)?;
    let mut rows = Vec::with_capacity(record.len());
    for mut pass in passes(&steps, directions) {
        rows.clear();
        pass.over(&steps, &mut rows);
        taken(&pass.members, &rows);
    }
    Ok(())
}

/// A run of the filter with directions carried along in the same pass.
pub(crate) struct Along {
    /// What [`filter`](crate::filter::kalman::filter) makes of the record.
    pub(crate) filtered: Filtered,
    /// What [`few_at_a_time`] gives of it: indices of directions, and a row a step.
    pub(crate) blocks: Vec<(Vec<usize>, Vec<Lanes>)>,
    /// One for each step that was asked for, but the first of the record.
    pub(crate) forks: Vec<Fork>,
}

/// A step at which the filter and directions can take another way.
#[derive(Debug, Clone)]
pub(crate) struct Fork {
    begin: Begin,
    /// Of the first [`LANES`] directions.
    x: States,
}

/// Runs the filter and carries directions along; `at` are the steps of the forks.
///
/// For a handful of directions: their derivatives are all held at once.
pub(crate) fn filtered_along(
    model: &AugmentedModel,
    record: &Observations,
    directions: &[Direction],
    at: &[usize],
) -> Result<Along, GapError> {
    let n = record.len();
    let mut steps = Steps::new(model, record, directions, AT_ONCE.min(n));
    let mut passes: Vec<_> =
        passes(&steps, directions).map(|pass| (pass, Vec::with_capacity(n))).collect();
    let mut filtered = Filtered::with_capacity(n);
    let mut forks = Vec::with_capacity(at.len());
    let mut at = at.iter().copied().skip_while(|step| *step == 0).peekable();
    run_from(model, record, Begin::of(model, record), None, n, |step, covariance| {
        filtered.push(&step);
        steps.push(&step)?;
        let next = step.step + 1;
        let fork = at.next_if_eq(&next).is_some();
        if steps.each.len() == AT_ONCE || next == n || fork {
            for (pass, rows) in &mut passes {
                pass.over(&steps, rows);
            }
            steps.clear();
        }
        if let Some((pass, _)) = passes.first().filter(|_| fork) {
            let begin = Begin { step: next, state: *step.following, covariance: *covariance };
            forks.push(Fork { begin, x: pass.x });
        }
        Ok(())
    })?;
    let blocks = passes.into_iter().map(|(pass, rows)| (pass.members, rows)).collect();
    Ok(Along { filtered, blocks, forks })
}

/// Filters from each fork on, for at most `reach` steps, without the meal at its step; `directions` are those of the forks,
/// at most [`LANES`]. `taken` gets the fork's step, the innovations from there on and their derivatives. A fork from which
/// the record cannot be filtered is passed over.
pub(crate) fn without_meals(
    model: &AugmentedModel,
    record: &Observations,
    directions: &[Direction],
    forks: &[Fork],
    reach: usize,
    mut taken: impl FnMut(usize, &[Option<Innovation>], &[Lanes]),
) {
    let n = record.len();
    let mut steps = Steps::new(model, record, directions, AT_ONCE.min(n));
    let Some(mut pass) = passes(&steps, directions).next() else { return };
    let (mut innovations, mut rows) = (Vec::with_capacity(reach), Vec::with_capacity(reach));
    for Fork { begin, x } in forks {
        let (step, end) = (begin.step, n.min(begin.step + reach));
        innovations.clear();
        rows.clear();
        steps.clear_before(step);
        pass.x = *x;
        let mut input = record.inputs[step];
        input.carbs.0 = 0.0;
        let run = run_from(model, record, begin.clone(), Some(input), end, |step, _| {
            innovations.push(step.innovation);
            steps.push(&step)?;
            if steps.each.len() == AT_ONCE || step.step + 1 == end {
                pass.over(&steps, &mut rows);
                steps.clear();
            }
            Ok(())
        });
        if run.is_ok() {
            taken(step, &innovations, &rows);
        }
    }
}

/// Whether a field changes the reading and not the state.
fn reads_only(field: Field) -> bool {
    matches!(field, Field::SensorGain | Field::SensorOffset)
}

#[cfg(test)]
pub(crate) mod tests {
    use effects::Modulation;
    use physiology::{Grams, Kilograms, MgPerDl, StepInput, Units, UnitsPerHour};

    use super::*;
    use crate::filter::kalman::filter;
    use crate::filter::noise::NoiseModel;
    use crate::filter::observations::Reading;

    /// A record in which much happens.
    pub(crate) fn record(n: usize) -> Observations {
        let wave = |k: usize| (0.4 * k as f64).sin();
        let reading = |k: usize| match k % 7 {
            3 => Reading::Missing,
            _ => Reading::Within(MgPerDl(150.0 + 110.0 * wave(k))),
        };
        let modulation = |k: usize| {
            let mut modulation = Modulation::NEUTRAL;
            modulation[Field::Production] = 1.0 + 0.2 * wave(2 * k);
            modulation
        };
        Observations {
            person: "p".into(),
            weight: Kilograms(70.0),
            readings: (0..n).map(reading).collect(),
            inputs: (0..n)
                .map(|k| StepInput {
                    basal: UnitsPerHour(1.0),
                    bolus: Units(if k == 9 { 4.0 } else { 0.0 }),
                    carbs: Grams(if k == 10 { 40.0 } else { 0.0 }),
                    ..StepInput::default()
                })
                .collect(),
            doses_recorded: vec![true; n],
            modulations: (0..n).map(modulation).collect(),
            interpolated_share: 0.0,
        }
    }

    #[test]
    fn directions_carried_with_the_filter_are_those_carried_after_it() {
        // No multiple of what is worked out at once, and more directions than fit side by side.
        let n = 3 * AT_ONCE + 5;
        let wave = |k: usize| (0.4 * k as f64).sin();
        let record = record(n);
        let parameters = OdeParameters::nominal();
        let noise = NoiseModel::working();
        let model = AugmentedModel::new(parameters, record.weight, noise);
        let parameters = [Parameter::Action, Parameter::TMaxG, Parameter::VG, Parameter::K12];
        let mut directions: Vec<Direction> =
            parameters.into_iter().map(Direction::Parameter).collect();
        directions.push(Direction::Pulses { field: Field::Flux, first: 3, every: 20, length: 4 });
        directions.extend(Field::ALL.map(|field| {
            let course = (0..n).map(|k| if k % 5 == 0 { 0.0 } else { wave(k) }).collect();
            Direction::Course(vec![(field, course)])
        }));
        let frozen = filter(&model, &record).expect("finite");
        let mut after = Vec::new();
        few_at_a_time(&model, &record, &frozen, &directions, |members, rows| {
            after.push((members.to_vec(), rows.to_vec()));
        })
        .expect("finite");
        let Along { filtered, blocks: along, .. } =
            filtered_along(&model, &record, &directions, &[]).expect("finite");
        assert_eq!(along.len(), 3);
        assert_eq!(along, after);
        assert!(along.iter().all(|(_, rows)| rows.iter().flatten().any(|value| *value != 0.0)));
        assert_eq!(filtered.states, frozen.states);
        assert_eq!(filtered.gains, frozen.gains);
        assert_eq!(filtered.innovations, frozen.innovations);
    }

    #[test]
    fn from_a_fork_on_a_meal_is_left_out_as_in_a_record_without_it() {
        let n = 3 * AT_ONCE + 5;
        let record = record(n);
        let (weight, noise) = (record.weight, NoiseModel::working());
        let model = AugmentedModel::new(OdeParameters::nominal(), weight, noise);
        let directions = [Parameter::Action, Parameter::TMaxG].map(Direction::Parameter);
        let along = |record: &Observations, at: &[usize]| {
            filtered_along(&model, record, &directions, at).expect("finite")
        };
        let Along { forks, blocks: with, .. } = along(&record, &[0, 10]);
        assert_eq!(forks.len(), 1);
        let mut struck = record.clone();
        struck.inputs[10].carbs.0 = 0.0;
        let Along { filtered, blocks: without, .. } = along(&struck, &[]);
        assert_ne!(without, with);
        let (_, rows) = &without[0];
        let mut visited = 0;
        without_meals(&model, &record, &directions, &forks, 40, |step, innovations, along| {
            let steps = step..step + 40;
            assert_eq!(step, 10);
            assert_eq!(innovations, &filtered.innovations[steps.clone()]);
            assert_eq!(along, &rows[steps]);
            visited += 1;
        });
        assert_eq!(visited, 1);
    }

    #[test]
    fn pulses_are_the_course_that_they_make_up() {
        let n = 70;
        let record = record(n);
        let (weight, noise) = (record.weight, NoiseModel::working());
        let model = AugmentedModel::new(OdeParameters::nominal(), weight, noise);
        let frozen = filter(&model, &record).expect("finite");
        for field in [Field::ExtraCarbs, Field::SensorOffset] {
            let course = (0..n).map(|k| f64::from(u8::from(k >= 5 && (k - 5) % 21 < 6))).collect();
            let written_out = Direction::Course(vec![(field, course)]);
            let pulses = Direction::Pulses { field, first: 5, every: 21, length: 6 };
            let found =
                signatures(&model, &record, &frozen, &[written_out, pulses]).expect("finite");
            assert!(found[0].iter().any(|value| value.abs() > 0.1));
            assert_eq!(found[0], found[1], "{field:?}");
        }
    }
}
