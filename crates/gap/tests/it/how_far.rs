//! What a found effect removes on held-out days.

use cohort::{Channel, Cohort};
use effects::Effect;
use gap::diagnosis::HowFar;
use gap::filter::augmented::AugmentedModel;
use gap::filter::calibration::{Calibration, calibrate};
use gap::how_far::{NamedEffect, how_far, shrinkage};
use gap::{CalibratedPerson, DiagnosisConfig, LocalisationRule, NoiseModel, Observations};
use ode_sim::OdeParameters;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::synthetic::{Gap, World, cohort_under, with_gaps};

/// Half of the noise that free-living people need, so that a few people for a fortnight show an effect.
fn noise() -> NoiseModel {
    let working = NoiseModel::working();
    NoiseModel {
        flux_sd: 0.5 * working.flux_sd,
        carb_count_cv: 0.5 * working.carb_count_cv,
        insulin_cv: 0.5 * working.insulin_cv,
        effect_cv: 0.5 * working.effect_cv,
        ..working
    }
}

fn cohort(world: &World, people: usize, seed: u64) -> Cohort {
    cohort_under(world, people, seed, &noise())
}

fn config() -> DiagnosisConfig {
    let working = DiagnosisConfig { noise: noise(), ..DiagnosisConfig::working() };
    let localisation = LocalisationRule { replicates: 500, ..working.localisation };
    DiagnosisConfig { localisation, ..working }
}

/// Everybody's observations and calibration.
fn calibrated(cohort: &Cohort) -> Vec<(Observations, Calibration)> {
    let config = config();
    cohort
        .people
        .par_iter()
        .map(|person| {
            let observations = Observations::from_person(person).expect("a good record");
            let weight = observations.weight;
            let population = AugmentedModel::new(OdeParameters::nominal(), weight, config.noise);
            let calibration =
                calibrate(&population, &observations, &config.calibration).expect("calibrates");
            (observations, calibration)
        })
        .collect()
}

fn measured(cohort: &Cohort, effects: &[(&dyn Effect, usize)]) -> HowFar {
    measured_at(1.0, cohort, effects)
}

/// With effects that were named with this amplitude.
fn measured_at(amplitude: f64, cohort: &Cohort, effects: &[(&dyn Effect, usize)]) -> HowFar {
    let known = calibrated(cohort);
    let people: Vec<CalibratedPerson<'_>> = cohort
        .people
        .iter()
        .zip(&known)
        .map(|(person, (observations, calibration))| CalibratedPerson {
            person,
            observations,
            calibration,
        })
        .collect();
    let found: Vec<NamedEffect<'_>> = effects
        .iter()
        .map(|(effect, variant)| NamedEffect {
            effect: *effect,
            variant: *variant,
            amplitudes: vec![amplitude; people.len()],
        })
        .collect();
    how_far(&people, &found, &config(), 1).expect("measured")
}

/// The variant of the library's dawn that has the form of [`Gap::MorningBump`].
const PEAK_AT_SIX: usize = 1;
/// Rise of production at the peak at amplitude 1 in the library's dawn.
const RISE: f64 = 0.22;

fn errors(found: &HowFar, horizon: usize) -> (Vec<f64>, Vec<f64>) {
    let of = |person: &gap::diagnosis::PersonChange| {
        let error = |errors: &[Option<f64>]| errors[horizon].expect("everyone has runs");
        (error(&person.mae_before), error(&person.mae_after))
    };
    found.people.iter().map(of).unzip()
}

#[test]
fn a_planted_effect_shrinks_the_error_nearly_as_far_as_the_truth_would() {
    let planted = 2.0;
    let under = |gap| cohort(&World { gap, days: 14, spread: 0.7 }, 8, 21);
    let dawn = effects::find("dawn").expect("in the library");
    // The variant handed over is wrong: training days put it right.
    let found = measured(&under(Gap::MorningBump(planted * RISE)), &[(dawn.as_ref(), 0)]);
    assert_eq!(found.amplitudes[0].variants, [PEAK_AT_SIX; 3]);
    // The same people with the same noise: without the effect the plant before is the true one.
    let without = measured(&under(Gap::None), &[(dawn.as_ref(), PEAK_AT_SIX)]);

    let amplitude = found.amplitudes[0].mean;
    assert!(amplitude.lower < planted && planted < amplitude.upper, "{amplitude:?}");
    assert!(amplitude.upper - amplitude.lower < 1.5, "{amplitude:?} says little");
    for (index, row) in found.horizons.iter().enumerate() {
        assert!(!row.reconstructed && row.people == 8, "{row:?}");
        let change = row.mae_after - row.mae_before;
        assert!((row.difference.value - change).abs() < 1e-9, "rounding of means: {row:?}");
        assert!(row.difference.upper < 0.0, "{row:?}");
        let (before, after) = errors(&found, index);
        // At five hours and a day few errors are independent, and too little is left to be removed.
        if row.minutes > 60 {
            continue;
        }
        let (truth, _) = errors(&without, index);
        let plan = stats::Bootstrap { replicates: 500, level: 0.95, seed: 3 };
        let share = shrinkage(&before, &after, &truth, 0.1, &plan).expect("eight people");
        let share = share.expect("more than 0.1 mg/dL can be removed");
        // Amplitudes come from nine days; what they miss by costs a few per cent of what they remove.
        let near = (0.85..1.15).contains(&share.value);
        assert!(near && share.lower < 1.0 && share.upper > 0.9, "{} min: {share:?}", row.minutes);
    }
    let innovations = found.innovations.expect("scored");
    assert!(innovations.difference.lower > 0.0, "{innovations:?}");
    // A model that lacks nothing but its noise comes close to its own floor.
    let hour = &found.horizons[0];
    let floor = hour.floor.expect("taken");
    assert!((hour.mae_after / floor - 1.0).abs() < 0.15, "{hour:?}");
    assert_eq!(found.outcomes.len(), 6);
    assert!(found.notes.is_empty(), "{:?}", found.notes);
}

#[test]
fn without_the_effect_nothing_is_gained() {
    let dawn = effects::find("dawn").expect("in the library");
    let mut covered = [0; 3];
    let worlds = 8;
    for seed in 0..worlds {
        let world = World { gap: Gap::None, days: 10, spread: 0.7 };
        let found = measured(&cohort(&world, 5, 300 + seed), &[(dawn.as_ref(), PEAK_AT_SIX)]);
        for (count, row) in covered.iter_mut().zip(&found.horizons) {
            *count += usize::from(row.difference.lower <= 0.0 && row.difference.upper >= 0.0);
            assert!(row.difference.value.abs() < 0.5, "{row:?}");
        }
        assert!(found.amplitudes[0].mean.value < 0.8, "{:?}", found.amplitudes);
    }
    // At 95 %, fewer than six of eight happen in 0.6 % of such tests.
    assert!(covered.iter().all(|count| *count >= 6), "{covered:?} of {worlds}");
}

#[test]
fn the_answer_does_not_depend_on_the_number_of_threads() {
    let world = World { gap: Gap::MorningBump(0.3), days: 6, spread: 0.5 };
    let cohort = cohort(&world, 3, 5);
    let dawn = effects::find("dawn").expect("in the library");
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| measured(&cohort, &[(dawn.as_ref(), PEAK_AT_SIX)]))
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn nothing_found_changes_nothing() {
    let world = World { gap: Gap::None, days: 5, spread: 0.5 };
    let found = measured(&cohort(&world, 2, 5), &[]);
    assert_eq!(found, HowFar::default());
}

/// Leaves every third lunch out of the log.
fn forget_lunches(cohort: &mut Cohort) {
    for person in &mut cohort.people {
        let carbs = person.record.channel_mut(Channel::Carbs);
        for (step, grams) in carbs.iter_mut().enumerate() {
            let (day, hour) = (step / 288, (step % 288) / 12);
            if day % 3 == 1 && (10..15).contains(&hour) {
                *grams = Some(0.0);
            }
        }
    }
}

#[test]
fn hidden_events_are_reconstructed_and_kept_apart() {
    let world = World { gap: Gap::None, days: 12, spread: 0.7 };
    let missed = effects::find("missed_meals").expect("in the library");
    let logged = cohort(&world, 5, 40);
    let mut forgotten = logged.clone();
    forget_lunches(&mut forgotten);
    let found = measured(&forgotten, &[(missed.as_ref(), 0)]);
    assert_eq!(found.horizons.len(), 3);
    assert!(found.horizons.iter().all(|row| row.reconstructed), "no row may pass for a prediction");
    assert!(found.amplitudes.is_empty() && found.outcomes.is_empty());
    assert_eq!(found.notes.len(), 1, "{:?}", found.notes);
    let five_hours = &found.horizons[1];
    // Four lunches in twelve days spoil one run in ten by about 60 mg/dL at five hours.
    assert!(five_hours.difference.upper < -1.0, "{five_hours:?}");
    for person in &found.people {
        assert_eq!(person.mae_before, person.mae_after, "nothing was predicted");
        assert_ne!(person.mae_reconstructed, person.mae_after);
    }
    // Meals of the usual size that are missed seldom are as large as others.
    let seldom = measured_at(0.4, &forgotten, &[(missed.as_ref(), 0)]);
    assert!(seldom.horizons[1].difference.upper < -1.0, "{:?}", seldom.horizons[1]);
    let nothing_missed = measured(&logged, &[(missed.as_ref(), 0)]);
    for row in &nothing_missed.horizons {
        assert!(row.difference.value.abs() < 0.5, "{row:?}");
    }
}

#[test]
fn a_driven_and_a_hidden_effect_have_rows_of_their_own() {
    let world = World { gap: Gap::MorningBump(2.0 * RISE), days: 8, spread: 0.5 };
    let mut cohort = cohort(&world, 5, 7);
    forget_lunches(&mut cohort);
    let dawn = effects::find("dawn").expect("in the library");
    let missed = effects::find("missed_meals").expect("in the library");
    let random = effects::find("insulin_absorption").expect("in the library");
    let found = measured(
        &cohort,
        &[(missed.as_ref(), 0), (dawn.as_ref(), PEAK_AT_SIX), (random.as_ref(), 0)],
    );
    let kinds: Vec<bool> = found.horizons.iter().map(|row| row.reconstructed).collect();
    assert_eq!(kinds, [false, false, false, true, true, true]);
    for (predicted, reconstructed) in found.horizons[..3].iter().zip(&found.horizons[3..]) {
        let chained = (predicted.mae_after - reconstructed.mae_before).abs();
        assert!(chained < 1e-9, "reconstruction goes on from the prediction: {chained}"); // rounding
    }
    assert_eq!(found.amplitudes.len(), 1);
    assert_eq!(found.amplitudes[0].effect, "dawn");
}

#[test]
fn people_with_gaps_foreign_days_and_short_records_are_judged_or_named() {
    let world = World { gap: Gap::None, days: 8, spread: 0.5 };
    let mut cohort = cohort(&world, 4, 9);
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    cohort.people = cohort.people.into_iter().map(|p| with_gaps(p, &mut rng)).collect();
    // One starts at noon and ends in the morning; one has a day and a half; one misses doses for a day.
    cohort.people[1].record = cohort.people[1].record.slice(144..2100).expect("inside");
    cohort.people[2].record = cohort.people[2].record.slice(0..432).expect("inside");
    cohort.people[3].record.channel_mut(Channel::Bolus)[800..1088].fill(None);
    let dawn = effects::find("dawn").expect("in the library");
    let set_ageing = effects::find("set_ageing").expect("in the library");
    let found = measured(&cohort, &[(dawn.as_ref(), 1), (set_ageing.as_ref(), 0)]);
    let judged: Vec<usize> = found.people.iter().map(|person| person.days).collect();
    assert!(judged[0] == 8 && judged[1] >= 7 && judged[3] < judged[0], "{judged:?}");
    assert_eq!(judged[2], 0, "a record of one whole day cannot be split");
    assert!(found.notes.iter().any(|note| note.contains("p2")), "{:?}", found.notes);
    assert_eq!(found.amplitudes[1].people.len(), 4);
    for row in &found.horizons {
        assert!(row.people == 3 && row.difference.value.is_finite(), "{row:?}");
    }
}

#[test]
fn what_depends_on_glucose_and_who_lacks_a_channel_is_said() {
    let world = World { gap: Gap::None, days: 5, spread: 0.5 };
    let mut cohort = cohort(&world, 3, 9);
    for person in &mut cohort.people[..2] {
        let rates = person.record.channel_mut(Channel::HeartRate);
        for (step, rate) in rates.iter_mut().enumerate() {
            *rate = Some(if (200..212).contains(&(step % 288)) { 130.0 } else { 65.0 });
        }
    }
    let exercise = effects::find("exercise").expect("in the library");
    let found = measured(&cohort, &[(exercise.as_ref(), 0)]);
    let expected = [
        "exercise: 1 of 3 records do not signal it",
        "exercise depends on glucose: free runs drive it with their own",
    ];
    assert_eq!(found.notes, expected);
    // Without the channel nothing is changed.
    let without = &found.people[2];
    assert_eq!(without.mae_before, without.mae_after);
    assert!(found.amplitudes[0].mean.value < 0.5, "{:?}", found.amplitudes);
}
