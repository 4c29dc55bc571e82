//! `insulin_clock_offset`, `meal_clock_offset`: doses whose clock disagrees with the sensor's.
//!
//! Three witnesses, none of which needs the diagnosis' own model:
//! - how far boluses lie from the meals they were given for ([`dose_distance`]): exact to a step,
//!   but silent about which of the two clocks is off, and about both together;
//! - when a controller's basal rate answered the sensor ([`controller`]): exact to a step for the
//!   insulin clock, for automated delivery alone;
//! - how well glucose follows the doses when they are moved ([`sensor_fit`]): coarse, but it speaks of
//!   either clock.
//!
//! An offset is *recorded minus actual*: positive where doses are recorded later than they were
//! given. It is reported where its 95 % interval lies wholly beyond [`MARGIN`]. Where the distance
//! between boluses and meals shows an offset and neither other witness tells whose it is, both
//! readings are reported, each naming the other.
//!
//! Out of sight: offsets under [`MARGIN`], which habit explains as well (logging a meal afterwards,
//! bolusing before it); a clock that drifts; an offset of meals where no boluses, or of
//! boluses where no meals are logged (unless a controller tells); and more than one change of a
//! clock within a record.

mod controller;
mod dose_distance;
mod sensor_fit;

use cohort::{Channel, Person};
use physiology::STEPS_PER_DAY;

use self::dose_distance::DoseDistances;
use self::sensor_fit::{Offsets, SensorFit};
use super::{Consequence, Finding};
use crate::diagnosis::FindingEstimate;

/// Offsets whose interval reaches this far towards zero, min, are left to habit: people bolus up to
/// a quarter of an hour before they eat and are advised to.
const MARGIN: f64 = 15.0;
/// Standard errors over days by which the sensor must prefer one reading to name it.
const NAMED_Z: f64 = 2.0;
/// The same where the sensor alone shows an offset, of both clocks: many offsets were tried.
const COMMON_Z: f64 = 2.5;
/// Evidence that it needs besides, nats.
const COMMON_GAIN: f64 = 5.0;
/// Offsets of both clocks together that are tried, steps: 40 min and more.
const COMMON_STEPS: i32 = 8;
/// Uncertainty of an offset that the sensor alone tells: people's absorption and habits differ
/// from the kernels', min (standard deviation over clean records).
const KERNEL_SD: f64 = 12.0;

/// An estimate in minutes with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Minutes95 {
    value: f64,
    lower: f64,
    upper: f64,
}

impl Minutes95 {
    /// Whether the whole interval lies beyond [`MARGIN`].
    fn beyond_habit(&self) -> bool {
        self.lower > MARGIN || self.upper < -MARGIN
    }

    fn negated(&self) -> Self {
        Self { value: -self.value, lower: -self.upper, upper: -self.lower }
    }

    /// The difference of two independent estimates.
    fn minus(&self, other: &Self) -> Self {
        let value = self.value - other.value;
        let below = (self.value - self.lower).hypot(other.upper - other.value);
        let above = (self.upper - self.value).hypot(other.value - other.lower);
        Self { value, lower: value - below, upper: value + above }
    }

    /// The nearest number of steps.
    fn steps(&self) -> i32 {
        (self.value / 5.0).round() as i32
    }
}

/// Whose clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Clock {
    Insulin,
    Meals,
}

pub(super) fn findings(person: &Person) -> Vec<Finding> {
    let amounts = |channel: Channel| -> Vec<f64> {
        person.record.channel(channel).iter().map(|dose| dose.unwrap_or(0.0)).collect()
    };
    let (carbs, bolus) = (amounts(Channel::Carbs), amounts(Channel::Bolus));
    let distances = DoseDistances::count(&carbs, &bolus);
    let controlled = controller::delay(person.record.basal(), person.record.cgm());
    let Some(distances) = distances else {
        return controlled.and_then(|delay| by_controller(person, &delay)).into_iter().collect();
    };
    if let Some(day) = distances.change() {
        let found = changed(person, &distances, day, &carbs, &bolus);
        if !found.is_empty() {
            return found;
        }
    }
    let Some(distance) = distances.peak(0..distances.days()) else { return Vec::new() };
    if let Some(delay) = controlled {
        let meals = delay.minus(&distance);
        let about = "boluses lie at this distance from meals, and the basal rate answers the sensor \
                     as it should with the insulin clock set so";
        let of_meals = meals.beyond_habit().then(|| offset(person, Clock::Meals, &meals, about));
        return by_controller(person, &delay).into_iter().chain(of_meals).collect();
    }
    if distance.beyond_habit() {
        let fit = SensorFit::new(person, &carbs, &bolus);
        return attributed(person, &distance, fit.as_ref(), "");
    }
    // Distances that scatter say nothing, and then the sensor alone is too weak a witness.
    if distance.upper - distance.lower > 2.0 * MARGIN {
        return Vec::new();
    }
    SensorFit::new(person, &carbs, &bolus)
        .map_or_else(Vec::new, |fit| both_clocks(person, &distance, &fit))
}

/// An offset of the insulin clock that a controller's answers show.
fn by_controller(person: &Person, delay: &Minutes95) -> Option<Finding> {
    let about = "the basal rate answers the sensor by this delay";
    delay.beyond_habit().then(|| offset(person, Clock::Insulin, delay, about))
}

/// Whose offset a distance between boluses and meals is, as far as the sensor tells.
fn attributed(
    person: &Person,
    distance: &Minutes95,
    fit: Option<&SensorFit>,
    when: &str,
) -> Vec<Finding> {
    let insulin = Offsets { meals: 0, insulin: distance.steps() };
    let meals = Offsets { meals: -distance.steps(), insulin: 0 };
    let z = fit.map_or(0.0, |fit| fit.compare(insulin, meals).z);
    let about = format!("boluses lie at this distance from the meals they were given for{when}");
    if z >= NAMED_Z {
        let about = format!("{about}, and glucose follows the meals as logged");
        return vec![offset(person, Clock::Insulin, distance, &about)];
    }
    if z <= -NAMED_Z {
        let about = format!("{about}, and glucose follows the boluses as logged");
        return vec![offset(person, Clock::Meals, &distance.negated(), &about)];
    }
    let about = format!("{about}; glucose does not tell whose clock is off");
    let mut found = vec![
        offset(person, Clock::Insulin, distance, &format!("{about}, or else that of meals is")),
        offset(
            person,
            Clock::Meals,
            &distance.negated(),
            &format!("{about}, or else that of insulin is"),
        ),
    ];
    if z < 0.0 {
        found.reverse();
    }
    found
}

/// An offset that begins within the record.
fn changed(
    person: &Person,
    distances: &DoseDistances,
    day: usize,
    carbs: &[f64],
    bolus: &[f64],
) -> Vec<Finding> {
    let (before, after) = (distances.peak(0..day), distances.peak(day..distances.days()));
    let (Some(before), Some(after)) = (before, after) else { return Vec::new() };
    let date = person.record.time(day * STEPS_PER_DAY).date();
    let (wrong, days, when) = match (before.beyond_habit(), after.beyond_habit()) {
        (false, true) => (after, day..distances.days(), format!(" from {date} on")),
        (true, false) => (before, 0..day, format!(" until {date}")),
        _ => return Vec::new(),
    };
    // A part of the record: the sensor is asked about those days alone.
    let steps = days.start * STEPS_PER_DAY..(days.end * STEPS_PER_DAY).min(person.record.len());
    let part = person.record.slice(steps.clone()).map(|record| Person { record, ..person.clone() });
    let fit = part.and_then(|part| SensorFit::new(&part, &carbs[steps.clone()], &bolus[steps]));
    attributed(person, &wrong, fit.as_ref(), &when)
}

/// An offset of both clocks against the sensor.
fn both_clocks(person: &Person, distance: &Minutes95, fit: &SensorFit) -> Vec<Finding> {
    let apart = distance.steps();
    let Some((shift, first, last)) = fit.best_common(COMMON_STEPS, apart) else {
        return Vec::new();
    };
    let moved = Offsets { meals: shift, insulin: shift + apart };
    let still = Offsets { meals: 0, insulin: apart };
    let comparison = fit.compare(moved, still);
    if comparison.gain < COMMON_GAIN || comparison.z < COMMON_Z {
        return Vec::new();
    }
    let spread = |end: i32| (5.0 * f64::from(end - shift)).hypot(2.0 * KERNEL_SD);
    let value = 5.0 * f64::from(shift);
    let common = Minutes95 { value, lower: value - spread(first), upper: value + spread(last) };
    if !common.beyond_habit() {
        return Vec::new();
    }
    let about = "glucose follows meals and boluses together by this offset; the sensor's own clock \
                 may be the one that is off";
    vec![
        offset(person, Clock::Insulin, &common, about),
        offset(person, Clock::Meals, &common, about),
    ]
}

/// A finding of an offset: the person is left out until the clock is set.
fn offset(person: &Person, clock: Clock, minutes: &Minutes95, about: &str) -> Finding {
    let (check, name) = match clock {
        Clock::Insulin => ("insulin_clock_offset", "insulin"),
        Clock::Meals => ("meal_clock_offset", "meals"),
    };
    let direction = if minutes.value > 0.0 { "late" } else { "early" };
    let size = minutes.value.abs();
    let text = format!(
        "{name} recorded {size:.0} min too {direction} against the sensor: {about}; moving {name} by \
         {:+.0} min would mend it",
        -minutes.value
    );
    Finding::note(check, person, text)
        .with_estimate(FindingEstimate {
            value: minutes.value,
            lower: minutes.lower,
            upper: minutes.upper,
            unit: "min".to_owned(),
        })
        .with_consequence(Consequence::ExcludePerson)
}
