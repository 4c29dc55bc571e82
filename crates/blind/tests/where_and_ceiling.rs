//! "Where" and the ceiling get the scores that can be computed by hand.

use blind::{ScoredWorld, score, with_ceiling};
use contract::WithInterval;
use contract::blind_check::{
    Answer, BlindCheck, ExactCourse, Kind, Label, PortCourse, TrueCell, TrueEffect, TrueWhere,
    Verdict, WhereScore,
};
use contract::diagnosis::{CellFactor, CellGap, FoundEffect, PortEvidence};

/// 4 mg/dL from 3 to 8 h under one effect of the liver, half of that asleep; nothing elsewhere.
fn morning() -> TrueWhere {
    let cell = |factor: &str, level: &str, share: f64, mean: f64| TrueCell {
        factor: factor.to_owned(),
        level: level.to_owned(),
        share,
        mean_mg_dl: [Some(mean), Some(2.0 * mean), Some(3.0 * mean)],
    };
    let hours = (0..24).map(|hour| {
        let mean = if (3..8).contains(&hour) { 4.0 } else { 0.0 };
        cell("hour", &format!("{hour:02}"), 1.0 / 24.0, mean)
    });
    let others = [cell("context", "sleep", 0.3, 2.0), cell("context", "exercise", 0.02, 0.0)];
    let course = PortCourse {
        effect: "dawn".to_owned(),
        port: "egp".to_owned(),
        unit: "factor".to_owned(),
        by_hour: vec![Some(0.0); 24],
    };
    TrueWhere {
        mean_mg_dl: [0.8, 1.6, 2.4],
        mean_absolute_mg_dl: [0.8, 1.6, 2.4],
        cells: hours.chain(others).collect(),
        ports: vec![course],
    }
}

fn label(id: &str, gap: Option<TrueWhere>) -> Label {
    let effects = gap.iter().map(|_| TrueEffect {
        form: None,
        effect: "dawn".to_owned(),
        port: None,
        in_library: true,
        amplitude: 1.0,
        target_mg_dl: 10.0,
        achieved_mg_dl: 10.0,
        at_limit: false,
    });
    let kind = if gap.is_some() { Kind::Single } else { Kind::Null };
    Label { kind, effects: effects.collect(), gap, ..Label::null(id, "hovorka", "aid", 5, 14) }
}

/// Cells by factor, level and mean error, the largest share first, with intervals of 1 to either
/// side.
fn pointing_at(cells: &[(CellFactor, &str, f64)]) -> Answer {
    let cells = cells.iter().enumerate().map(|(index, (factor, level, mean))| CellGap {
        factor: *factor,
        level: (*level).to_owned(),
        mean_error_mg_dl: *mean,
        lower: mean - 1.0,
        upper: mean + 1.0,
        p_adjusted: 0.5,
        share_of_gap: 1.0 / (index + 1) as f64,
        expected_mg_dl: None,
        horizon_minutes: 60,
        people: 5,
        runs: 100,
        innovation: None,
    });
    Answer { cells: cells.collect(), ..Answer::none() }
}

fn where_score(worlds: Vec<(Label, Answer)>) -> WhereScore {
    let worlds: Vec<ScoredWorld> =
        worlds.into_iter().map(|(label, answer)| ScoredWorld { label, answer }).collect();
    score(1, &worlds).expect("countable").localisation.expect("scored")
}

const CELLS: [(CellFactor, &str, f64); 6] = [
    (CellFactor::Hour, "03-08", 4.5),
    (CellFactor::Hour, "12-17", 1.5),
    (CellFactor::Hour, "17-21", 0.5),
    (CellFactor::Hour, "21-24", 0.0),
    (CellFactor::Context, "exercise", 0.0),
    (CellFactor::Horizon, "300", 9.0),
];

#[test]
fn the_largest_cells_are_hot_where_the_truth_is() {
    let right = where_score(vec![(label("w", Some(morning())), pointing_at(&CELLS))]);
    for row in &right.context {
        assert_eq!((row.comparable.count, row.hit.count, row.sign_right.count), (1, 1, 1));
        // Three of four hours, of which one is hot: a quarter of the draws miss it.
        assert!((row.chance.expect("cells") - 0.75).abs() < 1e-12);
    }
    // 1.5 where the truth is 0 lies outside its interval; the others hold theirs.
    assert_eq!((right.coverage.cells.count, right.coverage.cells.of), (4, 5));
    assert_eq!((right.coverage.worlds.count, right.coverage.worlds.of), (0, 1));

    let mut turned = CELLS;
    turned[0].2 = -4.5;
    let turned = where_score(vec![(label("w", Some(morning())), pointing_at(&turned))]);
    assert_eq!((turned.context[0].hit.count, turned.context[0].sign_right.count), (1, 0));

    let elsewhere = where_score(vec![(label("w", Some(morning())), pointing_at(&CELLS[1..]))]);
    assert_eq!((elsewhere.context[0].hit.count, elsewhere.context[0].hit.of), (0, 1));
    assert_eq!(elsewhere.context[0].chance, Some(0.0));
    assert_eq!(elsewhere.context[0].sign_right.of, 0);
}

#[test]
fn worlds_without_a_hot_place_are_counted_and_not_compared() {
    let mut even = morning();
    for cell in &mut even.cells {
        cell.mean_mg_dl = [Some(0.8), Some(1.6), Some(2.4)];
    }
    let null = (label("n", None), pointing_at(&CELLS));
    let both = where_score(vec![(label("w", Some(even)), pointing_at(&CELLS)), null]);
    assert_eq!((both.context[0].comparable.count, both.context[0].comparable.of), (0, 1));
    assert_eq!((both.context[0].hit.of, both.context[0].chance), (0, None));
    // In the null world the truth is 0 in every cell.
    assert_eq!((both.coverage.null_cells.count, both.coverage.null_cells.of), (3, 5));
    assert_eq!(both.coverage.null_worlds.count, 0);
    // No answer is no hit.
    let silent = where_score(vec![(label("w", Some(morning())), Answer::failed("killed", 1.0))]);
    assert_eq!((silent.context[0].hit.count, silent.context[0].hit.of), (0, 1));
    assert_eq!(silent.context[0].chance, None);
}

#[test]
fn the_true_port_is_ranked_among_those_of_the_answer() {
    let evidence = |port: &str, probability: f64, confusable: &[&str]| PortEvidence {
        port: port.to_owned(),
        gain_nats: 1.0,
        probability,
        confusable_with: confusable.iter().map(|port| (*port).to_owned()).collect(),
        unit: String::new(),
        course: Vec::new(),
    };
    let with = |ports: Vec<PortEvidence>, found: Vec<FoundEffect>| {
        let verdict = Verdict::Effect;
        (label("w", Some(morning())), Answer { verdict, ports, found, ..Answer::none() })
    };
    let named = |effect: &str, port: &str, lower: f64| FoundEffect {
        effect: effect.to_owned(),
        port: port.to_owned(),
        gain_nats: 9.0,
        probability: 0.9,
        amplitude: WithInterval { value: 1.0, lower, upper: 2.0 },
        confusable_with: Vec::new(),
        people: Vec::new(),
        questioned: Vec::new(),
    };
    let found = where_score(vec![
        with(vec![evidence("sensor", 0.2, &[]), evidence("egp", 0.5, &[])], vec![]),
        with(
            vec![evidence("glucose_flux", 0.6, &["egp"]), evidence("egp", 0.4, &[])],
            vec![named("dawn", "egp", 0.4)],
        ),
        with(vec![evidence("sensor", 0.9, &[])], vec![named("alcohol", "egp", 0.4)]),
        with(vec![evidence("sensor", 0.9, &[])], vec![named("slow_meals", "gut_absorption", 0.0)]),
    ])
    .equations;
    assert_eq!((found.first.count, found.first.of), (1, 4));
    assert_eq!((found.first_or_in_set.count, found.among_three.count), (2, 2));
    assert_eq!(
        (found.not_listed.count, found.mean_rank, found.mean_listed),
        (2, Some(1.5), Some(1.5))
    );
    assert_eq!(found.first_by_port["egp"].of, 4);
    assert_eq!((found.port_of_first_name.count, found.port_of_first_name.of), (2, 3));
    assert_eq!((found.sign_of_amplitude.count, found.sign_of_amplitude.of), (1, 1));
    assert_eq!((found.course_answered.count, found.course_answered.of), (0, 4));
}

#[test]
fn the_ceiling_stands_beside_the_power() {
    let course = |id: &str, acts: bool, gain: Option<f64>| ExactCourse {
        id: id.to_owned(),
        effect: "dawn".to_owned(),
        acts,
        gain_nats: gain,
        amplitude: gain.map(|_| 1.0),
    };
    let ids = ["a", "b", "c"];
    let mut worlds: Vec<ScoredWorld> = ids
        .into_iter()
        .map(|id| ScoredWorld { label: label(id, Some(morning())), answer: Answer::none() })
        .collect();
    worlds[2].label.effects[0].achieved_mg_dl = 5.0;
    worlds.push(ScoredWorld { label: label("n", None), answer: Answer::none() });
    for id in ["o", "p"] {
        let mut outside = label(id, Some(morning()));
        outside.kind = Kind::Outside;
        worlds.push(ScoredWorld { label: outside, answer: Answer::none() });
    }
    let check = score(1, &worlds).expect("countable");
    assert!(check.ceiling.is_none() && check.power.iter().all(|row| row.ceiling.is_none()));
    let check = with_ceiling(
        check,
        vec![
            course("a", true, Some(5.1)),
            course("b", true, Some(4.9)),
            course("c", true, None),
            course("o", true, Some(5.2)),
            course("p", true, Some(1.0)),
            course("n", false, Some(0.0)),
            course("n", false, Some(5.0)),
        ],
    )
    .expect("countable");
    let ceiling = check.ceiling.as_ref().expect("asked");
    assert_eq!((ceiling.named.count, ceiling.named.of), (1, 3));
    assert_eq!((ceiling.named_at_10.count, ceiling.named_at_10.of), (1, 2));
    assert_eq!((ceiling.answered_at_5.count, ceiling.answered_at_5.of), (0, 3));
    assert_eq!((ceiling.unknown.count, ceiling.unknown.of), (1, 2));
    assert_eq!((ceiling.answered_unknown.count, ceiling.answered_unknown.of), (0, 2));
    // Of two courses that do not act none may be above the bar; of fifty, one.
    assert_eq!(ceiling.bar_nats, 5.0);
    // The courses that do not act are of one world, which has no interval.
    assert!(ceiling.at_lower_bar.is_none() && ceiling.at_upper_bar.is_none());
    assert_eq!((ceiling.false_alarms.count, ceiling.false_alarms.of), (0, 2));
    let rows: Vec<(f64, usize, usize)> = check
        .power
        .iter()
        .filter(|row| row.effect.is_some())
        .filter_map(|row| Some((row.from_mg_dl, row.ceiling?.count, row.ceiling?.of)))
        .collect();
    assert_eq!(rows, [(3.75, 0, 1), (7.5, 1, 2)]);
    let text = serde_json::to_string(&check).expect("JSON");
    assert_eq!(serde_json::from_str::<BlindCheck>(&text).expect("its own layout"), check);
}

#[test]
fn the_bar_of_the_ceiling_has_an_interval_over_worlds() {
    let course = |id: String, acts: bool, gain: f64| ExactCourse {
        id,
        effect: "dawn".to_owned(),
        acts,
        gain_nats: Some(gain),
        amplitude: Some(1.0),
    };
    // One world in ten has a course far above the others, so the bar of one course in fifty is there or is not.
    let nulls = (0..10).map(|world| {
        let gain = if world == 0 { 30.0 } else { 1.0 };
        course(format!("n{world}"), false, gain)
    });
    let acting = [("a", 0.5), ("b", 20.0), ("c", 40.0)];
    let worlds: Vec<ScoredWorld> = acting
        .iter()
        .map(|(id, _)| ScoredWorld { label: label(id, Some(morning())), answer: Answer::none() })
        .collect();
    let courses =
        nulls.chain(acting.iter().map(|(id, gain)| course((*id).to_owned(), true, *gain)));
    let check = with_ceiling(score(1, &worlds).expect("countable"), courses.collect());
    let ceiling = check.expect("countable").ceiling.expect("asked");
    assert_eq!((ceiling.bar_nats, ceiling.named_at_5.count), (30.0, 1));
    let (lower, upper) =
        (ceiling.at_lower_bar.expect("ten worlds"), ceiling.at_upper_bar.expect("ten worlds"));
    assert_eq!((lower.bar_nats, lower.named_at_5), (1.0, 2));
    assert_eq!((upper.bar_nats, upper.named_at_5), (30.0, 1));
}
