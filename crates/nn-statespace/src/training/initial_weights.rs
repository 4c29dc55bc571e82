//! Random weights to start from.

use physiology::Compartment;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::network::HiddenLayerNetwork;
use crate::per_compartment::PerCompartment;
use crate::signal::Signal;
use crate::widths::Widths;
use crate::wiring::Wiring;

/// Networks with weights and biases uniform within `1/sqrt(fan-in)` of zero, PyTorch's
/// initialisation of a linear layer, with the output layers' times `output_gain`.
///
/// C1 has no ground truth, so that a network which holds less of it after a meal fits as well as one
/// which holds more. To start on the physical side, which the soft constraint C1 >= 0 means, the
/// output weights of C1 take the signs of the hidden units' weights on carbohydrate, and those of
/// C2 the signs of the weights on C1: both slopes begin positive everywhere.
///
/// Each network draws from its own stream, so that a width does not change its neighbours.
#[must_use]
pub fn initial_networks(
    wiring: &Wiring,
    widths: &Widths,
    output_gain: f64,
    seed: u64,
) -> PerCompartment<HiddenLayerNetwork> {
    PerCompartment::from_fn(|compartment| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        // Stream 0 is left to the shuffling.
        rng.set_stream(1 + compartment as u64);
        let (inputs, hidden) = (wiring.inputs(compartment).len(), widths.of(compartment));
        let mut draw = |count: usize, fan_in: usize, gain: f64| -> Vec<f64> {
            let bound = 1.0 / (fan_in as f64).sqrt();
            // Rounded to f32, in which training goes on.
            (0..count).map(|_| f64::from((gain * rng.random_range(-bound..bound)) as f32)).collect()
        };
        let w1 = draw(hidden * inputs, inputs, 1.0);
        let b1 = draw(hidden, inputs, 1.0);
        let mut w2 = draw(hidden, hidden, output_gain);
        let b2 = draw(1, hidden, output_gain)[0];
        let rising = match compartment {
            Compartment::C1 => Some(Signal::Carbs),
            Compartment::C2 => Some(Signal::State(Compartment::C1)),
            _ => None,
        };
        let place = wiring.inputs(compartment).iter().position(|signal| Some(*signal) == rising);
        if let Some(place) = place {
            for (out, hidden) in w2.iter_mut().zip(w1.chunks_exact(inputs)) {
                *out = out.abs().copysign(hidden[place]);
            }
        }
        HiddenLayerNetwork::new(inputs, w1, b1, w2, b2).expect("widths are positive")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_fixes_the_weights_and_a_width_changes_only_its_own_network() {
        let wiring = Wiring::paper();
        let draw = |widths: &Widths, seed| initial_networks(&wiring, widths, 1.0, seed);
        let quick = Widths::quick();
        assert_eq!(draw(&quick, 7), draw(&quick, 7));
        assert_ne!(draw(&quick, 7), draw(&quick, 8));
        let mut wider = PerCompartment::from_fn(|c| quick.of(c));
        wider[Compartment::I] += 1;
        let (a, b) = (draw(&quick, 7), draw(&Widths::new(wider).expect("positive"), 7));
        for compartment in Compartment::ALL {
            assert_eq!(a[compartment] == b[compartment], compartment != Compartment::I);
        }
    }

    #[test]
    fn carbohydrate_raises_c1_and_c1_raises_c2_from_the_start() {
        let wiring = Wiring::paper();
        let networks = initial_networks(&wiring, &Widths::quick(), 1.0, 3);
        for (compartment, signal) in
            [(Compartment::C1, Signal::Carbs), (Compartment::C2, Signal::State(Compartment::C1))]
        {
            let inputs = wiring.inputs(compartment);
            let index = inputs.iter().position(|s| *s == signal).expect("wired");
            for start in [-3.0, 0.0, 2.0] {
                let mut point = vec![start; inputs.len()];
                let before = networks[compartment].evaluate(&point);
                point[index] += 5.0;
                assert!(networks[compartment].evaluate(&point) > before, "{compartment} {start}");
            }
        }
    }

    #[test]
    fn weights_stay_within_their_bounds() {
        let networks = initial_networks(&Wiring::paper(), &Widths::paper(), 0.1, 1);
        for (compartment, network) in networks.iter() {
            let bound = 1.0 / (network.inputs() as f64).sqrt();
            let most =
                network.w1().iter().chain(network.b1()).fold(0.0, |m: f64, w| m.max(w.abs()));
            assert!(most <= bound && most > 0.9 * bound, "{compartment}: {most} of {bound}");
            let bound = 0.1 / (network.hidden() as f64).sqrt();
            let most = network.w2().iter().fold(0.0, |m: f64, w| m.max(w.abs()));
            assert!(most <= bound && most > 0.8 * bound, "{compartment}: {most} of {bound}");
        }
    }
}
