//! Regions that half-spaces cut out of boxes.

use std::time::Duration;

use conformance::milp::{Form, MilpLimits, solve_step};
use conformance::{
    ConformanceError, Direction, Limits, OneHiddenLayer, Property, PropertyKind, Region, Scaling,
    Signal, Verdict, certify, share_of_region, step_bracket, verify, with_slice,
};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

fn property() -> Property {
    let (network, input) = ("y".to_owned(), "a".to_owned());
    Property { network, input, direction: Direction::Decreasing, kind: PropertyKind::Physical }
}

fn limits() -> Limits {
    Limits { relative_gap: 1e-6, nodes: 200_000, time: Duration::from_secs(60), cross_check: None }
}

fn still() -> Duration {
    Duration::ZERO
}

fn boxed() -> Region {
    Region::scaled([("a", [-1.0, 1.0]), ("b", [-1.0, 1.0]), ("z", [0.0, 1.0])]).expect("a box")
}

fn random(seed: u64) -> OneHiddenLayer {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = |n: usize| -> Vec<f64> { (0..n).map(|_| rng.random_range(-1.0..1.0)).collect() };
    let names = vec!["a".to_owned(), "b".to_owned()];
    OneHiddenLayer::new("y", names, draw(24), draw(12), draw(12), 0.0).expect("valid network")
}

/// `a b`-like: rises with a where b > 0, falls where b < 0.
fn saddle() -> OneHiddenLayer {
    let names = vec!["a".to_owned(), "b".to_owned()];
    let w1 = vec![1.0, 1.0, -1.0, -1.0, 1.0, -1.0, -1.0, 1.0];
    OneHiddenLayer::new("y", names, w1, vec![0.0; 4], vec![1.0, 1.0, -1.0, -1.0], 0.0)
        .expect("valid network")
}

#[test]
fn a_half_space_decides_a_property() {
    let whole = verify(&saddle(), &property(), &boxed(), &limits(), &still).expect("decided");
    assert_eq!(whole.verdict, Verdict::Violated);
    // |a + b| - |a - b| is -2a where b < -|a|.
    let cut = boxed()
        .within([("a", 1.0), ("b", 1.0)], -0.1)
        .and_then(|region| region.within([("a", -1.0), ("b", 1.0)], -0.1))
        .expect("half-spaces");
    let row = verify(&saddle(), &property(), &cut, &limits(), &still).expect("decided");
    assert_eq!((row.verdict, row.m_upper), (Verdict::Proved, -2.0));
    let kept = certify(&saddle(), &property(), &cut, row.m_upper, 10_000)
        .expect("decided")
        .expect("the search came to this bound");
    let inside = kept.inside.expect("half-spaces bind the network");
    let (a, b) = (inside["a"], inside["b"]);
    assert!(inside.len() == 2 && a + b < -0.1 && b - a < -0.1, "{inside:?}");
    // One that speaks of a signal the network does not see changes nothing.
    let other = boxed().within([("b", 1.0), ("z", 1.0)], -0.5).expect("a half-space");
    let same = verify(&saddle(), &property(), &other, &limits(), &still).expect("decided");
    assert_eq!(same.m_upper, whole.m_upper);
    let kept = certify(&saddle(), &property(), &other, same.m_upper, 10_000).expect("decided");
    assert!(kept.is_some_and(|kept| kept.inside.is_none()));
}

#[test]
fn brackets_hold_inside_and_witnesses_lie_inside() {
    let mut lowered = 0;
    for seed in 0..30 {
        let network = random(seed);
        let mut rng = ChaCha8Rng::seed_from_u64(1000 + seed);
        let weights = [rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0)];
        let region = boxed()
            .within([("a", weights[0]), ("b", weights[1])], 0.1)
            .expect("a half-space with the origin inside");
        let inside = |point: &[f64]| {
            weights[0] * point[0] + weights[1] * point[1] <= 0.1
                && point.iter().all(|x| (-1.0..=1.0).contains(x))
        };
        let row = verify(&network, &property(), &region, &limits(), &still).expect("decided");
        let free = verify(&network, &property(), &boxed(), &limits(), &still).expect("decided");
        assert!(row.m_lower <= row.m_upper && row.m_upper <= free.m_upper + 1e-12);
        assert!(row.m_upper - row.m_lower <= 1e-3, "seed {seed}: {row:?}");
        lowered += usize::from(row.m_upper < free.m_lower - 1e-6);
        let witness = row.witness.as_ref().expect("a piece with an interior");
        for a in [witness.from, witness.to] {
            assert!(inside(&[a, witness.point["b"]]), "seed {seed}: {witness:?}");
        }
        for _ in 0..3000 {
            let from = [rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0)];
            let to = [from[0] + 1e-6, from[1]];
            if inside(&from) && inside(&to) {
                let value = |x: &[f64]| network.evaluate(x).expect("finite");
                let slope = (value(&to) - value(&from)) / 1e-6;
                assert!(slope <= row.m_upper + 1e-8, "seed {seed}: {slope} {row:?}");
            }
        }
        let step = step_bracket(&network, &property(), &region, &row, 0.1).expect("a step");
        let milp = MilpLimits { time: Duration::from_secs(60), relative_gap: 0.0 };
        let solved =
            solve_step(&network, &property(), &region, 0.1, Form::Difference, &milp, &still)
                .expect("solved");
        let claimed = solved.claimed_bound.expect("a bound");
        assert!(step.z_lower <= claimed + 1e-6, "seed {seed}");
        assert!(claimed <= step.z_upper + 1e-6, "seed {seed}: {solved:?} {step:?}");
    }
    assert!(lowered > 5, "{lowered} of 30 half-spaces matter");
}

#[test]
fn a_witness_of_another_network_is_refused() {
    let (network, region) = (saddle(), boxed());
    let row = verify(&network, &property(), &region, &limits(), &still).expect("decided");
    let mut foreign = row.clone();
    foreign.witness.as_mut().expect("the saddle falls and rises").point.remove("b");
    let refused = [
        step_bracket(&network, &property(), &region, &foreign, 0.1).err(),
        with_slice(foreign, &network, &region, 5).err(),
        step_bracket(
            &network,
            &Property { network: "other".to_owned(), ..property() },
            &region,
            &row,
            0.1,
        )
        .err(),
    ];
    for error in refused {
        assert!(matches!(error, Some(ConformanceError::WrongNetwork { .. })), "{error:?}");
    }
}

#[test]
fn shares_count_what_is_inside() {
    let cut = boxed().within([("b", 1.0)], 0.0).expect("half of the box");
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let all = share_of_region(&saddle(), &property(), &boxed(), 4000, &mut rng).expect("a share");
    let half = share_of_region(&saddle(), &property(), &cut, 4000, &mut rng).expect("a share");
    assert!((all.value - 0.25).abs() < 0.03 && half.value < 0.01, "{all:?} {half:?}");
    assert!(half.points < 2200);
}

#[test]
fn files_name_half_spaces_in_either_unit() {
    let signal = |name: &str, centre, scale| Signal {
        name: name.to_owned(),
        scaling: Some(Scaling { centre, scale }),
    };
    let signals = [signal("a", 10.0, 2.0), signal("b", 0.0, 4.0)];
    let text = r#"{"unit": "physical", "bounds": {"a": [8, 12], "b": [-4, 4]},
        "half_spaces": [{"weights": {"a": 1, "b": -1}, "at_most": 11}]}"#;
    let region = Region::from_json(text.as_bytes(), &signals).expect("a region");
    let [half_space] = region.half_spaces() else { panic!("{region:?}") };
    assert_eq!((half_space.weights["a"], half_space.weights["b"]), (2.0, -4.0));
    assert!((half_space.at_most - 1.0).abs() < 1e-12 && half_space.at_most >= 1.0);
    let network = saddle();
    for (weights, at_most, message) in [
        (vec![("q", 1.0)], 0.0, "no bounds for 'q'"),
        (vec![("a", f64::NAN)], 0.0, "not a finite number"),
        (vec![("a", 0.0)], 0.0, "no weight differs from 0"),
    ] {
        let error = boxed().within(weights, at_most).expect_err("refused").to_string();
        assert!(error.contains(message), "{error}");
    }
    let empty = boxed().within([("a", 1.0)], -2.0).expect("a half-space");
    let error = verify(&network, &property(), &empty, &limits(), &still).expect_err("nothing");
    assert!(error.to_string().contains("strictly inside"), "{error}");
}

/// max(0, a - 0.5), which rises.
fn hinge() -> OneHiddenLayer {
    let names = vec!["a".to_owned(), "b".to_owned()];
    OneHiddenLayer::new("y", names, vec![1.0, 0.0], vec![-0.5], vec![1.0], 0.0)
        .expect("valid network")
}

#[test]
fn a_region_without_an_inside_proves_nothing() {
    let bounds = [("a", [-1.0, 1.0]), ("b", [0.0, 1.0])];
    // Two half-spaces that share their face, and one that touches the box.
    let faces = [vec![(1.0, 0.5), (-1.0, -0.5)], vec![(1.0, 0.0)]];
    for face in faces {
        let mut region = Region::scaled(bounds).expect("a box");
        for (weight, at_most) in face {
            region = region.within([("b", weight)], at_most).expect("a half-space");
        }
        let refused = verify(&hinge(), &property(), &region, &limits(), &still).map(drop);
        let error = refused.expect_err("no inside").to_string();
        assert!(error.contains("strictly inside"), "{error}");
        let refused = certify(&hinge(), &property(), &region, 0.0, 100).map(drop);
        let error = refused.expect_err("no inside").to_string();
        assert!(error.contains("strictly inside"), "{error}");
    }
}

#[test]
fn half_spaces_may_hold_on_the_whole_box() {
    // One that b, which is fixed, fulfils by itself; the middle of the box is outside of the other.
    let region = Region::scaled([("a", [-1.0, 1.0]), ("b", [0.0, 0.0])])
        .and_then(|region| region.within([("b", 1.0)], 0.5))
        .and_then(|region| region.within([("a", 1.0)], -0.5))
        .expect("half-spaces");
    let row = verify(&hinge(), &property(), &region, &limits(), &still).expect("decided");
    assert_eq!((row.verdict, row.m_upper), (Verdict::Proved, 0.0));
}
