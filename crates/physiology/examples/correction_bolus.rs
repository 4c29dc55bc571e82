//! A plant of one's own and something that drives it: a correction bolus at 180 mg/dL.
//!
//!     cargo run --package physiology --example correction_bolus
#![expect(clippy::print_stdout, reason = "an example shows what it found")]

use physiology::{
    Compartment, InputSource, MgPerDl, NonFinite, Plant, SimulationError, States, StepInput, Units,
    simulate,
};

/// Glucose that rises by 2 mg/dL a step and falls by 40 mg/dL a unit at once.
struct Rising;

impl Plant for Rising {
    type State = MgPerDl;

    fn step(&self, glucose: &MgPerDl, input: &StepInput) -> Result<MgPerDl, NonFinite> {
        Ok(*glucose + MgPerDl(2.0 - 40.0 * input.bolus.0))
    }

    fn glucose(&self, glucose: &MgPerDl) -> MgPerDl {
        *glucose
    }

    fn report(&self, glucose: &MgPerDl) -> States {
        let mut states = States::default();
        states[Compartment::Q1] = glucose.0;
        states
    }
}

/// Two units whenever glucose is above 180 mg/dL.
struct Correction;

impl InputSource for Correction {
    fn next(&mut self, _: usize, glucose: MgPerDl) -> Option<StepInput> {
        let bolus = if glucose.0 > 180.0 { Units(2.0) } else { Units(0.0) };
        Some(StepInput { bolus, ..StepInput::default() })
    }
}

fn main() -> Result<(), SimulationError> {
    let run = simulate(&Rising, MgPerDl(150.0), &mut Correction, 48)?;
    for (step, (glucose, input)) in run.glucose(&Rising).iter().zip(&run.inputs).enumerate() {
        if input.bolus.0 > 0.0 {
            println!("step {step}: {glucose:.0}, {}", input.bolus);
        }
    }
    Ok(())
}
