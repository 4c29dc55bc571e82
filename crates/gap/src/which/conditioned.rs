//! People under the effects that have been named.

use effects::{Form, Modulation};

use super::Score;
use super::tried::Tried;
use crate::calibrated_person::CalibratedPerson;
use crate::error::GapError;
use crate::filter::calibration::CalibrationRule;
use crate::filter::observations::Observations;

/// Least factor that hidden events may leave of anything.
const LEAST_FACTOR: f64 = 0.05;

/// What is worked out of a person under the effects that have been named: of her record, and of the calibrated filter that
/// is run on it; of `input` as it is where nothing is named.
pub(super) fn conditioned<T>(
    input: &CalibratedPerson<'_>,
    index: usize,
    tried: &Tried<'_>,
    named: &[Score],
    rule: &CalibrationRule,
    of: impl FnOnce(&CalibratedPerson<'_>) -> Result<T, GapError>,
) -> Result<T, GapError> {
    if named.is_empty() {
        return of(input);
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
    let calibration = input.calibration.about(&observations, rule)?;
    of(&CalibratedPerson { observations: &observations, calibration: &calibration, ..*input })
}
