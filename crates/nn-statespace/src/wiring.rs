//! Which signals each compartment's network sees: the structure of paper Eq. 2, by name.

use physiology::Compartment;

use crate::error::ModelError;
use crate::per_compartment::PerCompartment;
use crate::signal::Signal;

/// For each compartment the inputs of its network, in the order of the network's columns.
///
/// ```
/// use nn_statespace::{Signal, Wiring};
/// use physiology::Compartment;
///
/// let wiring = Wiring::paper();
/// assert_eq!(
///     wiring.inputs(Compartment::S1),
///     [Signal::State(Compartment::S1), Signal::Insulin],
/// );
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wiring(PerCompartment<Vec<Signal>>);

impl Wiring {
    /// The wiring of paper Eq. 2.
    ///
    /// The paper names the inputs of each network but not their order within it; the order here is
    /// that of the published weights (found by replaying the reference trace under every
    /// permutation), so that weight files of either origin read alike.
    #[must_use]
    pub fn paper() -> Self {
        use Compartment::{C1, C2, I, Q1, Q2, S1, S2, X1, X2, X3};
        let state = Signal::State;
        Self(PerCompartment::from_fn(|compartment| match compartment {
            S1 => vec![state(S1), Signal::Insulin],
            S2 => vec![state(S1), state(S2)],
            I => vec![state(S2), state(I)],
            X1 | X2 | X3 => vec![state(I), state(compartment)],
            Q1 => vec![state(X1), state(X3), state(Q1), state(Q2), state(C2)],
            Q2 => vec![state(X1), state(X2), state(Q1), state(Q2)],
            C1 => vec![state(C1), Signal::Carbs],
            C2 => vec![state(C1), state(C2)],
        }))
    }

    /// A wiring of one's own.
    ///
    /// # Errors
    /// [`ModelError::Wiring`] if a network has no input, or the same input twice.
    pub fn new(inputs: PerCompartment<Vec<Signal>>) -> Result<Self, ModelError> {
        for (network, signals) in inputs.iter() {
            if signals.is_empty() {
                return Err(ModelError::Wiring { network, problem: "no inputs".to_owned() });
            }
            for (position, signal) in signals.iter().enumerate() {
                if signals[..position].contains(signal) {
                    let problem = format!("{signal} appears twice");
                    return Err(ModelError::Wiring { network, problem });
                }
            }
        }
        Ok(Self(inputs))
    }

    /// The inputs of a compartment's network, in the order of the columns of its first matrix.
    #[must_use]
    pub fn inputs(&self, compartment: Compartment) -> &[Signal] {
        &self.0[compartment]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_s1_sees_insulin_and_only_c1_sees_carbs() {
        let wiring = Wiring::paper();
        for compartment in Compartment::ALL {
            let inputs = wiring.inputs(compartment);
            assert_eq!(inputs.contains(&Signal::Insulin), compartment == Compartment::S1);
            assert_eq!(inputs.contains(&Signal::Carbs), compartment == Compartment::C1);
            assert!(inputs.contains(&Signal::State(compartment)), "{compartment} sees itself");
        }
    }

    #[test]
    fn a_repeated_or_absent_input_is_refused() {
        let paper = |c: Compartment| Wiring::paper().inputs(c).to_vec();
        let mut inputs = PerCompartment::from_fn(paper);
        inputs[Compartment::I].push(Signal::State(Compartment::S2));
        let error = Wiring::new(inputs).expect_err("S2 twice");
        assert_eq!(error.to_string(), "wiring of network I: S2 appears twice");
        let mut inputs = PerCompartment::from_fn(paper);
        inputs[Compartment::C2].clear();
        let error = Wiring::new(inputs).expect_err("nothing left");
        assert_eq!(error.to_string(), "wiring of network C2: no inputs");
    }
}
