//! The page as a whole: structure, escaping, missing parts, figures, determinism.

use contract::ContractError;
use report::{Inputs, Part, ReportError, render};
use serde_json::{Value, json};

use crate::made_up::{self, completed};
use crate::reading::{SECTIONS, check_structure, page, with};

/// Labels of the figures that the made-up run must show.
const FIGURES: [&str; 23] = [
    "Size of the effect: dawn",
    "Size of the effect: exercise",
    "Held-out error before and after by horizon",
    "Change of the held-out error by horizon",
    "Held-out error of every person before and after",
    "Where in the model something is missing",
    "Mean error by time of day",
    "Mean error by situation",
    "Mean error by glucose band",
    "Mean error by person",
    "Glucose of p01 by time of day",
    "Glucose of p02 by time of day",
    "Glucose of p03 by time of day",
    "Every target with what was measured",
    "Share of effects found by the shift that they cause",
    "Stated probability against the share that came true",
    "Difference of every outcome in units of its margin",
    "Glucose percentiles by time of day, measured and twin",
    "Glucose, insulin, carbohydrate, heart rate and sleep over several days",
    "Glucose after meals under several doses",
    "Glucose after meals under several doses, with signs kept",
    "Training and validation loss by epoch",
    "Error of each twin against the population model",
];

#[test]
fn a_full_run_has_every_section_and_figure() {
    let html = page(&made_up::parts());
    check_structure(&html);
    for section in SECTIONS {
        assert!(html.contains(&format!("<section id=\"{section}\">")), "{section}");
    }
    for figure in FIGURES {
        assert!(html.contains(&format!("role=\"img\" aria-label=\"{figure}\"")), "{figure}");
    }
    let figures = FIGURES.len();
    assert_eq!(html.matches("<figure>").count(), figures);
    assert_eq!(html.matches("<figcaption>").count(), figures);
    assert_eq!(html.matches("viewBox=\"0 0 1000 ").count(), figures);
    assert_eq!(html.matches("<table").count(), html.matches("<caption>").count());
    let absent = html.matches("class=\"absent\"").count();
    assert_eq!(
        absent, 1,
        "a part that was given is missing, or the scenario without people is not"
    );
    // Values show under a pointer, and tables can be saved.
    assert!(
        html.contains("<title>60 min: before 14.5, after 13.6, a perfect model 8.7 mg/dL</title>")
    );
    assert!(html.contains("<title>12:15: median ") && html.contains("<title>07:30: 55 g</title>"));
    let long = html.matches("<a download=\"").count();
    assert!(long > 20 && html.matches("data:text/csv").count() == long, "{long}");
}

#[test]
fn the_verdict_comes_first_and_says_what_the_parts_say() {
    let html = page(&made_up::parts());
    let (verdict, _) = html.split_once("<nav").expect("the contents follow the verdict");
    for sentence in [
        "<p class=\"lead\">Glucose is under-predicted by 31 mg/dL from 04 to 08 h; found: dawn phenomenon \
         (probability 97\u{a0}%; cannot be separated from insulin sensitivity that follows the clock) and \
         glucose uptake during exercise (probability 91\u{a0}%); with them the error 5 h ahead on \
         held-out days falls from 30.4 to 27.9 mg/dL, by 8.2\u{a0}%.</p>",
        "Glucose is under-predicted by 31 mg/dL, 5 h ahead (simultaneous interval 20 to 42, adjusted p \
         &lt;0.001)",
        "7 of 10 targets are met, 2 missed, 1 not tested.",
        "Digital twin: 5 of 6 glucose outcomes are equivalent to the measured ones within their margins \
         (TIR, TAR, LBGI, HBGI and MG), over 12 people and 412 windows; equivalence is not shown \
         for TBR.",
        "2 of 4 physiological properties are proved, 1 violated, 1 undecided.",
    ] {
        assert!(verdict.contains(sentence), "{sentence}");
    }
}

#[test]
fn an_over_prediction_reads_as_one() {
    let cell = json!([{"factor": "context", "level": "after_exercise", "mean_error_mg_dl": -19.0,
        "lower": -40.0, "upper": 2.0, "p_adjusted": 0.03, "share_of_gap": 0.1}]);
    let html = page(&with(made_up::parts(), Part::Diagnosis, "/where", cell));
    check_structure(&html);
    let words = "Glucose is over-predicted by 19 mg/dL, 5 h ahead (simultaneous interval \u{2212}2 to 40, \
                 adjusted p 0.030)";
    assert!(html.contains("Glucose is over-predicted by 19 mg/dL after exercise;"));
    assert!(html.contains(words));
}

#[test]
fn what_comes_from_data_is_text() {
    let evil = "<script>alert(\"x\")</script>&'";
    let mut parts = made_up::parts();
    for (part, pointer) in [
        (Part::Manifest, "/command"),
        (Part::Manifest, "/stage"),
        (Part::Manifest, "/config/profile"),
        (Part::Manifest, "/inputs/0/path"),
        (Part::Outcomes, "/cohort"),
        (Part::Outcomes, "/methods/0/label"),
        (Part::Outcomes, "/methods/0/rows/0/metric"),
        (Part::Outcomes, "/methods/0/rows/0/unit"),
        (Part::Outcomes, "/exclusions/0/person_id"),
        (Part::Outcomes, "/ablation/0/label"),
        (Part::Outcomes, "/scenarios/0/label"),
        (Part::Outcomes, "/scenarios/0/methods/1/label"),
        (Part::Outcomes, "/scenarios/0/methods/1/rows/2/metric"),
        (Part::Conformance, "/rows/0/network"),
        (Part::Diagnosis, "/plant"),
        (Part::Diagnosis, "/where/1/level"),
        (Part::Diagnosis, "/data_quality/0/person_id"),
        (Part::Diagnosis, "/people/1/excluded"),
        (Part::Diagnosis, "/effects/0/effect"),
        (Part::Diagnosis, "/effects/0/port"),
        (Part::Diagnosis, "/effects/0/confusable_with/0"),
        (Part::Diagnosis, "/effects/0/people/0/person_id"),
        (Part::Diagnosis, "/candidates/0/effect"),
        (Part::Diagnosis, "/untried/0/effect"),
        (Part::Diagnosis, "/untried/0/reason"),
        (Part::Diagnosis, "/ports/0/port"),
        (Part::Diagnosis, "/ports/1/confusable_with/0"),
        (Part::Diagnosis, "/how_far/outcomes/0/metric"),
        (Part::Diagnosis, "/how_far/notes/0"),
        (Part::BlindCheck, "/targets/0/name"),
        (Part::BlindCheck, "/targets/0/says"),
        (Part::BlindCheck, "/confusion/answers/0"),
        (Part::BlindCheck, "/confusion/rows/0/truth"),
        (Part::BlindCheck, "/power/4/effect"),
        (Part::BlindCheck, "/worlds/0/id"),
        (Part::BlindCheck, "/worlds/0/truth/0/effect"),
        (Part::BlindCheck, "/worlds/0/found/0/effect"),
        (Part::BlindCheck, "/worlds/0/generator"),
        (Part::BlindCheck, "/worlds/0/failure"),
        (Part::BlindCheck, "/worlds/0/nuisances/0"),
        (Part::Seal, "/hash"),
        (Part::Seal, "/worlds/0/sha256"),
        (Part::Training, "/model"),
        (Part::Training, "/data/hash"),
        (Part::Twins, "/people/0/person_id"),
        (Part::ImportReport, "/format"),
        (Part::ImportReport, "/people/0/line"),
        (Part::ImportReport, "/people/3/findings/0/unit"),
        (Part::ImportReport, "/inferences/0/evidence"),
        (Part::ImportReport, "/notes/0/what"),
        (Part::ExampleDay, "/person_id"),
        (Part::ExampleDay, "/date"),
        (Part::ExampleDay, "/chosen"),
        (Part::WhatIf, "/order/2/person_id"),
        (Part::WhatIf, "/order/4/person_id"),
        (Part::WhatIf, "/order/2/worst_at"),
        (Part::Agp, "/person_id"),
    ] {
        parts = with(parts, part, pointer, json!(evil));
    }
    let html = page(&parts);
    check_structure(&html);
    assert!(html.contains("&lt;script&gt;alert(&quot;x&quot;)&lt;/script&gt;&amp;&#39;"));
}

#[test]
fn a_missing_part_is_said_and_never_an_empty_figure() {
    let html = render(&Inputs::default()).expect("nothing to draw");
    check_structure(&html);
    assert!(!html.contains("<figure>"));
    assert_eq!(html.matches("<section").count(), 2, "the verdict and how to reproduce it");
    assert_eq!(html.matches("class=\"absent\"").count(), 3);

    for missing in Part::ALL {
        let parts: Vec<(Part, Value)> =
            made_up::parts().into_iter().filter(|(part, _)| *part != missing).collect();
        let html = page(&parts);
        check_structure(&html);
        assert!(html.contains("class=\"absent\""), "{missing:?}");
    }
}

#[test]
fn parts_without_content_are_said_to_be_empty() {
    let parts = [
        (Part::Outcomes, "/methods", json!([]), "No outcome was tested."),
        (Part::Outcomes, "/forecast", json!([]), "No forecast was evaluated."),
        (Part::Outcomes, "/scenarios/0/methods", json!([]), "Fewer than two people"),
        (Part::WhatIf, "/curves", json!([]), "no course of glucose"),
        (Part::WhatIf, "/order", json!([]), "The order of the answers was not checked."),
        (Part::Diagnosis, "/where", json!([]), "holds no situation"),
        (Part::Diagnosis, "/effects", json!([]), "but the file names none"),
        (Part::Diagnosis, "/candidates", json!([]), "No effect was tried."),
        (Part::Diagnosis, "/how_far", json!({}), "there is no before and after"),
        (Part::BlindCheck, "/targets", json!([]), "No target was set."),
        (Part::BlindCheck, "/worlds", json!([]), "No world was made."),
        (Part::BlindCheck, "/power", json!([]), "No world with a single effect"),
        (Part::BlindCheck, "/reliability/bins", json!([]), "No probability was stated."),
        (Part::BlindCheck, "/confusion/rows", json!([]), "No world with one truth"),
        (Part::Training, "/epochs", json!([]), "holds no epoch"),
        (Part::Twins, "/people", json!([]), "No person has an error"),
        (Part::Agp, "/hour", json!([]), "There is no glucose profile"),
    ];
    for (part, pointer, value, words) in parts {
        let mut all = with(made_up::parts(), part, pointer, value);
        if part == Part::Agp {
            for series in ["p05", "p25", "p50", "p75", "p95"] {
                for whose in ["observed", "twin"] {
                    all = with(all, part, &format!("/{whose}/{series}"), json!([]));
                }
            }
        }
        let html = page(&all);
        check_structure(&html);
        assert!(html.contains(words), "{words}");
    }
}

#[test]
fn numbers_at_the_edge_are_drawn_or_dashed() {
    // One epoch, one person, all-missing sensor, zero errors and enormous intervals.
    let epoch =
        json!([{"epoch": 1, "train_loss": 0.0, "validation_loss": 0.0, "learning_rate": 0.001}]);
    let parts = with(made_up::parts(), Part::Training, "/epochs", epoch);
    let twin = json!([{"person_id": "p", "rmse_population": 0.0, "rmse_twin": 0.0}]);
    let parts = with(parts, Part::Twins, "/people", twin);
    let nothing = json!(vec![Value::Null; 864]);
    let parts = with(parts, Part::ExampleDay, "/cgm", nothing);
    let wide = json!({"value": 1e9, "lower": -1e300, "upper": 1e300});
    let parts = with(parts, Part::Outcomes, "/methods/0/rows/0/difference", wide.clone());
    let parts = with(parts, Part::Outcomes, "/methods/0/rows/0/difference_t", wide);
    let parts = with(parts, Part::Outcomes, "/methods/0/rows/1/margin", json!(0.0));
    check_structure(&page(&parts));
}

#[test]
fn the_page_is_deterministic() {
    assert_eq!(page(&made_up::parts()), page(&made_up::parts()));
}

#[test]
fn a_key_that_is_unknown_or_missing_and_another_schema_are_refused() {
    for (part, value) in made_up::parts() {
        let whole = completed(part, value);
        let refused = |changed: &Value| {
            let error = Inputs::default().read(part, changed.to_string().as_bytes());
            error.expect_err("not as the schema says").to_string()
        };
        let mut later = whole.clone();
        later["a_key_of_a_later_version"] = json!(1);
        let message = refused(&later);
        assert!(message.contains("unknown field `a_key_of_a_later_version`"), "{message}");
        let mut other = whole.clone();
        other["schema"] = json!("of-another-time/1");
        let message = refused(&other);
        let says = match part {
            Part::ImportReport => "unknown field `schema`",
            _ => "its schema is 'of-another-time/1', this version reads '",
        };
        assert!(message.contains(says), "{message}");
        let mut bare = whole;
        bare.as_object_mut().expect("an object").retain(|key, _| key == "schema");
        let message = refused(&bare);
        assert!(message.contains("missing field"), "{message}");
        assert!(message.contains("write the file again with the command that makes it"));
    }
}

#[test]
fn a_seed_that_the_command_does_not_hold_is_told() {
    let words = "Add --seed 1 to the command to get the same again.";
    assert!(!page(&made_up::parts()).contains(words));
    let command = json!("cargo xtask blind-check --out out");
    let html = page(&with(made_up::parts(), Part::Manifest, "/command", command));
    assert!(html.contains(words));
}

#[test]
fn bad_json_is_refused_with_its_place() {
    let mut inputs = Inputs::default();
    let error = inputs.read(Part::Twins, "{\"schema\": \"twins/1\",\n \"people\": 3}".as_bytes());
    let message = error.expect_err("people is not a list").to_string();
    assert!(message.starts_with("twins.json, line 2, column "), "{message}");

    let (part, day) = made_up::parts().swap_remove(7);
    let mut day = completed(part, day);
    day["twin"] = json!([100.0, 101.0]);
    let error = inputs.read(Part::ExampleDay, day.to_string().as_bytes());
    assert!(
        matches!(
            error,
            Err(ReportError::Contract(ContractError::UnevenSeries {
                series: "twin",
                found: 2,
                expected: 864,
                ..
            }))
        ),
        "{error:?}"
    );
    assert!(inputs.example_day.is_none(), "a part that is refused is not shown");
}

#[test]
fn a_large_cohort_shows_the_people_with_the_largest_errors() {
    let cells: Vec<Value> = (0..400)
        .map(|k| {
            let mean = f64::from(k) / 10.0 - 10.0;
            json!({"factor": "person", "level": format!("p{k}"), "mean_error_mg_dl": mean,
                "lower": mean - 5.0, "upper": mean + 5.0, "p_adjusted": 0.2, "share_of_gap": 0.0})
        })
        .collect();
    let html = page(&with(made_up::parts(), Part::Diagnosis, "/where", json!(cells)));
    check_structure(&html);
    assert!(html.contains("Shown are the 40 of 400 with the largest error."));
    // In the figure (text of the drawing has its own line) only the extreme ones.
    assert!(html.contains(">\np399\n</text>") && !html.contains(">\np100\n</text>"));
}

#[test]
fn an_importers_account_is_shown_in_words() {
    let account = json!({
        "format": "hupa-ucm",
        "people": [{
            "line": "P1: 11 days, 25.4 + 21.1 U/day",
            "therapy": "open_loop_pump",
            "balance": {"person": "P1", "days": 11.2, "basal_u_day": 25.4, "bolus_u_day": 21.1,
                "carbs_g_day": null, "mean_glucose_mg_dl": null, "cgm_share": 0.9,
                "heart_rate_share": 0.0},
            "totals": [{"column": "bolus_u", "unit": "U", "source": 240.5, "record": 240.0, "left_out": 0.5}],
            "findings": [{"person": "P1", "column": "carbs_g", "date": null, "step": 96,
                "time": "2020-01-01 08:00:00", "what": "meal", "value": 900.0, "unit": "g", "plausible": [0.0, 250.0]}],
        }],
        "inferences": [{"person": "P1", "file": "a.csv", "column": "carb_input",
            "conclusion": "servings of 10 g", "evidence": "16 g/U"}],
        "notes": [{"person": "P1", "file": "a.csv", "row": 7, "what": "filled gap", "count": 3}],
    });
    let html = page(&[(Part::ImportReport, account)]);
    check_structure(&html);
    for words in [
        "P1: 11 days, 25.4 + 21.1 U/day",
        "a.csv, column carb_input",
        "a.csv, row 7",
        "900 g",
        "240.5",
        "servings of 10 g",
        "open-loop pump",
    ] {
        assert!(html.contains(words), "{words}");
    }
    assert!(!html.contains("{&quot;"), "no JSON is left in the page");
    assert!(!html.contains("open_loop_pump"));
}

#[test]
fn the_same_finding_in_several_people_is_one_row() {
    let finding = |person: &str, estimate: Value| {
        json!({"check": "missing_channel", "person_id": person, "finding": "no sleep on record",
            "estimate": estimate})
    };
    let exact = json!({"value": 62.0, "lower": 62.0, "upper": 62.0, "unit": "% of values"});
    let list =
        json!([finding("Q1", Value::Null), finding("Q2", Value::Null), finding("Q3", exact)]);
    let html = page(&with(made_up::parts(), Part::Diagnosis, "/data_quality", list));
    check_structure(&html);
    assert!(html.contains("Q1, Q2"));
    assert_eq!(html.matches("no sleep on record").count(), 2);
    assert!(html.contains("62.0 % of values<"), "an interval without width is a number");
}
