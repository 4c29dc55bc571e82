//! All weights of the ten networks as one vector.

use std::ops::Range;

use physiology::Compartment;

use super::real::Real;
use crate::error::ModelError;
use crate::network::{HiddenLayerNetwork, shaped};
use crate::per_compartment::PerCompartment;
use crate::widths::Widths;
use crate::wiring::Wiring;

/// Where each weight of each network stands in a vector of all of them.
///
/// Networks follow [`Compartment::ALL`]. Within one stand its `w1`, shape (hidden, inputs),
/// row-major, its `b1` and `w2`, shape (hidden) each, and its `b2`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ParameterLayout {
    networks: PerCompartment<NetworkSpan>,
    /// Number of weights.
    pub(super) len: usize,
}

/// The weights of one network among those of all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NetworkSpan {
    start: usize,
    /// Inputs of the network.
    pub(crate) inputs: usize,
    /// Hidden units of the network.
    pub(crate) hidden: usize,
}

impl NetworkSpan {
    /// Weights of the hidden layer, shape (hidden, inputs), row-major.
    #[must_use]
    pub fn w1(&self) -> Range<usize> {
        self.start..self.start + self.hidden * self.inputs
    }

    /// Biases of the hidden layer.
    #[must_use]
    pub fn b1(&self) -> Range<usize> {
        let start = self.w1().end;
        start..start + self.hidden
    }

    /// Weights of the output.
    #[must_use]
    pub fn w2(&self) -> Range<usize> {
        let start = self.b1().end;
        start..start + self.hidden
    }

    /// Bias of the output.
    #[must_use]
    pub fn b2(&self) -> usize {
        self.w2().end
    }
}

impl ParameterLayout {
    /// The layout of networks of these widths.
    #[must_use]
    pub fn new(wiring: &Wiring, widths: &Widths) -> Self {
        let mut len = 0;
        let networks = PerCompartment::from_fn(|compartment| {
            let inputs = wiring.inputs(compartment).len();
            let span = NetworkSpan { start: len, inputs, hidden: widths.of(compartment) };
            len = span.b2() + 1;
            span
        });
        Self { networks, len }
    }

    /// Where the weights of one network stand.
    #[must_use]
    pub fn of(&self, compartment: Compartment) -> &NetworkSpan {
        &self.networks[compartment]
    }

    /// The weights of `networks` as one vector.
    ///
    /// # Errors
    /// [`ModelError::Shape`] if a network has other inputs or another width.
    pub fn flatten<T: Real>(
        &self,
        networks: &PerCompartment<HiddenLayerNetwork>,
    ) -> Result<Vec<T>, ModelError> {
        let mut parameters = Vec::with_capacity(self.len);
        for (compartment, network) in networks.iter() {
            let span = self.of(compartment);
            let expected = [span.hidden, span.inputs];
            let found = [network.hidden(), network.inputs()];
            shaped(format_args!("{compartment}.hidden.weight"), &expected, &found)?;
            let b2 = [network.b2()];
            let parts = [network.w1(), network.b1(), network.w2(), &b2];
            parameters.extend(parts.into_iter().flatten().map(|weight| T::of(*weight)));
        }
        Ok(parameters)
    }

    /// The networks with these weights.
    ///
    /// # Errors
    /// [`ModelError::Shape`] if there are more or fewer weights, [`ModelError::NotFinite`] if one of
    /// them is not a finite number.
    pub fn networks<T: Real>(
        &self,
        parameters: &[T],
    ) -> Result<PerCompartment<HiddenLayerNetwork>, ModelError> {
        shaped("parameters", &[self.len], &[parameters.len()])?;
        let wide = |range: Range<usize>| -> Vec<f64> {
            parameters[range].iter().map(|weight| weight.to_f64()).collect()
        };
        PerCompartment::try_from_fn(|compartment| {
            let span = self.of(compartment);
            HiddenLayerNetwork::new(
                span.inputs,
                wide(span.w1()),
                wide(span.b1()),
                wide(span.w2()),
                parameters[span.b2()].to_f64(),
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::training::initial_networks;

    #[test]
    fn networks_survive_the_vector() {
        let (wiring, widths) = (Wiring::paper(), Widths::paper());
        let layout = ParameterLayout::new(&wiring, &widths);
        assert_eq!(layout.len, 6782); // paper, section on the network architecture
        let networks = initial_networks(&wiring, &widths, 1.0, 3);
        let mut parameters: Vec<f32> = layout.flatten(&networks).expect("of these widths");
        assert_eq!(layout.networks(&parameters).expect("finite"), networks);
        parameters[layout.of(Compartment::X2).b2()] = f32::NAN;
        let error = layout.networks(&parameters).expect_err("not a number");
        assert_eq!(error.to_string(), "tensor output.bias: entry 0 is not a finite number");
        parameters.pop();
        assert!(layout.networks(&parameters).is_err());
        let other = initial_networks(&wiring, &Widths::quick(), 1.0, 3);
        assert!(layout.flatten::<f32>(&other).is_err());
    }
}
