//! Maps of the gap through the day.

use report::Part;
use serde_json::{Value, json};

use crate::made_up;
use crate::reading::{check_structure, page, section, with};

fn page_of(hourly: Value) -> String {
    let parts = vec![(Part::Diagnosis, made_up::diagnosis("effect"))];
    let html = page(&with(parts, Part::Diagnosis, "/hourly", hourly));
    check_structure(&html);
    html
}

fn hourly() -> Value {
    made_up::diagnosis("effect")["hourly"].clone()
}

#[test]
fn cells_print_their_sign_and_show_their_interval_under_a_pointer() {
    let html = page_of(hourly());
    let place = section(&html, "where");
    for part in [
        // Shade, frame, sign: what colour says, the cell says too.
        "<td class=\"framed p5\" title=\"All runs, 3\u{2013}6 h: +26.5 mg/dL (interval +20.5 to +32.5), \
         1008 runs of 12 people\">+26</td>",
        "<td class=\" m1\" title=\"All runs, 0\u{2013}3 h: \u{2212}2.0 mg/dL (interval \u{2212}8.0 to +4.0), \
         1008 runs of 12 people\">\u{2212}2</td>",
        "title=\"After meal, 0\u{2013}3 h: too few runs\">\u{2013}</td>",
        "title=\"p01, 3\u{2013}6 h: ",
        "<span class=\"m5\">\u{2212}30</span>",
        "<span class=\"p5\">+30</span>",
        "The largest error that stands out is from 3 to 6 h in the row \u{201c}Sleep\u{201d}: glucose is \
         under-predicted by 32 mg/dL.",
        "From 3 to 6 h glucose is under-predicted in 12 of 12 people; in no other part of the day are there more.",
        "5 h ahead, mg/dL, by hour of the day and situation",
        "one row a person",
        ">6\u{2013}\u{200b}9<",
        "the ODE model with parameters fitted to each person",
    ] {
        assert!(place.contains(part), "{part}");
    }
    // A saved table holds numbers that programs read.
    assert!(place.contains("Situation,0%E2%80%933,3%E2%80%936,"));
    assert!(place.contains("All%20runs,-2,%2B26,"));
}

#[test]
fn of_many_people_most_strips_are_folded_and_small() {
    let mut many = hourly();
    let people = many["people"].as_array_mut().expect("people");
    let twelve = people.clone();
    for k in 13..=500 {
        let mut row = twelve[k % 12].clone();
        row["name"] = json!(format!("q{k}"));
        people.push(row);
    }
    let few = page_of(hourly()).len();
    let html = page_of(many);
    let place = section(&html, "where");
    assert!(place.contains("the 30 of 500 people whom the model misses most"));
    assert!(place.contains("<summary>The other 470 people</summary>"));
    let (shown, folded) = place.split_once("<details>").expect("a fold");
    let strips = |html: &str| html.matches(", 3\u{2013}6 h: ").count();
    // Four situations stand above the strips.
    assert_eq!((strips(shown), strips(folded)), (4 + 30, 470));
    // 500 strips in the report's 20 MB.
    assert!(html.len() - few < 1_000_000, "{} bytes more", html.len() - few);
}

#[test]
fn a_map_without_a_certain_cell_says_so_and_an_older_file_has_none() {
    let mut open = hourly();
    for rows in ["situations", "people"] {
        for row in open[rows].as_array_mut().expect("rows") {
            for cell in
                row["cells"].as_array_mut().expect("cells").iter_mut().filter(|c| !c.is_null())
            {
                cell["lower"] = json!(-99.0);
                cell["upper"] = json!(99.0);
            }
        }
    }
    let html = page_of(open);
    let place = section(&html, "where");
    assert!(place.contains("No cell stands out: every interval holds 0."));
    assert!(place.contains("In nobody does a part of the day stand out by itself."));
    assert!(!place.contains("framed"));
    let html = page_of(Value::Null);
    assert!(!html.contains("Hour of the day by situation"));
    assert!(section(&html, "where").contains("Mean error by time of day"));
}
