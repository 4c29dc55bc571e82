//! What the page says of a diagnosis: the verdict, the cards, the tables, and odd inputs.

use report::Part;
use serde_json::{Value, json};

use crate::made_up;
use crate::reading::{check_structure, page, section, with};

fn diagnosis_page(verdict: &str, changes: &[(&str, Value)]) -> String {
    let mut parts = vec![(Part::Diagnosis, made_up::diagnosis(verdict))];
    for (pointer, value) in changes {
        parts = with(parts, Part::Diagnosis, pointer, value.clone());
    }
    let html = page(&parts);
    check_structure(&html);
    html
}

/// The answer: the first paragraphs of the page.
fn verdict_of(html: &str) -> &str {
    let (verdict, _) = html.split_once("<nav").expect("the contents follow the verdict");
    verdict
}

#[test]
fn every_verdict_has_its_words() {
    let places = |like: Value| json!([{"port": "egp", "gain_nats": 12.0, "probability": 0.8, "confusable_with": like}]);
    let said = |something: f64, from: f64| {
        json!({"something": something, "sets": [], "speaks_from": 0.75,
        "names_from": from, "source": "made up"})
    };
    /// Verdict, what is changed, and the expected sentence.
    type Case<'a> = (&'a str, &'a [(&'a str, Value)], &'a str);
    let cases: &[Case<'_>] = &[
        (
            "unknown",
            &[("/ports", places(json!([])))],
            "something is missing (probability 97\u{a0}%) and no effect can be named",
        ),
        (
            "unknown",
            &[("/ports", places(json!([])))],
            "Most probably it concerns the liver&#39;s glucose production</dd>",
        ),
        (
            "unknown",
            &[("/ports", places(json!(["sensor"])))],
            "the liver&#39;s glucose production or the sensor (the data cannot separate them)</dd>",
        ),
        (
            "unknown",
            &[("/ports", json!([]))],
            "<dd>No effect of the library explains it well enough</dd>",
        ),
        (
            "unknown",
            &[("/posterior", said(0.93, 0.5))],
            "something is missing (probability 93\u{a0}%) and no effect can be named (most \
             probable: something that the library does not hold, 93\u{a0}%; an effect is named from 50\u{a0}% on).",
        ),
        ("none", &[("/posterior", said(0.12, 0.5))], "<dd class=\"answer\">88\u{a0}%</dd>"),
        ("none", &[], "No effect is found (probability that something is missing: 7\u{a0}%)"),
        ("none", &[], "<dd>None of those that were tried stands out</dd>"),
    ];
    for (verdict, changes, words) in cases {
        let html = diagnosis_page(verdict, changes);
        assert!(verdict_of(&html).contains(words), "{words}: {}", verdict_of(&html));
    }
    let html = diagnosis_page("none", &[("/ports", json!([]))]);
    assert!(html.contains("No place in the model was assessed."));
    assert!(section(&html, "which").contains("<p>No effect is named.</p>"));
    let rule = "and nothing questions it";
    assert!(section(&diagnosis_page("effect", &[]), "which").contains(rule));
}

#[test]
fn one_effect_is_one() {
    let one = made_up::diagnosis("effect")["effects"][1].clone();
    let html = diagnosis_page("effect", &[("/effects", json!([one]))]);
    let words = "; found: glucose uptake during exercise (probability 91\u{a0}%); with it the error 5 h \
                 ahead on held-out days falls from 30.4 to 27.9 mg/dL, by 8.2\u{a0}%.";
    assert!(verdict_of(&html).contains(words), "{}", verdict_of(&html));
    assert_eq!(html.matches("<article").count(), 1);
}

#[test]
fn what_is_not_found_is_called_suspected_everywhere() {
    let change = |pointer: &str, value: Value| {
        let mut one = made_up::diagnosis("effect")["effects"][1].clone();
        *one.pointer_mut(pointer).expect("a key") = value;
        diagnosis_page("effect", &[("/effects", json!([one]))])
    };
    let person =
        json!({"person_id": "q", "amplitude": 1.0, "lower": 0.5, "upper": 1.5, "gain_nats": 2.0});
    let against =
        json!({"person_id": "r", "amplitude": 1.0, "lower": 0.5, "upper": 1.5, "gain_nats": -2.0});
    for (pointer, value, why) in [
        ("/probability", json!(0.41), "not more probable than not"),
        ("/amplitude/lower", json!(-0.1), "its size may be 0"),
        ("/people", json!([person, against]), "the data of one person alone favour it"),
        ("/people", json!([against]), "nobody&#39;s own data favour it"),
    ] {
        let html = change(pointer, value);
        let verdict = verdict_of(&html);
        let words = "; no effect is found; suspected: glucose uptake during exercise (";
        assert!(verdict.contains(words), "{verdict}");
        assert!(verdict.contains(&format!("{why}); with it")), "{why}: {verdict}");
        assert!(verdict.contains("(suspected)</dd>"), "{verdict}");
        assert!(html.contains(&format!("suspected, not found: {why}")), "{why}");
        assert!(html.contains(">\nsuspected; 31\u{a0}%\n</text>"), "the sketch says the same");
    }
    // One person's own answer is found by the same rule.
    let html = change("/people", json!([person]));
    assert!(
        verdict_of(&html).contains("; found: glucose uptake")
            && verdict_of(&html).contains("in this one person")
    );
}

#[test]
fn a_probability_says_what_it_is_conditional_on() {
    let html = diagnosis_page("effect", &[]);
    let words = "Probability that it acts, with others or alone";
    assert!(section(&html, "which").contains(&format!("<dt>{words}</dt>")));
    assert!(section(&html, "tried").contains(&format!(">{words}</th>")));
}

#[test]
fn the_first_screen_has_four_tiles_and_who_is_in_use() {
    let html = diagnosis_page("effect", &[]);
    let tiles = verdict_of(&html);
    for question in ["Where", "Which", "How far", "How sure"] {
        assert!(tiles.contains(&format!("<dt>{question}</dt>")), "{question}");
    }
    for words in [
        "<dd class=\"answer\">From 04 to 08 h</dd>",
        "<dd class=\"answer\">30.4 \u{2192} 27.9 mg/dL</dd>",
        "<dd class=\"answer\">91\u{a0}%</dd><dd>Probability that it acts, with others or alone; the least of them",
        "the data of 11 of 11 people favour it",
        "1 of 2 people in use, 28 days. Left out: p11 (fewer than 7 days of record).",
    ] {
        assert!(tiles.contains(words), "{words}: {tiles}");
    }
    let found = "meal_clock_offset: meals recorded 40 min too early; moving them would mend it";
    let html = diagnosis_page("effect", &[("/people/1/excluded", json!(found))]);
    let words = "Left out: p11 (the clock of meals: meals recorded 40 min too early; moving";
    assert!(verdict_of(&html).contains(words), "no key of a check");
    let mut three = made_up::diagnosis("effect")["effects"].as_array().expect("a list").clone();
    let mut third = three[1].clone();
    third["effect"] = json!("sleep_loss");
    three.push(third);
    let html = diagnosis_page("effect", &[("/effects", json!(three))]);
    let tiles = verdict_of(&html);
    assert!(tiles.contains("<dd class=\"answer\">Three effects</dd><dd>"), "{tiles}");
    assert_eq!(tiles.matches("times the published size").count(), 3, "{tiles}");
    for (doubtful, words) in [(1, "one"), (3, "three")] {
        for effect in three.iter_mut().take(doubtful) {
            effect["probability"] = json!(0.41);
        }
        let html = diagnosis_page("effect", &[("/effects", json!(three))]);
        let words = format!("<dd class=\"answer\">Three effects ({words} suspected)</dd>");
        assert!(verdict_of(&html).contains(&words), "{words}: {}", verdict_of(&html));
    }
    let known = json!([{"minutes": 300, "mae_before": 43.5, "mae_after": 39.8, "reconstructed": true,
        "floor": null, "share_above_floor": null,
        "difference": {"value": -3.7, "lower": -5.5, "upper": -1.9}}]);
    let html = diagnosis_page("effect", &[("/how_far/horizons", known)]);
    assert!(verdict_of(&html).contains("<dd class=\"answer\">No better forecast</dd>"));
    assert!(
        verdict_of(&html).contains(
            "if they were known, the error 5 h ahead would be 39.8 in place of 43.5 mg/dL."
        )
    );
}

#[test]
fn a_floor_above_the_measured_error_is_not_shown() {
    let change = |floor: f64| {
        let share = json!({"value": 0.2, "lower": 0.1, "upper": 0.3});
        let horizons = json!([{"minutes": 60, "mae_before": 18.7, "mae_after": 18.5, "floor": floor,
            "difference": {"value": -0.2, "lower": -0.3, "upper": -0.1}, "share_above_floor": share}]);
        diagnosis_page("effect", &[("/how_far/horizons", horizons)])
    };
    let (right, wrong) = (change(15.2), change(20.2));
    assert!(section(&right, "how-far").contains(">15.2</td>"));
    assert!(!section(&wrong, "how-far").contains("20.2"));
    assert!(section(&wrong, "how-far").contains("the bound is wrong and is not shown"));
    // Much evidence for a small change: the sentence says both.
    assert!(verdict_of(&wrong).contains("falls from 18.7 to 18.5 mg/dL, by 1.1\u{a0}%"));
}

#[test]
fn a_name_that_is_doubted_is_doubted_in_the_verdict() {
    let doubt = json!(["It rests on one person: without 02 its probability is 12 %."]);
    let mut effects = made_up::diagnosis("effect")["effects"].clone();
    effects[0]["questioned"] = doubt;
    let html = diagnosis_page("effect", &[("/effects", effects)]);
    let words = "<li>Dawn phenomenon is doubtful. It rests on one person: without 02 its probability is 12 %.</li>";
    assert!(verdict_of(&html).contains(words), "{}", verdict_of(&html));
    assert!(verdict_of(&html).contains("One doubt stands below"));
    let sentence = "suspected: dawn phenomenon (probability";
    assert!(verdict_of(&html).contains(sentence), "{}", verdict_of(&html));
    assert!(
        verdict_of(&html).contains("; it rests on one person: without 02 its probability is 12 %")
    );
    assert!(!verdict_of(&diagnosis_page("effect", &[])).contains("doubt"));
}

#[test]
fn the_course_at_a_place_is_drawn_where_the_verdict_is_about_it() {
    let part = |hours: &str, value: f64, half: f64| json!({"hours": hours, "value": value, "lower": value - half, "upper": value + half});
    let course = json!([part("00-12", 0.1, 0.05), part("12-24", -0.1, 0.2)]);
    let port = json!([{"port": "egp", "probability": 0.8, "unit": "factor", "course": course}]);
    let html = diagnosis_page("unknown", &[("/ports", port.clone())]);
    assert!(html.contains("The interval leaves 0 out at 00\u{2013}12 h."), "no course");
    assert!(html.contains("Change of a factor of 1"));
    let none = diagnosis_page("none", &[("/ports", port)]);
    assert!(!none.contains("The interval leaves 0 out"));
    let wide = json!([{"port": "egp", "unit": "factor", "course": [part("00-24", 0.0, 1.0)]}]);
    let html = diagnosis_page("unknown", &[("/ports", wide)]);
    assert!(html.contains("Every interval holds 0: no part of the day stands out."));
}

#[test]
fn a_change_that_could_be_none_is_called_that() {
    let change = json!([{"minutes": 60, "mae_before": 14.0, "mae_after": 13.9,
        "difference": {"value": -0.1, "lower": -0.5, "upper": 0.3}}]);
    let html = diagnosis_page("effect", &[("/how_far/horizons", change)]);
    let words =
        "no error on held-out days shrinks beyond chance (14.0 to 13.9 mg/dL 60 min ahead).";
    assert!(verdict_of(&html).contains(words), "{}", verdict_of(&html));
    assert!(verdict_of(&html).contains("<dd class=\"answer\">No certain change</dd>"));
}

#[test]
fn an_error_that_grows_stands_beside_one_that_falls() {
    let changes = json!([{"minutes": 60, "mae_before": 14.0, "mae_after": 14.5,
        "difference": {"value": 0.5, "lower": 0.2, "upper": 0.8}},
        {"minutes": 300, "mae_before": 30.4, "mae_after": 27.9,
        "difference": {"value": -2.5, "lower": -3.4, "upper": -1.6}}]);
    let html = diagnosis_page("effect", &[("/how_far/horizons", changes)]);
    for words in [
        "with them the error 5 h ahead on held-out days falls from 30.4 to 27.9 mg/dL, by 8.2\u{a0}%, and \
         the error 60 min ahead grows from 14.0 to 14.5 mg/dL, by 3.6\u{a0}%.",
        "<dd class=\"answer\">Smaller and larger</dd>",
        "14.0 \u{2192} 14.5 mg/dL 60 min ahead, change 0.5 (0.2 to 0.8)",
    ] {
        assert!(verdict_of(&html).contains(words), "{words}: {}", verdict_of(&html));
    }
}

#[test]
fn where_no_situation_is_certain_the_largest_part_is_named() {
    let cells = json!([{"factor": "hour", "level": "04-08", "mean_error_mg_dl": 3.0, "lower": -1.0,
        "upper": 7.0, "p_adjusted": 0.4, "share_of_gap": 0.15, "expected_mg_dl": 2.0}]);
    let html = diagnosis_page("effect", &[("/where", cells)]);
    let words = "The largest part of what is missing is expected from 04 to 08 h (15\u{a0}% of it)";
    assert!(verdict_of(&html).contains(words), "{}", verdict_of(&html));
}

#[test]
fn only_situations_have_a_share_and_figures_say_their_unit() {
    let html = diagnosis_page("effect", &[]);
    let place = section(&html, "where");
    for words in [
        "<td class=\"short\">p07</td><td class=\"number\">28.0 (14.0 to 42.0)</td>\
         <td class=\"number\">&lt;0.001</td><td class=\"number\">\u{2013}</td>",
        "<td class=\"short\">04-08 h</td><td class=\"number\">31.0 (20.0 to 42.0)</td>\
         <td class=\"number\">&lt;0.001</td><td class=\"number\">21.0 %</td>",
        "<title>p07: 28.00 (14.00 to 42.00) mg/dL</title>",
    ] {
        assert!(place.contains(words), "{words}");
    }
    let size = "<title>everyone: 1.10 (0.70 to 1.50) times the published size</title>";
    assert!(section(&html, "which").contains(size));
}

#[test]
fn a_card_says_what_a_reader_asks() {
    let html = diagnosis_page("effect", &[]);
    let (_, card) = html.split_once("<article").expect("there is a card");
    let (card, _) = card.split_once("</article>").expect("it ends");
    for words in [
        "1. Dawn phenomenon",
        "the liver&#39;s glucose production",
        "<rect width=\"97\" height=\"10\"/></svg>97\u{a0}%",
        "31.2 nats, very strong",
        "1.10 (0.70 to 1.50) times the published size",
        "insulin sensitivity that follows the clock; the answer is this set, not the one name",
        "the interval lies above zero in 11 of 11",
        "Published size",
    ] {
        assert!(card.contains(words), "{words}");
    }
}

#[test]
fn what_residual_networks_absorbed_is_said_by_effect() {
    let html = diagnosis_page("effect", &[("/notes", json!(["Not calibrated for this plant."]))]);
    assert!(verdict_of(&html).contains("Not calibrated for this plant."));
    let (_, section) = html.split_once("<section id=\"absorbed\">").expect("a section");
    let (section, _) = section.split_once("</section>").expect("it ends");
    for words in [
        "Without the residual the answer is dawn phenomenon and glucose uptake during exercise.",
        "dawn phenomenon</td><td class=\"number\">88.0</td><td class=\"number\">31.2</td>\
         <td class=\"number\">65\u{a0}%</td></tr>",
        "\u{2212}24\u{a0}%",
        "<td class=\"number\">16.1</td><td class=\"number\">14.5</td>",
    ] {
        assert!(section.contains(words), "{words}: {section}");
    }
    assert_eq!(section.matches("<tr class=\"bold\">").count(), 1, "one effect is half gone");
    let html = diagnosis_page("none", &[]);
    assert!(!html.contains("<section id=\"absorbed\">"));
}

#[test]
fn candidates_stand_by_gain_with_the_untried_below() {
    let html = diagnosis_page("effect", &[]);
    let place = |words: &str| html.find(words).unwrap_or_else(|| panic!("{words}"));
    let (_, tried) = html.split_once("<section id=\"tried\">").expect("a section");
    let order: Vec<usize> = [
        "dawn phenomenon",
        "insulin sensitivity that follows the clock",
        "unknown: something that the library does not hold",
        "none: nothing is missing",
        "insulin absorption that varies by day",
        "no person has sleep on record",
    ]
    .iter()
    .map(|words| tried.find(words).unwrap_or_else(|| panic!("{words}")))
    .collect();
    assert!(order.is_sorted(), "{order:?}");
    assert!(place("id=\"which\"") < place("id=\"tried\""));
}

#[test]
fn reconstructed_rows_are_marked_and_explained() {
    let html = diagnosis_page("effect", &[]);
    assert!(html.contains("5 h (reconstructed)") && html.contains("no longer equivalent"));
    // A reconstruction is no prediction, and stays out of the verdict.
    assert!(verdict_of(&html).contains("falls from 30.4 to 27.9 mg/dL"));
    assert!(html.contains("Rows marked as reconstructed") && html.contains("last third of each"));
    let plain = json!([{"metric": "tir", "margin": 5.0, "p_before": 0.4, "p_after": 0.01}]);
    let bare = json!({"horizons": [], "outcomes": plain});
    let html = diagnosis_page("effect", &[("/how_far", bare)]);
    assert!(!html.contains("reconstructed") && html.contains("becomes equivalent"));
}

#[test]
fn shrinkage_is_told_by_horizon_and_person() {
    let html = diagnosis_page("effect", &[]);
    let (_, section) = html.split_once("<section id=\"how-far\">").expect("a section");
    let (section, _) = section.split_once("</section>").expect("it ends");
    for words in [
        // 2.5 of the 12.16 mg/dL above the floor.
        "<td class=\"short\">5 h</td><td class=\"number\">30.4</td><td class=\"number\">27.9</td><td \
         class=\"number\">\u{2212}2.5 (\u{2212}3.4 to \u{2212}1.6)</td><td \
         class=\"number\">18.2</td><td class=\"number\">21\u{a0}%</td>",
        "aria-label=\"Held-out error of every person before and after\"",
        "Before, 5 h ahead (mg/dL)",
        "Errors of 11 people",
        "changes by 14.5 (8.1 to 20.9) nats",
        "1.05 (0.80 to 1.30)",
        "What a perfect model would leave",
        ">60 min: after</th>",
        "<td class=\"short\">TIR (%)</td>",
        "<td class=\"short\">MG (mg/dL)</td>",
        "Simulated \u{2212} measured, after</th>",
    ] {
        assert!(section.contains(words), "{words}");
    }
}

#[test]
fn one_person_and_many_have_their_figures() {
    let person = |k: u32| {
        json!({"person_id": format!("q{k}"), "amplitude": 1.0, "lower": 0.5, "upper": 1.5,
            "gain_nats": f64::from(k)})
    };
    for people in [1, 400_u32] {
        let all: Vec<Value> = (1..=people).map(person).collect();
        let html = diagnosis_page("effect", &[("/effects/0/people", json!(all))]);
        assert!(html.contains(&format!("above zero in {people} of {people}")));
        assert_eq!(html.contains("Shown are the 40 of 400"), people == 400);
        assert_eq!(html.contains(">\nq1\n</text>"), people == 1, "those whose data say most");
    }
}

#[test]
fn the_sketch_has_every_place_and_its_table_says_the_same() {
    let html = diagnosis_page("unknown", &[]);
    let (_, section) = html.split_once("<section id=\"ports\">").expect("a section");
    let (section, _) = section.split_once("</section>").expect("it ends");
    for words in ["production", "insulin available", "Sensor reading", "62\u{a0}%"] {
        assert!(section.contains(&format!(">\n{words}\n</text>")), "{words} in the sketch");
    }
    assert!(section.contains(
        "<tr class=\"bold\"><td class=\"wide\">A glucose flux that the model does not have"
    ));
    // Only the sketch says that a port was not assessed.
    let html = diagnosis_page("unknown", &[("/ports", json!([{"port": "sensor"}]))]);
    assert_eq!(html.matches("not assessed").count(), 8);
}

#[test]
fn a_frame_marks_what_the_verdict_is_about() {
    let frames = |html: &str| html.matches("stroke=\"#D55E00\" stroke-width=\"7\"").count();
    // The most probable port and the one that cannot be separated from it; where effects enter;
    // nothing.
    for (verdict, count) in [("unknown", 2), ("effect", 2), ("none", 0)] {
        let html = diagnosis_page(verdict, &[]);
        let (_, sketch) = html.split_once("<section id=\"ports\">").expect("a section");
        assert_eq!(frames(sketch), count, "{verdict}");
    }
    // An effect was found at a port without stated evidence.
    let html = diagnosis_page("effect", &[("/ports", json!([{"port": "sensor"}]))]);
    assert_eq!(html.matches(">\nfound\n</text>").count(), 2);
    // The stronger of two entries of one port counts.
    let twice = json!([{"port": "sensor", "gain_nats": 1.0, "probability": 0.2},
        {"port": "sensor", "gain_nats": 9.0, "probability": 0.7}]);
    let html = diagnosis_page("unknown", &[("/ports", twice)]);
    assert!(html.contains(">\n70\u{a0}%\n</text>") && !html.contains(">\n20\u{a0}%\n</text>"));
}

#[test]
fn what_is_not_known_stands_under_the_answer() {
    let said = json!({"something": 0.93, "sets": [], "speaks_from": 0.75, "names_from": 0.5,
        "source": "made up"});
    let candidates = json!([{"effect": "dawn", "gain_nats": 31.2, "probability": 0.97},
        {"effect": "exercise", "gain_nats": 12.4, "probability": 0.91},
        {"effect": "alcohol", "gain_nats": 2.0, "probability": 0.08},
        {"effect": "sensor_lag", "gain_nats": 2.0, "probability": 0.31},
        {"effect": "slow_meals", "gain_nats": 2.0, "probability": 0.04},
        {"effect": "unknown", "gain_nats": 0.0, "probability": 0.2}]);
    let html = diagnosis_page("effect", &[("/posterior", said), ("/candidates", candidates)]);
    for words in [
        "<strong>Not known.</strong> Lag of the sensor (31\u{a0}%) and alcohol (8\u{a0}%) may act: neither \
         named (an effect is named from 50\u{a0}% on) nor excluded. Not tried, since the records lack what \
         would show it: lower \
         insulin sensitivity after short sleep and ageing of the infusion set. Another effect that is small",
        "Compared with the sensor: the ODE model with parameters fitted to each person.",
    ] {
        assert!(verdict_of(&html).contains(words), "{words}: {}", verdict_of(&html));
    }
    let html = diagnosis_page("none", &[("/untried", json!([]))]);
    assert!(verdict_of(&html).contains("<strong>Not known.</strong> An effect that is small"));
}

#[test]
fn what_rests_on_one_person_is_told_and_not_named() {
    let why = "It rests on one person: without P-02 its probability is 12 %.";
    let candidates = json!([{"effect": "exercise", "gain_nats": 12.4, "probability": 0.76, "not_named": why},
        {"effect": "alcohol", "gain_nats": 2.0, "probability": 0.08},
        {"effect": "unknown", "gain_nats": 0.0, "probability": 0.2}]);
    let html = diagnosis_page("unknown", &[("/candidates", candidates)]);
    for words in [
        "no effect can be named (most probable: glucose uptake during exercise, 76\u{a0}%; it rests on \
         one person: without P-02 its probability is 12 %)",
        "Probable enough, and not named all the same: glucose uptake during exercise (76\u{a0}%; it rests \
         on one person",
        "Alcohol (8\u{a0}%) may act: neither named",
    ] {
        assert!(verdict_of(&html).contains(words), "{words}: {}", verdict_of(&html));
    }
}
