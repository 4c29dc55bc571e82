//! Slopes kept as physiology has them while a network is trained.

use physiology::Compartment;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::kernel::ParameterLayout;
use crate::signal::Signal;
use crate::structure::{UnitRole, products, slope_sign, unit_role};
use crate::training_set::WindowSet;
use crate::wiring::Wiring;

/// Most that a state's own monotone units may add up to as the slope of its rate by the state, per minute: below two
/// over a step of 5 min, so that a roll-out never swings itself up; a quarter of it beside a product, which has a share of
/// its own.
const MOST_OWN_SLOPE: f32 = 0.39;
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
/// what its slopes lack to `margin`, and as much again over linear pieces.
///
/// Points are drawn anew for each update, uniformly from the states' scaled range, from physical zero to
/// `reach` times what training rows hold. Pieces are those on both sides of the kink of one unit, drawn anew as well: every
/// piece borders on a kink, so that the smallest is met as often as the largest.
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
    /// Places of weights with the sign that each may have; 0 where a weight has to be 0.
    bounds: Vec<(usize, f32)>,
    products: Vec<Product>,
    own_slopes: Vec<OwnSlope>,
}

/// A network's slope by its own state, as far as monotone units make it.
#[derive(Debug, Clone)]
struct OwnSlope {
    /// Places of each unit's weight on the state and of its output weight.
    units: Vec<[usize; 2]>,
    most: f32,
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
        let (bounds, products, own_slopes) = (Vec::new(), Vec::new(), Vec::new());
        let mut keeper = Self { rule, seed, bounds, products, own_slopes };
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
        let place = |unit: usize, input: usize| span.w1().start + unit * span.inputs + input;
        let roles = (0..span.hidden).map(|unit| unit_role(network, unit));
        for (unit, role) in roles.enumerate() {
            match role {
                UnitRole::Monotone(own) => {
                    let own = own.factor();
                    self.bounds.push((span.w2().start + unit, own));
                    for (input, signal) in inputs.iter().enumerate() {
                        let sign = own * slope_sign(network, *signal).factor();
                        self.bounds.push((place(unit, input), sign));
                    }
                }
                UnitRole::Product(pair) => {
                    for (input, signal) in inputs.iter().enumerate() {
                        if !pair.map(Signal::State).contains(signal) {
                            self.bounds.push((place(unit, input), 0.0));
                        }
                    }
                }
            }
        }
        let own = inputs.iter().position(|signal| *signal == Signal::State(network));
        if let Some(own) = own {
            let monotone = (0..span.hidden)
                .filter(|unit| matches!(unit_role(network, *unit), UnitRole::Monotone(_)));
            let share = if products(network).is_empty() { 1.0 } else { 0.25 };
            self.own_slopes.push(OwnSlope {
                units: monotone.map(|unit| [place(unit, own), span.w2().start + unit]).collect(),
                most: share * MOST_OWN_SLOPE,
            });
        }
        for pair in products(network) {
            let signals = pair.map(Signal::State);
            let column = |signal: Signal| {
                inputs.iter().position(|input| *input == signal).expect("products are wired")
            };
            let [first, second] = signals.map(column);
            let units = (0..span.hidden)
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
        for (place, sign) in &self.bounds {
            parameters[*place] = parameters[*place].abs() * sign;
        }
    }

    /// Puts weights that have left their signs to zero, and scales down weights on a network's own state that add up
    /// to more than is stable.
    pub(super) fn project(&self, parameters: &mut [f32]) {
        for (place, sign) in &self.bounds {
            let weight = &mut parameters[*place];
            *weight = if *weight * sign > 0.0 { *weight } else { 0.0 };
        }
        for OwnSlope { units, most } in &self.own_slopes {
            let slopes = units.iter().map(|[own, out]| (parameters[*own] * parameters[*out]).abs());
            let sum: f32 = slopes.sum();
            if sum > *most {
                for [own, _] in units {
                    parameters[*own] *= most / sum;
                }
            }
        }
    }

    /// Whether the slopes of every product have their signs on all linear pieces, in single precision.
    pub(super) fn holds(&self, parameters: &[f32]) -> bool {
        self.products.iter().all(|product| {
            let right = |on: &[bool]| {
                let slopes = product.slopes(on, parameters);
                slopes.iter().zip(product.signs).all(|(slope, sign)| sign * slope >= 0.0)
            };
            let corner = product.range.map(|(low, _)| low);
            right(&product.active(corner, parameters))
                && (0..product.units.len()).all(|unit| {
                    product.along_kink(unit, parameters).into_iter().all(|middle| {
                        let mut on = product.active(middle, parameters);
                        [true, false].into_iter().all(|side| {
                            on[unit] = side;
                            right(&on)
                        })
                    })
                })
        })
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
                let on = product.active(point, parameters);
                product.add_penalty(&on, margin, share, parameters, gradient);
            }
            if product.units.is_empty() {
                continue;
            }
            let unit = rng.random_range(0..product.units.len());
            let middles = product.along_kink(unit, parameters);
            let share = (penalty.weight / (2 * middles.len()).max(1) as f64) as f32;
            for middle in middles {
                let mut on = product.active(middle, parameters);
                for side in [true, false] {
                    on[unit] = side;
                    product.add_penalty(&on, margin, share, parameters, gradient);
                }
            }
        }
    }
}

impl Product {
    /// Which units are active at a point.
    fn active(&self, point: [f32; 2], parameters: &[f32]) -> Vec<bool> {
        let at = |[first, second, bias, _]: &[usize; 4]| {
            parameters[*first] * point[0] + parameters[*second] * point[1] + parameters[*bias]
        };
        self.units.iter().map(|unit| at(unit) > 0.0).collect()
    }

    /// The slopes by the two states where these units are active.
    fn slopes(&self, on: &[bool], parameters: &[f32]) -> [f32; 2] {
        let mut slopes = [0.0; 2];
        for ([first, second, _, out], on) in self.units.iter().zip(on) {
            if *on {
                slopes[0] += parameters[*out] * parameters[*first];
                slopes[1] += parameters[*out] * parameters[*second];
            }
        }
        slopes
    }

    /// A point between each two neighbouring kinks of other units on the kink of one, within the range.
    fn along_kink(&self, unit: usize, parameters: &[f32]) -> Vec<[f32; 2]> {
        let line = |unit: usize| {
            let [first, second, bias, _] = self.units[unit];
            ([parameters[first], parameters[second]], parameters[bias])
        };
        let (weights, bias) = line(unit);
        let width = self.range.map(|(low, high)| high - low);
        // The state along which the kink is the less steep is the one that counts its points.
        let run = usize::from((weights[0] * width[0]).abs() > (weights[1] * width[1]).abs());
        let rise = 1 - run;
        if weights[rise] == 0.0 {
            return Vec::new();
        }
        let (slope, offset) = (-weights[run] / weights[rise], -bias / weights[rise]);
        let (mut low, mut high) = self.range[run];
        let (least, most) = self.range[rise];
        if slope == 0.0 {
            if !(least..=most).contains(&offset) {
                return Vec::new();
            }
        } else {
            let ends = [(least - offset) / slope, (most - offset) / slope];
            low = low.max(ends[0].min(ends[1]));
            high = high.min(ends[0].max(ends[1]));
        }
        if low >= high {
            return Vec::new();
        }
        let mut crossings = vec![low, high];
        for other in (0..self.units.len()).filter(|other| *other != unit) {
            let (weights, bias) = line(other);
            let along = weights[run] + weights[rise] * slope;
            let crossing = -(bias + weights[rise] * offset) / along;
            if crossing > low && crossing < high {
                crossings.push(crossing);
            }
        }
        crossings.sort_by(f32::total_cmp);
        let middles = crossings.windows(2).filter(|pair| pair[0] < pair[1]).map(|pair| {
            let middle = 0.5 * (pair[0] + pair[1]);
            let mut point = [0.0; 2];
            (point[run], point[rise]) = (middle, slope * middle + offset);
            point
        });
        middles.collect()
    }

    fn add_penalty(
        &self,
        on: &[bool],
        margin: f32,
        share: f32,
        parameters: &[f32],
        gradient: &mut [f32],
    ) {
        let slopes = self.slopes(on, parameters);
        // By how much a slope in the right direction lowers what is paid.
        let relief: [f32; 2] = std::array::from_fn(|k| {
            if self.signs[k] * slopes[k] < margin { -share * self.signs[k] } else { 0.0 }
        });
        if relief == [0.0; 2] {
            return;
        }
        for ([first, second, _, out], on) in self.units.iter().zip(on) {
            if *on {
                let (weights, output) =
                    ([parameters[*first], parameters[*second]], parameters[*out]);
                gradient[*out] += relief[0] * weights[0] + relief[1] * weights[1];
                gradient[*first] += relief[0] * output;
                gradient[*second] += relief[1] * output;
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
            let slopes = product.slopes(&product.active(point, parameters), parameters);
            let lacking = slopes.iter().zip(product.signs).map(|(s, sign)| margin - sign * s);
            lacking.map(|lack| f64::from(share * lack.max(0.0))).sum::<f64>()
        };
        let mut compared = 0;
        for _ in 0..40 {
            let point = product.range.map(|(low, high)| rng.random_range(low..high));
            let mut gradient = vec![0.0; parameters.len()];
            let on = product.active(point, &parameters);
            product.add_penalty(&on, margin, share, &parameters, &mut gradient);
            for (index, slope) in gradient.iter().enumerate() {
                let moved = |by: f32| {
                    let mut parameters = parameters.clone();
                    parameters[index] += by;
                    parameters
                };
                let (above, below) = (moved(1e-3), moved(-1e-3));
                // Where no unit and no hinge turns over between the two, what is paid is linear in a weight.
                let signs = |p: &[f32]| -> Vec<bool> {
                    let on = product.active(point, p);
                    let slopes = product.slopes(&on, p);
                    let hinges =
                        slopes.iter().zip(product.signs).map(|(s, sign)| sign * s < margin);
                    let units = on.iter().copied();
                    hinges.chain(units).collect()
                };
                if signs(&above) != signs(&below) {
                    continue;
                }
                let difference = (paid(&above, point) - paid(&below, point)) / 2e-3;
                // Rounding of single-precision sums over the distance.
                assert!(
                    (difference - f64::from(*slope)).abs() < 2e-3,
                    "{index}: {difference} {slope}"
                );
                compared += usize::from(*slope != 0.0);
            }
        }
        assert!(compared > 100, "{compared}");
    }

    #[test]
    fn points_along_a_kink_lie_on_it_and_between_all_others() {
        let product = product(30);
        let mut rng = ChaCha8Rng::seed_from_u64(6);
        let parameters: Vec<f32> = (0..120).map(|_| rng.random_range(-1.0..1.0)).collect();
        let mut patterns = std::collections::HashSet::new();
        let mut met = 0;
        for unit in 0..30 {
            let points = product.along_kink(unit, &parameters);
            met += usize::from(!points.is_empty());
            let mut before: Option<Vec<bool>> = None;
            for point in points {
                for (value, (low, high)) in point.into_iter().zip(product.range) {
                    assert!((low - 1e-4..=high + 1e-4).contains(&value), "{point:?}");
                }
                let [first, second, bias, _] = product.units[unit];
                let activation =
                    parameters[first] * point[0] + parameters[second] * point[1] + parameters[bias];
                assert!(activation.abs() < 1e-5, "on the kink of {unit}: {activation}");
                let mut on = product.active(point, &parameters);
                on[unit] = true;
                if let Some(before) = before.replace(on.clone()) {
                    let turned = before.iter().zip(&on).filter(|(a, b)| a != b).count();
                    assert_eq!(turned, 1, "one kink is crossed from each point to the next");
                }
                patterns.insert(on.clone());
                on[unit] = false;
                patterns.insert(on);
            }
        }
        assert!(met > 15);
        let keeper = SlopeKeeper {
            rule: SlopeRule::Free,
            seed: 0,
            bounds: Vec::new(),
            products: vec![product.clone()],
            own_slopes: Vec::new(),
        };
        let right = patterns.iter().all(|on| {
            let slopes = product.slopes(on, &parameters);
            slopes.iter().zip(product.signs).all(|(slope, sign)| sign * slope >= 0.0)
        });
        assert_eq!(keeper.holds(&parameters), right);
        assert!(!right && keeper.holds(&[0.0; 120]));
        // Every piece that random points find is one of them.
        for _ in 0..5000 {
            let point = product.range.map(|(low, high)| rng.random_range(low..high));
            assert!(patterns.contains(&product.active(point, &parameters)), "{point:?}");
        }
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
            own_slopes: Vec::new(),
        };
        for network in Compartment::ALL {
            keeper.add(network, &layout, &|_| (-1.0, 1.0));
        }
        let networks = initial_networks(&wiring, &widths, 1.0, 1);
        let mut parameters: Vec<f32> = layout.flatten(&networks).expect("of these widths");
        let drawn = parameters.clone();
        keeper.orient(&mut parameters);
        keeper.project(&mut parameters); // sums of own slopes
        for own in &keeper.own_slopes {
            let slopes = own.units.iter().map(|[w, v]| (parameters[*w] * parameters[*v]).abs());
            assert!(slopes.sum::<f32>() <= 1.0001 * own.most);
        }
        assert_eq!(keeper.own_slopes.len(), 10);
        let oriented = parameters.clone();
        assert_ne!(oriented, drawn);
        keeper.project(&mut parameters);
        for (place, weight) in parameters.iter().enumerate() {
            // A sum at its limit is scaled again by what rounding leaves.
            assert!((weight - oriented[place]).abs() < 1e-6, "oriented weights have their signs");
        }
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
