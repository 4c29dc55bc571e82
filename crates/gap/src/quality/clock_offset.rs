//! `insulin_clock_offset`, `meal_clock_offset`: doses whose clock disagrees with the sensor's.
//!
//! Four witnesses, none of which needs the diagnosis' own model:
//! - how far boluses lie from the meals they were given for ([`dose_distance`]): exact to a step,
//!   but silent about which of the two clocks is off, and about both together;
//! - when a controller's basal rate answered the sensor ([`controller`]): exact to a step for the
//!   insulin clock, for automated delivery alone;
//! - when glucose turned around boluses without a meal ([`corrections`]): the insulin clock of people
//!   who correct by hand, to about a quarter of an hour;
//! - how well glucose follows the doses when they are moved ([`sensor_fit`]): coarse, but it speaks of
//!   either clock.
//!
//! An offset is *recorded minus actual*: positive where doses are recorded later than they were
//! given. It is reported where its 95 % interval lies wholly beyond [`MARGIN`]. Where the distance
//! between boluses and meals shows an offset and no other witness tells whose it is, both
//! readings are reported, each naming the other.
//!
//! Beyond three hours, where habit ties every bolus to some meal, [`far`] compares distances with those of other days.
//!
//! Out of sight: offsets under [`MARGIN`], which habit explains as well (logging a meal afterwards,
//! bolusing before it); a clock that drifts; more than one change of a clock within a record; meals
//! without boluses; and both clocks together where corrections are few and meals well covered.

mod controller;
mod corrections;
mod dose_distance;
mod far;
mod sensor_fit;

use cohort::{Channel, Person};
use physiology::STEPS_PER_DAY;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use self::controller::CHANGES_A_DAY;
use self::corrections::{Corrections, SMALLEST_BOLUS};
use self::dose_distance::DoseDistances;
use self::sensor_fit::{Offsets, SensorFit};
use super::{Consequence, Finding};

/// Offsets whose interval reaches this far towards zero, min, are left to habit: people bolus up to
/// a quarter of an hour before they eat and are advised to.
const MARGIN: f64 = 15.0;
/// Standard errors over days by which the sensor must prefer one reading to name it.
const NAMED_Z: f64 = 2.0;
/// Standard errors from which two witnesses that differ in sign contradict each other.
const CONTRADICTION_Z: f64 = 1.0;
/// As [`NAMED_Z`] where the sensor alone shows an offset, of both clocks: many offsets were tried.
const COMMON_Z: f64 = 2.5;
/// Evidence that it needs besides, nats.
const COMMON_GAIN: f64 = 5.0;
/// Standard errors from which the fit agrees with an offset of both clocks that corrections show.
const AGREES_Z: f64 = 0.0;
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

/// The doses of a record or of a part of it, and what the sensor read.
struct DoseSteps<'a> {
    person: &'a Person,
    carbs: Vec<f64>,
    bolus: Vec<f64>,
}

impl<'a> DoseSteps<'a> {
    fn of(person: &'a Person) -> Self {
        let amounts = |channel: Channel| -> Vec<f64> {
            person.record.channel(channel).iter().map(|dose| dose.unwrap_or(0.0)).collect()
        };
        let mut bolus = amounts(Channel::Bolus);
        let given = bolus.iter().filter(|dose| **dose > 0.0).count();
        // A controller that acts by small boluses gives them at every hour: they belong to no meal.
        if given as f64 > CHANGES_A_DAY * bolus.len() as f64 / STEPS_PER_DAY as f64 {
            bolus.iter_mut().filter(|dose| **dose < SMALLEST_BOLUS).for_each(|dose| *dose = 0.0);
        }
        Self { person, carbs: amounts(Channel::Carbs), bolus }
    }

    fn corrections(&self, apart: i32) -> Option<Corrections> {
        Corrections::of(&self.carbs, &self.bolus, self.person.record.cgm(), apart)
    }

    fn sensor_fit(&self) -> Option<SensorFit> {
        SensorFit::new(self.person, &self.carbs, &self.bolus)
    }

    /// By how many standard errors glucose prefers the first offsets to the second: the clearer of the
    /// two witnesses or both together, and nothing where they contradict each other.
    fn preference(&self, first: Offsets, second: Offsets) -> f64 {
        let apart = first.insulin - first.meals;
        let fit = self.sensor_fit().map(|fit| fit.compare(first, second).z);
        let turns = self
            .corrections(apart)
            .map(|corrections| corrections.preference(first.insulin, second.insulin));
        let (Some(fit), Some(turns)) = (fit, turns) else { return fit.or(turns).unwrap_or(0.0) };
        if fit.min(turns) < -CONTRADICTION_Z && fit.max(turns) > CONTRADICTION_Z {
            return 0.0;
        }
        let together = (fit + turns) * std::f64::consts::FRAC_1_SQRT_2;
        let clearest =
            [fit, turns, together].into_iter().max_by(|a, b| a.abs().total_cmp(&b.abs()));
        clearest.unwrap_or(together)
    }
}

pub(super) fn findings(person: &Person) -> Vec<Finding> {
    let doses = DoseSteps::of(person);
    let distances = DoseDistances::count(&doses.carbs, &doses.bolus);
    let controlled = controller::delay(person.record.basal(), person.record.cgm());
    let Some(distances) = distances else {
        return match controlled {
            Some(delay) => by_controller(person, &delay).into_iter().collect(),
            None => by_corrections(&doses, None),
        };
    };
    let far = far::distance(&doses.carbs, &doses.bolus);
    if let (Some(far), None) = (&far, &controlled) {
        return far_off(&doses, far);
    }
    if let (Some(day), None) = (distances.change(), &far) {
        let found = changed(person, &distances, day);
        if !found.is_empty() {
            return found;
        }
    }
    let distance = far.or_else(|| distances.peak(0..distances.days()));
    let Some(distance) = distance else { return Vec::new() };
    if let Some(delay) = controlled {
        let meals = delay.minus(&distance);
        let about = "boluses lie at this distance from meals, and the basal rate answers the sensor \
                     as it should with the insulin clock set so";
        let of_meals = meals.beyond_habit().then(|| offset(person, Clock::Meals, &meals, about));
        return by_controller(person, &delay).into_iter().chain(of_meals).collect();
    }
    if distance.beyond_habit() {
        return attributed(&doses, &distance, "");
    }
    // Distances that scatter say nothing, and then glucose alone is too weak a witness.
    if distance.upper - distance.lower > 2.0 * MARGIN {
        return Vec::new();
    }
    let Some(fit) = doses.sensor_fit() else { return Vec::new() };
    let found = both_clocks(person, &distance, &fit);
    if found.is_empty() { by_corrections(&doses, Some((&distance, &fit))) } else { found }
}

/// An offset that the turns around corrections show: of both clocks where a distance ties the meals
/// to the boluses, and then only if the fit to the sensor agrees.
fn by_corrections(doses: &DoseSteps<'_>, meals: Option<(&Minutes95, &SensorFit)>) -> Vec<Finding> {
    let apart = meals.map_or(0, |(distance, _)| distance.steps());
    let Some(corrections) = doses.corrections(apart) else { return Vec::new() };
    let Some(delay) = corrections.delay().filter(Minutes95::beyond_habit) else {
        return Vec::new();
    };
    if corrections.preference(delay.steps(), 0) < NAMED_Z {
        return Vec::new();
    }
    if let Some((_, fit)) = meals {
        let moved = Offsets { meals: delay.steps() - apart, insulin: delay.steps() };
        let still = Offsets { meals: 0, insulin: apart };
        if fit.compare(moved, still).z < AGREES_Z {
            return Vec::new();
        }
    }
    let about = "glucose turns around boluses without a meal at this offset; the sensor's own clock may \
                 be the one that is off";
    let mut found = vec![offset(doses.person, Clock::Insulin, &delay, about)];
    if let Some((distance, _)) = meals {
        let meals = delay.minus(distance);
        let about = "meals lie with the boluses, around which glucose turns at this offset; the sensor's \
                     own clock may be the one that is off";
        found.push(offset(doses.person, Clock::Meals, &meals, about));
    }
    found
}

/// An offset of the insulin clock that a controller's answers show.
fn by_controller(person: &Person, delay: &Minutes95) -> Option<Finding> {
    let about = "the basal rate answers the sensor by this delay";
    delay.beyond_habit().then(|| offset(person, Clock::Insulin, delay, about))
}

/// Whose offset a distance of many hours is: glucose rises after what people eat, and they dose for that.
fn far_off(doses: &DoseSteps<'_>, distance: &Minutes95) -> Vec<Finding> {
    let (person, cgm) = (doses.person, doses.person.record.cgm());
    let z = far::rises_after_boluses(&doses.carbs, &doses.bolus, cgm).unwrap_or(0.0);
    let about = "boluses lie at this distance from the meals of the same day, and not as they lie from those of others";
    if z >= NAMED_Z {
        let about = format!("{about}, and glucose rises after boluses, not after meals");
        return vec![offset(person, Clock::Meals, &distance.negated(), &about)];
    }
    if z <= -NAMED_Z {
        let about = format!("{about}, and glucose rises after meals, not after boluses");
        return vec![offset(person, Clock::Insulin, distance, &about)];
    }
    either(person, distance, &format!("{about}; glucose does not tell whose clock is off"), -z)
}

/// Whose offset a distance between boluses and meals is, as far as the sensor tells.
fn attributed(doses: &DoseSteps<'_>, distance: &Minutes95, when: &str) -> Vec<Finding> {
    let person = doses.person;
    let insulin = Offsets { meals: 0, insulin: distance.steps() };
    let meals = Offsets { meals: -distance.steps(), insulin: 0 };
    let z = match controller::delay(person.record.basal(), person.record.cgm()) {
        // A controller's answer names the insulin clock's offset itself.
        Some(delay) if (delay.value - distance.value).abs() < delay.value.abs() => f64::INFINITY,
        Some(_) => f64::NEG_INFINITY,
        None => doses.preference(insulin, meals),
    };
    let about = format!("boluses lie at this distance from the meals they were given for{when}");
    if z >= NAMED_Z {
        let about = format!("{about}, and glucose follows the meals as logged");
        return vec![offset(person, Clock::Insulin, distance, &about)];
    }
    if z <= -NAMED_Z {
        let about = format!("{about}, and glucose follows the boluses as logged");
        return vec![offset(person, Clock::Meals, &distance.negated(), &about)];
    }
    either(person, distance, &format!("{about}; glucose does not tell whose clock is off"), z)
}

/// Both readings of a distance, each naming the other; that of meals first where glucose leans to it.
fn either(person: &Person, distance: &Minutes95, about: &str, z: f64) -> Vec<Finding> {
    let of_insulin = format!("{about}, or else that of meals is");
    let of_meals = format!("{about}, or else that of insulin is");
    let mut found = vec![
        offset(person, Clock::Insulin, distance, &of_insulin),
        offset(person, Clock::Meals, &distance.negated(), &of_meals),
    ];
    if z < 0.0 {
        found.reverse();
    }
    found
}

/// An offset that begins within the record.
fn changed(person: &Person, distances: &DoseDistances, day: usize) -> Vec<Finding> {
    let (before, after) = (distances.peak(0..day), distances.peak(day..distances.days()));
    let (Some(before), Some(after)) = (before, after) else { return Vec::new() };
    let date = person.record.time(day * STEPS_PER_DAY).date();
    let (wrong, days, when) = match (before.beyond_habit(), after.beyond_habit()) {
        (false, true) => (after, day..distances.days(), format!(" from {date} on")),
        (true, false) => (before, 0..day, format!(" until {date}")),
        _ => return Vec::new(),
    };
    // Glucose is asked about those days alone.
    let steps = days.start * STEPS_PER_DAY..(days.end * STEPS_PER_DAY).min(person.record.len());
    let Some(record) = person.record.slice(steps) else { return Vec::new() };
    let part = Person { record, ..person.clone() };
    attributed(&DoseSteps::of(&part), &wrong, &when)
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
        .with_estimate((minutes.value, minutes.lower, minutes.upper), "min")
        .with_consequence(Consequence::ExcludePerson)
}

/// The sum of the tables of some days.
fn total<'a, const N: usize>(days: impl IntoIterator<Item = &'a [f64; N]>) -> [f64; N] {
    let mut total = [0.0; N];
    for day in days {
        for (total, value) in total.iter_mut().zip(day) {
            *total += value;
        }
    }
    total
}

/// A statistic of days that are drawn with replacement, so many times: ascending, without draws that have none.
fn redrawn<T>(
    days: &[T],
    replicates: usize,
    statistic: impl Fn(Vec<&T>) -> Option<f64>,
) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let mut drawn: Vec<f64> = (0..replicates)
        .filter_map(|_| {
            let sample = (0..days.len()).map(|_| &days[rng.random_range(0..days.len())]);
            statistic(sample.collect())
        })
        .collect();
    drawn.sort_by(f64::total_cmp);
    drawn
}
