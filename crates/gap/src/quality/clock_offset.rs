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
use self::dose_distance::DayTable;
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
    /// An estimate from days, and its interval over days that are drawn with replacement so many times; it holds the
    /// estimate. Draws that have no estimate do not count.
    fn bootstrapped<T>(
        days: &[T],
        replicates: usize,
        estimate: impl Fn(Vec<&T>) -> Option<f64>,
    ) -> Option<Self> {
        let value = estimate(days.iter().collect())?;
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let mut drawn: Vec<f64> = (0..replicates)
            .filter_map(|_| {
                let sample = (0..days.len()).map(|_| &days[rng.random_range(0..days.len())]);
                estimate(sample.collect())
            })
            .collect();
        drawn.sort_by(f64::total_cmp);
        let last = drawn.len().checked_sub(1)?;
        let at = |share: f64| drawn[(share * last as f64).round() as usize];
        Some(Self { value, lower: at(0.025).min(value), upper: at(0.975).max(value) })
    }

    /// Whether the whole interval lies beyond [`MARGIN`].
    fn beyond_habit(&self) -> bool {
        self.lower > MARGIN || self.upper < -MARGIN
    }

    fn negated(self) -> Self {
        Self { value: -self.value, lower: -self.upper, upper: -self.lower }
    }

    /// The difference of two independent estimates.
    fn minus(self, other: Self) -> Self {
        let value = self.value - other.value;
        let below = (self.value - self.lower).hypot(other.upper - other.value);
        let above = (self.upper - self.value).hypot(other.value - other.lower);
        Self { value, lower: value - below, upper: value + above }
    }

    /// The same with an independent error of some standard deviation besides.
    fn with_error(self, sd: f64) -> Self {
        self.minus(Self { value: 0.0, lower: -2.0 * sd, upper: 2.0 * sd })
    }

    /// The same with an interval that is wider by so much on each side.
    fn widened(self, by: f64) -> Self {
        Self { value: self.value, lower: self.lower - by, upper: self.upper + by }
    }

    /// The nearest number of steps.
    fn steps(&self) -> i32 {
        (self.value / 5.0).round() as i32
    }
}

/// A clock: its check, and what it stamps.
type Clock = (&'static str, &'static str);
const INSULIN: Clock = ("insulin_clock_offset", "insulin");
const MEALS: Clock = ("meal_clock_offset", "meals");

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

    /// By how many standard errors glucose prefers the first offsets to the second: the clearer of the
    /// two witnesses or both together, and nothing where they contradict each other.
    fn preference(&self, first: Offsets, second: Offsets) -> f64 {
        let fit = SensorFit::new(self).map(|fit| fit.compare(first, second).z);
        let turns = Corrections::of(self, first.insulin - first.meals)
            .map(|corrections| corrections.preference(first.insulin, second.insulin));
        let (Some(fit), Some(turns)) = (fit, turns) else { return fit.or(turns).unwrap_or(0.0) };
        if fit.min(turns) < -CONTRADICTION_Z && fit.max(turns) > CONTRADICTION_Z {
            return 0.0;
        }
        let together = (fit + turns) * std::f64::consts::FRAC_1_SQRT_2;
        let witnesses = [fit, turns, together].into_iter();
        witnesses.max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(together)
    }
}

pub(super) fn findings(person: &Person) -> Vec<Finding> {
    let doses = DoseSteps::of(person);
    let controlled = controller::delay(person.record.basal(), person.record.cgm());
    let Some(days) = dose_distance::count(&doses.carbs, &doses.bolus) else {
        return match controlled {
            Some(delay) => by_controller(person, delay).into_iter().collect(),
            None => by_corrections(&doses, None).unwrap_or_default(),
        };
    };
    let far = far::distance(&doses.carbs, &doses.bolus);
    if let (Some(far), None) = (far, controlled) {
        return far_off(&doses, far);
    }
    if far.is_none()
        && let Some(found) = changed(person, &days)
    {
        return found;
    }
    let Some(distance) = far.or_else(|| dose_distance::peak(&days)) else { return Vec::new() };
    if let Some(delay) = controlled {
        let meals = delay.minus(distance);
        let about = "boluses lie at this distance from meals, and the basal rate answers the sensor \
                     as it should with the insulin clock set so";
        let of_meals = meals.beyond_habit().then(|| offset(person, MEALS, meals, about));
        return by_controller(person, delay).into_iter().chain(of_meals).collect();
    }
    if distance.beyond_habit() {
        return near_off(&doses, distance, "");
    }
    // Distances that scatter say nothing, and then glucose alone is too weak a witness.
    if distance.upper - distance.lower > 2.0 * MARGIN {
        return Vec::new();
    }
    let Some(fit) = SensorFit::new(&doses) else { return Vec::new() };
    both_clocks(person, distance, &fit)
        .or_else(|| by_corrections(&doses, Some((distance, &fit))))
        .unwrap_or_default()
}

/// An offset that the turns around corrections show: of both clocks where a distance ties the meals
/// to the boluses, and then only if the fit to the sensor agrees.
fn by_corrections(
    doses: &DoseSteps<'_>,
    meals: Option<(Minutes95, &SensorFit)>,
) -> Option<Vec<Finding>> {
    let apart = meals.map_or(0, |(distance, _)| distance.steps());
    let corrections = Corrections::of(doses, apart)?;
    let delay = corrections.delay().filter(Minutes95::beyond_habit)?;
    if corrections.preference(delay.steps(), 0) < NAMED_Z {
        return None;
    }
    let about = "glucose turns around boluses without a meal at this offset; the sensor's own clock may \
                 be the one that is off";
    let mut found = vec![offset(doses.person, INSULIN, delay, about)];
    if let Some((distance, fit)) = meals {
        let moved = Offsets { meals: delay.steps() - apart, insulin: delay.steps() };
        let still = Offsets { meals: 0, insulin: apart };
        if fit.compare(moved, still).z < AGREES_Z {
            return None;
        }
        let about = "meals lie with the boluses, around which glucose turns at this offset; the sensor's \
                     own clock may be the one that is off";
        found.push(offset(doses.person, MEALS, delay.minus(distance), about));
    }
    Some(found)
}

/// An offset of the insulin clock that a controller's answers show.
fn by_controller(person: &Person, delay: Minutes95) -> Option<Finding> {
    let about = "the basal rate answers the sensor by this delay";
    delay.beyond_habit().then(|| offset(person, INSULIN, delay, about))
}

/// Whose offset a distance of many hours is: glucose rises after what people eat, and they dose for that.
fn far_off(doses: &DoseSteps<'_>, distance: Minutes95) -> Vec<Finding> {
    let about = "boluses lie at this distance from the meals of the same day, and not as they lie from those of others";
    let z = far::rises_after_meals(doses).unwrap_or(0.0);
    let insulin = ", and glucose rises after meals, not after boluses";
    let meals = ", and glucose rises after boluses, not after meals";
    attributed(doses.person, distance, about, z, [insulin, meals])
}

/// Whose offset the distance is that most boluses have from meals, as far as the sensor tells.
fn near_off(doses: &DoseSteps<'_>, distance: Minutes95, when: &str) -> Vec<Finding> {
    let record = &doses.person.record;
    let z = match controller::delay(record.basal(), record.cgm()) {
        // A controller's answer names the insulin clock's offset itself.
        Some(delay) if (delay.value - distance.value).abs() < delay.value.abs() => f64::INFINITY,
        Some(_) => f64::NEG_INFINITY,
        None => doses.preference(
            Offsets { meals: 0, insulin: distance.steps() },
            Offsets { meals: -distance.steps(), insulin: 0 },
        ),
    };
    let about = format!("boluses lie at this distance from the meals they were given for{when}");
    let insulin = ", and glucose follows the meals as logged";
    let meals = ", and glucose follows the boluses as logged";
    attributed(doses.person, distance, &about, z, [insulin, meals])
}

/// Whose offset a distance is, of which `about` tells: glucose prefers that of the insulin clock by `z` standard errors,
/// and `because` says how it names that of insulin, and how that of meals. Where it names neither, both readings, each
/// naming the other; that of meals first where glucose leans to it.
fn attributed(
    person: &Person,
    distance: Minutes95,
    about: &str,
    z: f64,
    because: [&str; 2],
) -> Vec<Finding> {
    let of_insulin = |why: &str| offset(person, INSULIN, distance, &format!("{about}{why}"));
    let of_meals = |why: &str| offset(person, MEALS, distance.negated(), &format!("{about}{why}"));
    if z >= NAMED_Z {
        return vec![of_insulin(because[0])];
    }
    if z <= -NAMED_Z {
        return vec![of_meals(because[1])];
    }
    let mut found = vec![
        of_insulin("; glucose does not tell whose clock is off, or else that of meals is"),
        of_meals("; glucose does not tell whose clock is off, or else that of insulin is"),
    ];
    if z < 0.0 {
        found.reverse();
    }
    found
}

/// An offset that begins or ends within the record.
fn changed(person: &Person, days: &[DayTable]) -> Option<Vec<Finding>> {
    let day = dose_distance::change(days)?;
    let (before, after) = days.split_at(day);
    let (before, after) = (dose_distance::peak(before)?, dose_distance::peak(after)?);
    let start = day * STEPS_PER_DAY;
    let date = person.record.time(start).date();
    let (wrong, steps, when) = match (before.beyond_habit(), after.beyond_habit()) {
        (false, true) => (after, start..person.record.len(), format!(" from {date} on")),
        (true, false) => (before, 0..start, format!(" until {date}")),
        _ => return None,
    };
    // Glucose is asked about those days alone.
    let part = Person { record: person.record.slice(steps)?, ..person.clone() };
    Some(near_off(&DoseSteps::of(&part), wrong, &when))
}

/// An offset of both clocks against the sensor.
fn both_clocks(person: &Person, distance: Minutes95, fit: &SensorFit) -> Option<Vec<Finding>> {
    let apart = distance.steps();
    let (shift, first, last) = fit.best_common(COMMON_STEPS, apart)?;
    let moved = Offsets { meals: shift, insulin: shift + apart };
    let still = Offsets { meals: 0, insulin: apart };
    let comparison = fit.compare(moved, still);
    let [value, lower, upper] = [shift, first, last].map(|steps| 5.0 * f64::from(steps));
    let common = Minutes95 { value, lower, upper }.with_error(KERNEL_SD);
    if comparison.gain < COMMON_GAIN || comparison.z < COMMON_Z || !common.beyond_habit() {
        return None;
    }
    let about = "glucose follows meals and boluses together by this offset; the sensor's own clock \
                 may be the one that is off";
    Some([INSULIN, MEALS].map(|clock| offset(person, clock, common, about)).into())
}

/// A finding of an offset: the person is left out until the clock is set.
fn offset(person: &Person, (check, name): Clock, minutes: Minutes95, about: &str) -> Finding {
    let direction = if minutes.value > 0.0 { "late" } else { "early" };
    let size = minutes.value.abs();
    let text = format!(
        "{name} recorded {size:.0} min too {direction} against the sensor: {about}; moving {name} by \
         {:+.0} min would mend it",
        -minutes.value
    );
    Finding::new(check, person, Consequence::ExcludePerson, text)
        .with_estimate((minutes.value, minutes.lower, minutes.upper), "min")
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

/// What the days prefer, in standard errors over days: the sum of what each does, over the root of the sum of squares.
fn z_over_days(preferences: impl Iterator<Item = f64>) -> f64 {
    let (sum, squares) =
        preferences.fold((0.0, 0.0), |(sum, squares), day| (sum + day, squares + day * day));
    sum / f64::max(squares, f64::MIN_POSITIVE).sqrt()
}

/// A table under a triangle of `half_width` steps on each side of a place.
fn under_triangle(table: &[f64], place: usize, half_width: usize) -> f64 {
    let around = place - half_width..=place + half_width;
    around.map(|at| table[at] * (half_width + 1 - at.abs_diff(place)) as f64).sum()
}

/// The first of the places at which something is highest, and how high it is there.
fn highest(places: impl Iterator<Item = usize>, height: impl Fn(usize) -> f64) -> (usize, f64) {
    let heights = places.map(|place| (place, height(place)));
    heights.fold((0, f64::NEG_INFINITY), |best, next| if next.1 > best.1 { next } else { best })
}
