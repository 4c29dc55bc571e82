//! Continuous glucose sensors: interstitial lag, calibration that drifts, coloured noise, display.
//!
//! The form is that of Facchinetti et al. 2014: CGM(t) = a(t) IG(t) + b(t) + v(t), where IG lags
//! glucose by a first-order system, a and b are polynomials in the days since calibration, and v
//! is the sum of autoregressive processes of order two. Coefficients: Vettoretti et al. 2018
//! (Dexcom G5) and Vettoretti, Del Favero et al. 2019 (Dexcom G6), the means over their sensors.

use physiology::{MgPerDl, Minutes, STEP};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::error::{OdeError, not_negative, require};

/// Range that a sensor can show, mg/dL (Dexcom G5 and G6).
pub const DISPLAY_RANGE: (f64, f64) = (40.0, 400.0);
/// Lag of the interstitium used for the two named sensors.
///
/// The literature has 6 to 12 min; the error models leave it to the individual.
pub const INTERSTITIAL_LAG: Minutes = Minutes(8.0);

/// An autoregressive process of order two, v(k) = phi1 v(k-1) + phi2 v(k-2) + e(k), one value per
/// reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Autoregressive {
    /// Coefficient of the last value.
    pub phi_1: f64,
    /// Coefficient of the last but one.
    pub phi_2: f64,
    /// Variance of e, (mg/dL)^2.
    pub innovation_variance: f64,
}

impl Autoregressive {
    /// Whether the process has a stationary distribution: both roots inside the unit circle.
    #[must_use]
    pub fn is_stationary(&self) -> bool {
        self.phi_2.abs() < 1.0 && self.phi_1.abs() < 1.0 - self.phi_2
    }

    /// Autocorrelation at lag 1 and 2: phi1/(1 - phi2), and phi1 rho1 + phi2 (Yule-Walker).
    #[must_use]
    pub fn autocorrelation(&self) -> (f64, f64) {
        let first = self.phi_1 / (1.0 - self.phi_2);
        (first, self.phi_1 * first + self.phi_2)
    }

    /// Variance of the stationary process, (mg/dL)^2.
    #[must_use]
    pub fn variance(&self) -> f64 {
        let (first, second) = self.autocorrelation();
        self.innovation_variance / (1.0 - self.phi_1 * first - self.phi_2 * second)
    }

    /// The last two values (last first), drawn from the stationary distribution.
    fn draw(&self, rng: &mut impl Rng) -> [f64; 2] {
        let (sd, rho) = (self.variance().sqrt(), self.autocorrelation().0);
        let last: f64 = StandardNormal.sample(rng);
        let own: f64 = StandardNormal.sample(rng);
        [sd * last, sd * (rho * last + (1.0 - rho * rho).sqrt() * own)]
    }

    fn following(&self, past: [f64; 2], rng: &mut impl Rng) -> [f64; 2] {
        let e: f64 = StandardNormal.sample(rng);
        let value =
            self.phi_1 * past[0] + self.phi_2 * past[1] + self.innovation_variance.sqrt() * e;
        [value, past[0]]
    }
}

/// The error model of a make of sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorModel {
    /// Time constant of the interstitium; 0 for none.
    pub lag: Minutes,
    /// Gain a(t) = a0 + a1 t + a2 t^2, t in days since calibration; unitless, 1/d, 1/d^2.
    pub gain: [f64; 3],
    /// Offset b(t) = b0 + b1 t + b2 t^2; mg/dL, mg/dL/d, mg/dL/d^2.
    pub offset: [f64; 3],
    /// Noise of the sensor itself.
    pub own_noise: Autoregressive,
    /// Noise that all sensors on one body share.
    pub common_noise: Option<Autoregressive>,
    /// Time after which gain and offset start anew: calibration or a new sensor.
    pub calibrated_every: Minutes,
}

impl SensorModel {
    /// Dexcom G5 (Vettoretti et al. 2018, Table 1), calibrated twice a day.
    #[must_use]
    pub fn dexcom_g5() -> Self {
        Self {
            lag: INTERSTITIAL_LAG,
            gain: [1.04, 0.02, 0.0],
            offset: [-8.75, 0.0, 0.0],
            own_noise: Autoregressive { phi_1: 1.27, phi_2: -0.42, innovation_variance: 7.64 },
            common_noise: None,
            calibrated_every: Minutes(720.0),
        }
    }

    /// Dexcom G6 (Vettoretti, Del Favero et al. 2019, Tables 1 and 2), factory-calibrated for ten
    /// days.
    #[must_use]
    pub fn dexcom_g6() -> Self {
        Self {
            lag: INTERSTITIAL_LAG,
            gain: [1.048, -0.033, 0.002],
            offset: [-6.398, 6.179, -0.448],
            own_noise: Autoregressive { phi_1: 1.2204, phi_2: -0.3308, innovation_variance: 3.641 },
            common_noise: Some(Autoregressive {
                phi_1: 1.34,
                phi_2: -0.492,
                innovation_variance: 5.538,
            }),
            calibrated_every: Minutes(14_400.0),
        }
    }

    /// Checks that the model can be run.
    ///
    /// # Errors
    /// [`OdeError::Argument`] for a negative lag or variance, a noise process without a stationary
    /// distribution, or a calibration interval that is not positive.
    pub fn validated(self) -> Result<Self, OdeError> {
        not_negative("sensor lag, min", self.lag.0)?;
        let every = self.calibrated_every.0;
        require(every > 0.0, "calibration interval, min", every, "positive")?;
        for noise in std::iter::once(self.own_noise).chain(self.common_noise) {
            not_negative("noise variance, (mg/dL)^2", noise.innovation_variance)?;
            let requirement = "below 1 - phi_2 in size";
            require(noise.is_stationary(), "phi_1 of the noise", noise.phi_1, requirement)?;
        }
        Ok(self)
    }

    /// Gain and offset (mg/dL) `days` after calibration.
    #[must_use]
    pub fn calibration(&self, days: f64) -> (f64, f64) {
        let at = |c: [f64; 3]| c[0] + days * (c[1] + days * c[2]);
        (at(self.gain), at(self.offset))
    }
}

/// The clamp of a sensor's display: values outside 40 to 400 mg/dL show as the nearest end.
///
/// NaN stays NaN.
#[must_use]
pub fn clamp_to_display(glucose: MgPerDl) -> MgPerDl {
    MgPerDl(glucose.0.clamp(DISPLAY_RANGE.0, DISPLAY_RANGE.1))
}

/// What a sensor makes of glucose at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Glucose in the interstitium.
    pub interstitial: MgPerDl,
    /// Reading before the display.
    pub raw: MgPerDl,
    /// Reading as shown: [`clamp_to_display`] of `raw`.
    pub shown: MgPerDl,
}

/// A sensor that is being worn, read every 5 min.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    model: SensorModel,
    interstitial: f64,
    glucose: f64,
    since_calibration: f64,
    own: [f64; 2],
    common: [f64; 2],
}

impl Sensor {
    /// Inserts a sensor while glucose has been `glucose` for long; noise starts from its
    /// stationary distribution.
    ///
    /// # Errors
    /// [`OdeError::Argument`] for a model that cannot be ([`SensorModel::validated`]) or glucose
    /// that is not finite.
    pub fn inserted(
        model: SensorModel,
        glucose: MgPerDl,
        rng: &mut impl Rng,
    ) -> Result<Self, OdeError> {
        let model = model.validated()?;
        finite(glucose)?;
        let own = model.own_noise.draw(rng);
        let common = model.common_noise.map_or([0.0; 2], |noise| noise.draw(rng));
        Ok(Self {
            model,
            interstitial: glucose.0,
            glucose: glucose.0,
            since_calibration: 0.0,
            own,
            common,
        })
    }

    /// The reading now, without moving on.
    #[must_use]
    pub fn reading(&self) -> Reading {
        let (gain, offset) = self.model.calibration(self.since_calibration / 1440.0);
        let raw = MgPerDl(gain * self.interstitial + offset + self.own[0] + self.common[0]);
        Reading { interstitial: MgPerDl(self.interstitial), raw, shown: clamp_to_display(raw) }
    }

    /// The reading 5 min later, when glucose has gone straight to `glucose` from its last value.
    ///
    /// The lag dIG/dt = (G - IG)/lag is solved exactly for that ramp.
    ///
    /// # Errors
    /// [`OdeError::Argument`] for glucose that is not finite.
    pub fn next(&mut self, glucose: MgPerDl, rng: &mut impl Rng) -> Result<Reading, OdeError> {
        finite(glucose)?;
        let lag = self.model.lag.0;
        self.interstitial = if lag == 0.0 {
            glucose.0
        } else {
            let slope = (glucose.0 - self.glucose) / STEP.0;
            // Behind a ramp IG settles `slope x lag` below it.
            let behind = self.interstitial - (self.glucose - slope * lag);
            glucose.0 - slope * lag + behind * (-STEP.0 / lag).exp()
        };
        self.glucose = glucose.0;
        self.since_calibration += STEP.0;
        if self.since_calibration >= self.model.calibrated_every.0 {
            self.since_calibration = 0.0;
        }
        self.own = self.model.own_noise.following(self.own, rng);
        if let Some(noise) = self.model.common_noise {
            self.common = noise.following(self.common, rng);
        }
        Ok(self.reading())
    }
}

fn finite(glucose: MgPerDl) -> Result<(), OdeError> {
    require(glucose.0.is_finite(), "glucose", glucose.0, "finite")
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha12Rng;

    const QUIET: Autoregressive =
        Autoregressive { phi_1: 0.0, phi_2: 0.0, innovation_variance: 0.0 };

    /// A sensor without any error but the clamp of its display.
    fn ideal() -> SensorModel {
        SensorModel {
            lag: Minutes(0.0),
            gain: [1.0, 0.0, 0.0],
            offset: [0.0; 3],
            own_noise: QUIET,
            common_noise: None,
            ..SensorModel::dexcom_g6()
        }
    }

    fn read(model: SensorModel, glucose: &[MgPerDl]) -> Vec<Reading> {
        let mut rng = ChaCha12Rng::seed_from_u64(6);
        let mut sensor = Sensor::inserted(model, glucose[0], &mut rng).expect("a sensor");
        let mut readings = vec![sensor.reading()];
        readings.extend(glucose[1..].iter().map(|g| sensor.next(*g, &mut rng).expect("finite")));
        readings
    }

    fn autocorrelation(values: &[f64], lag: usize) -> f64 {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let product = |lag: usize| {
            let pairs = values.iter().zip(&values[lag..]);
            pairs.map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>()
        };
        product(lag) / product(0)
    }

    #[test]
    fn noise_has_the_autocorrelation_and_variance_of_its_coefficients() {
        for model in [SensorModel::dexcom_g5(), SensorModel::dexcom_g6()] {
            for noise in std::iter::once(model.own_noise).chain(model.common_noise) {
                let mut rng = ChaCha12Rng::seed_from_u64(4);
                let mut past = noise.draw(&mut rng);
                let values: Vec<f64> = (0..200_000)
                    .map(|_| {
                        past = noise.following(past, &mut rng);
                        past[0]
                    })
                    .collect();
                let (first, second) = noise.autocorrelation();
                // Four standard errors, at most 1/sqrt(200,000) each.
                assert!((autocorrelation(&values, 1) - first).abs() < 0.009);
                assert!((autocorrelation(&values, 2) - second).abs() < 0.009);
                let variance = values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64;
                // Some 20,000 independent values: 1 % standard error of a variance.
                assert!((variance / noise.variance() - 1.0).abs() < 0.04);
            }
        }
    }

    #[test]
    fn noise_starts_from_its_stationary_distribution() {
        let noise = SensorModel::dexcom_g6().own_noise;
        let mut rng = ChaCha12Rng::seed_from_u64(5);
        let n = 100_000;
        let (mut variance, mut product) = (0.0, 0.0);
        for _ in 0..n {
            let [last, before] = noise.draw(&mut rng);
            variance += last * last / f64::from(n);
            product += last * before / f64::from(n);
        }
        // Four standard errors of a mean of squares: 4 sqrt(2 / n) = 1.8 %.
        assert!((variance / noise.variance() - 1.0).abs() < 0.018);
        assert!((product / variance - noise.autocorrelation().0).abs() < 0.018);
    }

    #[test]
    fn an_ideal_sensor_shows_glucose_within_its_range() {
        let readings = read(ideal(), &[30.0, 100.0, 250.0, 450.0].map(MgPerDl));
        let shown: Vec<f64> = readings.iter().map(|r| r.shown.0).collect();
        assert_eq!(shown, [40.0, 100.0, 250.0, 400.0]);
        assert_eq!(readings[3].raw.0, 450.0);
    }

    #[test]
    fn the_interstitium_settles_behind_a_ramp_by_slope_times_lag() {
        let model = SensorModel { lag: Minutes(10.0), ..ideal() };
        let course: Vec<MgPerDl> = (0..100).map(|k| MgPerDl(100.0 + 2.0 * f64::from(k))).collect();
        let readings = read(model, &course);
        let last = readings.last().expect("a hundred readings");
        // 0.4 mg/dL/min x 10 min; exp(-50) of the start is left.
        assert!((course[99].0 - last.interstitial.0 - 4.0).abs() < 1e-9);
        let constant = read(model, &[MgPerDl(90.0); 5]);
        assert!(constant.iter().all(|r| (r.shown.0 - 90.0).abs() < 1e-12)); // rounding
    }

    #[test]
    fn calibration_drifts_and_starts_anew() {
        let model =
            SensorModel { own_noise: QUIET, common_noise: None, ..SensorModel::dexcom_g6() };
        let readings = read(model, &[MgPerDl(150.0); 2881]);
        let at = |day: f64| {
            150.0 * (1.048 - 0.033 * day + 0.002 * day * day) - 6.398 + 6.179 * day
                - 0.448 * day * day
        };
        assert!((readings[0].raw.0 - at(0.0)).abs() < 1e-9); // rounding
        assert!((readings[288 * 5].raw.0 - at(5.0)).abs() < 1e-9);
        assert!((readings[2880].raw.0 - at(0.0)).abs() < 1e-9);
    }

    #[test]
    fn models_that_cannot_be_are_refused() {
        let mut explosive = SensorModel::dexcom_g5();
        explosive.own_noise.phi_1 = 1.5;
        assert!(explosive.validated().is_err());
        let mut rng = ChaCha12Rng::seed_from_u64(9);
        assert!(Sensor::inserted(ideal(), MgPerDl(f64::NAN), &mut rng).is_err());
        let backwards = SensorModel { lag: Minutes(-1.0), ..ideal() };
        assert!(backwards.validated().is_err());
    }
}
