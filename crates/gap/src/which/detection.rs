//! What could have been found: the smallest size of an effect that these data would have shown.
//!
//! The held-out gain of an effect of amplitude theta is about half the square of a normal variable of mean
//! theta times the root of the information, less what fitting costs (half a nat). It clears its threshold
//! with 90 % probability when that mean lies 1.28 above the root of twice the threshold and one.

use effects::{Effect, Modulation, Port, Structure};
use physiology::{OpenLoop, STEPS_PER_DAY, simulate};
use rayon::prelude::*;

use super::Detectable;
use super::amplitude::Information;
use crate::calibrated_person::CalibratedPerson;
use crate::modulated_plant::ModulatedPlant;
use contract::diagnosis::DetectionPower;

/// Required probability of being found, and its normal quantile.
const PROBABILITY: f64 = 0.9;
const QUANTILE: f64 = 1.2816;
/// Most people over whom the shift of glucose is averaged.
const MOST_PEOPLE: usize = 20;

/// Standard errors below zero at which an estimate speaks against the form of an effect.
const AGAINST: f64 = 3.0;

/// The amplitude that would be found with 90 % probability; `all` is everybody's information together.
///
/// `None` where the data speak clearly against the effect: its form is then not what these bodies or sensors
/// do, and how much of it would be found cannot be told.
pub(super) fn amplitude(all: Information, threshold: f64) -> Option<f64> {
    let root = all.information.max(f64::MIN_POSITIVE).sqrt();
    let likely = all.score > -AGAINST * root;
    likely.then(|| ((2.0 * threshold + 1.0).sqrt() + QUANTILE) / root)
}

/// How far each detectable amplitude moves glucose: mean absolute difference of free runs of a day, with the
/// effect and without, from the same filtered states under the recorded inputs. Smallest shift first.
///
/// Effects of which no believable amplitude would be found are left out, and so are those of the sensor and those
/// that a difference of structure mimics: sensors and plants differ by more than the filter's noise says, and
/// the blind check does not find them at the sizes that this would give.
pub(crate) fn power(
    people: &[CalibratedPerson<'_>],
    library: &[Box<dyn Effect>],
    detectable: &[Detectable],
) -> Vec<DetectionPower> {
    let mut found: Vec<DetectionPower> = detectable
        .iter()
        .filter_map(|entry| {
            let effect = library.iter().find(|effect| effect.card().id == entry.effect)?.as_ref();
            let card = effect.card();
            let unsure = card.port == Port::Sensor || card.relations.structure != Structure::Unlike;
            if unsure || entry.amplitude > card.prior.largest {
                return None;
            }
            let shifts: Vec<f64> = people
                .par_iter()
                .zip(&entry.variants)
                .take(MOST_PEOPLE)
                .filter_map(|(input, variant)| shift(input, effect, *variant, entry.amplitude))
                .collect();
            let mean = shifts.iter().sum::<f64>() / shifts.len().max(1) as f64;
            (mean > 0.0).then(|| DetectionPower {
                effect: card.id.name().to_owned(),
                shift_mg_dl: mean,
                power: PROBABILITY,
            })
        })
        .collect();
    found.sort_by(|a, b| a.shift_mg_dl.total_cmp(&b.shift_mg_dl));
    found
}

/// Mean absolute change of what the sensor shows in one person, mg/dL; `None` if a run fails or there is no
/// whole day.
fn shift(
    input: &CalibratedPerson<'_>,
    effect: &dyn Effect,
    variant: usize,
    amplitude: f64,
) -> Option<f64> {
    let course = input.course();
    let mut modulations = vec![Modulation::NEUTRAL; course.len()];
    effect.modulate(variant, amplitude, &course, &mut modulations);
    let with = ModulatedPlant::new(&input.calibration.model, &modulations);
    let without = ModulatedPlant::new(&input.calibration.model, &[]);
    let (mut sum, mut count) = (0.0, 0.0);
    for day in 1..course.len() / STEPS_PER_DAY {
        let first = day * STEPS_PER_DAY;
        let start = ModulatedPlant::start(first, &input.calibration.filtered.states[first]);
        let steps = STEPS_PER_DAY.min(course.len() - 1 - first);
        let run = |plant: &ModulatedPlant<'_>| {
            let inputs = &input.observations.inputs[first..];
            simulate(plant, start, &mut OpenLoop::new(inputs), steps).ok()
        };
        let (changed, plain) = (run(&with)?, run(&without)?);
        for (a, b) in changed.states.iter().zip(&plain.states) {
            sum += (with.reading(a) - without.reading(b)).abs();
            count += 1.0;
        }
    }
    (count > 0.0).then(|| sum / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_information_shows_smaller_effects_and_a_threshold_larger_ones() {
        let of = |information, threshold| {
            amplitude(Information { information, score: -5.0 }, threshold).expect("not against it")
        };
        // sqrt(9) + 1.2816 over sqrt(100).
        assert!((of(100.0, 4.0) - 0.42816).abs() < 1e-12);
        assert!(of(400.0, 4.0) < of(100.0, 4.0));
        assert!(of(100.0, 12.0) > of(100.0, 4.0));
        assert_eq!(amplitude(Information { information: 100.0, score: -31.0 }, 4.0), None);
    }
}
