//! Verifies a hand-made network of two inputs that should fall in `x` and rise in `u`, and does
//! the latter only.
//!
//!     cargo run -p conformance --example small_network

use std::time::{Duration, Instant};

use conformance::milp::MilpLimits;
use conformance::{Direction, Limits, OneHiddenLayer, Property, PropertyKind, Region, verify};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // dx/dt = u/2 - x/4, bent upwards once x passes 3 with u small.
    let network = OneHiddenLayer::new(
        "x",
        vec!["x".to_owned(), "u".to_owned()],
        vec![1.0, 0.0, 0.0, 1.0, 1.0, -1.0],
        vec![0.0, 0.0, -3.0],
        vec![-0.25, 0.5, 0.375],
        0.0,
    )?;
    let region = Region::scaled([("x", [0.0, 5.0]), ("u", [0.0, 10.0])])?;
    let limits = Limits {
        relative_gap: 1e-9,
        nodes: 1_000_000,
        time: Duration::from_secs(10),
        cross_check: Some(MilpLimits { time: Duration::from_secs(10), relative_gap: 0.0 }),
    };
    let start = Instant::now();
    let clock = || start.elapsed();
    let mut rows = Vec::new();
    for (input, direction) in [("x", Direction::Decreasing), ("u", Direction::Increasing)] {
        let property = Property {
            network: "x".to_owned(),
            input: input.to_owned(),
            direction,
            kind: PropertyKind::Physical,
        };
        rows.push(verify(&network, &property, &region, &limits, &clock)?);
    }
    let text = serde_json::to_string_pretty(&rows)?;
    #[expect(clippy::print_stdout, reason = "an example shows its result")]
    {
        println!("{text}");
    }
    Ok(())
}
