//! How many hidden units each network has.

use physiology::Compartment;

use crate::error::ModelError;
use crate::per_compartment::PerCompartment;

/// Hidden units of each compartment's network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Widths(PerCompartment<usize>);

impl Widths {
    /// The widths of the published weights: Q1 248, Q2 80, S1 174, S2 60, I 197, X1 191, X2 101,
    /// X3 127, C1 149, C2 140 (found by the authors with Bayesian optimisation; 6,782 parameters).
    #[must_use]
    pub fn paper() -> Self {
        Self(PerCompartment::from_fn(|compartment| match compartment {
            Compartment::S1 => 174,
            Compartment::S2 => 60,
            Compartment::I => 197,
            Compartment::X1 => 191,
            Compartment::X2 => 101,
            Compartment::X3 => 127,
            Compartment::Q1 => 248,
            Compartment::Q2 => 80,
            Compartment::C1 => 149,
            Compartment::C2 => 140,
        }))
    }

    /// Small widths that train in minutes: 32 for Q1, which has five inputs, and 12 elsewhere.
    #[must_use]
    pub fn quick() -> Self {
        Self(PerCompartment::from_fn(|compartment| match compartment {
            Compartment::Q1 => 32,
            _ => 12,
        }))
    }

    /// Widths of one's own.
    ///
    /// # Errors
    /// [`ModelError::NoHiddenUnits`] if one of them is 0.
    pub fn new(widths: PerCompartment<usize>) -> Result<Self, ModelError> {
        match widths.iter().find(|(_, width)| **width == 0) {
            Some((network, _)) => Err(ModelError::NoHiddenUnits(network)),
            None => Ok(Self(widths)),
        }
    }

    /// Hidden units of one compartment's network.
    #[must_use]
    pub fn of(&self, compartment: Compartment) -> usize {
        self.0[compartment]
    }

    /// Hidden units of all networks together.
    #[must_use]
    pub fn total(&self) -> usize {
        self.0.values().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wiring::Wiring;

    #[test]
    fn the_papers_widths_give_the_papers_parameter_count() {
        let (widths, wiring) = (Widths::paper(), Wiring::paper());
        let parameters: usize = Compartment::ALL
            .into_iter()
            .map(|c| widths.of(c) * (wiring.inputs(c).len() + 2) + 1)
            .sum();
        assert_eq!(parameters, 6782); // paper, section on the network architecture
    }

    #[test]
    fn a_network_without_hidden_units_is_refused() {
        let error = Widths::new(PerCompartment::from_fn(|c| usize::from(c != Compartment::X2)))
            .expect_err("X2 has none");
        assert_eq!(error.to_string(), "network X2 has no hidden units; give it at least one");
    }
}
