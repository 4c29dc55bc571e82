//! People under the effects that have been named.

use effects::{Form, Modulation};
use rayon::prelude::*;

use super::Named;
use super::lag;
use super::round_person::RoundPerson;
use super::tried::Tried;
use crate::calibrated_person::CalibratedPerson;
use crate::error::GapError;
use crate::filter::calibration::{Calibration, CalibrationRule};
use crate::filter::observations::Observations;

/// Least factor that hidden events may leave of anything.
const LEAST_FACTOR: f64 = 0.05;

/// Runs the longer lags for everybody where the first ones call for it.
pub(super) fn longer_lags(
    subjects: &mut [RoundPerson],
    people: &[CalibratedPerson<'_>],
    tried: &Tried<'_>,
    named: &[Named],
    rule: &CalibrationRule,
) -> Result<(), GapError> {
    let Some(effect) = tried.lag() else { return Ok(()) };
    let known: Vec<&lag::Likelihoods> = subjects.iter().filter_map(|s| s.lags.as_ref()).collect();
    if known.is_empty() || !lag::calls_for_longer(&known) {
        return Ok(());
    }
    subjects.par_iter_mut().zip(people).enumerate().try_for_each(|(index, (subject, input))| {
        let Some(lags) = &mut subject.lags else { return Ok(()) };
        let about = conditioned(input, index, tried, named, rule)?;
        let person = about.as_ref().map_or(*input, |(observations, calibration)| {
            CalibratedPerson { observations, calibration, ..*input }
        });
        let rest = &lag::AMPLITUDES[lag::FIRST..];
        lags.extend(lag::likelihoods(&person, rule, effect, rest)?);
        Ok(())
    })
}

/// A person's record under the effects that have been named, and the calibrated filter run on it; `None` where nothing
/// is named.
pub(super) fn conditioned(
    input: &CalibratedPerson<'_>,
    index: usize,
    tried: &Tried<'_>,
    named: &[Named],
    rule: &CalibrationRule,
) -> Result<Option<(Observations, Calibration)>, GapError> {
    if named.is_empty() {
        return Ok(None);
    }
    let course = input.course();
    let mut modulations = vec![Modulation::NEUTRAL; course.len()];
    for named in named {
        let effect = tried.get(named.effect);
        match effect.form(&course) {
            Some(Form::Driven) => {
                let (amplitude, _) = named.personal[index];
                effect.modulate(named.variants[index], amplitude, &course, &mut modulations);
            }
            Some(Form::Events(shape)) => {
                for event in named.events.iter().filter(|event| event.person == index) {
                    let profile = &shape.profiles[event.profile];
                    for (modulation, add) in modulations[event.onset..].iter_mut().zip(profile) {
                        modulation[shape.field] += event.size * add;
                        if shape.field.neutral() == 1.0 {
                            modulation[shape.field] = modulation[shape.field].max(LEAST_FACTOR);
                        }
                    }
                }
            }
            _ => {}
        }
    }
    let observations = Observations { modulations, ..input.observations.clone() };
    let about = input.calibration.about(&observations, rule)?;
    Ok(Some((observations, about)))
}
