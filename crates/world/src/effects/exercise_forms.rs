//! Other forms of exercise: when working muscle feels it, and when insulin acts more after it.

use physiology::{Exercise, STEPS_PER_HOUR};

use super::forms::{AfterExerciseForm, ExerciseForm};
use crate::behaviour::{Life, Session};
use crate::calendar::within;

/// Rise of insulin action after 45 min at an effort of 0.5, as a share (as in the bodies: 20 to 50
/// %, McMahon et al., J Clin Endocrinol Metab 2007;92:963), and the effort times minutes of that
/// session.
const SENSITIVITY: f64 = 0.30;
const SESSION: f64 = 22.5;
/// Steps for which exercise persists, and after which it is felt where it is felt late.
const LINGERS: usize = STEPS_PER_HOUR;
const LATE: usize = 3;

/// The exercise of a step as muscle feels it; `None` where that is the exercise itself.
#[must_use]
pub(super) fn felt(form: ExerciseForm, life: &Life, step: usize) -> Option<Exercise> {
    let scaled = |session: &Session, share: f64| Exercise {
        vo2max_percent: share * session.exercise.vo2max_percent,
        ..session.exercise
    };
    match form {
        ExerciseForm::Held => None,
        ExerciseForm::Lingering => {
            let over =
                |s: &&Session| (s.start + s.steps..s.start + s.steps + LINGERS).contains(&step);
            if life.session_at(step).is_some() {
                return None;
            }
            let session = life.sessions.iter().find(over)?;
            let along = (step - session.start - session.steps) as f64 / LINGERS as f64;
            Some(scaled(session, 0.7 * (1.0 - along)))
        }
        ExerciseForm::Late => {
            let session = life.session_at(step)?;
            Some(scaled(session, if step < session.start + LATE { 0.0 } else { 1.3 }))
        }
        ExerciseForm::Fading => {
            let session = life.session_at(step)?;
            let along = (step - session.start) as f64 / session.steps.max(1) as f64;
            Some(scaled(session, 1.4 - 0.9 * along))
        }
    }
}

/// Factors on insulin action after the sessions of a life, one per step, in forms that the bodies
/// do not have themselves.
#[must_use]
pub(super) fn after(form: AfterExerciseForm, life: &Life, amplitude: f64) -> Vec<f64> {
    let steps = life.calendar.steps();
    let mut factors = vec![1.0; steps];
    if amplitude == 0.0 || form == AfterExerciseForm::Decaying {
        return factors;
    }
    for session in &life.sessions {
        let work = session.exercise.vo2max_percent / 100.0 * 5.0 * session.steps as f64;
        let rise = amplitude * SENSITIVITY * (work / SESSION).min(2.0);
        let end = session.start + session.steps;
        match form {
            AfterExerciseForm::Decaying => {}
            AfterExerciseForm::Overnight => {
                let night = life.nights.iter().find(|night| night.onset >= end as i64);
                let asleep = night.map_or(0..0, |night| within(night.onset..night.wake, steps));
                factors[asleep].iter_mut().for_each(|slot| *slot += rise);
            }
            AfterExerciseForm::TwoPhases => {
                let after = factors.iter_mut().skip(end).take(13 * STEPS_PER_HOUR);
                for (later, slot) in after.enumerate() {
                    let hours = later as f64 / STEPS_PER_HOUR as f64;
                    let second = (-0.5 * ((hours - 9.0) / 1.3).powi(2)).exp();
                    *slot += rise * (0.8 * (-hours / 1.5).exp() + second);
                }
            }
        }
    }
    factors
}
