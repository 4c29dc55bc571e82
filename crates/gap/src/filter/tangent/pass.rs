//! The tangent pass: a few directions carried over a record, side by side.

use effects::Field;
use ode_sim::slot;
use physiology::Compartment;

use super::step_slopes::reached;
use super::steps::Steps;
use super::{Direction, LANES, Lanes, States, reads_only};
use crate::filter::state::{INTERSTITIAL, SENSOR, STATES};

/// At most [`LANES`] directions, as far as they have come.
pub(super) struct Pass {
    /// Their indices among all directions.
    pub(super) members: Vec<usize>,
    /// Index of their parameters among those of [`Steps`].
    parameters: Option<usize>,
    /// Courses that change the state, by field; a row a step of the record.
    feeding: Vec<(Field, Vec<Lanes>)>,
    /// Courses that change the reading.
    read: Vec<(Field, Vec<Lanes>)>,
    /// Where they have come to.
    pub(super) x: States,
}

/// Directions at the start of the record, a few at a time: parameters first, as they were asked for; then courses, those
/// of the same fields beside each other.
pub(super) fn passes(steps: &Steps<'_>, directions: &[Direction]) -> impl Iterator<Item = Pass> {
    let mut order: Vec<usize> = (0..directions.len()).collect();
    order.sort_by_key(|index| match &directions[*index] {
        Direction::Parameter(_) => None,
        Direction::Pulses { field, .. } => Some(vec![*field as usize]),
        Direction::Course(courses) => Some(courses.iter().map(|(f, _)| *f as usize).collect()),
    });
    (0..order.len().div_ceil(LANES)).map(move |index| {
        let members = order.iter().copied().skip(LANES * index).take(LANES).collect();
        Pass::of(steps, index, members, directions)
    })
}

impl Pass {
    /// The directions that are `members`; `index` is their place among those that are carried along together.
    fn of(steps: &Steps<'_>, index: usize, members: Vec<usize>, directions: &[Direction]) -> Self {
        let n = steps.record.len();
        let (mut feeding, mut read) = (Vec::<(Field, Vec<Lanes>)>::new(), Vec::new());
        for (lane, member) in members.iter().enumerate() {
            directions[*member].additions(n, |field, first, values| {
                let courses = if reads_only(field) { &mut read } else { &mut feeding };
                let known = courses.iter().position(|(known, _)| *known == field);
                let known = known.unwrap_or_else(|| {
                    courses.push((field, vec![[0.0; LANES]; n]));
                    courses.len() - 1
                });
                for (row, value) in courses[known].1[first..].iter_mut().zip(values) {
                    row[lane] += *value as f32;
                }
            });
        }
        let parameters = steps.parameters.get(index);
        let x = parameters.map_or([[0.0; LANES]; STATES], |some| some.begin);
        Self { members, parameters: parameters.map(|_| index), feeding, read, x }
    }

    /// Carries the directions over the steps held, which are the next: the derivatives of their innovations
    /// are appended to `rows`.
    pub(super) fn over(&mut self, steps: &Steps<'_>, rows: &mut Vec<Lanes>) {
        pulp::Arch::new().dispatch(PassKernel(steps, self, rows));
    }
}

/// [`Pass::over`], compiled for the instructions of the machine it runs on. Products and sums are rounded one
/// by one on all of them, so that they agree bit for bit.
struct PassKernel<'a>(&'a Steps<'a>, &'a mut Pass, &'a mut Vec<Lanes>);

impl pulp::NullaryFnOnce for PassKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self(steps, pass, rows) = self;
        let parameters = pass.parameters.map(|index| &steps.parameters[index]);
        let mut x = pass.x;
        for (index, of) in steps.each.iter().enumerate() {
            let step = steps.first + index;
            let mut change = [0.0; LANES];
            for lane in 0..LANES {
                change[lane] = -of.sensor_gain * x[INTERSTITIAL][lane] - x[SENSOR][lane];
            }
            for (field, courses) in &pass.read {
                let factor = if *field == Field::SensorGain { of.expected } else { 1.0 };
                let course = courses[step];
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
            for (field, courses) in &pass.feeding {
                let reached = reached(*field);
                let slopes = &steps.fields[*field as usize][index * reached.len()..];
                let course = courses[step];
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
