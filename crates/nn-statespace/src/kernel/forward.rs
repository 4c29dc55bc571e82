//! The roll-out of a block.

use physiology::Compartment;

use super::block::{BLOCK, Block, Row};
use super::lanes::{Job, Lanes};
use super::real::Real;
use super::units::{Network, Networks, SIGNALS, Unit, Units};

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
        for step in 0..steps {
            let (past, future) = block.signals.split_at_mut(step + 1);
            let (now, next) = (&past[step], &mut future[0]);
            let slopes = &mut block.slopes[step * networks.slopes..][..networks.slopes];
            for network in &networks.each {
                let slopes = &mut slopes[network.first_slope..];
                match &network.units {
                    Units::Two(units) => advance(lanes, network, units, now, next, slopes),
                    Units::Four(units) => advance(lanes, network, units, now, next, slopes),
                    Units::Five(units) => advance(lanes, network, units, now, next, slopes),
                    Units::All(units) => advance(lanes, network, units, now, next, slopes),
                }
            }
            if let Some((lowest, highest)) = glucose_range {
                confine(&mut next[Compartment::Q1 as usize], lowest, highest);
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
    now: &[Row<T>; SIGNALS],
    next: &mut [Row<T>; SIGNALS],
    slopes: &mut [Row<T>],
) {
    // A vector of 16 lanes has work enough for itself; shorter ones share a unit's weights.
    if L::COUNT == 16 {
        advance_by::<T, L, N, 1>(lanes, network, units, now, next, slopes);
    } else {
        advance_by::<T, L, N, 2>(lanes, network, units, now, next, slopes);
    }
}

/// The same, `V` vectors at a time.
#[inline(always)]
fn advance_by<T: Real, L: Lanes<T>, const N: usize, const V: usize>(
    lanes: L,
    network: &Network<T>,
    units: &[Unit<T, N>],
    now: &[Row<T>; SIGNALS],
    next: &mut [Row<T>; SIGNALS],
    slopes: &mut [Row<T>],
) {
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
        for unit in units {
            let mut activation = [lanes.splat(unit.b); V];
            for k in 0..N {
                let w = lanes.splat(unit.w[k]);
                for v in 0..V {
                    activation[v] = lanes.multiply_add(w, x[k][v], activation[v]);
                }
            }
            let more = lanes.splat(unit.offset);
            for v in 0..V {
                let active = lanes.positive(activation[v]);
                for k in 0..N {
                    slope[k][v] = lanes.add_where(active, slope[k][v], lanes.splat(unit.slopes[k]));
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

/// Confines finite values to a range; others stay what they are, to be seen.
fn confine<T: Real>(row: &mut Row<T>, lowest: T, highest: T) {
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
