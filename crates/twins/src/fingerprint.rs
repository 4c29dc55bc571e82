//! Hashes that tie a twin to its training data and to its population model.

use nn_statespace::{PopulationModel, Signal};
use physiology::Compartment;
use sha2::{Digest, Sha256};

use crate::prepared::PreparedWindow;

/// SHA-256 of a population model in hexadecimal: wiring, weights and scaler. The clamp and a person's gains
/// on doses are ways of running the model and do not count.
#[must_use]
pub fn population_fingerprint(population: &PopulationModel) -> String {
    let mut hash = Sha256::new();
    let pair = |hash: &mut Sha256, signal: Signal| {
        let pair = population.scaler().of(signal);
        numbers(hash, &[pair.centre, pair.scale]);
    };
    for compartment in Compartment::ALL {
        hash.update(compartment.name());
        for signal in population.wiring().inputs(compartment) {
            hash.update(signal.name());
            hash.update([0]);
        }
        let network = population.network(compartment);
        numbers(&mut hash, network.w1());
        numbers(&mut hash, network.b1());
        numbers(&mut hash, network.w2());
        numbers(&mut hash, &[network.b2()]);
        pair(&mut hash, Signal::State(compartment));
    }
    pair(&mut hash, Signal::Insulin);
    pair(&mut hash, Signal::Carbs);
    hexadecimal(hash)
}

/// SHA-256 of training windows in hexadecimal: starts, inputs and measured glucose.
#[must_use]
pub fn windows_fingerprint(windows: &[PreparedWindow]) -> String {
    let mut hash = Sha256::new();
    for window in windows {
        hash.update((window.steps() as u64).to_le_bytes());
        for (_, value) in window.start().iter() {
            numbers(&mut hash, &[value]);
        }
        for (step, input) in window.inputs().iter().enumerate() {
            numbers(&mut hash, &[input.insulin().0, input.carbs.0, input.rescue.amount.0]);
            numbers(&mut hash, &window.personal[step]);
            // Nothing beside is what every earlier file was trained with.
            if window.added_rates[step] != 0.0 {
                numbers(&mut hash, &[window.added_rates[step]]);
            }
        }
        numbers(&mut hash, window.target());
    }
    hexadecimal(hash)
}

fn numbers(hash: &mut Sha256, values: &[f64]) {
    for value in values {
        hash.update(value.to_le_bytes());
    }
}

fn hexadecimal(hash: Sha256) -> String {
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}
