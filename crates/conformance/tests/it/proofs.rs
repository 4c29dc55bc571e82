//! What a verdict rests on: an accepted certificate, the construction, a witness.

use std::time::Duration;

use conformance::{
    AcceptedClaim, ConformanceError, DeepNetwork, Direction, Grounds, Limits, OneHiddenLayer,
    Property, PropertyKind, Region, Row, SlopeBound, Stop, Summand, Verdict, bounds_of_sum, prove,
    verify, verify_recorded,
};

/// 2 max(0, a) - max(0, b): rises with a, falls with b.
fn network() -> OneHiddenLayer {
    let names = ["a", "b"].map(str::to_owned).to_vec();
    OneHiddenLayer::new("y", names, vec![1.0, 0.0, 0.0, 1.0], vec![0.0; 2], vec![2.0, -1.0], 0.0)
        .expect("shapes fit")
}

fn property(input: &str, direction: Direction) -> Property {
    Property {
        network: "y".to_owned(),
        input: input.to_owned(),
        direction,
        kind: PropertyKind::Physical,
    }
}

fn rows(region: &Region, properties: &[Property]) -> Vec<Row> {
    let limits =
        Limits { relative_gap: 0.0, nodes: 100, time: Duration::from_secs(60), cross_check: None };
    let row = |property| verify(&network(), property, region, &limits, &|| Duration::ZERO);
    properties.iter().map(|property| row(property).expect("decided")).collect()
}

#[test]
fn a_row_is_proved_by_what_the_checker_accepts_and_by_nothing_else() {
    let region = Region::scaled([("a", [-1.0, 1.0]), ("b", [-1.0, 1.0])]).expect("a box");
    let properties = [
        property("a", Direction::Increasing),
        property("b", Direction::Decreasing),
        property("b", Direction::Increasing),
    ];
    let network = network();
    let of: Vec<(&OneHiddenLayer, &Property)> =
        properties.iter().map(|property| (&network, property)).collect();
    let fresh = rows(&region, &properties);
    let grounds: Vec<Option<Grounds>> = fresh.iter().map(|row| row.grounds).collect();
    assert_eq!(grounds, [Some(Grounds::Bound), Some(Grounds::Bound), Some(Grounds::Witness)]);

    // A checker that accepts the first claim alone, and other claims about the second row.
    let mut judged = fresh.clone();
    let claim = |input: &str, property, claim| AcceptedClaim {
        network: "y".to_owned(),
        input: input.to_owned(),
        property,
        claim,
    };
    let accept = |_: &[u8]| {
        Ok(vec![
            claim("a", Direction::Increasing, 0.0),
            claim("b", Direction::Decreasing, 0.5),
            claim("b", Direction::Increasing, 0.0),
        ])
    };
    let proofs = prove(&mut judged, &of, &region, b"model", accept).expect("proved");
    assert_eq!(proofs.accepted, 3);
    let file: serde_json::Value = serde_json::from_slice(&proofs.file).expect("JSON");
    assert_eq!(file["certificates"].as_array().map(Vec::len), Some(2));
    let verdicts: Vec<_> = judged.iter().map(|row| (row.verdict, row.grounds)).collect();
    let expected = [
        (Verdict::Proved, Some(Grounds::Certificate)),
        (Verdict::Undecided, None),
        (Verdict::Violated, Some(Grounds::Witness)),
    ];
    assert_eq!(verdicts, expected);

    let refused = prove(&mut fresh.clone(), &of, &region, b"model", |_| Err("no seal".to_owned()));
    let error = refused.expect_err("refused");
    assert!(matches!(&error, ConformanceError::Rejected { reason } if reason == "no seal"));
}

/// A network of two layers that falls with `a` by `slope` everywhere on positive inputs.
fn falling(slope: f64) -> DeepNetwork {
    let layers = vec![(vec![1.0], vec![0.0]), (vec![-slope], vec![0.0])];
    DeepNetwork::new(vec!["a".to_owned()], layers).expect("shapes fit")
}

#[test]
fn a_sum_is_proved_where_each_part_is_and_violated_where_a_step_shows_it() {
    let points: Vec<Vec<f64>> = [0.1, 0.4, 0.7].map(|x| vec![x]).to_vec();
    let (down, up) = (falling(2.0), falling(-3.0));
    let own = Summand { network: &down, points: &points };
    let other = Summand { network: &up, points: &points };
    let bound = |m_upper: f64, grounds: Option<Grounds>| SlopeBound {
        m_upper,
        grounds,
        nodes: 1,
        stop: Stop::Gap,
        seconds: 0.0,
    };
    let decide = |summands: &[Summand<'_>], bound| {
        let row = verify_recorded("sum", "a", summands, 1.0, bound).expect("steps lie inside");
        (row.verdict, row.grounds)
    };
    for grounds in [Grounds::Construction, Grounds::Summands] {
        assert_eq!(decide(&[own], bound(-2.0, Some(grounds))), (Verdict::Proved, Some(grounds)));
        assert_eq!(decide(&[own], bound(0.5, Some(grounds))), (Verdict::Undecided, None));
    }
    // A bound of boxes alone is no proof.
    assert_eq!(decide(&[own], bound(-2.0, None)), (Verdict::Undecided, None));
    let violated = (Verdict::Violated, Some(Grounds::Witness));
    assert_eq!(decide(&[own, other], bound(1.5, None)), violated);
    let row = verify_recorded("sum", "a", &[own, other], 1.0, bound(1.5, None)).expect("steps");
    assert!((row.m_lower - 1.0).abs() < 1e-9 && row.share_of_steps == Some(1.0), "{row:?}");

    // Steps that end beyond the box are not replayed.
    let outside =
        verify_recorded("sum", "a", &[own], 0.05, bound(-2.0, Some(Grounds::Construction)));
    assert!(matches!(outside, Err(ConformanceError::NoStep { .. })), "{outside:?}");
}

#[test]
fn a_slope_from_a_step_is_not_above_the_networks() {
    // Numbers about 1e9 lie so far apart that a step is longer or shorter than was asked for.
    let points = [vec![1e9]];
    let network = falling(-3.0);
    let own = Summand { network: &network, points: &points };
    let bound = SlopeBound { m_upper: 3.0, grounds: None, nodes: 1, stop: Stop::Gap, seconds: 0.0 };
    let row = verify_recorded("sum", "a", &[own], 2e9, bound).expect("a step lies inside");
    assert!(row.m_lower <= 3.0 && row.m_lower > 3.0 - 1e-12, "{row:?}");
}

#[test]
fn signs_that_are_kept_close_what_rounding_leaves_open() {
    assert_eq!(bounds_of_sum(1e-18, -0.5, true), (0.0, (-0.5_f64).next_up()));
    assert_eq!(bounds_of_sum(0.0, 0.0, true), (0.0, 0.0));
    let (residual, sum) = bounds_of_sum(0.25, -0.5, false);
    assert_eq!((residual, sum), (0.25, (-0.25_f64).next_up()));
}
