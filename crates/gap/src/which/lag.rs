//! Sensor lag by the likelihood of the whole filter.
//!
//! A constant lag leaves next to no mean in the innovations: the filter takes the slower glucose for glucose, and
//! what is left is shared with slow meals and slow insulin. It changes how glucose may move from one reading to
//! the next, and that is in the filter's gains, which signatures hold. So the filter is run again at each of some lags,
//! gains and all, and the lags are compared by the likelihood of the readings on days held out. What is tested is a lag
//! beyond the usual ones, which are tried as well: bodies and sensors below it are no finding. The likelihood has one
//! top along the lag: where a cohort likes the first longer lag less than the usual one next to it, no other is run.

use effects::{Course, Effect, EffectId, Field, Modulation};
use rayon::prelude::*;

use super::conditioned::conditioned;
use super::folds::{FOLDS, inside, outside};
use super::tried::Tried;
use super::{Score, Test};
use crate::calibrated_person::CalibratedPerson;
use crate::error::GapError;
use crate::filter::calibration::CalibrationRule;
use crate::filter::kalman::innovations;
use crate::filter::scored::{Whitening, normalised};
use crate::filter::whitening::{huber_loss, robust_scale};
use crate::log_sum::{moments, raised};

/// Amplitudes in the order in which they are run: 8 and 10 min, then 6, 12, 16, 22 and 32 min.
const AMPLITUDES: [f64; 7] = [0.0, 0.55, -0.71, 1.0, 1.7, 2.5, 3.4];
/// How many of them are run for everybody, the others where these call for it.
const FIRST: usize = 2;
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

/// Everybody's log likelihoods under the effects that have been named; of nobody once the lag is named.
///
/// # Errors
/// As [`filter`](crate::filter::kalman::filter).
pub(super) fn likelihoods(
    people: &[CalibratedPerson<'_>],
    tried: &Tried<'_>,
    named: &[Score],
    rule: &CalibrationRule,
) -> Result<Vec<Likelihoods>, GapError> {
    let open = |lag: &&dyn Effect| named.iter().all(|n| n.effect != lag.card().id);
    let Some(effect) = tried.lag().filter(open) else { return Ok(Vec::new()) };
    let at = |amplitudes: &[f64]| -> Result<Vec<Likelihoods>, GapError> {
        let people = people.par_iter().enumerate();
        let of = |person: &CalibratedPerson<'_>| of_person(person, rule, effect, amplitudes);
        people.map(|(index, input)| conditioned(input, index, tried, named, rule, of)).collect()
    };
    let mut found = at(&AMPLITUDES[..FIRST])?;
    if calls_for_longer(&found) {
        for (first, rest) in found.iter_mut().zip(at(&AMPLITUDES[FIRST..])?) {
            first.extend(rest);
        }
    }
    Ok(found)
}

/// Whether a cohort likes the first longer lag better than the usual one next to it.
fn calls_for_longer(people: &[Likelihoods]) -> bool {
    total(people, USUAL[0]) < total(people, LONGER[0])
}

/// Log likelihood of all days of everybody at an amplitude.
fn total(people: &[Likelihoods], amplitude: usize) -> f64 {
    people.iter().map(|person| person[amplitude].iter().sum::<f64>()).sum()
}

/// Log likelihoods of one person's days at some amplitudes of the lag.
fn of_person(
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
pub(super) fn score(effect: EffectId, people: &[Likelihoods]) -> Score {
    let mut gains = vec![0.0; people.len()];
    if !calls_for_longer(people) {
        let (amplitude, personal) = ((0.0, LEAST_ERROR), vec![(0.0, LEAST_ERROR); people.len()]);
        return Score { amplitude, personal, ..Score::of(effect, Test::Lag, gains) };
    }
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
    // Mean and standard deviation of the amplitude under these log likelihoods.
    let size = |logs: &[f64]| {
        let (mean, spread) = moments(&raised(logs), LONGER.map(|index| AMPLITUDES[index]));
        (mean, spread.hypot(LEAST_ERROR))
    };
    let personal = people.iter().map(|person| {
        let own = LONGER.into_iter().map(|a| person[a].iter().sum::<f64>());
        let logs = own.zip(&totals).map(|(own, all)| own + SHARED * (all - own));
        size(&logs.collect::<Vec<f64>>())
    });
    let (amplitude, personal) = (size(&totals), personal.collect());
    Score { amplitude, personal, ..Score::of(effect, Test::Lag, gains) }
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
        let found = score(EffectId::SENSOR_LAG, &people);
        // 12 against 8 min, 14 days of 2 and of 1 nats; rounding.
        assert!((found.gains[0] - 28.0).abs() < 1e-9 && (found.gains[1] - 14.0).abs() < 1e-9);
        assert!((found.amplitude.0 - 1.0).abs() < 0.05, "{:?}", found.amplitude);
        // A named lag drives the filter of later rounds, which asks for everybody's variant.
        assert_eq!((found.personal.len(), found.variants.len()), (2, 2));
        for liked in [-2.0, -0.5, 0.0, 0.2] {
            let usual = [person(liked, 2.0), person(liked, 1.0)];
            assert_eq!(score(EffectId::SENSOR_LAG, &usual).gains, [0.0, 0.0], "{liked}");
        }
    }
}
