//! Kinds of sensor.

use ode_sim::SensorModel;
use ode_sim::sensor::Autoregressive;
use physiology::{MgPerDl, Minutes, STEPS_PER_HOUR};
use rand::{Rng, RngExt};

use crate::generator::Generator;
use crate::stream::standard_normal;

/// Steps in a quarter of an hour.
const QUARTER: usize = 3;

/// A family of noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Noise {
    /// The published model of one make: two processes of order two, drift of gain and offset.
    Published,
    /// One process of order one.
    First,
    /// One process of order two, smoother than the published.
    Second,
    /// A weak process of order one with spikes of single readings.
    Spiky,
    /// A process of order one, read every 15 min and interpolated in between.
    Quarterly,
}

impl Noise {
    /// Families of a hand with their weights. Each hand lacks some, and each prefers another.
    const fn weights(hand: Generator) -> [(Self, f64); 3] {
        match hand {
            Generator::Hovorka => {
                [(Self::Published, 0.5), (Self::First, 0.3), (Self::Quarterly, 0.2)]
            }
            Generator::Padova => [(Self::First, 0.5), (Self::Second, 0.3), (Self::Published, 0.2)],
            Generator::Minimal => [(Self::Second, 0.4), (Self::Spiky, 0.4), (Self::Quarterly, 0.2)],
            Generator::Saturating => {
                [(Self::Quarterly, 0.4), (Self::Spiky, 0.3), (Self::First, 0.3)]
            }
        }
    }
}

/// The sensors that one person wears.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorKind {
    /// Its noise.
    pub noise: Noise,
    /// SD of the noise relative to the family's.
    pub scale: f64,
    /// Interstitial lag, min.
    pub lag: Minutes,
    /// Spread of the gain between sensors, as a share. With drift and noise, 5 % gives absolute
    /// differences near the 9 to 10 % that factory-calibrated sensors show (Wadwa et al., Diabetes
    /// Technol Ther 2018;20:395).
    pub gain_spread: f64,
    /// Spread of the offset between sensors, mg/dL.
    pub offset_spread: f64,
    /// Days for which one is worn.
    pub life_days: usize,
    /// Time after which the drift of one that is still worn starts anew.
    pub calibrated_every: Minutes,
    /// Steps of warm-up without readings.
    pub warm_up: usize,
    /// Days between lost stretches, on average.
    pub days_between_losses: f64,
    /// Steps of a lost stretch, on average.
    pub loss_steps: f64,
    /// Spikes a day, on average.
    pub spikes_a_day: f64,
}

impl SensorKind {
    /// The Dexcom G6 as published (Vettoretti et al., Sensors 2019;19:5320), worn for ten days.
    pub const PUBLISHED: Self = Self {
        noise: Noise::Published,
        scale: 1.0,
        lag: ode_sim::sensor::INTERSTITIAL_LAG,
        gain_spread: 0.05,
        offset_spread: 0.0,
        life_days: 10,
        calibrated_every: Minutes(14_400.0),
        warm_up: 2 * STEPS_PER_HOUR,
        days_between_losses: 2.0,
        loss_steps: 8.0,
        spikes_a_day: 0.0,
    };

    /// Draws the kind of a world, and a person's within it.
    ///
    /// Family by the weights of the hand; worn 7, 10 or 14 days (G5, G6, Libre; a warm-up of 1 or 2
    /// h); gains 2 to 8 % and offsets 0 to 6 mg/dL apart (mean absolute differences of 8 to 13 %
    /// between makes, Freckmann et al., J Diabetes Sci Technol 2019;13:575); lag 5 to 11 min (Basu
    /// et al., Diabetes 2013;62:4083); noise 0.6 to 1.4 times the family's; lost stretches every
    /// 0.7 to 6 days of 20 to 90 min on average; 0.3 to 3 spikes a day where there are any
    /// (assumed). Drift starts anew with the next sensor, however long one is worn.
    #[must_use]
    pub(super) fn sample(hand: Generator, world: &mut impl Rng, own: &mut impl Rng) -> Self {
        let mut draw = world.random::<f64>();
        let weights = Noise::weights(hand);
        let mut noise = weights[0].0;
        for (family, weight) in weights {
            noise = family;
            if draw < weight {
                break;
            }
            draw -= weight;
        }
        let life_days = [7, 10, 14][world.random_range(0..3_usize)];
        let warm_up = world.random_range(1..=2_usize) * STEPS_PER_HOUR;
        let (gain_spread, offset_spread) =
            (world.random_range(0.02..0.08), world.random_range(0.0..6.0));
        let (lag, scale) = (world.random_range(5.0..11.0), world.random_range(0.6..1.4));
        let (between, length) = (world.random_range(0.7..6.0), world.random_range(4.0..18.0));
        let spikes = world.random_range(0.3..3.0);
        let mut about = |value: f64| value * (0.15 * standard_normal(own)).clamp(-0.3, 0.3).exp();
        Self {
            noise,
            scale: about(scale),
            lag: Minutes(about(lag)),
            gain_spread,
            offset_spread,
            life_days,
            calibrated_every: Minutes(f64::INFINITY),
            warm_up,
            days_between_losses: about(between),
            loss_steps: about(length),
            spikes_a_day: if noise == Noise::Spiky { about(spikes) } else { 0.0 },
        }
    }

    /// The readings as a record on five-minute steps holds them. Where a sensor reads every 15 min,
    /// values in between lie on the line from one to the next, if both are there.
    #[must_use]
    pub fn drawn_through(
        &self,
        readings: impl Iterator<Item = Option<MgPerDl>>,
    ) -> Vec<Option<MgPerDl>> {
        let readings: Vec<Option<MgPerDl>> = readings.collect();
        if self.noise != Noise::Quarterly {
            return readings;
        }
        let read = |step: usize| readings.get(step).copied().flatten().map(|g| g.0);
        (0..readings.len())
            .map(|step| {
                let (from, later) = (step / QUARTER * QUARTER, step % QUARTER);
                let share = later as f64 / QUARTER as f64;
                let before = read(from)?;
                let after = if later == 0 { before } else { read(from + QUARTER)? };
                Some(MgPerDl(before + share * (after - before)))
            })
            .collect()
    }

    /// The model of such a sensor, without the gain and offset of the single sensor.
    ///
    /// Families besides the published one: a SD of 5 mg/dL and a correlation of 0.94 from reading
    /// to reading (AR(1)), 6 mg/dL with 0.97 and a second coefficient of -0.35 (AR(2)), both of the
    /// order of the published processes (Facchinetti et al., IEEE Trans Biomed Eng 2014;61:620); 3
    /// mg/dL with 0.85 and spikes; 6 mg/dL with 0.95 for readings every 15 min. Gain and offset do
    /// not drift in them.
    #[must_use]
    pub(crate) fn model(&self) -> SensorModel {
        let published = SensorModel::dexcom_g6();
        let scaled = |noise: Autoregressive| Autoregressive {
            innovation_variance: noise.innovation_variance * self.scale * self.scale,
            ..noise
        };
        let own = |sd: f64, rho: f64, phi_2: f64| {
            let phi_1 = rho * (1.0 - phi_2); // Yule-Walker
            let unit = Autoregressive { phi_1, phi_2, innovation_variance: 1.0 };
            let innovation_variance = sd * sd / unit.variance();
            SensorModel {
                gain: [1.0, 0.0, 0.0],
                offset: [0.0; 3],
                own_noise: scaled(Autoregressive { innovation_variance, ..unit }),
                common_noise: None,
                ..published
            }
        };
        let model = match self.noise {
            Noise::Published => SensorModel {
                own_noise: scaled(published.own_noise),
                common_noise: published.common_noise.map(scaled),
                ..published
            },
            Noise::First => own(5.0, 0.94, 0.0),
            Noise::Second => own(6.0, 0.97, -0.35),
            Noise::Spiky => own(3.0, 0.85, 0.0),
            Noise::Quarterly => own(6.0, 0.95, 0.0),
        };
        SensorModel { lag: self.lag, calibrated_every: self.calibrated_every, ..model }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_kind_is_the_published_model_and_all_can_be_run() {
        assert_eq!(SensorKind::PUBLISHED.model(), SensorModel::dexcom_g6());
        for (noise, sd) in [
            (Noise::First, 5.0),
            (Noise::Second, 6.0),
            (Noise::Spiky, 3.0),
            (Noise::Quarterly, 6.0),
        ] {
            let kind = SensorKind { noise, ..SensorKind::PUBLISHED };
            let model = kind.model().validated().expect("stationary");
            assert!((model.own_noise.variance().sqrt() - sd).abs() < 1e-9, "{noise:?}"); // rounding
        }
    }
}
