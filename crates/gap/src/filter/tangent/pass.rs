//! The tangent pass: a few directions carried over a record, side by side.

use effects::Field;
use ode_sim::slot;
use physiology::Compartment;

use super::step_slopes::reached;
use super::steps::Steps;
use super::{Direction, LANES, Lanes, States, pulses, reads_only};
use crate::filter::state::{INTERSTITIAL, SENSOR, STATES};

/// Courses of one field, side by side.
struct Courses {
    field: Field,
    /// One row a step of the record.
    rows: Vec<Lanes>,
}

/// What feeds at most [`LANES`] directions.
pub(super) struct LaneBlock {
    /// Index of their parameters among those of [`Steps`], and the derivative of the start by them.
    parameters: Option<(usize, States)>,
    /// Courses that change the state.
    feeding: Vec<Courses>,
    /// Courses that change the reading.
    read: Vec<Courses>,
}

impl LaneBlock {
    /// The block at `index` of the directions in their order; `n` steps of record.
    pub(super) fn of(
        steps: &Steps<'_>,
        index: usize,
        members: &[usize],
        directions: &[Direction],
        n: usize,
    ) -> Self {
        let parameters = steps.parameters.get(index).map(|some| (index, some.begin));
        let mut block = Self { parameters, feeding: Vec::new(), read: Vec::new() };
        for (lane, member) in members.iter().enumerate() {
            match &directions[*member] {
                Direction::Course(courses) => {
                    for (field, course) in courses {
                        for (row, value) in block.rows(*field, n).iter_mut().zip(course) {
                            row[lane] += *value as f32;
                        }
                    }
                }
                Direction::Pulses { field, first, every, length } => {
                    let rows = block.rows(*field, n);
                    for row in pulses(*first, *every, *length, n).flatten() {
                        rows[row][lane] += 1.0;
                    }
                }
                Direction::Parameter(_) => {}
            }
        }
        block
    }

    /// The courses of a field, a row a step.
    fn rows(&mut self, field: Field, n: usize) -> &mut [Lanes] {
        let all = if reads_only(field) { &mut self.read } else { &mut self.feeding };
        let known = all.iter().position(|courses| courses.field == field);
        let known = known.unwrap_or_else(|| {
            all.push(Courses { field, rows: vec![[0.0; LANES]; n] });
            all.len() - 1
        });
        &mut all[known].rows
    }
}

/// The directions of a block, as far as they have come.
pub(super) struct Pass<'a> {
    pub(super) block: &'a LaneBlock,
    /// Where the directions have come to.
    pub(super) x: States,
}

impl<'a> Pass<'a> {
    /// At the start of the record.
    pub(super) fn new(block: &'a LaneBlock) -> Self {
        let x = block.parameters.map_or([[0.0; LANES]; STATES], |(_, begin)| begin);
        Self { block, x }
    }

    /// Carries the directions over the steps held, which are the next: the derivatives of their innovations
    /// are appended to `rows`.
    pub(super) fn over(&mut self, steps: &Steps<'_>, rows: &mut Vec<Lanes>) {
        pulp::Arch::new().dispatch(PassKernel { steps, pass: self, rows });
    }
}

/// [`Pass::over`], compiled for the instructions of the machine it runs on. Products and sums are rounded one
/// by one on all of them, so that they agree bit for bit.
struct PassKernel<'a, 'b> {
    steps: &'a Steps<'a>,
    pass: &'a mut Pass<'b>,
    rows: &'a mut Vec<Lanes>,
}

impl pulp::NullaryFnOnce for PassKernel<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { steps, pass, rows } = self;
        let block = pass.block;
        let parameters = block.parameters.map(|(index, _)| &steps.parameters[index]);
        let mut x = pass.x;
        for (index, of) in steps.each.iter().enumerate() {
            let step = steps.first + index;
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
            rows.push(if of.scored { change } else { [0.0; LANES] });
            for (row, k) in x.iter_mut().zip(of.gain) {
                *row = std::array::from_fn(|lane| row[lane] + k * change[lane]);
            }
            if of.floored {
                x[slot(Compartment::Q1)] = [0.0; LANES];
            }
            of.transition.carry(&mut x);
            for courses in &block.feeding {
                let reached = reached(courses.field);
                let slopes = &steps.fields[courses.field as usize][index * reached.len()..];
                let course = courses.rows[step];
                for (state, slope) in reached.iter().zip(slopes) {
                    let row = &mut x[*state];
                    *row = std::array::from_fn(|lane| row[lane] + slope * course[lane]);
                }
            }
            if let Some(parameters) = parameters {
                for (row, fed) in x.iter_mut().zip(&parameters.steps[index]) {
                    *row = std::array::from_fn(|lane| row[lane] + fed[lane]);
                }
            }
        }
        pass.x = x;
    }
}
