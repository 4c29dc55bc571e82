//! What the page says of a blind check.

use report::Part;
use serde_json::{Value, json};

use crate::made_up;
use crate::reading::{check_structure, page, with};

fn check_page(changes: &[(&str, Value)]) -> String {
    let mut parts = made_up::folder("blind-check");
    for (pointer, value) in changes {
        parts = with(parts, Part::BlindCheck, pointer, value.clone());
    }
    let html = page(&parts);
    check_structure(&html);
    html
}

#[test]
fn a_check_alone_is_a_page_of_its_own() {
    let html = check_page(&[]);
    assert!(html.contains("<h1>Blind check of the diagnosis</h1>"));
    assert!(html.contains("This folder holds nothing for: Where the gap lies; "));
    assert!(!html.contains("id=\"which\""));
    for words in [
        "7 of 10 targets are met, 2 missed, 1 not tested.",
        "is named, and no other, in 89\u{a0}% of 168 worlds (95\u{a0}% interval 83 to 93\u{a0}%).",
        "Where nothing acts, something was found in 3 of 150 worlds (95",
        "master seed 20261121",
        "Hashes of the labels: SHA-256 of salt, line feed (0x0a), label",
    ] {
        assert!(html.contains(words), "{words}");
    }
}

#[test]
fn met_and_missed_are_words() {
    let html = check_page(&[]);
    let (_, table) = html.split_once("Targets; bold: missed").expect("a table");
    let (table, _) = table.split_once("</table>").expect("it ends");
    for (word, times) in
        [("\u{2713}\u{a0}met", 7), ("\u{2717}\u{a0}missed", 2), ("not\u{a0}tested", 1)]
    {
        assert_eq!(table.matches(word).count(), times, "{word}");
    }
    assert_eq!(table.matches("<tr class=\"bold\">").count(), 2);
    assert!(table.contains("\u{2265} 0.90") && table.contains("0.886 (0.830 to 0.930)"));
}

#[test]
fn one_is_singular() {
    let mut target = made_up::blind_check()["targets"][1].clone();
    let html = check_page(&[("/targets", json!([target.clone()])), ("/pairs/worlds", json!(1))]);
    assert!(html.contains("1 of 1 target is met."));
    assert!(html.contains("F1 of the names over 1 world with two effects"));
    target["met"] = json!(false);
    assert!(
        check_page(&[("/targets", json!([target]))]).contains("0 of 1 target is met, 1 missed.")
    );
}

#[test]
fn right_answers_are_framed_and_wrong_ones_shaded_otherwise() {
    let confusion = json!({"answers": ["dawn", "none", "unknown"], "rows": [
        {"truth": "dawn", "counts": [3, 1, 0]}, {"truth": "none", "counts": [0, 4, 0]},
        {"truth": "outside:caffeine", "counts": [1, 0, 4, 9]}]});
    let html = check_page(&[("/confusion", confusion)]);
    for row in [
        "Dawn phenomenon (4)</th><td class=\"framed p4\">3</td><td class=\" m2\">1</td><td \
         class=\"\">\u{b7}</td>",
        "None: nothing is missing (4)</th><td class=\"\">\u{b7}</td><td class=\"framed p5\">4</td>",
        // A count without a column has no cell.
        "<td class=\" m1\">1</td><td class=\"\">\u{b7}</td><td class=\"framed p2\">4</td></tr>",
    ] {
        assert!(html.contains(row), "{row}");
    }
}

#[test]
fn power_is_told_by_effect_and_bin() {
    let share = |count: usize, of: usize| {
        json!({"count": count, "of": of, "value": count as f64 / of as f64, "lower": 0.1,
            "upper": 0.9})
    };
    let row = |effect: Value, from: f64, to: Value, named: usize| {
        json!({"effect": effect, "from_mg_dl": from, "to_mg_dl": to, "mean_shift_mg_dl": from + 1.0,
            "named": share(named, 4), "named_or_in_set": share(named + 1, 4),
            "detected": share(4, 4)})
    };
    let rows = json!([
        row(Value::Null, 3.75, json!(7.5), 2),
        row(json!("dawn"), 12.5, Value::Null, 3),
        row(json!("dawn"), 0.0, json!(3.75), 1),
        row(json!("alcohol"), 0.0, json!(3.75), 0)
    ]);
    let html = check_page(&[("/power", rows)]);
    for words in [
        "3.75\u{2013}7.5",
        "<span>&lt;3.75</span></th><th scope=\"col\" class=\"level\"><span>\u{2265}12.5</span>",
        "Dawn phenomenon</th><td class=\" p2\">1/4 +1</td><td class=\" p4\">3/4 +1</td>",
        // No world in that bin: an empty cell.
        "Alcohol</th><td class=\"\">0/4 +1</td><td class=\"\"></td>",
    ] {
        assert!(html.contains(words), "{words}");
    }
}

#[test]
fn the_ceiling_stands_beside_the_answers_with_its_interval() {
    let html = check_page(&[]);
    for words in [
        "a bar of 14.3 nats (6.1 to 22.8):",
        "163 of 196: 83\u{a0}% (",
        "184 of 196: 94\u{a0}% (",
        ">171 to 190</td>",
        ">112 to 119</td>",
        ">29 to 34</td>",
    ] {
        assert!(html.contains(words), "{words}");
    }
    let no_ends = [("/ceiling/at_lower_bar", Value::Null), ("/ceiling/at_upper_bar", Value::Null)];
    let html = check_page(&no_ends);
    assert!(html.contains("a bar of 14.3 nats: at most") && !html.contains(">171 to 190</td>"));
    assert!(!check_page(&[("/ceiling", Value::Null)]).contains("id=\"ceiling\""));
}

#[test]
fn every_world_is_listed_folded() {
    let html = check_page(&[]);
    let (_, worlds) = html.split_once("Truth and answer of 60 worlds").expect("a summary");
    for words in
        ["world_0001", "world_0060", "injection site (9.7)", "dawn (94\u{a0}%)", "one of two"]
    {
        assert!(worlds.contains(words), "{words}");
    }
    let failure =
        [("/worlds/0/failure", json!("ran out of time")), ("/worlds/0/outcome", json!("failed"))];
    assert!(check_page(&failure).contains("no answer: ran out of time"));
}
