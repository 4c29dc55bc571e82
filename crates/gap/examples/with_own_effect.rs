//! Diagnoses a cohort with an effect of one's own beside the library.
//!
//!     cargo run -p gap --example with_own_effect -- COHORT
//!
//! The effect is the coffee of `crates/effects/examples/own_effect/caffeine.rs`. The embedded cohort is diagnosed
//! where no folder is given.

#[path = "../../effects/examples/own_effect/caffeine.rs"]
mod caffeine;

use std::path::PathBuf;

use caffeine::Caffeine;
use gap::{Diagnoser, DiagnosisConfig};

#[expect(clippy::print_stdout, reason = "an example shows its result")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let embedded = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/embedded/cohort");
    let folder = std::env::args_os().nth(1).map_or_else(|| embedded.into(), PathBuf::from);
    let cohort = cohort::read_folder(&folder)?;
    let mut library = effects::library();
    library.push(Box::new(Caffeine { habits: vec![vec![7.5], vec![7.5, 13.5]] }));
    let diagnosis = Diagnoser::new(&library, &DiagnosisConfig::working()).run(&cohort, 1)?;
    println!("verdict: {:?}", diagnosis.verdict);
    for candidate in &diagnosis.candidates {
        println!(
            "{:<28} {:>7.1} nats, probability {:.2}",
            candidate.effect, candidate.gain_nats, candidate.probability
        );
    }
    for note in &diagnosis.notes {
        println!("{note}");
    }
    Ok(())
}
