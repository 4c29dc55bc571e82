//! The linear model of a person's innovations: what every effect and the background would do to them.
//!
//! Rows are steps, whitened and in units of the innovations' scale; columns are directions. Nothing
//! is decided here.

use std::ops::Range;

use cohort::Person;
use effects::{Course, Effect, EffectId, Field, Form, Modulation, RandomUnit};
use physiology::STEPS_PER_HOUR;

pub use crate::background::Background;
use crate::background::{background, hours};
use crate::calibrated_person::CalibratedPerson;
use crate::error::GapError;
pub use crate::event_bank::{EventBank, HiddenEvents};
use crate::filter::calibration::Calibration;
use crate::filter::kalman::Innovation;
use crate::filter::observations::Observations;
use crate::filter::tangent::{Direction, LANES, Lanes, few_at_a_time};
use crate::filter::whitening::huber_weight;

/// Amplitude over which a driver's slope is taken: half the published size.
const AMPLITUDE: f64 = 0.5;

/// Steps that the answer of the filter to a unit of a random factor is followed beyond it: 6 h.
const ANSWER: usize = 6 * STEPS_PER_HOUR;

/// Steps that are whitened before they are handed to their columns: they stay in the fastest cache.
const BATCH: usize = 64;

/// What a column of a design stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Column {
    /// A direction of the background.
    Background {
        /// Which one.
        which: Background,
        /// Standard deviation of its prior.
        prior_sd: f64,
    },
    /// A variant of a driven effect.
    Effect {
        /// The effect.
        effect: EffectId,
        /// Its variant.
        variant: usize,
    },
}

impl Column {
    /// Whether it is this direction of the background.
    pub(crate) fn is(&self, wanted: Background) -> bool {
        matches!(self, Self::Background { which, .. } if *which == wanted)
    }
}

/// A random effect: a factor that is drawn for every unit, and what a change of each unit's does.
#[derive(Debug, Clone)]
pub struct UnitBank {
    /// The effect.
    pub effect: EffectId,
    /// What varies.
    pub field: Field,
    /// Standard deviation of its logarithm at amplitude 1.
    pub log_sd: f64,
    /// First step of each unit, ascending.
    pub starts: Vec<usize>,
    /// Whitened signature of each unit's factor from its first step on.
    pub answers: Vec<Vec<f32>>,
}

/// A person's linear model.
#[derive(Debug, Clone)]
pub struct Design {
    /// Whitened innovations in units of their scale, one a step; 0 where not scored.
    pub residuals: Vec<f64>,
    /// Huber's weights; 0 where not scored.
    pub weights: Vec<f64>,
    /// What the columns stand for.
    pub columns: Vec<Column>,
    /// Signatures, a list a column, an entry a step; single precision halves what a large cohort takes.
    pub signatures: Vec<Vec<f32>>,
    /// Hidden events, to be scored against what the background leaves.
    pub events: HiddenEvents,
    /// Random effects.
    pub random: Vec<UnitBank>,
    /// Effects that the record cannot show.
    pub untried: Vec<EffectId>,
}

/// The linear model of a calibrated person.
///
/// # Errors
/// As [`signatures`](crate::filter::tangent::signatures).
pub fn design(person: &CalibratedPerson<'_>, library: &[&dyn Effect]) -> Result<Design, GapError> {
    let CalibratedPerson { person: Person { record, .. }, observations, calibration } = *person;
    let course = person.course();
    let mut columns = Vec::new();
    let mut directions = Vec::new();
    for (which, prior_sd, direction) in background(observations, &hours(record), &course.glucose) {
        columns.push(Column::Background { which, prior_sd });
        directions.push(direction);
    }
    let (mut events, mut random, mut untried) = (Vec::new(), Vec::new(), Vec::new());
    let mut steps = vec![Modulation::NEUTRAL; course.len()];
    for effect in library {
        let id = effect.card().id;
        match effect.form(&course) {
            None => untried.push(id),
            Some(Form::Driven) => {
                for variant in 0..effect.variants_for(&course) {
                    columns.push(Column::Effect { effect: id, variant });
                    directions.push(driven(*effect, variant, &course, &mut steps));
                }
            }
            Some(Form::Events(shape)) => events.push((id, shape)),
            Some(Form::Random { field, unit, log_sd }) => {
                let units = unit_steps(unit, 0..course.len(), &course);
                random.push((id, field, log_sd, units));
            }
        }
    }
    let driven = directions.len();
    let mut events = HiddenEvents::of(events, course.len());
    directions.extend(events.directions());
    let events_end = directions.len();
    // The direction of each unit of the random effects.
    let mut lanes: Vec<Vec<usize>> = Vec::new();
    for (_, field, _, units) in &random {
        let (first, own) = (directions.len(), packed(units.iter().map(answered)));
        directions.extend(factors(units, &own, *field, observations));
        lanes.push(own.into_iter().map(|lane| first + lane).collect());
    }
    let whitener = Whitener::of(calibration);
    let mut whitened: Vec<Vec<f32>> = vec![Vec::new(); directions.len()];
    let (model, filtered) = (&calibration.model, &calibration.filtered);
    few_at_a_time(model, observations, filtered, &directions, |members, raw| {
        for (member, column) in members.iter().zip(whitener.columns(raw)) {
            whitened[*member] = column;
        }
    })?;
    let mut banks = Vec::with_capacity(random.len());
    for ((effect, field, log_sd, units), lanes) in random.into_iter().zip(lanes) {
        let answer = |(unit, lane): (&Range<usize>, usize)| {
            let end = answered(unit).end.min(course.len());
            whitened[lane][unit.start..end].to_vec()
        };
        let answers = units.iter().zip(lanes).map(answer).collect();
        let starts = units.iter().map(|unit| unit.start).collect();
        banks.push(UnitBank { effect, field, log_sd, starts, answers });
    }
    whitened.truncate(events_end);
    events.answered(whitened.split_off(driven));
    let residuals: Vec<f64> = calibration.whitened.iter().map(|w| w.unwrap_or(0.0)).collect();
    let weights: Vec<f64> =
        calibration.whitened.iter().map(|w| w.map_or(0.0, |w| huber_weight(w, 1.0))).collect();
    let signatures = whitened;
    Ok(Design { residuals, weights, columns, signatures, events, random: banks, untried })
}

/// Brings signatures into the units of the whitened innovations.
pub(crate) struct Whitener {
    spacing: usize,
    a1: f32,
    a2: f32,
    /// Over the standard deviation of each innovation; 0 where there is none.
    inverse: Vec<f32>,
    /// Over the scale of whitened innovations; 0 where they are not scored.
    scored: Vec<f32>,
}

impl Whitener {
    pub(crate) fn of(calibration: &Calibration) -> Self {
        let autoregression = &calibration.autoregression;
        let inverse = |i: &Option<Innovation>| i.map_or(0.0, |i| i.variance.sqrt().recip() as f32);
        let scale = calibration.scale.recip() as f32;
        Self {
            spacing: autoregression.spacing,
            a1: autoregression.a1 as f32,
            a2: autoregression.a2 as f32,
            inverse: calibration.filtered.innovations.iter().map(inverse).collect(),
            scored: calibration.whitened.iter().map(|w| w.map_or(0.0, |_| scale)).collect(),
        }
    }

    /// The transpose: what rows of factors on whitened innovations are as factors on the innovations themselves, 1/(mg/dL).
    pub(crate) fn back(&self, rows: &[Lanes]) -> Vec<Lanes> {
        let first = 2 * self.spacing;
        let at = |step: usize| match rows.get(step) {
            Some(row) if step >= first => row.map(|value| self.scored[step] * value),
            _ => [0.0; LANES],
        };
        (0..rows.len())
            .map(|step| {
                let (now, once, twice) =
                    (at(step), at(step + self.spacing), at(step + 2 * self.spacing));
                std::array::from_fn(|lane| {
                    self.inverse[step] * (now[lane] - self.a1 * once[lane] - self.a2 * twice[lane])
                })
            })
            .collect()
    }

    /// Whitens directions that lie side by side, a row a step, into a column each.
    fn columns(&self, raw: &[Lanes]) -> [Vec<f32>; LANES] {
        let mut columns: [Vec<f32>; LANES] = std::array::from_fn(|_| Vec::with_capacity(raw.len()));
        let mut rows = [[0.0; LANES]; BATCH];
        for first in (0..raw.len()).step_by(BATCH) {
            let count = BATCH.min(raw.len() - first);
            for (row, step) in rows.iter_mut().zip(first..first + count) {
                // What is whitened has both of the entries before it.
                if step < 2 * self.spacing {
                    continue;
                }
                let (earlier, before) = (step - 2 * self.spacing, step - self.spacing);
                let now = self.scored[step] * self.inverse[step];
                let once = self.scored[step] * self.a1 * self.inverse[before];
                let twice = self.scored[step] * self.a2 * self.inverse[earlier];
                *row = std::array::from_fn(|lane| {
                    now * raw[step][lane] - once * raw[before][lane] - twice * raw[earlier][lane]
                });
            }
            for (lane, column) in columns.iter_mut().enumerate() {
                column.extend(rows[..count].iter().map(|row| row[lane]));
            }
        }
        columns
    }
}

/// The slope of a driver. `steps` is scratch space for its modulations: neutral before and after.
fn driven(
    effect: &dyn Effect,
    variant: usize,
    course: &Course,
    steps: &mut [Modulation],
) -> Direction {
    effect.modulate(variant, AMPLITUDE, course, steps);
    let changed = Modulation::differing(steps.iter().map(|m| (m, &Modulation::NEUTRAL)));
    let change = |field: Field| {
        let changes = steps.iter_mut().map(|modulation| {
            let value = std::mem::replace(&mut modulation[field], field.neutral());
            (value - field.neutral()) / AMPLITUDE
        });
        (field, changes.collect())
    };
    Direction::Course(changed.into_iter().map(change).collect())
}

/// Steps of each unit within some steps: a calendar day, or a meal on record.
pub(crate) fn unit_steps(
    unit: RandomUnit,
    within: Range<usize>,
    course: &Course,
) -> Vec<Range<usize>> {
    let mut units: Vec<Range<usize>> = Vec::new();
    for step in within {
        match (unit, units.last_mut()) {
            (RandomUnit::Day, Some(day)) if course.day[day.start] == course.day[step] => {
                day.end = step + 1;
            }
            (RandomUnit::Day, _) => units.push(step..step + 1),
            (RandomUnit::Meal, _) if course.carbs[step] > 0.0 => units.push(step..step + 1),
            (RandomUnit::Meal, _) => {}
        }
    }
    units
}

/// Steps in which the answer of a unit is looked for: insulin of a whole day is still felt through the next.
fn answered(unit: &Range<usize>) -> Range<usize> {
    unit.start..unit.start + (2 * unit.len()).max(unit.len() + ANSWER)
}

/// The direction of each answer, whose steps are given by ascending start: answers that do not meet share one.
pub(crate) fn packed(answers: impl Iterator<Item = Range<usize>>) -> Vec<usize> {
    let mut ends: Vec<usize> = Vec::new();
    answers
        .map(|steps| {
            let free = ends.iter().position(|end| *end <= steps.start);
            let lane = free.unwrap_or(ends.len());
            match ends.get_mut(lane) {
                Some(end) => *end = steps.end,
                None => ends.push(steps.end),
            }
            lane
        })
        .collect()
}

/// The slopes along the logarithm of the factor of each unit, which is the factor that is there. `lanes` are the
/// directions of the units.
fn factors(
    units: &[Range<usize>],
    lanes: &[usize],
    field: Field,
    observations: &Observations,
) -> impl Iterator<Item = Direction> {
    let mut courses: Vec<Vec<f64>> = Vec::new();
    for (unit, lane) in units.iter().zip(lanes) {
        if *lane == courses.len() {
            courses.push(vec![0.0; observations.len()]);
        }
        for step in unit.clone() {
            courses[*lane][step] = observations.modulation(step)[field];
        }
    }
    courses.into_iter().map(move |course| Direction::Course(vec![(field, course)]))
}
