//! Judging twins of a cohort whose truth is known, and the tables that come out.

#[expect(dead_code, reason = "tests of the twins use the rest of this module")]
#[path = "../../twins/tests/it/synthetic.rs"]
mod synthetic;

use std::collections::BTreeMap;

use cohort::{Cohort, WindowRule};
use contract::OutcomesTable;
use contract::what_if::WhatIfPlan;
use evaluation::{
    EvaluationSettings, Method, Model, PersonModels, evaluate, example_day, glucose_profile,
    outcomes_table, twins_table, what_if,
};
use nn_statespace::GlucoseClamp;
use physiology::{OpenLoop, simulate};
use synthetic::{cohort_of, trained_looking, twin_of};
use twins::{
    Doses, InputSet, PersonWindows, Protocol, ResidualNetwork, TrainingPlan, Twin, TwinRecipe,
    WindowStart, build_twins, window_starts,
};

fn protocol() -> Protocol {
    Protocol { training_days: 4, start: WindowStart::Carried, ..Protocol::paper() }
}

fn settings() -> EvaluationSettings {
    let settings = EvaluationSettings::paper(protocol(), 3);
    EvaluationSettings {
        bootstrap: stats::Bootstrap { replicates: 200, ..settings.bootstrap },
        ..settings
    }
}

fn truth() -> Twin {
    let mut twin = twin_of(trained_looking(7), GlucoseClamp::Reproduction);
    twin.heart_rate_scaler = Some(twins::HeartRateScaler { center: 2.0, scale: 20.0 });
    twin
}

fn three_people() -> Cohort {
    cohort_of(&truth(), 3, 8)
}

fn same_twin_for_all(cohort: &Cohort, twin: &Twin) -> BTreeMap<String, PersonModels> {
    let people = cohort.people.iter();
    people.map(|person| (person.id.clone(), PersonModels::new(person, twin.clone()))).collect()
}

fn rmse(person: &evaluation::PersonEvaluation, method: Method) -> f64 {
    person.of(method).expect("judged").rmse
}

#[test]
fn the_true_twin_is_found_equivalent_and_best() {
    let cohort = three_people();
    let truth = truth();
    let twins = same_twin_for_all(&cohort, &truth);
    let found = evaluate(&cohort, &twins, &truth.population, &settings()).expect("judged");
    assert_eq!((found.people.len(), found.exclusions.len()), (3, 0));
    for person in &found.people {
        // The record is the truth's own run; a carried start differs from it only by what is left
        // of the record's first hours.
        let twin = rmse(person, Method::Twin);
        assert!(twin < 0.1, "{twin}");
        assert!(rmse(person, Method::Population) > 10.0 * twin);
        assert_eq!(person.windows, 19); // 4 x 288 steps hold 19 windows of 60
    }
    let table = outcomes_table("made", &found, &settings()).expect("three people");
    let twin = &table.methods[0];
    assert_eq!((twin.name.as_str(), twin.rows.len()), ("twin", 6));
    assert!(twin.rows.iter().all(|row| row.equivalent && row.p <= row.p_holm));
    assert!(table.comparisons.iter().all(|c| c.difference.upper < 0.0));
    // The sensor on the training days is told from the sensor on the days after.
    assert_eq!(table.training_days.len(), 6);
    assert!(table.training_days.iter().zip(&twin.rows).all(|(own, row)| own.actual == row.actual));
    let mean = |rows: &[contract::outcomes::OutcomeRow]| rows[5].simulated.mean;
    assert!((mean(&table.training_days) - mean(&twin.rows)).abs() > 0.1);
    let training: f64 = found.people.iter().map(|person| person.training.mg).sum();
    assert!((mean(&table.training_days) - training / 3.0).abs() < 1e-9);
    let all = table.methods.iter().flat_map(|method| &method.rows);
    for row in all.chain(&table.training_days) {
        let shift = row.simulated.mean - row.actual.mean;
        for difference in [row.difference, row.difference_t] {
            assert!((difference.value - shift).abs() < 1e-9, "{row:?}"); // rounding of means
            assert!(difference.lower <= shift + 1e-9 && shift <= difference.upper + 1e-9);
        }
    }
    let twin_120 = table.forecast.iter().find(|r| r.method == "twin" && r.minutes == 120);
    let persistence = table.forecast.iter().find(|r| r.method == "persistence" && r.minutes == 120);
    let (twin_120, persistence) = (twin_120.expect("a row"), persistence.expect("a row"));
    assert!(twin_120.rmse.mean < 0.1 && persistence.rmse.mean > 5.0);
    // Three plants, persistence and the line; four training days are too few for the regression.
    assert_eq!(table.forecast.len(), 15);
}

#[test]
fn the_error_is_taken_over_the_steps_after_the_start() {
    let mut cohort = three_people();
    cohort.people.truncate(1);
    let (truth, person) = (truth(), cohort.people[0].clone());
    let twins = same_twin_for_all(&cohort, &truth);
    let found = evaluate(&cohort, &twins, &truth.population, &settings()).expect("judged");
    let cut = PersonWindows::new(0, &person, &protocol()).expect("cut");
    let steps: Vec<usize> = cut.test.iter().map(|window| window.start).collect();
    let (model, start) = (&*truth.population, WindowStart::Carried);
    let starts = window_starts(model, &person, &cut.inputs, &steps, start, cut.mean_basal);
    let (mut squares, mut samples) = (0.0, 0.0);
    for (state, first) in starts.expect("starts").states.into_iter().zip(steps) {
        let inputs = &cut.inputs[first..first + 59];
        let run = simulate(model, state, &mut OpenLoop::new(inputs), 59).expect("finite");
        for (step, glucose) in run.glucose(model).into_iter().enumerate().skip(1) {
            let reading = person.record.cgm()[first + step].expect("a reading");
            squares += (glucose.0.clamp(40.0, 400.0) - reading).powi(2);
            samples += 1.0;
        }
    }
    let expected: f64 = squares / samples;
    let rmse = rmse(&found.people[0], Method::Population);
    assert!((rmse - expected.sqrt()).abs() < 1e-9, "{rmse} {}", expected.sqrt()); // rounding
}

#[test]
fn an_untrained_twin_is_the_population_model() {
    let cohort = three_people();
    let untrained = Twin { residual: ResidualNetwork::untrained(4), ..truth() };
    let twins = same_twin_for_all(&cohort, &untrained);
    for start in [WindowStart::Carried, WindowStart::SteadyState] {
        let settings =
            EvaluationSettings { protocol: Protocol { start, ..protocol() }, ..settings() };
        let found = evaluate(&cohort, &twins, &untrained.population, &settings).expect("judged");
        for person in &found.people {
            let [twin, population] =
                [Method::Twin, Method::Population].map(|method| person.of(method).expect("judged"));
            assert_eq!((twin.outcomes, twin.rmse), (population.outcomes, population.rmse));
            assert_ne!(population.rmse, rmse(person, Method::Ode));
        }
    }
}

#[test]
fn people_without_a_twin_or_with_too_little_are_listed() {
    let mut cohort = three_people();
    let truth = truth();
    let mut twins = same_twin_for_all(&cohort, &truth);
    twins.remove("p0");
    cohort.people[1].record.channel_mut(cohort::Channel::Carbs).fill(Some(0.0));
    let found = evaluate(&cohort, &twins, &truth.population, &settings()).expect("judged");
    let reasons: Vec<(&str, &str)> =
        found.exclusions.iter().map(|e| (e.person_id.as_str(), e.reason.as_str())).collect();
    assert_eq!(
        reasons,
        [("p0", "no twin was given"), ("p1", "no carbohydrate recorded in the training days")]
    );
    let error = outcomes_table("made", &found, &settings()).expect_err("one person is left");
    assert!(error.to_string().contains("people to judge: 1; left out: 2"), "{error}");
}

#[test]
fn the_tables_have_the_keys_of_the_contract() {
    let cohort = three_people();
    let truth = truth();
    let recipe = TwinRecipe {
        population: truth.population.clone(),
        protocol: protocol(),
        plan: TrainingPlan { epochs: 1, ..TrainingPlan::quick() },
        inputs: InputSet::All,
        doses: Doses::Population,
        seed: 1,
    };
    let mut built = build_twins(&cohort, &recipe, &|_| {}).expect("trained");
    let twins = built
        .iter()
        .zip(&cohort.people)
        .filter_map(|(built, person)| {
            let twin = built.result.as_ref().ok()?.twin.clone();
            Some((built.person_id.clone(), PersonModels::new(person, twin)))
        })
        .collect();
    let found = evaluate(&cohort, &twins, &truth.population, &settings()).expect("judged");
    built[2].result = Err(twins::Exclusion::NoCarbs(twins::Part::Test));
    let twins = serde_json::to_value(twins_table(&built, &found)).expect("JSON");
    assert_eq!(twins["schema"], "twins/1");
    assert_eq!(twins["people"][0]["excluded"], serde_json::Value::Null);
    assert_eq!(twins["people"][2]["excluded"], "no carbohydrate recorded in the test days");
    for key in
        ["windows_train", "windows_test", "loss_first", "loss_last", "rmse_population", "rmse_twin"]
    {
        assert!(twins["people"][0][key].is_number(), "{key}");
    }
    let table = outcomes_table("made", &found, &settings()).expect("three people");
    let json = serde_json::to_value(&table).expect("JSON");
    assert_eq!((&json["schema"], &json["cohort"]), (&"outcomes/2".into(), &"made".into()));
    assert_eq!((&json["people"], &json["window_minutes"]), (&3.into(), &300.into()));
    let row = &json["methods"][0]["rows"][0];
    assert_eq!((&row["metric"], &row["unit"]), (&"tir".into(), &"%".into()));
    for path in ["/actual/mean", "/simulated/sd", "/difference/value", "/difference/lower", "/p"] {
        assert!(row.pointer(path).is_some_and(serde_json::Value::is_number), "{path}");
    }
    assert!(row["equivalent"].is_boolean());
    assert!(json["methods"][0]["rmse_5h"]["mean"].is_number());
    assert!(json["forecast"][0]["rmse"]["sd"].is_number());
    let back: OutcomesTable = serde_json::from_value(json).expect("our own");
    assert_eq!(back.methods.len(), 3);
}

/// A network that takes glucose up where insulin acts: physiology upside down.
fn upside_down() -> ResidualNetwork {
    let (mut w0, mut w1) = (vec![0.0; 1280], vec![0.0; 8192]);
    let (mut w2, mut w3) = (vec![0.0; 2048], vec![0.0; 32]);
    w0[2] = 1.0; // X1 into the first unit
    (w1[0], w2[0], w3[0]) = (1.0, 1.0, 0.05);
    let biases = [vec![0.0; 128], vec![0.0; 64], vec![0.0; 32], vec![0.0]];
    ResidualNetwork::from_tensors([&w0, &w1, &w2, &w3], biases.each_ref().map(Vec::as_slice))
        .expect("shapes fit")
}

#[test]
fn a_twin_that_answers_insulin_upside_down_is_flagged() {
    let untrained = Twin { residual: ResidualNetwork::untrained(4), ..truth() };
    let inverted = Twin { residual: upside_down(), ..truth() };
    // The clamp of the synthetic model hides differences at 40 mg/dL; small doses stay above.
    let plan = WhatIfPlan {
        carbs_g: vec![10.0, 20.0],
        ratios_g_per_u: vec![10.0, 20.0, 40.0],
        starts_mg_dl: vec![150.0],
        hours: vec![12],
        steps: 60,
    };
    let found = what_if(&[("right", &untrained), ("wrong", &inverted)], &plan).expect("runs");
    let [right, wrong] = &found.order[..] else { panic!("two people: {:?}", found.order) };
    assert!(right.ordered && right.worst_mg_dl == 0.0, "{right:?}");
    assert!(!wrong.ordered && wrong.worst_mg_dl > 1.0, "{wrong:?}");
    assert!(wrong.worst_at.contains("g/U"));
    assert!(right.peaks_grow_with_meals);
    assert_eq!(found.curves.len(), 6);
    for curve in &found.curves {
        assert_eq!((curve.minutes.len(), curve.minutes[60]), (61, 300.0));
        let quartiles = curve.lower.iter().zip(&curve.median).zip(&curve.upper);
        assert!(quartiles.into_iter().all(|((l, m), u)| l <= m && m <= u));
    }
}

#[test]
fn scenarios_and_other_inputs_have_rows_of_their_own() {
    let cohort = three_people();
    let truth = truth();
    let without = Twin { inputs: InputSet::None, ..truth.clone() };
    let models: BTreeMap<String, PersonModels> = same_twin_for_all(&cohort, &truth)
        .into_iter()
        .map(|(id, models)| {
            let none = Method::Ablated(InputSet::None);
            (id, models.with(none, Model::Twin(without.clone())))
        })
        .collect();
    let found = evaluate(&cohort, &models, &truth.population, &settings()).expect("judged");
    let table = outcomes_table("made", &found, &settings()).expect("three people");
    assert_eq!(table.ablation.len(), 1);
    assert!(table.methods.iter().all(|method| method.name != "none"));
    assert!(table.ablation[0].rmse_5h.mean > 1.0, "{:?}", table.ablation[0].rmse_5h);
    let names: Vec<&str> = table.scenarios.iter().map(|s| s.scenario.as_str()).collect();
    assert_eq!(names, ["physical_activity", "meal", "sleep"]);
    for scenario in &table.scenarios {
        // The made days raise heart rate, feed and sleep every day of all three.
        assert!(scenario.people == 3 && scenario.windows >= 9, "{scenario:?}");
        let methods: Vec<&str> = scenario.methods.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(methods, ["twin", "population", "none"]);
        // The record is the truth's own run.
        assert!(scenario.methods[0].rmse_5h.mean < 0.1);
    }
    assert!(table.comparisons.iter().all(|c| c.p <= c.p_holm));
    for row in table.methods.iter().flat_map(|method| &method.rows) {
        assert!(row.p_unbiased <= row.p + 1e-12, "{row:?}");
    }
}

#[test]
fn courses_that_cannot_be_drawn_name_the_person() {
    let cohort = three_people();
    let truth = truth();
    let models = same_twin_for_all(&cohort, &truth);
    let found = evaluate(&cohort, &models, &truth.population, &settings()).expect("judged");
    let people = cohort.people.iter();
    let twins: BTreeMap<String, Twin> =
        people.map(|person| (person.id.clone(), truth.clone())).collect();
    let test = WindowRule { len: 0, ..protocol().test };
    let protocol = Protocol { test, ..protocol() };
    let population = &truth.population;
    let profile = glucose_profile(&cohort, &twins, population, &found, &protocol);
    let day = example_day(&cohort, &twins, population, &models, &found, &protocol);
    for error in [profile.expect_err("no length"), day.expect_err("no length")] {
        assert!(error.to_string().starts_with("person 'p"), "{error}");
    }
}

#[test]
fn people_must_be_judged_alike() {
    let cohort = three_people();
    let truth = truth();
    let mut models = same_twin_for_all(&cohort, &truth);
    let more =
        models["p1"].clone().with(Method::Ablated(InputSet::None), Model::Twin(truth.clone()));
    models.insert("p1".to_owned(), more);
    let error = evaluate(&cohort, &models, &truth.population, &settings()).expect_err("unlike");
    assert!(error.to_string().contains("has no model 'none'"), "{error}");
}
