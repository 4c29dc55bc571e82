//! The paper's results on the page: outcomes by method and scenario, days, what-ifs.

use contract::ContractError;
use report::{Inputs, Part, ReportError};
use serde_json::{Value, json};

use crate::made_up;
use crate::reading::{check_structure, page, section, with};

#[test]
fn outcomes_stand_down_and_methods_across() {
    let html = page(&made_up::parts());
    let outcomes = section(&html, "outcomes");
    // All windows, the ablation, and the two scenarios with enough people.
    assert_eq!(outcomes.matches("class=\"crossed\"").count(), 4);
    assert_eq!(outcomes.matches("<details>").count(), 4);
    for words in [
        "<th scope=\"col\" class=\"number\">Records</th><th scope=\"col\" class=\"number\">Digital \
         twin</th>",
        "<td class=\"number marked\">69.4 \u{b1} 17.8 <span class=\"beneath\">p &lt;0.001 \u{2713}</span></td>",
        // Outside its margin although enough people could have shown it inside, and the opposite.
        "<td class=\"number\">2.90 \u{b1} 3.85 <span class=\"beneath\">p = 0.370</span></td>",
        "<td class=\"number\">2.35 \u{b1} 3.85 <span class=\"beneath\">p = 0.370 \u{2020}</span></td>",
        // Nine columns would not fit a page: there methods stand down and outcomes across.
        "<th scope=\"col\">Method</th><th scope=\"col\" class=\"number\">TIR \u{b1}5 %</th>",
        "<th scope=\"row\">Training days</th><td class=\"number marked\">",
        "changes too much from week to week",
        "<th scope=\"row\">RMSE <span class=\"beneath\">mg/dL</span></th><td class=\"number\"></td>\
         <td class=\"number\">43.0 \u{b1} 7.0</td>",
        "\u{2020}: so few people, scattered so much, could not have shown equivalence even of a \
         method without any bias",
        "Windows that begin with: Physical activity",
        "12 people and 44 windows.",
        "Fewer than two people have such windows",
        "Digital twin minus other methods within people, RMSE over 5 h (mg/dL)",
        ">No inputs</td>",
        "Last reading held",
    ] {
        assert!(outcomes.contains(words), "{words}");
    }
}

#[test]
fn what_differs_between_methods_is_said() {
    // A method that lacks people has other actual outcomes; one that lacks an outcome has a dash.
    let parts = with(
        made_up::parts(),
        Part::Outcomes,
        "/methods/1/rows/0/actual",
        json!({"mean": 66.6, "sd": 10.0}),
    );
    let parts = with(parts, Part::Outcomes, "/methods/2/rows", json!([]));
    let parts = with(parts, Part::Outcomes, "/comparisons/0/quantity", json!("TIR"));
    let html = page(&parts);
    check_structure(&html);
    let outcomes = section(&html, "outcomes");
    for words in [
        "<span class=\"beneath\">records 66.6 \u{b1} 10.0</span>",
        "<td class=\"number\">\u{2013}</td>",
        "Digital twin minus other methods within people, TIR (mg/dL)",
        "Digital twin minus other methods within people, RMSE over 5 h (mg/dL)",
    ] {
        assert!(outcomes.contains(words), "{words}");
    }
}

#[test]
fn too_few_people_are_told_in_the_verdict() {
    let words = "For TBR the differences of this method vary too much over so few people to show it, even if it had no bias.";
    assert!(!page(&made_up::parts()).contains(words));
    let few = with(made_up::parts(), Part::Outcomes, "/methods/0/rows/2/p_unbiased", json!(0.2));
    assert!(page(&few).contains(words));

    // TBR leaves its margin although enough people could have shown it inside; training days do not
    // show it either.
    let words = "For TBR the sensor on the training days does not show it either.";
    let open = with(made_up::parts(), Part::Outcomes, "/methods/0/rows/2/equivalent", json!(false));
    assert!(!page(&open).contains(words));
    let floor = with(open, Part::Outcomes, "/training_days/2/equivalent", json!(false));
    assert!(page(&floor).contains(words));
}

#[test]
fn several_days_have_their_times_in_ranges() {
    let html = page(&made_up::parts());
    let days = section(&html, "example-day");
    for words in [
        "TBR, TIR and TAR: sensor 1.9\u{a0}%, 83.1\u{a0}% and 15.0\u{a0}%; digital twin \
         4.7\u{a0}%, 88.4\u{a0}% and 6.8\u{a0}%; closest virtual patient 16.6\u{a0}%",
        "ODE, closest virtual patient</li>",
        "Upright lines stand at midnight.",
        "Chosen: person with the median twin error",
    ] {
        assert!(days.contains(words), "{words}");
    }
    // Half days are labelled, and the end of a day is the start of the next.
    assert_eq!(days.matches(">\n12:00\n</text>").count(), 3);
    assert!(!days.contains(">\n24:00\n</text>"));
}

#[test]
fn twins_out_of_order_are_named_where_doses_are_compared() {
    let html = page(&made_up::parts());
    let answers = section(&html, "what-if");
    for words in [
        "at 120 mg/dL and 12:00",
        "median (thick) and middle half (shaded) of 12 twins",
        "in 10 of 12 twins, checked from 120, 90 and 180 mg/dL at 12:00, 7:00 and 19:00. The others \
         are not to be used for what-ifs:",
        "<td class=\"short\">p09</td><td class=\"number\">6.4</td><td class=\"wide\">30 g at 180 \
         mg/dL and 7 h, 20 against 10 g/U</td>",
        "in 11 of 12 twins; not in p05",
        "Order of the answers of twins that keep physiology&#39;s signs",
        "in 12 of 12 twins, checked",
    ] {
        assert!(answers.contains(words), "{words}");
    }
    assert_eq!(answers.matches("<table").count(), 1, "nothing is out of order with signs kept");
    for panel in ["30 g", "60 g", "90 g"] {
        assert!(answers.contains(&format!(">\n{panel}\n</text>")), "{panel}");
    }
    let verdict = section(&html, "verdict");
    let words = "More insulin does not always mean less glucose in 2 of 12 twins, which must not be used \
                 for what-ifs: p03 and p09. More insulin always lowers mean glucose, and never raises \
                 glucose by more than 0.5 mg/dL, in 12 of 12 twins that keep physiology&#39;s signs.";
    assert!(verdict.contains(words), "{verdict}");
}

#[test]
fn a_twin_may_be_out_of_order_in_its_mean_alone() {
    let parts = with(made_up::parts(), Part::WhatIf, "/order/2/worst_mg_dl", json!(0.3));
    let html = page(&parts);
    let row = "<td class=\"short\">p03</td><td class=\"number\">0.3</td><td class=\"wide\">mean glucose does \
               not grow with the ratio</td>";
    assert!(section(&html, "what-if").contains(row));
}

#[test]
fn rows_of_twins_have_a_person_and_the_steps_of_the_record() {
    let row = json!({"person_id": "p03", "network": "residual", "input": "X1",
        "property": "decreasing", "kind": "physical", "m_lower": 0.1, "m_upper": 0.2,
        "verdict": "violated", "seconds": 1.0, "share_of_steps": 0.25});
    let html = page(&with(made_up::parts(), Part::Conformance, "/rows", json!([row])));
    check_structure(&html);
    let table = section(&html, "conformance");
    for words in [
        "<th scope=\"col\">Person</th><th scope=\"col\">Network</th>",
        "<td class=\"short\">p03</td><td class=\"short\">residual</td>",
        "<td class=\"number\">25.0</td>",
    ] {
        assert!(table.contains(words), "{words}: {table}");
    }
    assert!(
        section(&html, "verdict").contains("0 of 1 physiological property is proved, 1 violated.")
    );
    let plain = page(&made_up::parts());
    assert!(!section(&plain, "conformance").contains("<th scope=\"col\">Person</th>"));
}

#[test]
fn either_file_of_what_ifs_may_be_alone() {
    let all = made_up::parts();
    for (part, figures) in [(Part::WhatIf, 1), (Part::WhatIfConstrained, 1)] {
        let alone: Vec<(Part, Value)> = all.iter().filter(|(p, _)| *p == part).cloned().collect();
        let html = page(&alone);
        check_structure(&html);
        assert_eq!(section(&html, "what-if").matches("<figure>").count(), figures, "{part:?}");
    }
}

#[test]
fn quartiles_have_to_fit_their_minutes() {
    let (_, mut answers) = made_up::parts()
        .into_iter()
        .find(|(part, _)| *part == Part::WhatIfConstrained)
        .expect("part of the run");
    answers["curves"][4]["upper"] = json!([120.0]);
    let mut inputs = Inputs::default();
    let error = inputs.read(Part::WhatIfConstrained, answers.to_string().as_bytes());
    assert!(
        matches!(
            error,
            Err(ReportError::Contract(ContractError::UnevenSeries {
                series: "upper",
                found: 1,
                expected: 61,
                ..
            }))
        ),
        "{error:?}"
    );
}
