#![expect(clippy::print_stdout, reason = "with --nocapture the tests print their table")]
//! The paper's published population weights over one box: every row decided, by every engine.
//!
//! `cargo test -p conformance --test it published -- --nocapture` prints the table.

use std::time::{Duration, Instant};

use conformance::milp::{MilpLimits, MilpStatus};
use conformance::{
    Limits, OneHiddenLayer, Property, PropertyKind, Region, Row, Stop, Verdict,
    largest_slope_by_enumeration, paper_properties, verify,
};

/// The box of the values below, scaled units.
fn region() -> Region {
    Region::scaled([
        ("Q1", [-0.9375, 3.375]),
        ("Q2", [-1.140625, 8.15625]),
        ("S1", [-1.875, 57.96875]),
        ("S2", [-1.0, 19.4375]),
        ("I", [-0.984375, 19.578125]),
        ("X1", [-0.984375, 9.84375]),
        ("X2", [-0.953125, 18.0]),
        ("X3", [-0.828125, 16.234375]),
        ("C2", [-0.140625, 12.15625]),
        ("C1", [0.0, 41.078125]),
        ("u_insulin", [-1.734375, 467.625]),
        ("u_carbs", [0.0, 150.0]),
    ])
    .expect("valid region")
}

/// Largest slopes of physical rows, certified by an earlier prover, to the digits known.
const KNOWN: [(&str, &str, f64, f64); 9] = [
    // network, input, M, half a unit in its last digit
    ("S1", "S1", 0.378050, 5e-7),
    ("S1", "u_insulin", 0.0236161, 5e-8),
    ("S2", "S1", 0.114276, 5e-7),
    ("I", "I", 0.116293, 5e-7),
    ("X2", "X2", -0.0108953, 5e-8),
    ("X3", "X3", 0.0644592, 5e-8),
    ("C1", "u_carbs", -0.0224845, 5e-8),
    ("Q2", "X2", 0.081307, 5e-7),
    ("Q1", "X3", 0.327558, 5e-7),
];

/// Rows of the networks with at most `most` and at least `least` inputs.
fn table(
    networks: &[OneHiddenLayer],
    [least, most]: [usize; 2],
    cross_check: Option<MilpLimits>,
) -> Vec<Row> {
    let limits = Limits {
        relative_gap: 1e-9,
        nodes: 50_000_000,
        time: Duration::from_secs(60),
        cross_check,
    };
    rows_of(networks, [least, most])
        .map(|(network, property)| {
            let start = Instant::now();
            let clock = || start.elapsed();
            verify(network, &property, &region(), &limits, &clock).expect("valid row")
        })
        .collect()
}

fn rows_of(
    networks: &[OneHiddenLayer],
    [least, most]: [usize; 2],
) -> impl Iterator<Item = (&OneHiddenLayer, Property)> {
    paper_properties()
        .into_iter()
        .map(|property| {
            let named = |network: &&OneHiddenLayer| network.output() == property.network;
            (networks.iter().find(named).expect("ten networks"), property)
        })
        .filter(move |(network, _)| (least..=most).contains(&network.inputs().len()))
}

fn check(rows: &[Row], networks: &[OneHiddenLayer]) {
    for row in rows {
        println!(
            "{:2} {:9} {:?} {:?} [{:.12}, {:.12}] {:?} {:.3} s, {} boxes",
            row.network,
            row.input,
            row.property,
            row.kind,
            row.m_lower,
            row.m_upper,
            row.verdict,
            row.seconds,
            row.nodes
        );
        let place = format!("{}/{} {:?}", row.network, row.input, row.property);
        assert_eq!(row.stop, Stop::Gap, "{place}");
        assert_ne!(row.verdict, Verdict::Undecided, "{place}");
        assert_eq!(row.verdict == Verdict::Proved, row.m_upper <= 0.0, "{place}");
        // The gap asked for.
        assert!(row.m_upper - row.m_lower <= 1e-9 * row.m_lower.abs(), "{place}");
        if row.kind == PropertyKind::OppositeInformational {
            assert_eq!(row.verdict, Verdict::Violated, "{place}");
        }
        let known = KNOWN.iter().find(|known| (known.0, known.1) == (&row.network, &row.input));
        if let (Some((_, _, m, half_unit)), PropertyKind::Physical) = (known, row.kind) {
            assert!((row.m_upper - m).abs() <= *half_unit, "{place}: {} for {m}", row.m_upper);
        }
        check_witness(row, networks, &place);
    }
}

/// The witness, evaluated in ordinary floating point by the network's own formula.
fn check_witness(row: &Row, networks: &[OneHiddenLayer], place: &str) {
    let witness = row.witness.as_ref().expect(place);
    let network =
        networks.iter().find(|network| network.output() == row.network).expect("ten networks");
    let value = |x: f64| {
        let point: Vec<f64> = network
            .inputs()
            .iter()
            .map(|name| if *name == row.input { x } else { witness.point[name] })
            .collect();
        network.evaluate(&point).expect("finite point")
    };
    let rise = row.property.against() * (value(witness.to) - value(witness.from));
    // Outputs of up to about 100 from sums of 248 terms: rounding stays below 1e-11.
    assert!((rise - witness.rise).abs() < 1e-11, "{place}: {rise} {}", witness.rise);
    assert_eq!(witness.rise > 0.0, row.verdict == Verdict::Violated, "{place}");
}

#[test]
fn rows_of_two_to_four_inputs_are_decided_and_known_values_met() {
    let name = "rows_of_two_to_four_inputs_are_decided_and_known_values_met";
    let Some(networks) = crate::weights::published(name) else { return };
    let rows = table(&networks, [2, 4], None);
    check(&rows, &networks);
    assert_eq!(rows.len(), 26);
    // Measured at about 0.2 s on two cores; the bound is the design's.
    assert!(rows.iter().map(|row| row.seconds).sum::<f64>() <= 5.0);
    let proved = rows.iter().filter(|row| row.verdict == Verdict::Proved);
    let proved: Vec<_> = proved.map(|row| (row.network.as_str(), row.input.as_str())).collect();
    assert_eq!(proved, [("X2", "X2"), ("C1", "C1"), ("C1", "u_carbs")]);
}

#[test]
fn rows_of_five_inputs_are_decided_and_known_values_met() {
    let name = "rows_of_five_inputs_are_decided_and_known_values_met";
    let Some(networks) = crate::weights::published(name) else { return };
    let rows = table(&networks, [5, 5], None);
    check(&rows, &networks);
    assert_eq!(rows.len(), 7);
}

#[test]
fn enumeration_agrees_on_every_row_of_two_inputs() {
    let name = "enumeration_agrees_on_every_row_of_two_inputs";
    let Some(networks) = crate::weights::published(name) else { return };
    let rows = table(&networks, [2, 2], None);
    for (row, (network, property)) in rows.iter().zip(rows_of(&networks, [2, 2])) {
        let exact = largest_slope_by_enumeration(network, &property, &region()).expect("planar");
        let place = format!("{}/{}", row.network, row.input);
        assert!(row.m_lower <= exact.m_lower && exact.m_upper <= row.m_upper, "{place}");
        // The gap asked for.
        assert!((row.m_lower - exact.m_lower).abs() <= 1e-9 * row.m_upper.abs(), "{place}");
    }
}

#[test]
fn milp_agrees_on_every_row_of_two_to_four_inputs() {
    let name = "milp_agrees_on_every_row_of_two_to_four_inputs";
    let Some(networks) = crate::weights::published(name) else { return };
    let limits = MilpLimits { time: Duration::from_secs(30), relative_gap: 0.0 };
    let rows = table(&networks, [2, 4], Some(limits));
    for row in &rows {
        let milp = row.milp.as_ref().expect("asked for");
        let attained = milp.m_lower.expect("an incumbent");
        println!(
            "{:2} {:9} {:?} attained {attained:.12} claimed bound {:.12} {:.3} s, {} binaries",
            row.network,
            row.input,
            row.property,
            milp.claimed_bound.expect("a bound"),
            milp.seconds,
            milp.binaries
        );
        let place = format!("{}/{} {:?}", row.network, row.input, row.property);
        assert_eq!(milp.status, MilpStatus::Optimal, "{place}");
        // What is attained can never exceed what is certified, whatever the solver's tolerances.
        assert!(attained <= row.m_upper, "{place}");
        // The gap of branch and bound.
        assert!(attained >= row.m_lower - 1e-9 * row.m_lower.abs(), "{place}: {attained}");
        // The solver's claim is only good to its tolerances: below the truth by 3e-8 on two rows.
        assert_eq!(row.milp_contradicted, Some(false), "{place}");
    }
}
