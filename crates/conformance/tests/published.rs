//! The paper's published population weights over one box, against certified values known for some
//! rows.

mod weights;

use std::time::{Duration, Instant};

use conformance::{
    CrossCheck, Limits, OneHiddenLayer, Region, Row, Verdict, paper_properties, verify,
};

/// The box of the published values, scaled units.
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

fn table(networks: &[OneHiddenLayer], limits: &Limits, of: impl Fn(&OneHiddenLayer) -> bool) -> Vec<Row> {
    let region = region();
    let mut rows = Vec::new();
    for property in paper_properties() {
        let network = networks.iter().find(|network| network.output() == property.network);
        let network = network.expect("ten networks");
        if of(network) {
            let start = Instant::now();
            rows.push(verify(network, &property, &region, limits, &|| start.elapsed()).expect("valid row"));
        }
    }
    rows
}

fn print(rows: &[Row]) {
    for row in rows {
        println!("{:?} {:?}\n{:3} {:10} {:?} {:.12e} {:.12e} {:?} {:.3}s nodes {} {:?}", row.witness.as_ref().map(|w|(w.to-w.from,w.rise/(w.to-w.from))), row.milp.as_ref().map(|m|(m.status,m.m_lower,m.claimed_objective,m.claimed_bound,m.binaries,m.seconds)), row.network, row.input, row.property, row.m_lower, row.m_upper, row.verdict, row.seconds, row.nodes, row.stop);
    }
}

#[test]
fn small_rows() {
    let Some(networks) = weights::published("small_rows") else { return };
    let limits = Limits { relative_gap: 1e-9, nodes: 100_000_000, time: Duration::from_secs(30), cross_check: CrossCheck::Milp(conformance::milp::MilpLimits{time:Duration::from_secs(20),relative_gap:0.0}) };
    let rows = table(&networks, &limits, |network| network.inputs().len() <= 4);
    print(&rows);
    let _ = Verdict::Proved;
}

#[test]
fn q1_rows() {
    let Some(networks) = weights::published("q1_rows") else { return };
    let limits = Limits { relative_gap: 0.01, nodes: 100_000_000, time: Duration::from_secs(20), cross_check: CrossCheck::None };
    let rows = table(&networks, &limits, |network| network.inputs().len() == 5 && true);
    print(&rows);
}
