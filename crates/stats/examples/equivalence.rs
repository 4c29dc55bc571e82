//! The outcomes table of a made-up cohort: twelve people, measured and simulated.
//!
//! `cargo run -p stats --example equivalence`

#![expect(clippy::print_stdout, reason = "an example prints its result")]

use physiology::MgPerDl;
use stats::{Bootstrap, Outcome, Outcomes, StatsError, compare_outcomes, multiplicity, paired};

fn main() -> Result<(), StatsError> {
    let mut actual = Vec::new();
    let mut simulated = Vec::new();
    for person in 0..12 {
        let phase = f64::from(person);
        let level = 120.0 + 6.0 * phase;
        let real = |k: i32| MgPerDl(level + 45.0 * (0.09 * f64::from(k) + phase).sin());
        let model = |k: i32| MgPerDl(level + 2.0 + 42.0 * (0.09 * f64::from(k) + phase).sin());
        actual.push(Outcomes::of((0..288).map(real))?);
        simulated.push(Outcomes::of((0..288).map(model))?);
    }

    println!("metric   actual   simulated   difference [90 % interval]   margin   p");
    let rows = compare_outcomes(&actual, &simulated, 0.05)?;
    for row in &rows {
        println!(
            "{:<6} {:>8.2} {:>10.2} {:>12.2} [{:.2}, {:.2}] {:>10} {:>10.4}",
            row.metric,
            row.actual.mean,
            row.simulated.mean,
            row.difference.value,
            row.difference.lower,
            row.difference.upper,
            row.margin,
            row.p,
        );
    }
    let p: Vec<f64> = rows.iter().map(|row| row.p).collect();
    println!("Holm-adjusted: {:.4?}", multiplicity::holm(&p)?);

    let column =
        |people: &[Outcomes]| -> Vec<f64> { people.iter().map(|o| o.get(Outcome::Tir)).collect() };
    let plan = Bootstrap { replicates: 2000, level: 0.95, seed: 1 };
    let tir = paired::compare(&column(&simulated), &column(&actual), &plan)?;
    println!(
        "TIR difference {:.2} points, 95 % percentile interval [{:.2}, {:.2}] over people",
        tir.difference.value, tir.difference.percentile.lower, tir.difference.percentile.upper,
    );
    Ok(())
}
