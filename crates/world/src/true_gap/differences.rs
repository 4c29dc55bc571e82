//! Courses with and without an effect, from the same states.

use physiology::{MgPerDl, STEPS_PER_DAY};

use super::{MINUTES, steps_of};
use crate::effects::{Amplitudes, conditions};
use crate::error::WorldError;
use crate::physique::{Acting, Restart};
use crate::virtual_person::{FIRST_GLUCOSE, LivedDays, VirtualPerson};

/// Steps from one start to the next: half an hour.
const EVERY: usize = 6;
/// Of so many starts, one goes on to the longer horizon.
const LONG_EVERY: usize = 4;
/// Steps before the first start: 12 h, after which the steady state of the beginning no longer
/// matters.
const BURN_IN: usize = STEPS_PER_DAY / 2;

/// The difference at the end of one run.
pub(super) struct RunDifference {
    /// First step.
    pub(super) start: usize,
    /// Length.
    pub(super) steps: usize,
    /// Index of the length in [`MINUTES`].
    pub(super) horizon: usize,
    /// With minus without, mg/dL.
    pub(super) difference: f64,
}

/// Differences of a life.
pub(super) struct Differences {
    /// After 60 and 300 min.
    pub(super) runs: Vec<RunDifference>,
    /// Each step of days that begin at midnight, with the difference there.
    pub(super) days: Vec<(usize, f64)>,
}

/// With minus without the effects that `without` switches off.
pub(super) fn differences(
    person: &VirtualPerson,
    lived: &LivedDays,
    without: &Amplitudes,
) -> Result<Differences, WorldError> {
    let in_body = |source: ode_sim::OdeError| WorldError::Body { person: person.index, source };
    let steps = lived.glucose.len();
    let happenings = person.happenings(&lived.life);
    let course =
        |amplitudes: &Amplitudes| conditions(&lived.life, &happenings, &person.shapes, amplitudes);
    let (with, other) = (course(&person.amplitudes), course(without));
    let inputs = person.inputs_behind_the_log(lived, without);
    let restarts = restarts(steps);
    let forms = person.shapes.forms;
    let acting = |conditions, amplitudes, inputs| Acting {
        conditions,
        amplitudes: forms.in_body(amplitudes),
        warps: person.everyday.warps,
        inputs,
    };
    let courses = person
        .body
        .restarted(
            FIRST_GLUCOSE,
            acting(&with, person.amplitudes, &lived.inputs),
            acting(&other, *without, &inputs),
            &restarts,
        )
        .map_err(in_body)?;
    let shown = shown(person, lived, without)?;
    let at = |step: usize, glucose: &MgPerDl| -> Option<f64> {
        Some(lived.glucose.get(step)?.0 - glucose.0 + shown.get(step).copied().flatten()?)
    };
    let mut found = Differences { runs: Vec::new(), days: Vec::new() };
    for (restart, course) in restarts.iter().zip(&courses) {
        let start = restart.start;
        if restart.steps == STEPS_PER_DAY {
            // The last value, at 24:00, belongs to the next day's first hour, which no run of this day reaches.
            let of_day = course.iter().enumerate().take(STEPS_PER_DAY).skip(1);
            let of_day =
                of_day.filter_map(|(k, glucose)| Some((start + k, at(start + k, glucose)?)));
            found.days.extend(of_day);
            continue;
        }
        for (horizon, steps) in MINUTES.map(steps_of).into_iter().enumerate() {
            let difference = course.get(steps).and_then(|glucose| at(start + steps, glucose));
            if let Some(difference) = difference {
                found.runs.push(RunDifference { start, steps, horizon, difference });
            }
        }
    }
    Ok(found)
}

/// Runs of 60 and 300 min, and of whole days.
fn restarts(steps: usize) -> Vec<Restart> {
    let [short, long, _] = MINUTES.map(steps_of);
    let runs = (BURN_IN..steps).step_by(EVERY).enumerate().map(|(index, start)| Restart {
        start,
        steps: if index % LONG_EVERY == 0 { long } else { short },
    });
    let days = (0..steps).step_by(STEPS_PER_DAY);
    let days = days.map(|start| Restart { start, steps: STEPS_PER_DAY });
    runs.chain(days).map(|run| Restart { steps: run.steps.min(steps - run.start), ..run }).collect()
}

/// The difference that the effects make to the sensor at the same glucose, mg/dL; `None` where a
/// needed reading is lost.
fn shown(
    person: &VirtualPerson,
    lived: &LivedDays,
    without: &Amplitudes,
) -> Result<Vec<Option<f64>>, WorldError> {
    if !person.sensors_differ(without) {
        return Ok(vec![Some(0.0); lived.glucose.len()]);
    }
    let of = |amplitudes| person.sensed(&lived.life, &lived.glucose, amplitudes);
    let (with, other) = (of(&person.amplitudes)?, of(without)?);
    Ok(with.iter().zip(&other).map(|(a, b)| Some((*a)?.0 - (*b)?.0)).collect())
}
