//! Plantings in the log of meals.

use cohort::{Channel, Record};
use physiology::STEPS_PER_DAY;
use rand::RngExt as _;
use rand::seq::SliceRandom as _;
use rand_chacha::ChaCha8Rng;

use super::Happenings;
use super::moved::move_earlier;

/// Least carbohydrate of a meal, g; smaller entries are snacks or corrections of a low.
const LEAST_MEAL: f64 = 15.0;
/// Most carbohydrate of a rescue, g: the rule of 15 g, doubled.
const MOST_RESCUE: f64 = 30.0;
/// Glucose below which an entry counts as a rescue, mg/dL: a little above the alert of a low.
const LOW: f64 = 80.0;
/// Steps before the entry within which the sensor must show it: 20 min.
const BEFORE: usize = 4;
/// Hours of dinner, of the clock.
const DINNER: std::ops::Range<u8> = 18..23;

/// Steps and grams of the logged carbohydrate of at least `least` g, above 0.
fn logged(record: &Record, least: f64) -> Vec<(usize, f64)> {
    let entries = record.carbs().iter().enumerate();
    entries
        .filter_map(|(step, grams)| Some((step, (*grams)?)))
        .filter(|(_, grams)| *grams > 0.0 && *grams >= least)
        .collect()
}

/// Removes what is logged at some steps: they then say "nothing", as any other step does.
fn strike(record: &mut Record, steps: &[usize]) {
    let carbs = record.channel_mut(Channel::Carbs);
    steps.iter().for_each(|step| carbs[*step] = Some(0.0));
}

/// Meals that were eaten and not logged: removes `size` meals a day, at most every other one. Their
/// boluses stay.
pub(super) fn miss(record: &mut Record, size: f64, rng: &mut ChaCha8Rng) -> Happenings {
    let mut meals: Vec<usize> = logged(record, LEAST_MEAL).into_iter().map(|meal| meal.0).collect();
    meals.shuffle(rng);
    let days = record.len() as f64 / STEPS_PER_DAY as f64;
    let count = ((size * days).round() as usize).min(meals.len() / 2);
    strike(record, &meals[..count]);
    Happenings { count, places: meals.len() }
}

/// Carbohydrate eaten at a low and not logged: removes a share `size` of the logged rescues.
///
/// Only what a person logged can be removed. A cohort that logs no rescue cannot have this
/// planting.
pub(super) fn leave_out_rescues(
    record: &mut Record,
    size: f64,
    rng: &mut ChaCha8Rng,
) -> Happenings {
    let low = |step: usize| {
        let shown = &record.cgm()[step.saturating_sub(BEFORE)..=step];
        shown.iter().flatten().any(|glucose| *glucose < LOW)
    };
    let mut rescues = logged(record, 0.0);
    rescues.retain(|(step, grams)| *grams <= MOST_RESCUE && low(*step));
    // One draw per rescue, so that a larger share contains the smaller one.
    let struck = rescues.iter().map(|(step, _)| *step).filter(|_| rng.random::<f64>() < size);
    let struck: Vec<usize> = struck.collect();
    strike(record, &struck);
    Happenings { count: struck.len(), places: rescues.len() }
}

/// Large meals counted as smaller than they are: logged = k eaten^(1 / (1 + size)).
///
/// Counts err more for larger meals (Brazeau et al. 2013: 20.9 % on average, large meals
/// underestimated). `k` keeps the mean of the log, so that no common factor on carbohydrate
/// corrects it.
pub(super) fn miscount(record: &mut Record, size: f64) {
    let eaten = logged(record, 0.0);
    let counted = |grams: f64| grams.powf(1.0 / (1.0 + size));
    let total: f64 = eaten.iter().map(|meal| meal.1).sum();
    let by_count: f64 = eaten.iter().map(|meal| counted(meal.1)).sum();
    if by_count <= 0.0 {
        return;
    }
    let carbs = record.channel_mut(Channel::Carbs);
    for (step, grams) in eaten {
        carbs[step] = Some(total / by_count * counted(grams));
    }
}

/// Dinners that reach the blood later than logged: moves their carbohydrate in the log by `size`
/// minutes, rounded to steps, to the earlier. Boluses stay.
///
/// The body's response to a dinner then begins `size` minutes later than the log says. A slow meal
/// of the literature rises later *and* more slowly: here the time at which half has arrived is
/// right, but the shape is that of the person's usual meal.
pub(super) fn slow_down(record: &mut Record, size: f64) {
    let steps = (size / 5.0).round() as isize;
    let dinner: Vec<bool> = (0..record.len())
        .map(|k| {
            DINNER.contains(&record.hour(k))
                && record.carbs()[k].is_some_and(|grams| grams >= LEAST_MEAL)
        })
        .collect();
    move_earlier(record, Channel::Carbs, |k| if dinner[k] { steps } else { 0 });
}
