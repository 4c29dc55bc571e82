//! Covariance of the augmented state: propagation and the scalar measurement update.
//!
//! Fixed arrays of 14 x 14, rows padded to 16 so that they fill vector registers; at this size they
//! are several times faster than a general matrix type. The transition's structural zeros are
//! skipped. Updates take Joseph's form and symmetry is restored by every propagation, so that
//! the matrix stays positive semidefinite however small the reading noise is. Both are inlined
//! always, so that they are compiled for the instructions of the filter that calls them.

use crate::augmented::{INTERSTITIAL, SENSOR, STATES, Transition};

/// Entries of a padded row.
const WIDTH: usize = 16;

/// A symmetric positive semidefinite 14 x 14 matrix over the augmented state, in its units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Covariance([[f64; WIDTH]; STATES]);

/// Gain of one scalar update and the variance of the innovation, mg/dL squared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// Correction of each state per mg/dL of innovation.
    pub gain: [f64; STATES],
    /// Variance of the innovation before the update, mg/dL squared.
    pub innovation_variance: f64,
}

impl Covariance {
    /// Independent states with these standard deviations.
    #[must_use]
    pub fn diagonal(sd: &[f64; STATES]) -> Self {
        let mut p = Self([[0.0; WIDTH]; STATES]);
        for (state, sd) in sd.iter().enumerate() {
            p.0[state][state] = sd * sd;
        }
        p
    }

    /// The entry of two states.
    #[must_use]
    pub fn get(&self, row: usize, column: usize) -> f64 {
        self.0[row][column]
    }

    /// Adds `variance` to that of one state.
    pub fn add(&mut self, state: usize, variance: f64) {
        self.0[state][state] += variance;
    }

    /// Adds `covariance` to that of two different states.
    pub fn link(&mut self, one: usize, other: usize, covariance: f64) {
        self.0[one][other] += covariance;
        self.0[other][one] += covariance;
    }

    /// `A P A'` for a transition `A`.
    #[must_use]
    pub fn propagated(&self, transition: &Transition) -> Self {
        let mut p = *self;
        p.propagate(transition);
        p
    }

    /// Becomes `A P A'` for a transition `A`.
    #[inline(always)]
    pub fn propagate(&mut self, transition: &Transition) {
        // Columns are vectors to the transition: A P, then A (A P)', which is symmetric but for rounding.
        transition.carry(&mut self.0);
        for row in 0..STATES {
            for column in 0..row {
                let (above, below) = (self.0[column][row], self.0[row][column]);
                self.0[column][row] = below;
                self.0[row][column] = above;
            }
        }
        transition.carry(&mut self.0);
        // One triangle stands for both.
        for row in 0..STATES {
            for column in 0..row {
                self.0[column][row] = self.0[row][column];
            }
        }
    }

    /// Updates with one reading, interstitial glucose plus sensor error plus white noise of variance
    /// `reading_variance`, in Joseph's form (I - K h) P (I - K h)' + r K K'.
    ///
    /// Returns the gain and the variance of the innovation.
    #[inline(always)]
    pub fn update(&mut self, reading_variance: f64) -> Gain {
        let mut along = [0.0; WIDTH];
        for (value, row) in along.iter_mut().zip(&self.0) {
            *value = row[INTERSTITIAL] + row[SENSOR];
        }
        let innovation_variance = along[INTERSTITIAL] + along[SENSOR] + reading_variance;
        let padded = along.map(|value| value / innovation_variance);
        for (row, k) in self.0.iter_mut().zip(padded) {
            let rest = row[INTERSTITIAL] - k * along[INTERSTITIAL] + row[SENSOR]
                - k * along[SENSOR]
                - reading_variance * k;
            for ((entry, along), gain) in row.iter_mut().zip(along).zip(padded) {
                *entry = *entry - k * along - rest * gain;
            }
        }
        let mut gain = [0.0; STATES];
        gain.copy_from_slice(&padded[..STATES]);
        Gain { gain, innovation_variance }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::{Mat, Side};
    use rand::{RngExt, SeedableRng};

    fn random_covariance(rng: &mut impl rand::Rng) -> Covariance {
        let factor: [[f64; STATES]; STATES] =
            std::array::from_fn(|_| std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
        let mut p = Covariance::diagonal(&[0.0; STATES]);
        for row in 0..STATES {
            for column in 0..STATES {
                p.0[row][column] = (0..STATES).map(|k| factor[row][k] * factor[column][k]).sum();
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
        let difference = (as_faer(&p.propagated(&transition)) - dense).norm_max();
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
            p = p.propagated(&transition);
            p.update(1e-9);
        }
        let values = as_faer(&p).self_adjoint_eigenvalues(Side::Lower).expect("symmetric");
        let largest = values.iter().copied().fold(0.0, f64::max);
        // Rounding of eigenvalues relative to the largest.
        assert!(values.iter().all(|v| *v > -1e-13 * largest), "{values:?}");
    }

    #[test]
    fn the_filters_own_recursion_keeps_it_positive_semidefinite() {
        use crate::augmented::AugmentedModel;
        use crate::noise::NoiseModel;
        use physiology::{Grams, Kilograms, MgPerDl, StepInput, Units, UnitsPerHour};
        let parameters = ode_sim::OdeParameters::nominal();
        let egp = ode_sim::EgpMode::NonNegative;
        // A sensor without white noise to speak of is the hardest case.
        let noise = NoiseModel { reading_sd: 1e-4, ..NoiseModel::working() };
        let model = AugmentedModel::new(parameters, Kilograms(76.3), egp, noise);
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
            p = p.propagated(&transition);
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
