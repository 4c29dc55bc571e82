//! Courses with and without an effect, from the same states.

use std::ops::Range;

use physiology::{MgPerDl, STEPS_PER_DAY};

use super::{MINUTES, steps_of};
use crate::effects::{Amplitudes, conditions};
use crate::error::WorldError;
use crate::physique::Acting;
use crate::virtual_person::{LivedDays, VirtualPerson};

/// Steps from one start to the next: half an hour.
const EVERY: usize = 6;
/// Of so many starts, one goes on to the longer horizon.
const LONG_EVERY: usize = 4;
/// Steps before the first start: 12 h, after which the steady state of the beginning no longer
/// matters.
const BURN_IN: usize = STEPS_PER_DAY / 2;

/// The difference after 60 or 300 min, or at a step of a day that begins at midnight.
pub(super) struct Difference {
    /// Index of the length in [`MINUTES`].
    pub(super) horizon: usize,
    /// Step to whose hour it belongs.
    pub(super) hour_at: usize,
    /// Step to whose situation it belongs.
    pub(super) situation_at: usize,
    /// With minus without, mg/dL.
    pub(super) value: f64,
}

/// With minus without the effects that `without` switches off.
pub(super) fn differences(
    person: &VirtualPerson,
    lived: &LivedDays,
    without: &Amplitudes,
) -> Result<Vec<Difference>, WorldError> {
    let happenings = &lived.happenings;
    let course =
        |amplitudes: &Amplitudes| conditions(&lived.life, happenings, &person.shapes, amplitudes);
    let (with, other) = (course(&person.amplitudes), course(without));
    let inputs = person.inputs_behind_the_log(lived, without);
    let restarts = restarts(lived.glucose.len());
    let forms = person.shapes.forms;
    let acting = |conditions, amplitudes, inputs| Acting {
        conditions,
        amplitudes: forms.in_body(amplitudes),
        inputs,
    };
    let courses = person
        .body
        .restarted(
            acting(&with, person.amplitudes, &lived.inputs),
            acting(&other, *without, &inputs),
            person.everyday.warps,
            &restarts,
        )
        .map_err(|source| person.failed(source))?;
    let shown = person.shown_by_sensors(lived, without)?;
    let at = |step: usize, glucose: &MgPerDl| -> Option<f64> {
        Some(lived.glucose.get(step)?.0 - glucose.0 + shown.get(step).copied().flatten()?)
    };
    let mut found: Vec<Difference> = Vec::new();
    let mut add = |horizon, hour_at, situation_at, value: Option<f64>| {
        found.extend(value.map(|value| Difference { horizon, hour_at, situation_at, value }));
    };
    for (run, course) in restarts.into_iter().zip(&courses) {
        if run.len() == STEPS_PER_DAY {
            // The last value, at 24:00, belongs to the next day's first hour, which no run of this
            // day reaches.
            for (step, glucose) in run.zip(course).skip(1) {
                add(2, step, step, at(step, glucose));
            }
            continue;
        }
        for (horizon, steps) in MINUTES.map(steps_of).into_iter().enumerate() {
            let difference = course.get(steps).and_then(|glucose| at(run.start + steps, glucose));
            add(horizon, run.start + steps / 2, run.start, difference);
        }
    }
    Ok(found)
}

/// Runs of 60 and 300 min, and of whole days.
fn restarts(steps: usize) -> Vec<Range<usize>> {
    let [short, long, _] = MINUTES.map(steps_of);
    let lengths = (0..).map(|index| if index % LONG_EVERY == 0 { long } else { short });
    let starts = (BURN_IN..steps).step_by(EVERY);
    let runs = starts.zip(lengths).map(|(start, length)| start..start + length);
    let days = (0..steps).step_by(STEPS_PER_DAY).map(|start| start..start + STEPS_PER_DAY);
    runs.chain(days).map(|run| run.start..run.end.min(steps)).collect()
}
