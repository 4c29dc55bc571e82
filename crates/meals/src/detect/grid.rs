//! GRID, the glucose rate increase detector, as published.
//!
//! Harvey, Dassau, Zisser, Seborg and Doyle, J Diabetes Sci Technol 2014;8:307-320: a filter
//! against spikes (their Eq. 1), a low-pass filter (Eq. 2), the derivative of the parabola through
//! three values (Eq. 3), and an alarm where glucose is high and the last two or the last three
//! derivatives exceed a threshold (Eq. 4). One set of constants for everybody; no estimate of size,
//! none of when the meal was eaten.
//!
//! Three things the publication leaves open are settled here: the filters begin anew where more
//! than a quarter of an hour lies between two readings; the first step of a run of alarms is the
//! detection; and alarms within [`GridSettings::pause`] of a detection belong to it.

use physiology::STEP;

use crate::detect::{Detected, Detection};
use crate::error::{MealError, require};
use crate::signals::Signals;

/// Constants of GRID.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridSettings {
    /// Largest change that the spike filter lets through, mg/dL per minute.
    pub spike: f64,
    /// Time constant of the low-pass filter, min.
    pub tau_f: f64,
    /// Filtered glucose that must be exceeded, mg/dL.
    pub g_min: f64,
    /// Slope that the last three values must exceed, mg/dL/min.
    pub slope_3: f64,
    /// Slope that the last two values must exceed, mg/dL/min.
    pub slope_2: f64,
    /// Steps after a detection in which alarms belong to it.
    pub pause: usize,
}

impl GridSettings {
    /// The published constants; the pause of an hour is ours.
    #[must_use]
    pub const fn published() -> Self {
        Self {
            spike: 3.0,   // mg/dL in a minute (Harvey et al. 2014, Eq. 1)
            tau_f: 6.0,   // min (Harvey et al. 2014, Eq. 2)
            g_min: 130.0, // mg/dL (Harvey et al. 2014, Eq. 4)
            slope_3: 1.5, // mg/dL/min (Harvey et al. 2014, Eq. 4)
            slope_2: 1.6, // mg/dL/min (Harvey et al. 2014, Eq. 4)
            pause: 12,    // an hour, as the other detector's
        }
    }
}

/// Standard deviation and coefficients of the error of a sensor, an autoregression of order two per
/// reading: Vettoretti et al., Sensors 2019;19:5320 (Dexcom G6, 1.2204 and -0.3308). The
/// standard deviation is that of [`PlantSettings`](crate::PlantSettings).
const SENSOR_SD: f64 = 8.0;
const SENSOR_PHI: [f64; 2] = [1.2204, -0.3308];
/// Most steps from one reading to the next: those of a sensor that is read four times an hour.
const LARGEST_GAP: usize = 3;
/// Readings over which the low-pass filter forgets.
const MEMORY: usize = 24;

/// Runs GRID along a record.
///
/// # Errors
/// [`MealError::Setting`] for a time constant that is not positive.
pub fn detect(signals: &Signals<'_>, settings: &GridSettings) -> Result<Detected, MealError> {
    let tau_f = settings.tau_f;
    require(tau_f.is_finite() && tau_f > 0.0, "tau_f", tau_f, "positive and finite")?;
    let sd = slope_sd(tau_f);
    let mut meals: Vec<Detection> = Vec::new();
    let mut run = Run::default();
    let mut alarmed = false;
    for (step, reading) in signals.cgm.iter().enumerate() {
        let Some(reading) = *reading else { continue };
        if run.steps[0].is_some_and(|last| step - last > LARGEST_GAP) {
            (run, alarmed) = (Run::default(), false);
        }
        run.push(step, reading, settings.spike, tau_f);
        let all_above = |slopes: &[Option<f64>], least: f64| {
            slopes.iter().all(|slope| slope.is_some_and(|slope| slope > least))
        };
        let alarm = run.filtered[0].is_some_and(|g| g > settings.g_min)
            && (all_above(&run.slopes[..2], settings.slope_2)
                || all_above(&run.slopes, settings.slope_3));
        let waits = meals.last().is_some_and(|meal| step - meal.step < settings.pause);
        if alarm && !alarmed && !waits {
            let evidence = run.slopes[0].map_or(0.0, |slope| slope / sd);
            meals.push(Detection { step, carbs: None, evidence });
        }
        alarmed = alarm;
    }
    Ok(Detected { meals, sensitivity: None })
}

/// The filters over a run of readings without a gap; newest values first.
#[derive(Debug, Clone, Copy, Default)]
struct Run {
    steps: [Option<usize>; 3],
    spike_free: Option<f64>,
    filtered: [Option<f64>; 3],
    slopes: [Option<f64>; 3],
}

impl Run {
    /// Takes the next reading. `spike` in mg/dL/min, `tau_f` in min.
    fn push(&mut self, step: usize, reading: f64, spike: f64, tau_f: f64) {
        let passed = self.steps[0].map_or(1, |last| step - last) as f64 * STEP.0;
        let (most, share) = (spike * passed, passed / (tau_f + passed));
        let spike_free =
            self.spike_free.map_or(reading, |before| reading.clamp(before - most, before + most));
        let smooth =
            self.filtered[0].map_or(spike_free, |before| before + share * (spike_free - before));
        self.spike_free = Some(spike_free);
        self.steps = [Some(step), self.steps[0], self.steps[1]];
        self.filtered = [Some(smooth), self.filtered[0], self.filtered[1]];
        let slope = match (self.steps, self.filtered) {
            ([Some(c), Some(b), Some(a)], [Some(now), Some(before), Some(oldest)]) => {
                let [a, b, c] = [a, b, c].map(|step| step as f64 * STEP.0);
                Some(lagrange_slope([a, b, c], [oldest, before, now]))
            }
            _ => None,
        };
        self.slopes = [slope, self.slopes[0], self.slopes[1]];
    }
}

/// Slope at the last of three times, min, of the parabola through three values, mg/dL/min.
fn lagrange_slope([a, b, c]: [f64; 3], [oldest, before, now]: [f64; 3]) -> f64 {
    (c - b) / ((a - b) * (a - c)) * oldest
        + (c - a) / ((b - a) * (b - c)) * before
        + (2.0 * c - a - b) / ((c - a) * (c - b)) * now
}

/// Standard deviation of the slope of filtered readings whose only change is the sensor's error,
/// read every 5 min.
fn slope_sd(tau_f: f64) -> f64 {
    let mut run = Run {
        steps: [Some(2), Some(1), Some(0)],
        filtered: [Some(0.0); 3],
        spike_free: Some(0.0),
        slopes: [None; 3],
    };
    let response: Vec<f64> = (0..MEMORY)
        .map(|k| {
            run.push(3 + k, if k == 0 { 1.0 } else { 0.0 }, f64::INFINITY, tau_f);
            run.slopes[0].unwrap_or(0.0)
        })
        .collect();
    let mut correlation = vec![1.0, SENSOR_PHI[0] / (1.0 - SENSOR_PHI[1])];
    for lag in 2..MEMORY {
        let next = SENSOR_PHI[0] * correlation[lag - 1] + SENSOR_PHI[1] * correlation[lag - 2];
        correlation.push(next);
    }
    let pairs = response
        .iter()
        .enumerate()
        .flat_map(|(i, a)| response.iter().enumerate().map(move |(j, b)| (a * b, i.abs_diff(j))));
    let variance: f64 = pairs.map(|(product, lag)| product * correlation[lag]).sum();
    SENSOR_SD * variance.sqrt()
}

#[cfg(test)]
mod tests {
    use cohort::{Channel, Person, Record, Therapy};

    use super::*;

    fn found(readings: &[Option<f64>], settings: &GridSettings) -> Result<Detected, MealError> {
        let start = "2024-03-08T00:00:00".parse().expect("a literal time");
        let mut record = Record::new(start, readings.len()).expect("on the grid");
        record.channel_mut(Channel::Cgm).copy_from_slice(readings);
        let person = Person {
            id: "a".into(),
            weight: None,
            therapy: Therapy::Unknown,
            heart_rate_baseline: None,
            record,
        };
        let signals = Signals::of(&person).expect("values that can be");
        detect(&signals, settings)
    }

    fn steps_of(readings: &[Option<f64>]) -> Vec<usize> {
        let found = found(readings, &GridSettings::published()).expect("settings that can be");
        found.meals.iter().map(|meal| meal.step).collect()
    }

    /// Flat at `base`, from step 10 rising by `slope` mg/dL a minute to the end.
    fn ramp(base: f64, slope: f64, len: usize) -> Vec<Option<f64>> {
        (0..len).map(|k| Some(base + slope * 5.0 * (k as f64 - 10.0).max(0.0))).collect()
    }

    #[test]
    fn the_parabola_through_three_values_has_its_slope() {
        // g = 3 t^2 + 2 t + 1 has slope 2 at 0; equally and unequally spaced.
        for times in [[-10.0, -5.0, 0.0], [-20.0, -5.0, 0.0]] {
            let slope = lagrange_slope(times, times.map(|t| 3.0 * t * t + 2.0 * t + 1.0));
            assert!((slope - 2.0).abs() < 1e-12, "{slope}"); // rounding
        }
    }

    #[test]
    fn an_alarm_needs_height_and_slope() {
        // Base and slope of a ramp, and whether it is an alarm within 12 steps of rising.
        for (base, slope, alarm) in
            [(140.0, 2.0, true), (140.0, 1.4, false), (60.0, 1.0, false), (40.0, 2.0, true)]
        {
            let found = steps_of(&ramp(base, slope, 24));
            assert_eq!(!found.is_empty(), alarm, "{base} {slope}: {found:?}");
        }
        // From 40 at 10 mg/dL a step, filtered glucose is past 130 only ten steps later.
        assert!(steps_of(&ramp(40.0, 2.0, 24))[0] >= 19);
    }

    #[test]
    fn an_alarm_comes_two_steps_after_the_filtered_slope_passes() {
        // The low-pass filter passes 5/11 a step: slopes of filtered values after the kink of a
        // ramp of 10 mg/dL a step are 1.36, 1.65, 1.81 mg/dL/min (by hand), so that the last two
        // exceed 1.6 at the third step of the rise.
        assert_eq!(steps_of(&ramp(140.0, 2.0, 20)), [13]);
    }

    #[test]
    fn a_spike_is_no_meal_and_a_gap_begins_anew() {
        let mut spike = ramp(140.0, 0.0, 30);
        spike[15] = Some(300.0);
        assert!(steps_of(&spike).is_empty());
        let mut broken = ramp(140.0, 2.0, 19);
        broken[11..14].fill(None);
        // Readings at steps 10 and 14 are more than a quarter of an hour apart. The run that begins
        // at 14 has slopes of 1.65 at 16 and 1.81 at 17, as at the foot of a ramp.
        assert_eq!(steps_of(&broken[..17]), [] as [usize; 0]);
        assert_eq!(steps_of(&broken), [17]);
        // A sensor that is read every quarter of an hour is no broken one.
        let mut slow = ramp(140.0, 2.0, 28);
        for (k, reading) in slow.iter_mut().enumerate() {
            *reading = reading.filter(|_| k % 3 == 1);
        }
        assert_eq!(steps_of(&slow).len(), 1);
    }

    #[test]
    fn alarms_of_one_rise_are_one_meal() {
        // Rising, a plateau of three steps, rising again within the hour.
        let mut readings = ramp(120.0, 2.0, 40);
        for (k, reading) in readings.iter_mut().enumerate().skip(16) {
            *reading = Some(180.0 + 10.0 * (k as f64 - 19.0).max(0.0));
        }
        assert_eq!(steps_of(&readings).len(), 1);
    }

    #[test]
    fn a_time_constant_that_cannot_be_is_named() {
        for tau_f in [0.0, -6.0, f64::NAN, f64::INFINITY] {
            let settings = GridSettings { tau_f, ..GridSettings::published() };
            let error = found(&[None; 3], &settings).expect_err("no time constant");
            assert!(matches!(error, MealError::Setting { name: "tau_f", .. }), "{error}");
        }
    }

    #[test]
    fn the_noise_of_a_slope_is_that_of_simulated_errors() {
        // A long run of the autoregression, by a small generator of pseudo-random numbers.
        let tau_f = GridSettings::published().tau_f;
        let mut seed = 1_u64;
        let mut uniform = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        let (first, second) = (SENSOR_PHI[0] / (1.0 - SENSOR_PHI[1]), SENSOR_PHI[1]);
        let innovation = SENSOR_SD * ((1.0 - first * first) * (1.0 - second * second)).sqrt();
        let (mut errors, mut run, mut sum) = ([0.0; 2], Run::default(), 0.0);
        let n = 200_000_usize;
        for step in 0..n {
            // Sum of twelve uniform numbers: near normal with variance one.
            let normal = (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
            let next = SENSOR_PHI[0] * errors[0] + SENSOR_PHI[1] * errors[1] + innovation * normal;
            errors = [next, errors[0]];
            run.push(step, next, f64::INFINITY, tau_f);
            sum += run.slopes[0].unwrap_or(0.0).powi(2);
        }
        let sd = (sum / n as f64).sqrt();
        // 200,000 correlated slopes leave about half a per cent.
        assert!((slope_sd(tau_f) / sd - 1.0).abs() < 0.02, "{} {sd}", slope_sd(tau_f));
    }
}
