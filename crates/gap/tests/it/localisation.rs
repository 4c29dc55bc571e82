//! A planted gap is found where it was planted, and none where there is none.

use cohort::Cohort;
use gap::diagnosis::{CellFactor, CellGap, HourlyRow};
use gap::{Diagnoser, Diagnosis, DiagnosisConfig, GapError, LocalisationRule, Verdict};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::ThreadPoolBuilder;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::synthetic::{Gap, World, cohort, with_gaps};

/// Fewer replicates than for people's data: p-values of 0.05 need no more.
fn config() -> DiagnosisConfig {
    let working = DiagnosisConfig::working();
    let localisation = LocalisationRule { replicates: 500, ..working.localisation };
    DiagnosisConfig { localisation, ..working }
}

fn diagnose(cohort: &Cohort, config: &DiagnosisConfig, seed: u64) -> Result<Diagnosis, GapError> {
    Diagnoser::new(&effects::library(), config).run(cohort, seed)
}

fn cell<'a>(diagnosis: &'a Diagnosis, factor: CellFactor, level: &str) -> &'a CellGap {
    let found = diagnosis.cells.iter().find(|c| c.factor == factor && c.level == level);
    found.unwrap_or_else(|| panic!("no cell {factor:?} {level}"))
}

#[test]
fn a_planted_dawn_is_found_in_the_early_morning_with_its_sign() {
    let world = World { gap: Gap::Dawn(0.35), days: 14, spread: 0.7 };
    let mut cohort = cohort(&world, 5, 11);
    // Missing readings must not hide it.
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    cohort.people = cohort.people.into_iter().map(|p| with_gaps(p, &mut rng)).collect();
    let diagnosis = diagnose(&cohort, &config(), 1).expect("diagnosed");
    assert_eq!(diagnosis.verdict, Verdict::Effect, "{:?}", diagnosis.candidates);
    assert_eq!(diagnosis.effects[0].effect, "dawn", "{:?}", diagnosis.effects);
    let dawn = cell(&diagnosis, CellFactor::Hour, "03-06");
    assert!(dawn.p_adjusted <= 0.05 && dawn.lower > 0.0, "{dawn:?}");
    let innovation = dawn.innovation.expect("hours have both layers");
    assert!(innovation.p_adjusted <= 0.05 && innovation.lower > 0.0, "{innovation:?}");
    // A third more production for an hour is 0.0048 mmol/kg/min x 60 min = 33 mg/dL without insulin;
    // insulin suppresses part and calibration takes up a fifth.
    assert!((3.0..33.0).contains(&dawn.mean_error_mg_dl), "{dawn:?}");
    let hours = diagnosis.cells.iter().filter(|c| c.factor == CellFactor::Hour);
    let largest = hours.max_by(|a, b| a.mean_error_mg_dl.total_cmp(&b.mean_error_mg_dl));
    assert_eq!(largest.map(|c| c.level.as_str()), Some("03-06"));
    assert!(diagnosis.cells.is_sorted_by(|a, b| a.share_of_gap >= b.share_of_gap));

    // The maps by hour show it in the same hours, in everybody.
    let maps = diagnosis.hourly.as_ref().expect("maps are made");
    let largest = |row: &HourlyRow| {
        let cells = row.cells.iter().zip(&maps.parts);
        let cells = cells.filter_map(|(cell, part)| Some((cell.as_ref()?, part.as_str())));
        cells.max_by(|a, b| a.0.mean_error_mg_dl.total_cmp(&b.0.mean_error_mg_dl)).map_or_else(
            String::new,
            |(cell, part)| {
                assert!(cell.lower < cell.mean_error_mg_dl && cell.mean_error_mg_dl < cell.upper);
                part.to_owned()
            },
        )
    };
    let all = &maps.situations[0];
    assert_eq!(all.name, "all");
    let part = largest(all);
    assert!(["03-06", "06-09"].contains(&part.as_str()), "{all:?}");
    assert_eq!(maps.people.len(), 5);
    let early = ["03-06", "06-09"];
    let same = maps.people.iter().filter(|row| early.contains(&largest(row).as_str()));
    assert!(same.count() >= 4, "{:?}", maps.people);
}

#[test]
fn worlds_without_a_gap_raise_few_alarms() {
    let world = World { gap: Gap::None, days: 14, spread: 0.7 };
    let worlds = 40;
    let alarms = (0..worlds)
        .filter(|seed| {
            let cohort = cohort(&world, 5, 1000 + seed);
            diagnose(&cohort, &config(), *seed).expect("diagnosed").verdict != Verdict::None
        })
        .count();
    // These people are the plant and repeat the same day, unlike all on whom the posterior was trained (decision 0054:
    // three of them over six days alarm more often). At one in ten, more than 9 of 40 happen in 0.5 % of such tests.
    assert!(alarms <= 9, "{alarms} alarms in {worlds} worlds");
}

#[test]
fn many_people_without_a_gap_show_none_where_glucose_is_high_or_low() {
    // Twenty people are enough to resolve 1 mg/dL: runs that drop the filter's flux would miss by
    // that much above 180 and by three times as much below 70.
    let world = World { gap: Gap::None, days: 14, spread: 0.7 };
    let diagnosis = diagnose(&cohort(&world, 20, 3), &config(), 1).expect("diagnosed");
    for level in [">180", "70-180", "<70"] {
        let band = cell(&diagnosis, CellFactor::GlucoseBand, level);
        assert!(band.p_adjusted > 0.05 && band.mean_error_mg_dl.abs() < 3.0, "{band:?}");
    }
    assert_eq!(diagnosis.verdict, Verdict::None);
}

#[test]
fn the_answer_does_not_depend_on_the_number_of_threads() {
    let world = World { gap: Gap::None, days: 5, spread: 0.5 };
    let cohort = cohort(&world, 4, 5);
    let on = |threads: usize| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let done = AtomicUsize::new(0);
        let diagnosis = pool.install(|| {
            let count = |_, of| {
                assert_eq!(of, 4);
                done.fetch_add(1, Ordering::Relaxed);
            };
            let library = effects::library();
            Diagnoser::new(&library, &config()).progress(&count).run(&cohort, 9)
        });
        assert_eq!(done.load(Ordering::Relaxed), 4);
        serde_json::to_string(&diagnosis.expect("diagnosed")).expect("serialises")
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn the_file_has_the_keys_of_the_format_and_reads_back() {
    let world = World { gap: Gap::None, days: 5, spread: 0.5 };
    let diagnosis = diagnose(&cohort(&world, 2, 5), &config(), 9).expect("diagnosed");
    let text = serde_json::to_string(&diagnosis).expect("serialises");
    // Not compared number by number: the reader may round the last digit.
    let again: Diagnosis = serde_json::from_str(&text).expect("reads back");
    assert_eq!((again.verdict, again.cells.len()), (diagnosis.verdict, diagnosis.cells.len()));
    assert_eq!(again.config, diagnosis.config);
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(json["schema"], "diagnosis/3");
    for (list, keys) in [
        (
            "where",
            &[
                "factor",
                "level",
                "mean_error_mg_dl",
                "lower",
                "upper",
                "p_adjusted",
                "share_of_gap",
            ][..],
        ),
        ("people", &["person_id", "days", "excluded"]),
        ("data_quality", &["check", "person_id", "finding", "estimate"]),
        ("baseline", &["minutes", "mae", "rmse", "bias"]),
    ] {
        let first = &json[list][0];
        for key in keys {
            assert!(first.get(key).is_some(), "{list}: no {key} in {first}");
        }
    }
    assert_eq!(json["effects"], serde_json::json!([]));
    for (list, entry) in [("candidates", "effect"), ("ports", "port")] {
        let entries = json[list].as_array().expect("a list");
        assert!(!entries.is_empty(), "{list}");
        for key in [entry, "gain_nats", "probability"] {
            assert!(
                entries.iter().all(|e| e.get(key).is_some_and(|v| !v.is_null())),
                "{list}: {key}"
            );
        }
    }
    assert_eq!(json["how_far"]["horizons"], serde_json::json!([]));
    assert!(!text.contains("null,\"lower\""), "a number that is not finite became null");
}

#[test]
fn people_who_cannot_be_diagnosed_are_excluded_by_name_and_reason() {
    use cohort::Channel::{Basal, Bolus, Carbs, Cgm, HeartRate};
    let world = World { gap: Gap::None, days: 5, spread: 0.5 };
    let mut cohort = cohort(&world, 6, 5);
    cohort.people[0].record = cohort.people[0].record.slice(0..600).expect("inside");
    for channel in [Basal, Bolus] {
        cohort.people[1].record.channel_mut(channel).fill(None);
    }
    cohort.people[2].record.channel_mut(Carbs).fill(None);
    cohort.people[3].record.channel_mut(Cgm)[..1000].fill(None);
    cohort.people[4].weight = None;
    cohort.people[5].record.channel_mut(HeartRate).fill(Some(60.0));
    let diagnosis = diagnose(&cohort, &config(), 1).expect("two are left");
    let reasons: Vec<_> = diagnosis.people.iter().map(|p| p.excluded.as_deref()).collect();
    for (reason, part) in reasons.iter().zip(["whole days", "insulin", "carbohydrate", "CGM"]) {
        assert!(reason.is_some_and(|r| r.contains(part)), "{reason:?} should name {part}");
    }
    assert_eq!(reasons[4..], [None, None]);
    let assumed = diagnosis.people[4].calibration.as_ref().map(|c| (c.weight_assumed, c.weight_kg));
    assert_eq!(assumed, Some((true, 76.3)));
    let missing = |id: &str, part: &str| {
        diagnosis
            .data_quality
            .iter()
            .any(|f| f.check == "missing_channel" && f.person_id == id && f.finding.contains(part))
    };
    assert!(missing("p4", "weight") && !missing("p5", "weight"));
    assert!(missing("p4", "heart rate") && !missing("p5", "heart rate"));
    assert!(missing("p1", "insulin") && missing("p2", "carbohydrate"));
    // No sleep, exercise or set change is on record: such cells are absent, not zero.
    for level in ["sleep", "exercise", "set_day_3_plus", "sensor_late"] {
        assert!(diagnosis.cells.iter().all(|c| c.level != level), "{level}");
    }
}

#[test]
fn a_single_person_is_judged_on_their_own_days() {
    let world = World { gap: Gap::Dawn(0.6), days: 14, spread: 0.5 };
    let diagnosis = diagnose(&cohort(&world, 1, 21), &config(), 1).expect("diagnosed");
    let dawn = cell(&diagnosis, CellFactor::Hour, "03-06");
    assert_eq!(dawn.people, 1);
    assert!(dawn.mean_error_mg_dl > 3.0 && dawn.lower < dawn.upper, "{dawn:?}");
    assert_eq!(diagnosis.baseline.len(), 3);
    for horizon in &diagnosis.baseline {
        assert!(horizon.mae.lower < horizon.mae.value && horizon.mae.value < horizon.mae.upper);
    }
}

#[test]
fn unrecorded_doses_are_treated_as_the_policy_says() {
    let world = World { gap: Gap::None, days: 5, spread: 0.5 };
    let mut cohort = cohort(&world, 2, 5);
    let whole = diagnose(&cohort, &config(), 1).expect("diagnosed");
    cohort.people[0].record.channel_mut(cohort::Channel::Bolus)[700..720].fill(None);
    let held = diagnose(&cohort, &config(), 1).expect("diagnosed");
    let runs = |d: &Diagnosis| d.people[0].calibration.as_ref().map_or(0, |c| c.runs);
    assert_eq!(held.people[0].calibration.as_ref().map(|c| c.unrecorded_doses), Some(20));
    assert!(0 < runs(&held) && runs(&held) < runs(&whole), "{} {}", runs(&held), runs(&whole));
    let strict =
        DiagnosisConfig { missing_doses: gap::MissingDosePolicy::ExcludePerson, ..config() };
    let strict = diagnose(&cohort, &strict, 1).expect("one is left");
    let reason = strict.people[0].excluded.as_deref();
    assert!(reason.is_some_and(|r| r.starts_with("20 steps")), "{reason:?}");
}

#[test]
fn bad_input_is_an_error_that_says_where() {
    let world = World { gap: Gap::None, days: 5, spread: 0.5 };
    let good = cohort(&world, 1, 5);
    let empty = diagnose(&Cohort::default(), &config(), 1);
    assert_eq!(empty, Err(GapError::EmptyCohort));

    let mut broken = good.clone();
    broken.people[0].record.channel_mut(cohort::Channel::Cgm)[77] = Some(f64::NAN);
    let error = diagnose(&broken, &config(), 1).expect_err("NaN").to_string();
    assert!(error.contains("person p0, step 77: cgm_mg_dl is NaN"), "{error}");

    let mut short = good.clone();
    short.people[0].record = short.people[0].record.slice(0..300).expect("inside");
    let error = diagnose(&short, &config(), 1).expect_err("one day").to_string();
    assert!(error.contains("p0") && error.contains("whole days"), "{error}");

    let mut settings = config();
    settings.free_run.horizons = vec![60, 12];
    let error = diagnose(&good, &settings, 1).expect_err("descending").to_string();
    assert!(error.contains("horizons"), "{error}");
    settings = config();
    settings.localisation.horizon = 13;
    assert!(diagnose(&good, &settings, 1).is_err(), "cells need a horizon that is run");
}
