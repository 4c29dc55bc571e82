//! The Kalman filter that turns readings into innovations.

use physiology::{MG_PER_DL_PER_MMOL_PER_L, STEP};

use crate::detect::plant::FilterNoise;
use crate::detect::plant::insulin::{GlucoseStep, InsulinAction};
use crate::signals::Signals;

/// States of the filter: Q1, Q2 and the interstitium [mmol/kg], the quick and the slow flux
/// [mmol/kg/min], and the sensor's error now and a step before [mg/dL].
pub(crate) const STATES: usize = 7;
const Q1: usize = 0;
const Q2: usize = 1;
const INTERSTITIUM: usize = 2;
const QUICK: usize = 3;
const SLOW: usize = 4;
const ERROR: usize = 5;
const ERROR_BEFORE: usize = 6;

pub(crate) type Vector = [f64; STATES];
type Matrix = [Vector; STATES];

/// Standard deviations of Q1 and Q2 before the first reading, mmol/kg: 60 mg/dL and as much.
const FIRST_SD: f64 = 0.5;
/// Median of the absolute value of a standard normal variable.
const NORMAL_QUARTILE: f64 = 0.674_489_75;

/// The filter's linear system, but for what insulin makes of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Filter {
    noise: FilterNoise,
    /// mg/dL shown for each mmol/kg in the interstitium.
    shown: f64,
    quick_left: f64,
    slow_left: f64,
    lag: [f64; 3],
}

impl Filter {
    pub(crate) fn new(action: &InsulinAction, noise: &FilterNoise) -> Self {
        let left = |time: f64| (-STEP.0 / time).exp();
        // A first-order lag behind a value that moves in a straight line through the step.
        let lag = left(noise.interstitial_lag);
        let late = (1.0 - lag) * noise.interstitial_lag / STEP.0;
        Self {
            noise: *noise,
            shown: MG_PER_DL_PER_MMOL_PER_L / action.plant.parameters.v_g,
            quick_left: left(noise.flux_time),
            slow_left: left(noise.slow_time),
            lag: [lag, late - lag, 1.0 - late],
        }
    }

    /// The part of the state after a step that is linear in the state before, with `flux`
    /// mmol/kg/min into Q1 besides those of the state.
    #[inline]
    pub(crate) fn advance(&self, step: &GlucoseStep, x: &Vector, flux: f64) -> Vector {
        let [[a, b], [c, d]] = step.transition;
        let flux = flux + x[QUICK] + x[SLOW];
        let q1 = a * x[Q1] + b * x[Q2] + step.gain[0] * flux;
        let q2 = c * x[Q1] + d * x[Q2] + step.gain[1] * flux;
        let [kept, from_start, from_end] = self.lag;
        let phi = self.noise.sensor_phi;
        [
            q1,
            q2,
            kept * x[INTERSTITIUM] + from_start * x[Q1] + from_end * q1,
            self.quick_left * x[QUICK],
            self.slow_left * x[SLOW],
            phi[0] * x[ERROR] + phi[1] * x[ERROR_BEFORE],
            x[ERROR],
        ]
    }

    /// What the sensor shows of a state, mg/dL.
    #[inline]
    pub(crate) fn shows(&self, x: &Vector) -> f64 {
        self.shown * x[INTERSTITIUM] + x[ERROR]
    }

    fn covariance_after(&self, step: &GlucoseStep, p: &Matrix) -> Matrix {
        // F P F': rows of P become rows of P F', whose columns become rows of the whole, which is
        // symmetric.
        let half: Matrix = std::array::from_fn(|row| self.advance(step, &p[row], 0.0));
        let mut after: Matrix = std::array::from_fn(|column| {
            self.advance(step, &std::array::from_fn(|row| half[row][column]), 0.0)
        });
        let n = &self.noise;
        let quick_sd = n.flux_sd + n.insulin_share * step.moved.max(0.0);
        after[Q1][Q1] += n.glucose_sd.powi(2);
        after[QUICK][QUICK] += quick_sd.powi(2) * (1.0 - self.quick_left.powi(2));
        after[SLOW][SLOW] += n.slow_sd.powi(2) * (1.0 - self.slow_left.powi(2));
        after[ERROR][ERROR] += self.sensor_innovation();
        // Rounding must not make it lopsided.
        std::array::from_fn(|row| {
            std::array::from_fn(|column| 0.5 * (after[row][column] + after[column][row]))
        })
    }

    fn sensor_innovation(&self) -> f64 {
        let [first, second] = self.noise.sensor_phi;
        let correlation = first / (1.0 - second);
        self.noise.sensor_sd.powi(2) * (1.0 - correlation.powi(2)) * (1.0 - second.powi(2))
    }

    fn first_covariance(&self) -> Matrix {
        let n = &self.noise;
        let mut p = [[0.0; STATES]; STATES];
        for glucose in [Q1, Q2, INTERSTITIUM] {
            p[glucose][glucose] = FIRST_SD.powi(2);
        }
        p[QUICK][QUICK] = n.flux_sd.powi(2);
        p[SLOW][SLOW] = n.slow_sd.powi(2);
        let variance = n.sensor_sd.powi(2);
        let correlation = n.sensor_phi[0] / (1.0 - n.sensor_phi[1]);
        p[ERROR][ERROR] = variance;
        p[ERROR_BEFORE][ERROR_BEFORE] = variance;
        p[ERROR][ERROR_BEFORE] = correlation * variance;
        p[ERROR_BEFORE][ERROR] = correlation * variance;
        p
    }
}

/// What the filter makes of one reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Update {
    /// Innovation over its standard deviation.
    pub(crate) whitened: f64,
    /// That standard deviation, mg/dL.
    pub(crate) sd: f64,
    /// Gain of each state.
    pub(crate) gain: Vector,
}

/// The innovations of a record.
#[derive(Debug, Clone, PartialEq)]
pub struct Innovations {
    pub(crate) filter: Filter,
    /// One entry a step; `None` where there is no reading.
    pub(crate) updates: Vec<Option<Update>>,
}

impl Innovations {
    /// Runs the filter along a record.
    #[must_use]
    pub fn of(signals: &Signals<'_>, action: &InsulinAction, noise: &FilterNoise) -> Self {
        let filter = Filter::new(action, noise);
        let mut x = [0.0; STATES];
        [x[Q1], x[Q2]] = action.first;
        x[INTERSTITIUM] = x[Q1];
        let mut p = filter.first_covariance();
        let mut updates = Vec::with_capacity(signals.cgm.len());
        for (reading, step) in signals.cgm.iter().zip(&action.steps) {
            let update = reading.map(|reading| {
                let towards: Vector = std::array::from_fn(|state| filter.shows(&p[state]));
                let variance = filter.shows(&towards) + noise.reading_sd.powi(2);
                let gain = towards.map(|value| value / variance);
                let innovation = reading - filter.shows(&x);
                for state in 0..STATES {
                    x[state] += gain[state] * innovation;
                    for other in 0..STATES {
                        p[state][other] -= gain[state] * towards[other];
                    }
                }
                let sd = variance.sqrt();
                Update { whitened: innovation / sd, sd, gain }
            });
            updates.push(update);
            x = filter.advance(step, &x, 0.0);
            x[Q1] += step.constant[0];
            x[Q2] += step.constant[1];
            x[INTERSTITIUM] += filter.lag[2] * step.constant[0];
            p = filter.covariance_after(step, &p);
        }
        Self { filter, updates }
    }

    /// The standard deviation of the innovations over the expected one, by the median of their
    /// absolute values: what happens seldom, such as meals, hardly moves it. 1 without readings.
    #[must_use]
    pub fn scale(&self) -> f64 {
        let mut sizes: Vec<f64> = self.whitened().flatten().map(f64::abs).collect();
        let middle = sizes.len() / 2;
        if sizes.is_empty() {
            return 1.0;
        }
        let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
        *median / NORMAL_QUARTILE
    }

    /// The same innovations if every noise is `scale` times as large, which leaves the filter's
    /// gains as they are.
    #[must_use]
    pub fn with_noise_scaled(mut self, scale: f64) -> Self {
        for update in self.updates.iter_mut().flatten() {
            update.whitened /= scale;
            update.sd *= scale;
        }
        self
    }

    /// Innovations over their standard deviations, one a step, `None` where there is no reading.
    pub fn whitened(&self) -> impl Iterator<Item = Option<f64>> + '_ {
        self.updates.iter().map(|update| update.map(|u| u.whitened))
    }

    /// Logarithm of the likelihood of the readings without any meal, nats, but for a constant that
    /// is the same for every record of as many readings.
    #[must_use]
    pub fn log_likelihood(&self) -> f64 {
        self.updates.iter().flatten().map(|u| -0.5 * u.whitened.powi(2) - u.sd.ln()).sum()
    }
}

#[cfg(test)]
mod tests {
    use cohort::Channel;

    use super::*;
    use crate::detect::plant::synthetic::person;

    /// Standard normal numbers, near enough: the sum of twelve uniform ones.
    struct Normal(u64);

    impl Normal {
        fn draw(&mut self) -> f64 {
            let mut uniform = || {
                self.0 = self
                    .0
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                (self.0 >> 11) as f64 / (1_u64 << 53) as f64
            };
            (0..12).map(|_| uniform()).sum::<f64>() - 6.0
        }
    }

    #[test]
    fn innovations_of_the_filters_own_model_are_white_and_of_unit_size() {
        let steps = 6000;
        let mut person = person(steps, &[], &[]);
        // Less flux than usual, or glucose would wander below zero with nobody to eat.
        let noise = FilterNoise { flux_sd: 0.001, insulin_share: 0.02, ..FilterNoise::working() };
        let quiet = person.clone();
        let signals = Signals::of(&quiet).expect("values that can be");
        let action = InsulinAction::along(&signals, 1.0).expect("a plant that runs");
        let filter = Filter::new(&action, &noise);
        let mut normal = Normal(1);
        let mut x = [0.0; STATES];
        [x[Q1], x[Q2]] = action.first;
        x[INTERSTITIUM] = x[Q1];
        for step in 0..steps {
            let shown = filter.shows(&x) + noise.reading_sd * normal.draw();
            person.record.channel_mut(Channel::Cgm)[step] = Some(shown);
            let of = &action.steps[step];
            x = filter.advance(of, &x, 0.0);
            x[Q1] += of.constant[0] + noise.glucose_sd * normal.draw();
            x[Q2] += of.constant[1];
            x[INTERSTITIUM] += filter.lag[2] * of.constant[0];
            let quick = noise.flux_sd + noise.insulin_share * of.moved;
            x[QUICK] += quick * (1.0 - filter.quick_left.powi(2)).sqrt() * normal.draw();
            x[SLOW] += noise.slow_sd * (1.0 - filter.slow_left.powi(2)).sqrt() * normal.draw();
            x[ERROR] += filter.sensor_innovation().sqrt() * normal.draw();
        }
        let signals = Signals::of(&person).expect("glucose above zero");
        let white: Vec<f64> =
            Innovations::of(&signals, &action, &noise).whitened().flatten().skip(300).collect();
        let found = Innovations::of(&signals, &action, &noise);
        // The error of a median of 6,000 is 0.016.
        assert!((found.scale() - 1.0).abs() < 0.07, "{}", found.scale());
        let twice = found.clone().with_noise_scaled(2.0);
        assert!((twice.scale() - 0.5 * found.scale()).abs() < 1e-12); // rounding
        let n = white.len() as f64;
        let variance = white.iter().map(|w| w * w).sum::<f64>() / n;
        // 5,700 independent squares: a standard error of 0.019.
        assert!((variance - 1.0).abs() < 0.08, "{variance}");
        for lag in 1..6 {
            let product: f64 = white.iter().zip(&white[lag..]).map(|(a, b)| a * b).sum();
            // A standard error of 0.013.
            assert!((product / n).abs() < 0.055, "lag {lag}: {}", product / n);
        }
    }

    #[test]
    fn after_a_gap_the_filter_expects_more_error() {
        let mut person = person(300, &[], &[]);
        person.record.channel_mut(Channel::Cgm)[200..260].fill(None);
        let signals = Signals::of(&person).expect("values that can be");
        let action = InsulinAction::along(&signals, 1.0).expect("a plant that runs");
        let found = Innovations::of(&signals, &action, &FilterNoise::working());
        assert!(found.updates[200..260].iter().all(Option::is_none));
        let sd = |step: usize| found.updates[step].expect("a reading").sd;
        assert!(sd(260) > 3.0 * sd(199), "{} {}", sd(260), sd(199));
    }
}
