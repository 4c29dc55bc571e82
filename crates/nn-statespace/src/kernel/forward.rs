//! The roll-out of a block.

use physiology::Compartment;

use super::block::{BLOCK, Block, PARTS, Row, WIDE};
use super::lanes::{Job, Lanes};
use super::real::Real;
use super::units::{Network, Networks, Unit, Units};
use crate::training::windows::SIGNALS;

/// Rolls a block out and keeps the slopes of every step.
pub(super) struct Forward<'a, T> {
    pub(super) networks: &'a Networks<T>,
    /// Bounds of Q1, scaled, if it is confined after each step.
    pub(super) glucose_range: Option<(T, T)>,
    pub(super) block: &'a mut Block<T>,
}

impl<T: Real> Job<T> for Forward<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes<T>>(self, lanes: L) {
        let Self { networks, glucose_range, block } = self;
        let steps = block.steps();
        block.slopes.resize(steps * networks.slopes, [T::ZERO; BLOCK]);
        if L::MASKS_ARE_BITS {
            block.activity.resize(steps * PARTS * networks.units, 0);
        }
        for step in 0..steps {
            let (past, future) = block.signals.split_at_mut(step + 1);
            let (now, next) = (&past[step], &mut future[0]);
            let slopes = &mut block.slopes[step * networks.slopes..][..networks.slopes];
            let activity = block.activity.get_mut(step * PARTS * networks.units..);
            let activity = activity.unwrap_or_default();
            Step { networks, now, next: &mut *next, slopes, activity }.run(lanes);
            if let Some((lowest, highest)) = glucose_range {
                confine(&mut next[Compartment::Q1 as usize], lowest, highest);
            }
        }
    }
}

/// One step of every network, with the slopes of the step.
pub(super) struct Step<'a, T> {
    pub(super) networks: &'a Networks<T>,
    pub(super) now: &'a [Row<T>; SIGNALS],
    pub(super) next: &'a mut [Row<T>; SIGNALS],
    /// Of all networks, one after the other.
    pub(super) slopes: &'a mut [Row<T>],
    /// Of the step, shape (parts of the block, units of all networks), where it is kept.
    pub(super) activity: &'a mut [u16],
}

impl<T: Real> Job<T> for Step<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes<T>>(mut self, lanes: L) {
        let networks = self.networks;
        for network in &networks.each {
            match &network.units {
                Units::Two(units) => advance(lanes, network, units, &mut self),
                Units::Four(units) => advance(lanes, network, units, &mut self),
                Units::Five(units) => advance(lanes, network, units, &mut self),
                Units::All(units) => advance(lanes, network, units, &mut self),
            }
        }
    }
}

/// One network's state after a step, and the slopes of the step.
#[inline(always)]
fn advance<T: Real, L: Lanes<T>, const N: usize>(
    lanes: L,
    network: &Network<T>,
    units: &[Unit<T, N>],
    step: &mut Step<'_, T>,
) {
    // A vector of 16 lanes has work enough for itself; shorter ones share a unit's weights.
    if L::COUNT == WIDE {
        advance_by::<T, L, N, 1>(lanes, network, units, step);
    } else {
        advance_by::<T, L, N, 2>(lanes, network, units, step);
    }
}

/// The same, `V` vectors at a time; activity is kept one vector at a time.
#[inline(always)]
fn advance_by<T: Real, L: Lanes<T>, const N: usize, const V: usize>(
    lanes: L,
    network: &Network<T>,
    units: &[Unit<T, N>],
    step: &mut Step<'_, T>,
) {
    let (now, next, all_units) = (step.now, &mut *step.next, step.networks.units);
    let (slopes, activity) = (&mut step.slopes[network.first_slope..], &mut *step.activity);
    let zero = lanes.splat(T::ZERO);
    let state = network.compartment as usize;
    let mut at = 0;
    while at < BLOCK {
        let mut x = [[zero; V]; N];
        for (x, row) in x.iter_mut().zip(network.signals) {
            for (v, x) in x.iter_mut().enumerate() {
                *x = lanes.load(&now[row][at + v * L::COUNT..]);
            }
        }
        let mut slope = [[zero; V]; N];
        let mut offset = [lanes.splat(network.offset); V];
        let kept = if L::MASKS_ARE_BITS {
            &mut activity[at / WIDE * all_units + network.first_unit..][..units.len()]
        } else {
            &mut []
        };
        for (index, unit) in units.iter().enumerate() {
            let mut activation = [lanes.splat(unit.b); V];
            for (weight, x) in unit.w.iter().zip(&x) {
                let weight = lanes.splat(*weight);
                for v in 0..V {
                    activation[v] = lanes.multiply_add(weight, x[v], activation[v]);
                }
            }
            let more = lanes.splat(unit.offset);
            for v in 0..V {
                let active = lanes.positive(activation[v]);
                if L::MASKS_ARE_BITS {
                    kept[index] = lanes.bits(active);
                }
                for (slope, more) in slope.iter_mut().zip(&unit.slopes) {
                    slope[v] = lanes.add_where(active, slope[v], lanes.splat(*more));
                }
                offset[v] = lanes.add_where(active, offset[v], more);
            }
        }
        for v in 0..V {
            let place = at + v * L::COUNT;
            let mut change = offset[v];
            for k in 0..N {
                change = lanes.multiply_add(slope[k][v], x[k][v], change);
                lanes.store(slope[k][v], &mut slopes[k][place..]);
            }
            let from = lanes.load(&now[state][place..]);
            lanes.store(lanes.add(from, change), &mut next[state][place..]);
        }
        at += V * L::COUNT;
    }
}

/// One step of every network and nothing else.
pub(super) struct PlainStep<'a, T> {
    pub(super) networks: &'a Networks<T>,
    pub(super) now: &'a [Row<T>; SIGNALS],
    pub(super) next: &'a mut [Row<T>; SIGNALS],
}

impl<T: Real> Job<T> for PlainStep<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes<T>>(self, lanes: L) {
        let Self { networks, now, next } = self;
        for network in &networks.each {
            match &network.units {
                Units::Two(units) => advance_alone(lanes, network, units, now, next),
                Units::Four(units) => advance_alone(lanes, network, units, now, next),
                Units::Five(units) => advance_alone(lanes, network, units, now, next),
                Units::All(units) => advance_alone(lanes, network, units, now, next),
            }
        }
    }
}

/// One network's state after a step and nothing else.
#[inline(always)]
fn advance_alone<T: Real, L: Lanes<T>, const N: usize>(
    lanes: L,
    network: &Network<T>,
    units: &[Unit<T, N>],
    now: &[Row<T>; SIGNALS],
    next: &mut [Row<T>; SIGNALS],
) {
    const TOGETHER: usize = 2;
    let zero = lanes.splat(T::ZERO);
    let state = network.compartment as usize;
    let mut at = 0;
    while at < BLOCK {
        let mut x = [[zero; TOGETHER]; N];
        for (x, row) in x.iter_mut().zip(network.signals) {
            for (v, x) in x.iter_mut().enumerate() {
                *x = lanes.load(&now[row][at + v * L::COUNT..]);
            }
        }
        let mut change = [lanes.splat(network.offset); TOGETHER];
        for unit in units {
            let output = lanes.splat(unit.output);
            for v in 0..TOGETHER {
                let mut activation = lanes.splat(unit.b);
                for (weight, x) in unit.w.iter().zip(&x) {
                    activation = lanes.multiply_add(lanes.splat(*weight), x[v], activation);
                }
                let active = lanes.positive(activation);
                change[v] = lanes.multiply_add_where(active, activation, output, change[v]);
            }
        }
        for (v, change) in change.into_iter().enumerate() {
            let place = at + v * L::COUNT;
            let from = lanes.load(&now[state][place..]);
            lanes.store(lanes.add(from, change), &mut next[state][place..]);
        }
        at += TOGETHER * L::COUNT;
    }
}

/// Confines finite values to a range; others stay what they are, to be seen.
pub(super) fn confine<T: Real>(row: &mut Row<T>, lowest: T, highest: T) {
    for value in row {
        if value.is_finite() {
            if *value < lowest {
                *value = lowest;
            } else if *value > highest {
                *value = highest;
            }
        }
    }
}
