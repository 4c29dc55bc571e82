//! The slopes of the loss, backwards through a block.

use std::slice::Chunks;

use physiology::Compartment;

use super::block::{BLOCK, Block, Row, WIDE};
use super::lanes::{Job, Lanes};
use super::layout::ParameterLayout;
use super::real::Real;
use super::units::{Network, Networks, Unit, Units};

/// Carries the slopes of the loss from the last step to the first, then sums up what the weights
/// need. The block must have been rolled out, and its `adjoint` hold the slopes of the loss.
pub(super) struct Backward<'a, T> {
    pub(super) networks: &'a Networks<T>,
    pub(super) layout: &'a ParameterLayout,
    /// As in the roll-out.
    pub(super) glucose_range: Option<(T, T)>,
    pub(super) block: &'a mut Block<T>,
}

impl<T: Real> Job<T> for Backward<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes<T>>(self, lanes: L) {
        let Self { networks, layout, glucose_range, block } = self;
        for step in (0..block.steps()).rev() {
            if let Some(range) = glucose_range {
                block_confined(block, step, range);
            }
            if step > 0 {
                carry(lanes, networks, block, step);
            }
        }
        block.sums.clear();
        block.sums.resize(layout.len, T::ZERO);
        for network in &networks.each {
            match &network.units {
                Units::Two(units) => sum(lanes, networks, network, units, layout, block),
                Units::Four(units) => sum(lanes, networks, network, units, layout, block),
                Units::Five(units) => sum(lanes, networks, network, units, layout, block),
                Units::All(units) => sum(lanes, networks, network, units, layout, block),
            }
        }
    }
}

/// No slope runs through a value that was confined.
fn block_confined<T: Real>(block: &mut Block<T>, step: usize, (lowest, highest): (T, T)) {
    let q1 = Compartment::Q1 as usize;
    let (after, slopes) = (&block.signals[step + 1][q1], &mut block.adjoint[step][q1]);
    for (slope, value) in slopes.iter_mut().zip(after) {
        if *value <= lowest || *value >= highest {
            *slope = T::ZERO;
        }
    }
}

/// Adds to the slopes by the states before `step` what they owe to the states after it.
#[inline(always)]
fn carry<T: Real, L: Lanes<T>>(
    lanes: L,
    networks: &Networks<T>,
    block: &mut Block<T>,
    step: usize,
) {
    let (before, after) = block.adjoint.split_at_mut(step);
    let (before, after) = (&mut before[step - 1], &after[0]);
    let slopes = &block.slopes[step * networks.slopes..][..networks.slopes];
    let mut at = 0;
    while at < BLOCK {
        for (before, after) in before.iter_mut().zip(after) {
            let sum = lanes.add(lanes.load(&before[at..]), lanes.load(&after[at..]));
            lanes.store(sum, &mut before[at..]);
        }
        for network in &networks.each {
            let by_state = lanes.load(&after[network.compartment as usize][at..]);
            let seen = &network.signals[..network.seen];
            for (signal, slopes) in seen.iter().zip(&slopes[network.first_slope..]) {
                // Nothing hangs on the inputs of the model.
                if let Some(row) = before.get_mut(*signal) {
                    let slope = lanes.load(&slopes[at..]);
                    let sum = lanes.multiply_add(slope, by_state, lanes.load(&row[at..]));
                    lanes.store(sum, &mut row[at..]);
                }
            }
        }
        at += L::COUNT;
    }
}

/// The sums of one network's units.
#[inline(always)]
fn sum<T: Real, L: Lanes<T>, const N: usize>(
    lanes: L,
    networks: &Networks<T>,
    network: &Network<T>,
    units: &[Unit<T, N>],
    layout: &ParameterLayout,
    block: &mut Block<T>,
) {
    // What its units meet, side by side: for each step and each WIDE samples the slope of the loss
    // by the state's step, then the inputs.
    let (state, rows) = (network.compartment as usize, &mut block.rows);
    rows.clear();
    for (signals, adjoint) in block.signals.iter().zip(&block.adjoint) {
        for at in (0..BLOCK).step_by(WIDE) {
            let wide = |row: &Row<T>| *row[at..].first_chunk::<WIDE>().expect("whole in a block");
            rows.push(wide(&adjoint[state]));
            rows.extend(network.signals[..N].iter().map(|signal| wide(&signals[*signal])));
        }
    }
    // As many units at a time as have room in the registers.
    let mut first = 0;
    if L::MASKS_ARE_BITS {
        if N == 2 {
            first = sum_groups::<T, L, N, 8>(lanes, networks, network, units, first, layout, block);
        }
        if N <= 5 {
            first = sum_groups::<T, L, N, 4>(lanes, networks, network, units, first, layout, block);
        }
    } else {
        first = sum_groups::<T, L, N, 2>(lanes, networks, network, units, first, layout, block);
    }
    sum_groups::<T, L, N, 1>(lanes, networks, network, units, first, layout, block);
    let mut all = [T::ZERO; WIDE];
    for slopes in block.rows.iter().step_by(N + 1) {
        for (sum, slope) in all.iter_mut().zip(slopes) {
            *sum = *sum + *slope;
        }
    }
    block.sums[layout.of(network.compartment).b2()] = total(&all);
}

/// Sums of `U` units at a time, from the unit `first`; returns the first unit that is left.
#[inline(always)]
fn sum_groups<T: Real, L: Lanes<T>, const N: usize, const U: usize>(
    lanes: L,
    networks: &Networks<T>,
    network: &Network<T>,
    units: &[Unit<T, N>],
    mut first: usize,
    layout: &ParameterLayout,
    block: &mut Block<T>,
) -> usize {
    let span = layout.of(network.compartment);
    for units in units[first..].as_chunks::<U>().0 {
        let mut by_input = [[[T::ZERO; WIDE]; N]; U];
        let mut alone = [[T::ZERO; WIDE]; U];
        let activity = block.activity.get(network.first_unit + first..).unwrap_or_default();
        let mut part = 0;
        while part < WIDE {
            let activity = activity.chunks(networks.units);
            sum_part(lanes, units, activity, &block.rows, part, &mut by_input, &mut alone);
            part += L::COUNT;
        }
        for (by_input, alone) in by_input.iter().zip(&alone) {
            let row = span.w1().start + first * span.inputs;
            for (place, lanes) in (row..row + span.inputs).zip(by_input) {
                block.sums[place] = total(lanes);
            }
            block.sums[span.b1().start + first] = total(alone);
            first += 1;
        }
    }
    first
}

/// The sums of some units over all steps, for the lanes from `part` on. Where the roll-out kept
/// activity, each item of `activity` begins with that of these units; elsewhere it is computed
/// again.
#[inline(always)]
fn sum_part<T: Real, L: Lanes<T>, const N: usize, const U: usize>(
    lanes: L,
    units: &[Unit<T, N>; U],
    mut activity: Chunks<'_, u16>,
    rows: &[[T; WIDE]],
    part: usize,
    by_input: &mut [[[T; WIDE]; N]; U],
    alone: &mut [[T; WIDE]; U],
) {
    let zero = lanes.splat(T::ZERO);
    let mut w = [[zero; N]; U];
    let mut b = [zero; U];
    for u in 0..U {
        b[u] = lanes.splat(units[u].b);
        for (w, weight) in w[u].iter_mut().zip(units[u].w) {
            *w = lanes.splat(weight);
        }
    }
    let mut sums = [[zero; N]; U];
    let mut sums_alone = [zero; U];
    for rows in rows.chunks_exact(N + 1) {
        let g = lanes.load(&rows[0][part..]);
        let mut x = [zero; N];
        for k in 0..N {
            x[k] = lanes.load(&rows[1 + k][part..]);
        }
        let kept: &[u16; U] = if L::MASKS_ARE_BITS {
            activity.next().and_then(<[u16]>::first_chunk).expect("a number a unit")
        } else {
            &[0; U]
        };
        for u in 0..U {
            let active = if L::MASKS_ARE_BITS {
                lanes.mask(kept[u])
            } else {
                let mut activation = b[u];
                for k in 0..N {
                    activation = lanes.multiply_add(w[u][k], x[k], activation);
                }
                lanes.positive(activation)
            };
            for k in 0..N {
                sums[u][k] = lanes.multiply_add_where(active, g, x[k], sums[u][k]);
            }
            sums_alone[u] = lanes.add_where(active, sums_alone[u], g);
        }
    }
    for u in 0..U {
        for k in 0..N {
            lanes.store(sums[u][k], &mut by_input[u][k][part..]);
        }
        lanes.store(sums_alone[u], &mut alone[u][part..]);
    }
}

/// The sum over lanes, always in the same order.
#[inline(always)]
fn total<T: Real>(lanes: &[T; WIDE]) -> T {
    let mut sums = *lanes;
    let mut half = WIDE / 2;
    while half > 0 {
        for lane in 0..half {
            sums[lane] = sums[lane] + sums[lane + half];
        }
        half /= 2;
    }
    sums[0]
}
