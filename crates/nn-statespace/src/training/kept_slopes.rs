//! Slopes kept as physiology has them while a network is trained.

use physiology::Compartment;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::kernel::ParameterLayout;
use crate::structure::{UnitRole, products, slope_sign, unit_role};
use crate::training_set::WindowSet;
use crate::wiring::{Signal, Wiring};

/// Streams of the seed from here on are those of the points of each update.
const FIRST_POINTS: u64 = 1 << 48;

/// What training does about the signs of slopes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SlopeRule {
    /// Nothing (paper).
    Free,
    /// Units have roles, by [`unit_role`](crate::structure::unit_role()): weights of monotone units are put back
    /// to their signs after each update, and the sums that stand for products pay for slopes against physiology.
    Kept(ProductPenalty),
}

/// What a sum of units that stands for a product pays: `weight` times the mean, over points of its two states, of
/// what its slopes lack to `margin`.
///
/// Points are drawn anew for each update, uniformly from the states' scaled range, from physical zero to
/// `reach` times what training rows hold.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ProductPenalty {
    /// Factor of the mean.
    pub weight: f64,
    /// Points an update.
    pub points: usize,
    /// Least slope in the right direction, scaled rate a minute per scaled state.
    pub margin: f64,
    /// Highest point over the highest training row, both from physical zero.
    pub reach: f64,
}

impl ProductPenalty {
    /// The values in use.
    #[must_use]
    pub fn working() -> Self {
        Self { weight: 10.0, points: 64, margin: 2e-4, reach: 1.2 }
    }
}

/// Puts slopes back.
#[derive(Debug, Clone)]
pub(super) struct SlopeKeeper {
    rule: SlopeRule,
    seed: u64,
    bounds: Vec<(usize, Bound)>,
    products: Vec<Product>,
}

/// What a weight is held to.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Bound {
    Zero,
    /// Sign of what is allowed.
    Sign(f32),
}

/// A sum of units that stands for a product of two states.
#[derive(Debug, Clone)]
struct Product {
    /// Places of each unit's weights on the two states, of its bias and of its output weight.
    units: Vec<[usize; 4]>,
    /// Signs that the slopes by the two states have to have.
    signs: [f32; 2],
    /// Scaled range of the two states.
    range: [(f32, f32); 2],
}

impl SlopeKeeper {
    pub(super) fn new(
        rule: SlopeRule,
        layout: &ParameterLayout,
        windows: &WindowSet,
        seed: u64,
    ) -> Self {
        let mut keeper = Self { rule, seed, bounds: Vec::new(), products: Vec::new() };
        let SlopeRule::Kept(penalty) = rule else { return keeper };
        let range = |signal: Signal| {
            let constants = windows.scaler().of(signal);
            let zero = -constants.centre / constants.scale;
            let most = zero + penalty.reach * (windows.bounds(signal).1 - zero);
            (zero as f32, most as f32)
        };
        for network in Compartment::ALL {
            keeper.add(network, layout, &range);
        }
        keeper
    }

    /// The bounds and products of a network; `range` is that of a state, scaled.
    fn add(
        &mut self,
        network: Compartment,
        layout: &ParameterLayout,
        range: &impl Fn(Signal) -> (f32, f32),
    ) {
        let wiring = Wiring::paper();
        let (inputs, span) = (wiring.inputs(network), layout.of(network));
        let place = |unit: usize, input: usize| span.w1().start + unit * span.inputs() + input;
        let roles = (0..span.hidden()).map(|unit| unit_role(network, unit));
        for (unit, role) in roles.enumerate() {
            match role {
                UnitRole::Monotone(own) => {
                    let own = own.factor();
                    self.bounds.push((span.w2().start + unit, Bound::Sign(own)));
                    for (input, signal) in inputs.iter().enumerate() {
                        let sign = own * slope_sign(network, *signal).factor();
                        self.bounds.push((place(unit, input), Bound::Sign(sign)));
                    }
                }
                UnitRole::Product(pair) => {
                    for (input, signal) in inputs.iter().enumerate() {
                        if !pair.map(Signal::State).contains(signal) {
                            self.bounds.push((place(unit, input), Bound::Zero));
                        }
                    }
                }
            }
        }
        for pair in products(network) {
            let signals = pair.map(Signal::State);
            let column = |signal: Signal| {
                inputs.iter().position(|input| *input == signal).expect("products are wired")
            };
            let [first, second] = signals.map(column);
            let units = (0..span.hidden())
                .filter(|unit| unit_role(network, *unit) == UnitRole::Product(*pair))
                .map(|unit| {
                    let (bias, out) = (span.b1().start + unit, span.w2().start + unit);
                    [place(unit, first), place(unit, second), bias, out]
                })
                .collect();
            self.products.push(Product {
                units,
                signs: signals.map(|signal| slope_sign(network, signal).factor()),
                range: signals.map(range),
            });
        }
    }

    /// Gives weights that were drawn without regard to signs their roles: sizes stay, signs become those that are
    /// asked for.
    pub(super) fn orient(&self, parameters: &mut [f32]) {
        for (place, bound) in &self.bounds {
            let weight = &mut parameters[*place];
            *weight = match bound {
                Bound::Zero => 0.0,
                Bound::Sign(sign) => weight.abs() * sign,
            };
        }
    }

    /// Puts weights that have left their signs to zero.
    pub(super) fn project(&self, parameters: &mut [f32]) {
        for (place, bound) in &self.bounds {
            let weight = &mut parameters[*place];
            match bound {
                Bound::Sign(sign) if *weight * sign > 0.0 => {}
                _ => *weight = 0.0,
            }
        }
    }

    /// Adds the slopes of what is paid at the points of an update.
    pub(super) fn add_penalty(&self, parameters: &[f32], update: u32, gradient: &mut [f32]) {
        let SlopeRule::Kept(penalty) = self.rule else { return };
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(FIRST_POINTS + u64::from(update));
        let (margin, share) =
            (penalty.margin as f32, (penalty.weight / penalty.points.max(1) as f64) as f32);
        for product in &self.products {
            for _ in 0..penalty.points {
                let point = product.range.map(|(low, high)| rng.random_range(low..high));
                product.add_penalty(point, margin, share, parameters, gradient);
            }
        }
    }
}

impl Product {
    /// The slopes by the two states at a point.
    fn slopes(&self, point: [f32; 2], parameters: &[f32]) -> [f32; 2] {
        let mut slopes = [0.0; 2];
        for [first, second, bias, out] in &self.units {
            let weights = [parameters[*first], parameters[*second]];
            let activation = weights[0] * point[0] + weights[1] * point[1] + parameters[*bias];
            if activation > 0.0 {
                slopes[0] += parameters[*out] * weights[0];
                slopes[1] += parameters[*out] * weights[1];
            }
        }
        slopes
    }

    fn add_penalty(
        &self,
        point: [f32; 2],
        margin: f32,
        share: f32,
        parameters: &[f32],
        gradient: &mut [f32],
    ) {
        let slopes = self.slopes(point, parameters);
        // By how much a slope in the right direction lowers what is paid.
        let relief: [f32; 2] = std::array::from_fn(|k| {
            if self.signs[k] * slopes[k] < margin { -share * self.signs[k] } else { 0.0 }
        });
        if relief == [0.0; 2] {
            return;
        }
        for [first, second, bias, out] in &self.units {
            let weights = [parameters[*first], parameters[*second]];
            let activation = weights[0] * point[0] + weights[1] * point[1] + parameters[*bias];
            if activation > 0.0 {
                gradient[*out] += relief[0] * weights[0] + relief[1] * weights[1];
                gradient[*first] += relief[0] * parameters[*out];
                gradient[*second] += relief[1] * parameters[*out];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::training::initial_networks;
    use crate::widths::Widths;

    /// A product whose units are those of the whole vector: two weights, a bias, an output weight each.
    fn product(units: usize) -> Product {
        Product {
            units: (0..units).map(|unit| std::array::from_fn(|k| 4 * unit + k)).collect(),
            signs: [-1.0, 1.0],
            range: [(-1.0, 2.0), (-2.0, 1.0)],
        }
    }

    #[test]
    fn what_is_paid_has_the_slopes_that_are_added() {
        let product = product(12);
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let parameters: Vec<f32> = (0..48).map(|_| rng.random_range(-1.0..1.0)).collect();
        let (margin, share) = (0.05, 0.7);
        let paid = |parameters: &[f32], point| {
            let slopes = product.slopes(point, parameters);
            let lacking = slopes.iter().zip(product.signs).map(|(s, sign)| margin - sign * s);
            lacking.map(|lack| f64::from(share * lack.max(0.0))).sum::<f64>()
        };
        let mut compared = 0;
        for _ in 0..40 {
            let point = product.range.map(|(low, high)| rng.random_range(low..high));
            let mut gradient = vec![0.0; parameters.len()];
            product.add_penalty(point, margin, share, &parameters, &mut gradient);
            for (place, slope) in gradient.iter().enumerate() {
                let moved = |by: f32| {
                    let mut parameters = parameters.clone();
                    parameters[place] += by;
                    parameters
                };
                let (above, below) = (moved(1e-3), moved(-1e-3));
                // Where no unit and no hinge turns over between the two, what is paid is linear in a weight.
                let signs = |p: &[f32]| -> Vec<bool> {
                    let slopes = product.slopes(point, p);
                    let hinges =
                        slopes.iter().zip(product.signs).map(|(s, sign)| sign * s < margin);
                    let units = product.units.iter().map(|[a, b, bias, _]| {
                        p[*a] * point[0] + p[*b] * point[1] + p[*bias] > 0.0
                    });
                    hinges.chain(units).collect()
                };
                if signs(&above) != signs(&below) {
                    continue;
                }
                let difference = (paid(&above, point) - paid(&below, point)) / 2e-3;
                // Rounding of single-precision sums over the distance.
                assert!(
                    (difference - f64::from(*slope)).abs() < 2e-3,
                    "{place}: {difference} {slope}"
                );
                compared += usize::from(*slope != 0.0);
            }
        }
        assert!(compared > 100, "{compared}");
    }

    #[test]
    fn weights_that_leave_their_signs_are_put_to_zero_and_others_stay() {
        let (wiring, widths) = (Wiring::paper(), Widths::quick());
        let layout = ParameterLayout::new(&wiring, &widths);
        let mut keeper = SlopeKeeper {
            rule: SlopeRule::Free,
            seed: 0,
            bounds: Vec::new(),
            products: Vec::new(),
        };
        for network in Compartment::ALL {
            keeper.add(network, &layout, &|_| (-1.0, 1.0));
        }
        let networks = initial_networks(&wiring, &widths, 1.0, 1);
        let mut parameters: Vec<f32> = layout.flatten(&networks).expect("of these widths");
        let drawn = parameters.clone();
        keeper.orient(&mut parameters);
        let oriented = parameters.clone();
        assert_ne!(oriented, drawn);
        keeper.project(&mut parameters);
        assert_eq!(parameters, oriented, "oriented weights have their signs");
        for weight in &mut parameters {
            *weight = -*weight;
        }
        keeper.project(&mut parameters);
        for (place, bound) in &keeper.bounds {
            assert_eq!(parameters[*place], 0.0, "{bound:?}");
        }
        let held: std::collections::HashSet<usize> =
            keeper.bounds.iter().map(|(place, _)| *place).collect();
        for place in (0..drawn.len()).filter(|place| !held.contains(place)) {
            assert_eq!(parameters[place], -drawn[place], "biases and product units are free");
        }
    }
}
