//! Makes and simulates weeks of the paper's development set, on all cores, and counts them.
//!
//! `cargo run -p ode-sim --example development_weeks [WEEKS]` (480 weeks unless told; 46200 is all)

use std::time::Instant;

use ode_sim::development_set::Origin;
use ode_sim::{DevelopmentPlan, DevelopmentSet, OdeError};
use physiology::Plant;

#[expect(clippy::print_stdout, reason = "an example shows its result")]
fn main() -> Result<(), OdeError> {
    let wanted = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(480);
    let set = DevelopmentSet::new(DevelopmentPlan::paper(1))?;
    let weeks = wanted.min(set.len());
    let clock = Instant::now();
    let mut counts = [0_usize; 3];
    let (mut lowest, mut highest) = (f64::MAX, f64::MIN);
    // The end of the set holds the additional weeks: take both ends.
    let from_end = weeks * set.plan().additional_weeks / set.len();
    for range in [0..weeks - from_end, set.len() - from_end..set.len()] {
        for start in range.clone().step_by(256) {
            for (week, run) in set.simulate(start..(start + 256).min(range.end))? {
                counts[match week.origin {
                    Origin::Combination => 0,
                    Origin::AdditionalLow => 1,
                    Origin::AdditionalHigh => 2,
                }] += 1;
                for state in &run.states {
                    let glucose = set.plant().glucose(state).0;
                    lowest = lowest.min(glucose);
                    highest = highest.max(glucose);
                }
            }
        }
    }
    let seconds = clock.elapsed().as_secs_f64();
    let [combinations, low, high] = counts;
    println!(
        "{combinations} weeks of combinations, {low} low and {high} high ones in {seconds:.2} s"
    );
    println!("glucose from {lowest:.1} to {highest:.1} mg/dL");
    println!("the whole set at this pace: {:.1} s", seconds * set.len() as f64 / weeks as f64);
    Ok(())
}
