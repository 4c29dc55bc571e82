//! Residual networks that keep physiology's signs by construction.
//!
//! The population network's properties are proved (crate `conformance`), and a residual network may
//! undo them: nothing keeps its slope by insulin action from being positive. Here the units of each
//! layer fall into three groups. *Rising* units may only rise, *falling* units may only fall along
//! the direction in which a state drives glucose up; *context* units see no state at all. A group
//! takes from itself with weights of at least 0, from the context with any weight, from the other
//! group with none. Rising units count with a weight of at least 0 in the output, falling ones with
//! one of at most 0. The network then has the signs below for every weight that training can find,
//! and a twin with it has whatever signs its population network is proved to have.

use crate::inputs::STATE_INPUTS;
use crate::residual::{HIDDEN, PARAMETERS, ResidualNetwork, SHAPES};

/// Whether training keeps the signs of a residual network's slopes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Signs {
    /// Any network, as in the paper.
    Free,
    /// Only networks whose addition to dQ1/dt does not rise with Q1, X1 and X3, does not fall with C2, and
    /// does not see Q2: what Q2 gives to Q1 it must lose, and a residual network cannot take it from there.
    Kept,
}

/// Signs of the slopes by Q1, Q2, X1, X3 and C2 (paper, conformance properties of Q1); 0 is no slope.
const STATE_SIGNS: [f64; STATE_INPUTS] = [-1.0, 0.0, -1.0, -1.0, 1.0];

/// Of eight units of a layer, three rise, three fall, two see the context alone.
const RISING: usize = 3;
const FALLING: usize = 3;
const OF: usize = 8;

/// What a parameter may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Bound {
    Free,
    AtLeastZero,
    AtMostZero,
    Zero,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Group {
    Rising,
    Falling,
    Context,
}

fn group(unit: usize, units: usize) -> Group {
    if unit < units * RISING / OF {
        Group::Rising
    } else if unit < units * (RISING + FALLING) / OF {
        Group::Falling
    } else {
        Group::Context
    }
}

/// What each parameter may be, in the order in which the roll-out keeps them.
fn bounds() -> Vec<Bound> {
    let mut bounds = Vec::with_capacity(PARAMETERS);
    for (layer, (inputs, outputs)) in SHAPES.into_iter().enumerate() {
        for input in 0..inputs {
            for output in 0..outputs {
                bounds.push(bound(layer, input, output));
            }
        }
        bounds.extend(std::iter::repeat_n(Bound::Free, outputs));
    }
    bounds
}

fn bound(layer: usize, input: usize, output: usize) -> Bound {
    match layer {
        0 => match (STATE_SIGNS.get(input), group(output, HIDDEN[0])) {
            (None, _) => Bound::Free,
            (Some(_), Group::Context) => Bound::Zero,
            (Some(sign), _) if *sign == 0.0 => Bound::Zero,
            (Some(sign), Group::Rising) if *sign > 0.0 => Bound::AtLeastZero,
            (Some(sign), Group::Falling) if *sign < 0.0 => Bound::AtLeastZero,
            (Some(_), _) => Bound::AtMostZero,
        },
        3 => match group(input, HIDDEN[2]) {
            Group::Rising => Bound::AtLeastZero,
            Group::Falling => Bound::AtMostZero,
            Group::Context => Bound::Free,
        },
        _ => match (group(input, HIDDEN[layer - 1]), group(output, HIDDEN[layer])) {
            (Group::Context, _) => Bound::Free,
            (from, to) if from == to => Bound::AtLeastZero,
            _ => Bound::Zero,
        },
    }
}

/// Keeps parameters within what signs allow.
#[derive(Debug, Clone)]
pub(crate) struct Keeper(Vec<Bound>);

impl Keeper {
    /// `None` where everything is allowed.
    pub(crate) fn new(signs: Signs) -> Option<Self> {
        (signs == Signs::Kept).then(|| Self(bounds()))
    }

    /// Moves each parameter to the nearest that is allowed.
    pub(crate) fn keep(&self, parameters: &mut [f32]) {
        for (parameter, bound) in parameters.iter_mut().zip(&self.0) {
            match bound {
                Bound::Free => {}
                Bound::AtLeastZero => *parameter = parameter.max(0.0),
                Bound::AtMostZero => *parameter = parameter.min(0.0),
                Bound::Zero => *parameter = 0.0,
            }
        }
    }

    /// Mirrors each parameter of a fresh network to where it is allowed, so that none starts at
    /// zero that could be anywhere else.
    pub(crate) fn begin(&self, parameters: &mut [f32]) {
        for (parameter, bound) in parameters.iter_mut().zip(&self.0) {
            match bound {
                Bound::Free => {}
                Bound::AtLeastZero => *parameter = parameter.abs(),
                Bound::AtMostZero => *parameter = -parameter.abs(),
                Bound::Zero => *parameter = 0.0,
            }
        }
    }
}

impl ResidualNetwork {
    /// Whether the weights alone show that the network has the signs of [`Signs::Kept`], whatever
    /// its inputs: a proof that needs no search.
    #[must_use]
    pub fn keeps_signs(&self) -> bool {
        let parameters =
            self.layers.iter().flat_map(|layer| layer.weight.iter().chain(&layer.bias));
        parameters.zip(bounds()).all(|(value, bound)| match bound {
            Bound::Free => true,
            Bound::AtLeastZero => *value >= 0.0,
            Bound::AtMostZero => *value <= 0.0,
            Bound::Zero => *value == 0.0,
        })
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    use super::*;
    use crate::inputs::INPUTS;
    use crate::roll_out::{network_of, parameters_of};

    fn random(seed: u64) -> Vec<f32> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (0..PARAMETERS).map(|_| rng.random_range(-0.4..0.4)).collect()
    }

    #[test]
    fn kept_parameters_have_the_signs_everywhere_and_others_do_not() {
        let keeper = Keeper::new(Signs::Kept).expect("something to keep");
        let mut rng = ChaCha8Rng::seed_from_u64(9);
        let (mut broken, mut moved) = (0, [false; STATE_INPUTS]);
        for seed in 0..20 {
            let mut parameters = random(seed);
            assert!(!network_of(&parameters).keeps_signs());
            let free = network_of(&parameters);
            match seed % 2 {
                0 => keeper.keep(&mut parameters),
                _ => keeper.begin(&mut parameters),
            }
            let kept = network_of(&parameters);
            assert!(kept.keeps_signs());
            for _ in 0..200 {
                let input: [f64; INPUTS] = std::array::from_fn(|_| rng.random_range(-2.0..2.0));
                let slopes = kept.evaluate_with_slopes(&input).1;
                for (k, (slope, sign)) in slopes.into_iter().zip(STATE_SIGNS).enumerate() {
                    assert!(slope * sign >= 0.0, "input {k}: {slope}");
                    moved[k] |= slope != 0.0;
                }
                let slopes = free.evaluate_with_slopes(&input).1;
                broken +=
                    usize::from(slopes.iter().zip(STATE_SIGNS).any(|(s, sign)| s * sign < 0.0));
            }
        }
        // Every state is able to act but Q2.
        assert_eq!(moved, STATE_SIGNS.map(|sign| sign != 0.0));
        assert!(broken > 1000, "free networks break signs: {broken}");
    }

    #[test]
    fn a_network_survives_its_vector() {
        let parameters = random(3);
        assert_eq!(parameters_of::<f32>(&network_of(&parameters)), parameters);
        assert!(Keeper::new(Signs::Free).is_none());
    }
}
