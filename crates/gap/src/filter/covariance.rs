//! Covariance of the augmented state: propagation and the scalar measurement update.
//!
//! The sensor error goes its own way between readings: what it has in common with the body is kept apart, and the
//! twelve other states fill vector registers without rest. The transition's structural zeros are skipped. Symmetry is
//! restored by every propagation, so that the matrix stays positive semidefinite however small the reading noise is.
//! Both steps are inlined always, so that they are compiled for the instructions of the filter that calls them.

use crate::filter::state::{INTERSTITIAL, SENSOR, STATES};
use crate::filter::transition::Transition;

/// States but for the sensor error: the body's, the flux and interstitial glucose.
const BODY: usize = SENSOR;
/// Columns that are worked on together, and rows of a block.
const SIDE: usize = 4;

/// A symmetric positive semidefinite 14 x 14 matrix over the augmented state, in its units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Covariance {
    body: [[f64; BODY]; BODY],
    /// Of each of these states with the sensor error of this step and of the one before.
    cross: [[f64; 2]; BODY],
    /// Of the sensor error: its variance, its covariance with that of the step before, and that one's variance.
    sensor: [f64; 3],
}

/// Gain of one scalar update and the variance of the innovation, mg/dL squared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// Correction of each state per mg/dL of innovation.
    pub gain: [f64; STATES],
    /// Variance of the innovation before the update, mg/dL squared.
    pub innovation_variance: f64,
}

/// Some columns over all states but the sensor error.
type Columns = [[f64; SIDE]; BODY];
type Block = [[f64; SIDE]; SIDE];

impl Covariance {
    /// Independent states with these standard deviations.
    #[must_use]
    pub fn diagonal(sd: &[f64; STATES]) -> Self {
        let mut p = Self { body: [[0.0; BODY]; BODY], cross: [[0.0; 2]; BODY], sensor: [0.0; 3] };
        for (state, sd) in sd.iter().enumerate() {
            p.add(state, sd * sd);
        }
        p
    }

    /// The entry of two states.
    #[must_use]
    pub fn get(&self, row: usize, column: usize) -> f64 {
        let (first, second) = (row.min(column), row.max(column));
        match (first.checked_sub(BODY), second.checked_sub(BODY)) {
            (None, None) => self.body[row][column],
            (None, Some(sensor)) => self.cross[first][sensor],
            _ => self.sensor[first + second - 2 * BODY],
        }
    }

    /// Adds `variance` to that of one state.
    #[inline(always)]
    pub fn add(&mut self, state: usize, variance: f64) {
        match state.checked_sub(BODY) {
            None => self.body[state][state] += variance,
            Some(sensor) => self.sensor[2 * sensor] += variance,
        }
    }

    /// Adds `covariance` to that of two different states.
    pub fn link(&mut self, one: usize, other: usize, covariance: f64) {
        let (first, second) = (one.min(other), one.max(other));
        match (first.checked_sub(BODY), second.checked_sub(BODY)) {
            (None, None) => {
                self.body[one][other] += covariance;
                self.body[other][one] += covariance;
            }
            (None, Some(sensor)) => self.cross[first][sensor] += covariance,
            _ => self.sensor[1] += covariance,
        }
    }

    /// Becomes `A P A'` for a transition `A`.
    #[inline(always)]
    pub fn propagate(&mut self, transition: &Transition) {
        // (A P)', a few columns of P at a time.
        let mut half = [[0.0; BODY]; BODY];
        transpose::<0>(&self.body, &mut half, transition);
        transpose::<1>(&self.body, &mut half, transition);
        transpose::<2>(&self.body, &mut half, transition);
        // A (A P)'; one triangle stands for both.
        let mut first = columns::<0>(&half);
        transition.carry_body(&mut first);
        put::<0, 0>(&mut self.body, mirrored(block::<0>(&first)));
        put::<1, 0>(&mut self.body, block::<1>(&first));
        put::<2, 0>(&mut self.body, block::<2>(&first));
        put::<0, 1>(&mut self.body, transposed(block::<1>(&first)));
        put::<0, 2>(&mut self.body, transposed(block::<2>(&first)));
        let mut second = columns::<1>(&half);
        transition.carry_body(&mut second);
        put::<1, 1>(&mut self.body, mirrored(block::<1>(&second)));
        put::<2, 1>(&mut self.body, block::<2>(&second));
        put::<1, 2>(&mut self.body, transposed(block::<2>(&second)));
        let mut third = columns::<2>(&half);
        transition.carry_body(&mut third);
        put::<2, 2>(&mut self.body, mirrored(block::<2>(&third)));
        transition.carry_body(&mut self.cross);
        let [on, earlier, kept] = transition.sensor();
        for [now, before] in &mut self.cross {
            (*now, *before) = (on * *now + earlier * *before, kept * *now);
        }
        let [now, both, before] = self.sensor;
        let (with_now, with_before) = (on * now + earlier * both, on * both + earlier * before);
        self.sensor = [on * with_now + earlier * with_before, kept * with_now, kept * kept * now];
    }

    /// Updates with one reading, interstitial glucose plus sensor error plus white noise of variance
    /// `reading_variance`: P - K (h P) with the gain K that makes the variance least. What Joseph's form would
    /// add is rounding.
    ///
    /// Returns the gain and the variance of the innovation.
    #[inline(always)]
    #[expect(clippy::needless_range_loop, reason = "unrolled by number, as below")]
    pub fn update(&mut self, reading_variance: f64) -> Gain {
        let mut along = [0.0; BODY];
        for k in 0..BODY {
            along[k] = self.body[INTERSTITIAL][k] + self.cross[k][0];
        }
        let [now, before] = self.cross[INTERSTITIAL];
        let of_sensor = [now + self.sensor[0], before + self.sensor[1]];
        let innovation_variance = along[INTERSTITIAL] + of_sensor[0] + reading_variance;
        let mut gain = [0.0; STATES];
        for k in 0..BODY {
            gain[k] = along[k] / innovation_variance;
        }
        for k in 0..2 {
            gain[BODY + k] = of_sensor[k] / innovation_variance;
        }
        for row in 0..BODY {
            for k in 0..BODY {
                self.body[row][k] -= gain[row] * along[k];
            }
            for k in 0..2 {
                self.cross[row][k] -= gain[row] * of_sensor[k];
            }
        }
        self.sensor[0] -= gain[BODY] * of_sensor[0];
        self.sensor[1] -= gain[BODY] * of_sensor[1];
        self.sensor[2] -= gain[BODY + 1] * of_sensor[1];
        Gain { gain, innovation_variance }
    }
}

// Loops by number, which are unrolled: closures over arrays are not always inlined, and would then stay on the
// plainest instructions.

#[inline(always)]
fn columns<const COLUMN: usize>(from: &[[f64; BODY]; BODY]) -> Columns {
    let mut columns = [[0.0; SIDE]; BODY];
    for row in 0..BODY {
        for k in 0..SIDE {
            columns[row][k] = from[row][SIDE * COLUMN + k];
        }
    }
    columns
}

/// Writes the transpose of `A P` at some columns of P.
#[inline(always)]
fn transpose<const COLUMN: usize>(
    p: &[[f64; BODY]; BODY],
    to: &mut [[f64; BODY]; BODY],
    transition: &Transition,
) {
    let mut columns = columns::<COLUMN>(p);
    transition.carry_body(&mut columns);
    put::<COLUMN, 0>(to, transposed(block::<0>(&columns)));
    put::<COLUMN, 1>(to, transposed(block::<1>(&columns)));
    put::<COLUMN, 2>(to, transposed(block::<2>(&columns)));
}

#[inline(always)]
fn block<const ROW: usize>(columns: &Columns) -> Block {
    let first = SIDE * ROW;
    [columns[first], columns[first + 1], columns[first + 2], columns[first + 3]]
}

#[inline(always)]
fn put<const ROW: usize, const COLUMN: usize>(to: &mut [[f64; BODY]; BODY], block: Block) {
    for row in 0..SIDE {
        for k in 0..SIDE {
            to[SIDE * ROW + row][SIDE * COLUMN + k] = block[row][k];
        }
    }
}

#[inline(always)]
fn transposed(block: Block) -> Block {
    let [a, b, c, d] = block;
    [
        [a[0], b[0], c[0], d[0]],
        [a[1], b[1], c[1], d[1]],
        [a[2], b[2], c[2], d[2]],
        [a[3], b[3], c[3], d[3]],
    ]
}

/// The lower triangle of a block on the diagonal, and what mirrors it.
#[inline(always)]
fn mirrored(block: Block) -> Block {
    let [a, b, c, d] = block;
    [
        [a[0], b[0], c[0], d[0]],
        [b[0], b[1], c[1], d[1]],
        [c[0], c[1], c[2], d[2]],
        [d[0], d[1], d[2], d[3]],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::{Mat, Side};
    use rand::{RngExt, SeedableRng};

    fn random_covariance(rng: &mut impl rand::Rng) -> Covariance {
        let factor: [[f64; STATES]; STATES] =
            std::array::from_fn(|_| std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
        let product = |row: usize, column: usize| -> f64 {
            (0..STATES).map(|k| factor[row][k] * factor[column][k]).sum()
        };
        let mut p = Covariance::diagonal(&[0.0; STATES]);
        for row in 0..STATES {
            p.add(row, product(row, row));
            for column in 0..row {
                p.link(row, column, product(row, column));
            }
        }
        p
    }

    fn as_faer(p: &Covariance) -> Mat<f64> {
        Mat::from_fn(STATES, STATES, |row, column| p.get(row, column))
    }

    #[test]
    fn propagation_and_update_agree_with_dense_algebra() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let mut transition = Transition::default();
        for row in 0..STATES {
            for &column in Transition::NONZERO[row] {
                transition.set(row, column, rng.random_range(-1.0..1.0));
            }
        }
        let p = random_covariance(&mut rng);
        let a = Mat::from_fn(STATES, STATES, |row, column| transition.get(row, column));
        let dense = &a * as_faer(&p) * a.transpose();
        let mut propagated = p;
        propagated.propagate(&transition);
        let difference = (as_faer(&propagated) - dense).norm_max();
        assert!(difference < 1e-12, "rounding of 14-term sums, not {difference}");

        let h = Mat::from_fn(1, STATES, |_, state| {
            if state == INTERSTITIAL || state == SENSOR { 1.0 } else { 0.0 }
        });
        let dense_p = as_faer(&p);
        let variance = (&h * &dense_p * h.transpose())[(0, 0)] + 0.25;
        let gain = &dense_p * h.transpose() * (1.0 / variance);
        let dense = &dense_p - &gain * &h * &dense_p;
        let mut updated = p;
        let found = updated.update(0.25);
        assert!((found.innovation_variance - variance).abs() < 1e-12);
        assert!((as_faer(&updated) - dense).norm_max() < 1e-12);
    }

    #[test]
    fn ten_thousand_updates_with_tiny_noise_leave_it_positive_semidefinite() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(4);
        let mut p = random_covariance(&mut rng);
        let mut transition = Transition::default();
        for state in 0..STATES {
            transition.set(state, state, 0.999);
        }
        for _ in 0..10_000 {
            p.propagate(&transition);
            p.update(1e-9);
        }
        let values = as_faer(&p).self_adjoint_eigenvalues(Side::Lower).expect("symmetric");
        let largest = values.iter().copied().fold(0.0, f64::max);
        // Rounding of eigenvalues relative to the largest.
        assert!(values.iter().all(|v| *v > -1e-13 * largest), "{values:?}");
    }

    #[test]
    fn the_filters_own_recursion_keeps_it_positive_semidefinite() {
        use crate::filter::augmented::AugmentedModel;
        use crate::filter::noise::NoiseModel;
        use physiology::{Grams, Kilograms, MgPerDl, StepInput, Units, UnitsPerHour};
        let parameters = ode_sim::OdeParameters::nominal();
        // A sensor without white noise to speak of is the hardest case.
        let noise = NoiseModel { reading_sd: 1e-4, ..NoiseModel::working() };
        let model = AugmentedModel::new(parameters, Kilograms(76.3), noise);
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(6);
        let (mut state, mut p) = model.start(UnitsPerHour(1.0), MgPerDl(150.0));
        for step in 0..4000 {
            if step % 7 != 0 {
                let gain = p.update(noise.reading_sd.powi(2));
                let innovation = gain.innovation_variance.sqrt() * rng.random_range(-1.7..1.7);
                state = model.corrected(&state, &gain.gain, innovation);
            }
            let meal = step % 70 == 0;
            let input = StepInput {
                basal: UnitsPerHour(1.0),
                bolus: Units(if meal { 5.0 } else { 0.0 }),
                carbs: Grams(if meal { 60.0 } else { 0.0 }),
                ..StepInput::default()
            };
            model.add_meal_noise(&mut p, &input);
            let (following, transition) =
                model.linearised(&state, &input, &effects::Modulation::NEUTRAL).expect("finite");
            p.propagate(&transition);
            model.add_process_noise(&mut p, &input, &following);
            state = following;
            if step % 50 == 0 {
                // States differ by six orders of magnitude, so judge the correlation matrix.
                let sd: Vec<f64> = (0..STATES).map(|k| p.get(k, k).sqrt().max(1e-300)).collect();
                let scaled = Mat::from_fn(STATES, STATES, |r, c| p.get(r, c) / (sd[r] * sd[c]));
                let values = scaled.self_adjoint_eigenvalues(Side::Lower).expect("symmetric");
                // Rounding of a 14 x 14 correlation matrix.
                assert!(values.iter().all(|v| *v > -1e-12), "step {step}: {values:?}");
            }
        }
    }
}
