//! Sensor lag by the likelihood of the whole filter.
//!
//! A constant lag leaves next to no mean in the innovations: the filter takes the slower glucose for glucose, and
//! what is left is shared with slow meals and slow insulin. It changes how glucose may move from one reading to
//! the next, and that is in the filter's gains, which signatures hold. So the filter is run again at each of some lags,
//! gains and all, and the lags are compared by the likelihood of the readings on days held out. What is tested is a lag
//! beyond the usual ones, which are tried as well: bodies and sensors below it are no finding. The likelihood has one
//! top along the lag: where a cohort likes the first longer lag less than the usual one next to it, no other is run.

use effects::{Course, Effect, Field, Modulation};

use super::folds::{FOLDS, inside, outside};
use crate::calibrated_person::CalibratedPerson;
use crate::error::GapError;
use crate::filter::calibration::CalibrationRule;
use crate::filter::kalman::innovations;
use crate::filter::scored::{Whitening, normalised};
use crate::filter::whitening::{huber_loss, robust_scale};
use crate::log_sum::raised;

/// Amplitudes in the order in which they are run: 8 and 10 min, then 6, 12, 16, 22 and 32 min.
pub(super) const AMPLITUDES: [f64; 7] = [0.0, 0.55, -0.71, 1.0, 1.7, 2.5, 3.4];
/// How many of them are run for everybody, the others where these call for it.
pub(super) const FIRST: usize = 2;
/// Indices of those that are usual, and of those beyond.
const USUAL: [usize; 2] = [0, 2];
const LONGER: [usize; 5] = [1, 3, 4, 5, 6];
/// How much the other people's evidence for a lag counts for a person's own.
const SHARED: f64 = 0.5;
/// Least standard error of the mean amplitude: a third of the distance between neighbouring lags.
const LEAST_ERROR: f64 = 0.2;

/// Log likelihoods of one person: by amplitude, all of [`AMPLITUDES`] or the first alone, and by day of the record,
/// nats.
pub(super) type Likelihoods = Vec<Vec<f64>>;

/// Whether a cohort likes the first longer lag better than the usual one next to it.
pub(super) fn calls_for_longer(people: &[&Likelihoods]) -> bool {
    total(people, USUAL[0]) < total(people, LONGER[0])
}

/// Log likelihood of all days of everybody at an amplitude.
fn total(people: &[&Likelihoods], amplitude: usize) -> f64 {
    people.iter().map(|person| person[amplitude].iter().sum::<f64>()).sum()
}

/// The answer.
#[derive(Debug, Clone)]
pub(super) struct LagEvidence {
    /// Gain of each person, nats.
    pub(super) gains: Vec<f64>,
    /// Mean amplitude and its standard error.
    pub(super) mean: (f64, f64),
    /// Each person's amplitude and its standard deviation.
    pub(super) personal: Vec<(f64, f64)>,
}

/// Log likelihoods of one person's days at some amplitudes of the lag.
///
/// # Errors
/// As [`filter`](crate::filter::kalman::filter).
pub(super) fn likelihoods(
    person: &CalibratedPerson<'_>,
    rule: &CalibrationRule,
    effect: &dyn Effect,
    amplitudes: &[f64],
) -> Result<Likelihoods, GapError> {
    let CalibratedPerson { observations, calibration, .. } = *person;
    let steps = observations.len();
    let scored = rule.scored(observations, &(0..steps));
    let of = |amplitude: &f64| {
        let mut one = [Modulation::NEUTRAL];
        effect.modulate(0, *amplitude, &Course::default(), &mut one);
        let all = if one[0].is_neutral() {
            // The calibration's own run.
            calibration.filtered.innovations.clone()
        } else {
            let model = calibration.model.with_lag(one[0][Field::SensorLag]);
            innovations(&model, observations, steps)?
        };
        let spread = |left: &[Option<f64>]| robust_scale(left).max(f64::MIN_POSITIVE);
        let (Whitening { scale, .. }, left) = Whitening::fitted(&normalised(&all, &scored), spread);
        let mut days = vec![0.0; steps.div_ceil(physiology::STEPS_PER_DAY)];
        for (step, (w, innovation)) in left.iter().zip(&all).enumerate() {
            if let (Some(w), Some(innovation)) = (w, innovation) {
                days[step / physiology::STEPS_PER_DAY] -=
                    0.5 * innovation.variance.ln() + scale.ln() + huber_loss(w / scale, 1.0);
            }
        }
        Ok(days)
    };
    amplitudes.iter().map(of).collect()
}

/// Held-out evidence for a longer lag than usual, none where the cohort does not call for one. One entry a person.
pub(super) fn score(people: &[&Likelihoods]) -> LagEvidence {
    let known = people.iter().map(|person| person.len()).min().unwrap_or(0);
    if !calls_for_longer(people) || known < AMPLITUDES.len() {
        let none = vec![0.0; people.len()];
        let nobody = vec![(0.0, LEAST_ERROR); people.len()];
        return LagEvidence { gains: none, mean: (0.0, LEAST_ERROR), personal: nobody };
    }
    let mut gains = vec![0.0; people.len()];
    for index in 0..FOLDS {
        let trained = |amplitude: usize| -> f64 {
            people.iter().map(|person| outside(&person[amplitude], index)).sum()
        };
        let best = |among: &[usize]| -> usize {
            let of = |a: &&usize, b: &&usize| trained(**a).total_cmp(&trained(**b));
            among.iter().max_by(of).copied().unwrap_or(0)
        };
        let (usual, long) = (best(&USUAL), best(&LONGER));
        if trained(long) <= trained(usual) {
            continue;
        }
        for (gain, person) in gains.iter_mut().zip(people) {
            *gain += inside(&person[long], index) - inside(&person[usual], index);
        }
    }
    let totals = LONGER.map(|amplitude| total(people, amplitude));
    let (mean, spread) = moments(&totals);
    let personal = people
        .iter()
        .map(|person| {
            let own = LONGER.into_iter().map(|a| person[a].iter().sum::<f64>());
            let logs: Vec<f64> =
                own.zip(&totals).map(|(own, all)| own + SHARED * (all - own)).collect();
            let (mean, spread) = moments(&logs);
            (mean, spread.hypot(LEAST_ERROR))
        })
        .collect();
    LagEvidence { gains, mean: (mean, spread.hypot(LEAST_ERROR)), personal }
}

/// Mean and standard deviation of the amplitude under these log likelihoods of [`LONGER`].
fn moments(logs: &[f64]) -> (f64, f64) {
    let weights = raised(logs);
    let sum: f64 = weights.iter().sum();
    let amplitudes = || LONGER.map(|index| AMPLITUDES[index]);
    let mean = weights.iter().zip(amplitudes()).map(|(w, a)| w * a).sum::<f64>() / sum;
    let squares = weights.iter().zip(amplitudes()).map(|(w, a)| w * (a - mean).powi(2));
    let square = squares.sum::<f64>() / sum;
    (mean, square.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two weeks of a person whose days like one amplitude best, by `sharp` nats a squared unit.
    fn person(liked: f64, sharp: f64) -> Likelihoods {
        let of = |a: &f64| vec![-sharp * (a - liked).powi(2); 14];
        AMPLITUDES.iter().map(of).collect()
    }

    #[test]
    fn a_longer_lag_gains_by_the_days_that_like_it_and_a_usual_one_does_not() {
        let people = [person(1.0, 2.0), person(1.0, 1.0)];
        let found = score(&people.iter().collect::<Vec<_>>());
        // 12 against 8 min, 14 days of 2 and of 1 nats; rounding.
        assert!((found.gains[0] - 28.0).abs() < 1e-9 && (found.gains[1] - 14.0).abs() < 1e-9);
        assert!((found.mean.0 - 1.0).abs() < 0.05, "{:?}", found.mean);
        for liked in [-2.0, -0.5, 0.0, 0.2] {
            let usual = [person(liked, 2.0), person(liked, 1.0)];
            assert_eq!(score(&usual.iter().collect::<Vec<_>>()).gains, [0.0, 0.0], "{liked}");
        }
    }
}
