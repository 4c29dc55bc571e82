//! What the page says of people: the checks of their data, their glucose, and the truth about them.

use report::Part;
use serde_json::{Value, json};

use crate::made_up;
use crate::reading::{check_structure, page, read, section, with};

fn small(parts: Vec<(Part, Value)>) -> String {
    let html = page(&parts);
    check_structure(&html);
    html
}

#[test]
fn checks_stand_in_one_table_by_person() {
    let html = small(vec![(Part::DataInUse, made_up::data_in_use())]);
    let checks = section(&html, "data-quality");
    for row in [
        "<td class=\"short\">p01</td><td class=\"short\">in use</td><td class=\"number\">28 of 28</td>\
         <td class=\"number\">4</td>",
        "<td class=\"short\">p05</td><td class=\"short\">in use</td><td class=\"number\">27 of 28</td>\
         <td class=\"number\">3</td><td>the clock of insulin</td>",
        "<tr class=\"bold\"><td class=\"short\">p11</td><td class=\"short\">left out</td><td \
         class=\"number\">0 of 28</td><td class=\"number\">3</td>",
        "insulin runs ahead of glucose",
    ] {
        assert!(checks.contains(row), "{row}: {checks}");
    }
    assert!(section(&html, "exclusions").contains("the sensor stands still"));
}

#[test]
fn of_many_people_those_who_pass_share_a_row() {
    let mut data = made_up::data_in_use();
    let people = data["people"].as_array_mut().expect("people");
    let whole = people[0].clone();
    for k in 0..488 {
        let mut person = whole.clone();
        person["person_id"] = json!(format!("q{k}"));
        people.push(person);
    }
    let html = small(vec![
        (Part::DataInUse, data),
        (Part::GlucoseByPerson, made_up::glucose_by_person(500)),
    ]);
    let checks = section(&html, "data-quality");
    assert!(checks.contains("All others (498 people)"), "{checks}");
    assert!(checks.contains(">p05<") && checks.contains(">p11<") && !checks.contains(">q7<"));
    let people = section(&html, "people");
    assert!(!people.contains("<details>") && people.contains("40 people at most"));
    assert_eq!(people.matches("class=\"ranges\"").count(), 500);
    assert!(html.len() < 20_000_000, "{} bytes", html.len());
}

#[test]
fn more_days_left_out_than_there_are_leave_none() {
    let mut data = made_up::data_in_use();
    data["people"][4]["days"] = json!(0);
    data["people"][4]["channels_left_out"] =
        json!([{"channel": "basal_u_h", "share": 1.0, "reason": "basal_unit"}]);
    let html = small(vec![(Part::DataInUse, data)]);
    let checks = section(&html, "data-quality");
    for words in [
        "<th scope=\"col\">Status</th>",
        "<td class=\"number\">0 of 0</td>",
        "100\u{a0}% of basal insulin (the unit of basal insulin)",
    ] {
        assert!(checks.contains(words), "{words}: {checks}");
    }
}

#[test]
fn a_person_has_a_fold_with_profile_and_ranges() {
    let html = small(made_up::parts());
    let people = section(&html, "people");
    assert_eq!(people.matches("<details>").count(), 3);
    for words in [
        "<summary>p02: TIR 70\u{a0}%, mean 151 mg/dL</summary>",
        "aria-label=\"Glucose of p02 by time of day\"",
        "54 to 70 mg/dL: 3.0\u{a0}%",
        "28 of 28 days in use.",
        "Dawn phenomenon: ",
        // A saved table has the ranges apart.
        "below%2054%20mg%2FdL:%201.0%20%25%3B%2054%20to%2070%20mg%2FdL:%203.0%20%25%3B",
    ] {
        assert!(people.contains(words), "{words}: {people:.3000}");
    }
}

#[test]
fn truth_stands_beside_the_answer() {
    let html = small(made_up::parts());
    let truth = section(&html, "truth");
    for words in [
        "3 effects act in this cohort; 1 found: dawn phenomenon; 2 not named. Named although not acting: \
         glucose uptake during exercise.",
        "<td class=\"number\">1.20 (0.84 to 1.68)</td><td class=\"short\">found</td><td \
         class=\"number\">1.10 (0.70 to 1.50)</td>",
        "<td class=\"short\">not tried</td>",
        "<td class=\"short\">not named</td>",
        "<td class=\"number\">does not act</td><td class=\"short\">found</td>",
        "The diagnosis does not read it",
    ] {
        assert!(truth.contains(words), "{words}: {truth}");
    }
    let inputs = read(&made_up::parts());
    let diagnosis = inputs.diagnosis.expect("a diagnosis");
    let text = report::answer(&diagnosis, inputs.truth.as_ref());
    let lines: Vec<&str> = text.lines().collect();
    assert!(
        lines[0].starts_with("Glucose is under-predicted by 31 mg/dL from 04 to 08 h; found: dawn")
    );
    assert!(
        lines.iter().any(|line| line.starts_with("dawn phenomenon  ") && line.ends_with("97 %"))
    );
    assert_eq!(lines.len(), 1 + 1 + 1 + 1 + 4, "{text}");
    let alone = report::answer(&diagnosis, None);
    assert_eq!(alone.lines().count(), 1);
}

#[test]
fn folders_of_the_machine_do_not_leak() {
    let command =
        "cargo xtask diagnose --cohort /home/ann/secret/study/cohort --out=/home/ann/out/d";
    let parts = with(made_up::parts(), Part::Manifest, "/command", json!(command));
    let parts = with(parts, Part::Manifest, "/inputs/0/path", json!("/home/ann/secret/people.csv"));
    let parts = with(parts, Part::Manifest, "/config/profile", json!("/home/ann/secret/x/y"));
    let html = small(parts);
    let provenance = section(&html, "provenance");
    assert!(
        !html.contains("/home/ann") && provenance.contains("\u{2026}/study/cohort"),
        "{provenance}"
    );
    // Configuration and hashes are folded away.
    let (before, folded) = provenance.split_once("<details>").expect("a fold");
    assert!(
        !before.contains("SHA-256")
            && folded.contains("SHA-256")
            && folded.contains("window minutes")
    );
}

/// Short words that the page uses.
const SHORT: [&str; 13] =
    ["TIR", "TAR", "TBR", "LBGI", "HBGI", "MG", "AGP", "TOST", "nats", "CGM", "RMSE", "ODE", "F1"];

#[test]
fn short_words_are_explained_and_steps_follow() {
    let html = small(made_up::parts());
    for word in SHORT {
        assert!(section(&html, "glossary").contains(&format!("<dt>{word}</dt>")), "{word}");
    }
    let next = section(&html, "next");
    for words in [
        "2 people have a warning",
        "Test what was found",
        "could not be tried",
        "The section \u{201c}What was weighed\u{201d} says what is missing for each.",
    ] {
        assert!(next.contains(words), "{words}: {next}");
    }
}

#[test]
fn an_evaluation_of_too_few_people_says_who_was_left_out() {
    let reason = "8 complete test windows, 10 needed";
    let html = small(vec![(Part::Exclusions, json!([{ "person_id": "p7", "reason": reason }]))]);
    assert!(section(&html, "exclusions").contains(reason));
    assert!(!html.contains("Nobody was left out of any step"));
}

#[test]
fn who_was_left_out_by_the_diagnosis_alone_is_not_in_use() {
    let reason = json!("no run of a day");
    let parts = with(made_up::parts(), Part::Diagnosis, "/people/0/excluded", reason);
    let html = page(&parts);
    for words in ["10 of 12 people in use, 279 of their 280 days. ", "p01 (no run of a day)"] {
        assert!(html.contains(words), "{words}");
    }
}
