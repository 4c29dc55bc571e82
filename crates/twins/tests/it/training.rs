//! Training on people whose addition to the population model is known.

use std::sync::Arc;

use nn_statespace::{DoseGains, GlucoseClamp, PopulationModel};
use twins::{
    BuiltTwin, Doses, HeldOut, InputSet, KeptEpoch, Protocol, ResidualNetwork, Signs, TrainingPlan,
    Twin, TwinRecipe, WindowStart, build_twin, build_twins,
};

use crate::synthetic::{cohort_of, planted, population, twin_of};

/// Six training days, two test days, windows an hour apart: enough for a small network to learn
/// from, short enough for a test.
fn recipe() -> TwinRecipe {
    let protocol = Protocol {
        training_days: 6,
        least_windows: 5,
        start: WindowStart::Carried,
        ..Protocol::quick()
    };
    let plan = TrainingPlan {
        learning_rate: 1e-3,
        epochs: 8,
        batch: 8,
        keep: KeptEpoch::Best,
        ..TrainingPlan::paper()
    };
    TwinRecipe {
        population: population(GlucoseClamp::Reproduction),
        protocol,
        plan,
        inputs: InputSet::All,
        doses: Doses::Population,
        seed: 11,
    }
}

/// Of a record of eleven days, of which seven may train.
fn built(recipe: &TwinRecipe, before: Option<&twins::Twin>) -> BuiltTwin {
    let truth = twin_of(planted(), GlucoseClamp::Reproduction);
    let cohort = cohort_of(&truth, 1, 11);
    let person = build_twin(0, &cohort.people[0], recipe, before).expect("trainable");
    person.result.expect("not excluded")
}

#[test]
fn training_finds_a_planted_addition() {
    let found = built(&recipe(), None);
    let trained = &found.trained;
    // The windows are the truth's own output, so that nothing but training limits the fit; eight
    // epochs must take away most of it.
    assert!(
        trained.loss_after < 0.2 * trained.loss_before,
        "{} of {}",
        trained.loss_after,
        trained.loss_before
    );
    assert_eq!(trained.epochs.len(), 8);
    assert!(trained.kept > 0);
    assert_eq!(found.missing.heart_rate, 0);
    assert!(found.twin.heart_rate_scaler.is_some());
}

#[test]
fn gains_on_doses_are_found_and_kept_when_training_goes_on() {
    // Somebody who answers to insulin by half as much as the population, and to food by a quarter more.
    let gains = DoseGains { insulin: 0.5, carbs: 1.25 };
    let plain = twin_of(ResidualNetwork::zeros(), GlucoseClamp::Off);
    let own = PopulationModel::clone(&plain.population).with_dose_gains(gains).expect("positive");
    let cohort = cohort_of(&Twin { population: Arc::new(own), ..plain }, 1, 8);
    let plan = TrainingPlan { epochs: 1, signs: Signs::Kept, ..recipe().plan };
    let recipe = TwinRecipe {
        population: population(GlucoseClamp::Off),
        plan,
        doses: Doses::Scaled,
        ..recipe()
    };
    let build = |before: Option<&Twin>| {
        let built = build_twin(0, &cohort.people[0], &recipe, before).expect("trainable");
        built.result.expect("not excluded")
    };
    let first = build(None);
    let found = first.twin.population.scaler().dose_gains();
    // The record begins with other insulin on board than a settled start has.
    assert!((found.insulin - gains.insulin).abs() < 0.05, "{found:?}");
    assert!((found.carbs - gains.carbs).abs() < 0.05, "{found:?}");
    assert!(first.twin.residual.keeps_signs());
    let again = build(Some(&first.twin));
    assert_eq!(again.twin.population.scaler().dose_gains(), found);
}

#[test]
fn where_nothing_is_missing_nothing_is_learned() {
    let truth = twin_of(ResidualNetwork::zeros(), GlucoseClamp::Reproduction);
    let cohort = cohort_of(&truth, 1, 8);
    let plan = TrainingPlan { epochs: 2, keep: KeptEpoch::Last, ..recipe().plan };
    let recipe = TwinRecipe { plan, ..recipe() };
    let person = build_twin(0, &cohort.people[0], &recipe, None).expect("trainable");
    let trained = person.result.expect("not excluded").trained;
    // The record is the population model's own free run. A window's carried start differs from it
    // only by the settling of the record's first hours.
    assert!(trained.loss_before < 1e-3, "{}", trained.loss_before);
    // The steps of two epochs lead nowhere: little beside what an addition would leave.
    let planted = built(&recipe, None).trained.loss_before;
    assert!(trained.loss_after < 0.25 * planted, "{} of {planted}", trained.loss_after);
}

#[test]
fn the_result_depends_on_the_seed_and_not_on_the_threads() {
    let truth = twin_of(planted(), GlucoseClamp::Reproduction);
    // The same person twice: only their places in the cohort differ.
    let mut cohort = cohort_of(&truth, 1, 8);
    cohort.people.push(cohort.people[0].clone());
    let bytes = |threads: usize, seed: u64| -> Vec<Vec<u8>> {
        let recipe =
            TwinRecipe { plan: TrainingPlan { epochs: 1, ..recipe().plan }, seed, ..recipe() };
        let pool =
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a thread pool");
        let twins =
            pool.install(|| build_twins(&cohort, &recipe, &|_| {})).expect("trainable people");
        twins
            .into_iter()
            .map(|p| p.result.expect("not excluded").twin)
            .map(|twin| twin.to_bytes().expect("writable"))
            .collect()
    };
    let once = bytes(1, 11);
    assert_eq!(once, bytes(1, 11));
    assert_eq!(once, bytes(3, 11));
    let other = bytes(1, 12);
    assert_ne!(once[0], other[0]);
    let weights = |bytes: &[u8]| bytes[bytes.len() - 8 * 11_777..].to_vec();
    assert_ne!(weights(&once[0]), weights(&once[1]));
}

#[test]
fn new_days_go_on_from_the_old_twin() {
    let plan = TrainingPlan { epochs: 3, ..recipe().plan };
    let first = built(&TwinRecipe { plan, ..recipe() }, None);
    let protocol = Protocol { training_days: 7, least_windows: 1, ..recipe().protocol };
    let again = built(&TwinRecipe { plan, protocol, ..recipe() }, Some(&first.twin));
    // The first loss of the second training is that of the old twin on seven days.
    assert!(again.trained.loss_before < 1.5 * first.trained.loss_after);
    assert!(again.trained.loss_after < first.trained.loss_after);
    assert_eq!(again.twin.heart_rate_scaler, first.twin.heart_rate_scaler);
    let truth = twin_of(planted(), GlucoseClamp::Reproduction);
    let cohort = cohort_of(&truth, 1, 11);
    let refused = |recipe: &TwinRecipe, before: &Twin| {
        let error = build_twin(0, &cohort.people[0], recipe, Some(before)).expect_err("refused");
        error.to_string()
    };
    // Days that trained the old twin would test the new one.
    let protocol = Protocol { training_days: 4, ..recipe().protocol };
    let error = refused(&TwinRecipe { protocol, ..recipe() }, &first.twin);
    assert!(error.contains("--training-days 6"), "{error}");
    let mut stranger = first.twin;
    stranger.card.person_id = "someone".to_owned();
    let error = refused(&recipe(), &stranger);
    assert!(error.contains("someone"), "{error}");
}

#[test]
fn held_out_days_choose_the_epoch() {
    let protocol = Protocol { held_out: HeldOut::Last(1), ..recipe().protocol };
    let plan = TrainingPlan { epochs: 4, ..recipe().plan };
    let trained = built(&TwinRecipe { protocol, plan, ..recipe() }, None).trained;
    let losses: Vec<f64> = trained.epochs.iter().map(|e| e.held_out.expect("held out")).collect();
    let best = losses.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(best < trained.held_out_before.expect("held out"));
    assert_eq!(losses[trained.kept - 1], best);
}

#[test]
fn test_days_do_not_reach_the_twin() {
    let truth = twin_of(planted(), GlucoseClamp::Reproduction);
    let recipe = TwinRecipe { plan: TrainingPlan { epochs: 1, ..recipe().plan }, ..recipe() };
    let bytes = |person: &cohort::Person| {
        let built = build_twin(0, person, &recipe, None).expect("trainable");
        built.result.expect("not excluded").twin.to_bytes().expect("writable")
    };
    let mut person = cohort_of(&truth, 1, 8).people.remove(0);
    let before = bytes(&person);
    let first = recipe.protocol.training_days_of(&person.record) * physiology::STEPS_PER_DAY;
    for channel in cohort::Channel::ALL {
        let column = person.record.channel_mut(channel);
        column[first..].fill(Some(0.75));
    }
    assert_eq!(bytes(&person), before);
    person.record.channel_mut(cohort::Channel::HeartRate)[100] = Some(90.0);
    assert_ne!(bytes(&person), before);
}

#[test]
fn people_are_left_out_for_a_reason() {
    let truth = twin_of(ResidualNetwork::zeros(), GlucoseClamp::Reproduction);
    let recipe = TwinRecipe { plan: TrainingPlan { epochs: 1, ..recipe().plan }, ..recipe() };
    let day = physiology::STEPS_PER_DAY;
    type Spoil<'a> = &'a dyn Fn(&mut cohort::Record);
    let cases: [(&str, Spoil<'_>); 4] = [
        ("no insulin recorded in the test days", &|record| {
            record.channel_mut(cohort::Channel::Basal)[6 * day..].fill(Some(0.0));
            record.channel_mut(cohort::Channel::Bolus)[6 * day..].fill(Some(0.0));
        }),
        ("no carbohydrate recorded in the training days", &|record| {
            record.channel_mut(cohort::Channel::Carbs)[..6 * day].fill(Some(0.0));
        }),
        ("0 complete training windows, 5 needed", &|record| {
            for reading in record.channel_mut(cohort::Channel::Cgm)[..6 * day].iter_mut().step_by(9)
            {
                *reading = None;
            }
        }),
        // Two days: one trains, and the other holds four windows of five hours.
        ("4 complete test windows, 5 needed", &|record| {
            *record = record.slice(0..2 * day).expect("inside");
        }),
    ];
    for (reason, spoil) in cases {
        let mut person = cohort_of(&truth, 1, 9).people.remove(0);
        spoil(&mut person.record);
        let built = build_twin(0, &person, &recipe, None).expect("no error");
        let excluded = built.result.err().map(|excluded| excluded.to_string());
        assert_eq!(excluded.as_deref(), Some(reason));
    }
}

#[test]
fn a_short_record_keeps_a_third_of_its_days_to_test_on() {
    let truth = twin_of(ResidualNetwork::zeros(), GlucoseClamp::Reproduction);
    let record = cohort_of(&truth, 1, 9).people.remove(0).record;
    let two_weeks = Protocol::paper();
    assert_eq!(two_weeks.training_days_of(&record), 6);
    assert_eq!(Protocol { training_days: 4, ..two_weeks }.training_days_of(&record), 4);
}

#[test]
fn settings_that_cannot_be_are_refused_by_name() {
    let truth = twin_of(ResidualNetwork::zeros(), GlucoseClamp::Reproduction);
    let person = cohort_of(&truth, 1, 9).people.remove(0);
    for (plan, name) in [
        (TrainingPlan { batch: 0, ..TrainingPlan::quick() }, "batch"),
        (TrainingPlan { learning_rate: f64::NAN, ..TrainingPlan::quick() }, "learning_rate"),
        (TrainingPlan { epochs: 0, ..TrainingPlan::quick() }, "epochs"),
    ] {
        let error = build_twin(0, &person, &TwinRecipe { plan, ..recipe() }, None);
        let message = error.expect_err("refused").to_string();
        assert!(message.contains(name), "{message}");
    }
    let far = TrainingPlan { learning_rate: 1e9, epochs: 40, ..TrainingPlan::quick() };
    let off = population(GlucoseClamp::Off);
    let recipe = TwinRecipe { plan: far, population: Arc::clone(&off), ..recipe() };
    let error = build_twin(0, &person, &recipe, None).expect_err("diverges");
    assert!(error.to_string().contains("lower the learning rate"), "{error}");
}
