//! The adjoint of the signatures: scores of every course at once.
//!
//! Any sum of innovations' derivatives along a course is linear in the course. One pass backwards over the record
//! gives its coefficients, a number a field and step; the score of a course is then the product of both. This is
//! the reverse of [`signatures`](super::signatures), which costs a pass a course.

use effects::Field;
use ode_sim::slot;
use physiology::Compartment;

use super::step_slopes::reached;
use super::steps::Steps;
use super::{Direction, LANES, Lanes, reads_only};
use crate::error::GapError;
use crate::filter::augmented::AugmentedModel;
use crate::filter::kalman::Filtered;
use crate::filter::observations::Observations;
use crate::filter::state::{INTERSTITIAL, SENSOR, STATES};

/// For each field, a row a step: the derivative of sum_j u_j e_j by what is added to the field in that step.
///
/// Each of `factors` is u, [`LANES`] sums side by side, a row a step; where `frozen` has no innovation they are not
/// read. The answer has one list of fields for each.
///
/// # Errors
/// [`GapError::FilterNotFinite`] with the step.
pub(crate) fn course_scores(
    model: &AugmentedModel,
    record: &Observations,
    frozen: &Filtered,
    fields: &[Field],
    factors: &[Vec<Lanes>],
) -> Result<Vec<Vec<Vec<Lanes>>>, GapError> {
    let n = record.len();
    let everywhere: Vec<Direction> = fields
        .iter()
        .map(|field| Direction::Pulses { field: *field, first: 0, every: n.max(1), length: n })
        .collect();
    let steps = Steps::of_run(model, record, frozen, &everywhere)?;
    let back = |factors: &Vec<Lanes>| {
        let mut scores = vec![vec![[0.0; LANES]; n]; fields.len()];
        pulp::Arch::new().dispatch(AdjointKernel(&steps, fields, factors, &mut scores));
        scores
    };
    Ok(factors.iter().map(back).collect())
}

/// The way back, compiled for the instructions of the machine it runs on.
struct AdjointKernel<'a>(&'a Steps<'a>, &'a [Field], &'a [Lanes], &'a mut [Vec<Lanes>]);

impl pulp::NullaryFnOnce for AdjointKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self(steps, fields, factors, scores) = self;
        // Derivatives of the sum by the state before a step's reading.
        let mut by_state = [[0.0; LANES]; STATES];
        for (step, of) in steps.each.iter().enumerate().rev() {
            for (field, scores) in fields.iter().zip(scores.iter_mut()) {
                if reads_only(*field) {
                    continue;
                }
                let reached = reached(*field);
                let slopes = &steps.fields[*field as usize][step * reached.len()..];
                let score = &mut scores[step];
                for (state, slope) in reached.iter().zip(slopes) {
                    let row = by_state[*state];
                    *score = std::array::from_fn(|lane| score[lane] + slope * row[lane]);
                }
            }
            of.transition.carry_back(&mut by_state);
            if of.floored {
                by_state[slot(Compartment::Q1)] = [0.0; LANES];
            }
            let mut by_innovation = if of.scored { factors[step] } else { [0.0; LANES] };
            for (row, k) in by_state.iter().zip(of.gain) {
                for (sum, value) in by_innovation.iter_mut().zip(row) {
                    *sum += k * value;
                }
            }
            for (field, scores) in fields.iter().zip(scores.iter_mut()) {
                let by_course = match field {
                    Field::SensorGain => -of.expected,
                    Field::SensorOffset => -1.0,
                    _ => continue,
                };
                scores[step] = by_innovation.map(|value| by_course * value);
            }
            for (lane, value) in by_innovation.iter().enumerate() {
                by_state[INTERSTITIAL][lane] -= of.sensor_gain * value;
                by_state[SENSOR][lane] -= value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use ode_sim::OdeParameters;

    use super::*;
    use crate::filter::kalman::filter;
    use crate::filter::noise::NoiseModel;
    use crate::filter::tangent::signatures;
    use crate::filter::tangent::tests::record;

    #[test]
    fn a_score_is_the_product_of_course_and_adjoint() {
        let n = 90;
        let wave = |k: usize| (0.4 * k as f64).sin();
        let record = record(n);
        let (weight, noise) = (record.weight, NoiseModel::working());
        let model = AugmentedModel::new(OdeParameters::nominal(), weight, noise);
        let frozen = filter(&model, &record).expect("finite");
        let factors: Vec<Lanes> =
            (0..n).map(|k| std::array::from_fn(|lane| (0.7 * (k + lane) as f32).cos())).collect();
        let all = [vec![[0.0; LANES]; n], factors.clone()];
        let scores = course_scores(&model, &record, &frozen, &Field::ALL, &all).expect("finite");
        assert!(scores[0].iter().flatten().flatten().all(|score| *score == 0.0));
        let scores = &scores[1];
        let course: Vec<f64> = (0..n).map(|k| wave(3 * k + 1)).collect();
        for (field, scores) in Field::ALL.into_iter().zip(scores) {
            let direction = Direction::Course(vec![(field, course.clone())]);
            let forward = signatures(&model, &record, &frozen, &[direction]).expect("finite");
            for lane in 0..LANES {
                let by_steps = forward[0].iter().zip(&factors);
                let expected: f64 = by_steps.map(|(s, u)| s * f64::from(u[lane])).sum();
                let rows = scores.iter().zip(&course);
                let found: f64 = rows.map(|(row, c)| f64::from(row[lane]) * c).sum();
                // Rounding of single precision over 90 steps, beside the size of the terms.
                let size: f64 = forward[0].iter().map(|s| s.abs()).sum();
                assert!((found - expected).abs() < 1e-4 * size, "{field:?}: {found}, {expected}");
            }
        }
    }
}
