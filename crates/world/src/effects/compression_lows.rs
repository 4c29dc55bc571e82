//! Readings fall while the person lies on the sensor, and rebound when they turn.

use physiology::STEP;
use rand::{Rng, RngExt};

use super::forms::CompressionForm;
use crate::behaviour::Life;
use crate::stream::standard_normal;

/// Candidates in each night; each occurs with [`CHANCE`] times the amplitude.
const CANDIDATES: usize = 3;
/// Chance of a candidate at amplitude 1: an event on three nights in ten (assumed).
const CHANCE: f64 = 0.1;
/// Fall of the reading, mg/dL: 24 (10 to 48), and its length, min: 45 (30 to 70) (sizes of the
/// design of this effect, after Mensh et al., J Diabetes Sci Technol 2013;7:863 and Baysal et al.,
/// J Diabetes Sci Technol 2014;8:1091).
const FALL: (f64, f64, f64) = (24.0, 10.0, 48.0);
const MINUTES: (f64, f64, f64) = (45.0, 30.0, 70.0);
/// Time constants of the fall and of the rebound, min: sharp.
const FALL_TIME: f64 = 6.0;
const REBOUND_TIME: f64 = 8.0;

/// Pressure on the sensor that would occur in a night.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compression {
    /// Uniform draw from 0 to 1: it occurs if this lies below its chance.
    pub draw: f64,
    /// First step.
    pub from: usize,
    /// Length, min.
    pub minutes: f64,
    /// Fall of the reading, mg/dL.
    pub fall: f64,
}

/// Draws the candidates of every night.
#[must_use]
pub(super) fn sample(life: &Life, rng: &mut (impl Rng + ?Sized)) -> Vec<Compression> {
    let mut drawn = Vec::with_capacity(CANDIDATES * life.nights.len());
    for night in &life.nights {
        for _ in 0..CANDIDATES {
            let (draw, place) = (rng.random(), rng.random_range(0.1..0.85));
            let mut around = |(middle, low, high): (f64, f64, f64)| {
                (middle * (0.35 * standard_normal(rng)).exp()).clamp(low, high)
            };
            let (fall, minutes) = (around(FALL), around(MINUTES));
            let from = night.onset + (place * (night.wake - night.onset) as f64) as i64;
            if let Ok(from) = usize::try_from(from) {
                drawn.push(Compression { draw, from, minutes, fall });
            }
        }
    }
    drawn
}

/// Lowers what is added to the offset (mg/dL, beside the gain, one pair per step) by the events
/// that occur.
pub(super) fn act(
    form: CompressionForm,
    added: &mut [(f64, f64)],
    candidates: &[Compression],
    amplitude: f64,
) {
    let (deeper, longer) = match form {
        CompressionForm::Sharp => (1.0, 1.0),
        CompressionForm::Long => (0.6, 2.0),
        CompressionForm::Brief => (1.5, 0.4),
        CompressionForm::Sinking => (1.2, 1.3),
    };
    for event in candidates.iter().filter(|c| c.draw < amplitude * CHANCE) {
        let minutes = longer * event.minutes;
        let steps = ((minutes + 6.0 * REBOUND_TIME) / STEP.0) as usize;
        for (later, (_, offset)) in added.iter_mut().skip(event.from).take(steps).enumerate() {
            *offset -= deeper * event.fall * course(form, later as f64 * STEP.0, minutes);
        }
    }
}

/// Share of the fall `minutes` after its beginning.
fn course(form: CompressionForm, minutes: f64, length: f64) -> f64 {
    let (pressed, rebound) = match form {
        CompressionForm::Sinking => (minutes.min(length) / length, 0.25 * REBOUND_TIME),
        _ => (1.0 - (-minutes.min(length) / FALL_TIME).exp(), REBOUND_TIME),
    };
    pressed * (-(minutes - length).max(0.0) / rebound).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reading_falls_sharply_and_comes_back() {
        let event = Compression { draw: 0.05, from: 10, minutes: 45.0, fall: 24.0 };
        let act = |amplitude| {
            let mut added = [(0.0, 0.0); 60];
            act(CompressionForm::Sharp, &mut added, &[event], amplitude);
            assert!(added.iter().all(|(gain, _)| *gain == 0.0));
            added.map(|(_, offset)| offset)
        };
        let offset = act(1.0);
        assert_eq!(offset[10], 0.0);
        assert!(offset[12] < -0.8 * 24.0 && offset[18] < -0.99 * 24.0);
        assert!(offset[22] > -0.2 * 24.0 && offset[40] == 0.0, "{offset:?}");
        assert_eq!(act(0.4), [0.0; 60]);
    }
}
