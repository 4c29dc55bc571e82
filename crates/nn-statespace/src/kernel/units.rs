//! The networks in the form that the kernel reads.

use physiology::{Compartment, STEP};

use super::layout::ParameterLayout;
use super::real::Real;
use crate::error::ModelError;
use crate::network::shaped;
use crate::training::windows::SIGNALS;
use crate::wiring::Wiring;

/// A hidden unit and what it adds while it is active.
///
/// Its activation is `w . x + b`. While that is positive, the step of the unit's state grows by
/// `slopes . x + offset`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Unit<T, const N: usize> {
    pub(super) w: [T; N],
    pub(super) b: T,
    /// `STEP v w`, with the unit's output weight `v`; scaled units per scaled unit.
    pub(super) slopes: [T; N],
    /// `STEP v b`, scaled units.
    pub(super) offset: T,
    /// `STEP v`.
    pub(super) output: T,
}

/// The units of a network by the number of its inputs, filled up with inputs of weight 0.
///
/// Paper Eq. 2 knows two, four and five inputs; twelve are all signals.
#[derive(Debug, Clone)]
pub(super) enum Units<T> {
    Two(Vec<Unit<T, 2>>),
    Four(Vec<Unit<T, 4>>),
    Five(Vec<Unit<T, 5>>),
    All(Vec<Unit<T, SIGNALS>>),
}

/// A network in the form that the kernel reads.
#[derive(Debug, Clone)]
pub(super) struct Network<T> {
    pub(super) compartment: Compartment,
    /// Rows of the signals it sees; what fills them up repeats the first.
    pub(super) signals: [usize; SIGNALS],
    /// How many of them are seen.
    pub(super) seen: usize,
    pub(super) units: Units<T>,
    /// `STEP b2`, scaled units.
    pub(super) offset: T,
    /// Its first row among the stored slopes of a step.
    pub(super) first_slope: usize,
    /// Its first unit among all.
    pub(super) first_unit: usize,
}

/// All ten.
#[derive(Debug, Clone)]
pub(super) struct Networks<T> {
    pub(super) each: Vec<Network<T>>,
    /// Rows of slopes in a step.
    pub(super) slopes: usize,
    /// Units of all networks.
    pub(super) units: usize,
}

impl<T: Real> Networks<T> {
    /// Networks without units, to be filled by [`Self::set`].
    pub(super) fn new(wiring: &Wiring) -> Self {
        let mut slopes = 0;
        let each = Compartment::ALL.map(|compartment| {
            let seen = wiring.inputs(compartment);
            let mut signals = [seen[0].row(); SIGNALS];
            for (row, signal) in signals.iter_mut().zip(seen) {
                *row = signal.row();
            }
            // Inputs of a unit, those of weight 0 included.
            let (inputs, units) = match seen.len() {
                ..=2 => (2, Units::Two(Vec::new())),
                3 | 4 => (4, Units::Four(Vec::new())),
                5 => (5, Units::Five(Vec::new())),
                _ => (SIGNALS, Units::All(Vec::new())),
            };
            let first_slope = slopes;
            slopes += inputs;
            let seen = seen.len();
            let offset = T::ZERO;
            Network { compartment, signals, seen, units, offset, first_slope, first_unit: 0 }
        });
        Self { each: each.into(), slopes, units: 0 }
    }

    /// Takes over the weights.
    ///
    /// # Errors
    /// [`ModelError::Shape`] or [`ModelError::NotFinite`], as [`ParameterLayout::networks`].
    pub(super) fn set(
        &mut self,
        layout: &ParameterLayout,
        parameters: &[T],
    ) -> Result<(), ModelError> {
        shaped("parameters", &[layout.len], &[parameters.len()])?;
        // The activity of a unit would hide a weight that is not a number.
        if let Some(index) = parameters.iter().position(|weight| !weight.is_finite()) {
            return Err(ModelError::NotFinite { tensor: "parameters".to_owned(), index });
        }
        let step = T::of(STEP.0);
        self.units = 0;
        for network in &mut self.each {
            network.first_unit = self.units;
            let span = layout.of(network.compartment);
            network.offset = step * parameters[span.b2()];
            let rows = parameters[span.w1()].chunks_exact(span.inputs);
            let biases = parameters[span.b1()].iter().zip(&parameters[span.w2()]);
            let each = rows.zip(biases).map(|(row, (b, v))| (row, *b, *v));
            match &mut network.units {
                Units::Two(units) => fill(units, each),
                Units::Four(units) => fill(units, each),
                Units::Five(units) => fill(units, each),
                Units::All(units) => fill(units, each),
            }
            self.units += span.hidden;
        }
        Ok(())
    }
}

fn fill<'a, T: Real, const N: usize>(
    units: &mut Vec<Unit<T, N>>,
    each: impl Iterator<Item = (&'a [T], T, T)>,
) {
    let step = T::of(STEP.0);
    units.clear();
    units.extend(each.map(|(row, b, v)| {
        let mut w = [T::ZERO; N];
        w[..row.len()].copy_from_slice(row);
        let slopes = w.map(|weight| step * v * weight);
        Unit { w, b, slopes, offset: step * v * b, output: step * v }
    }));
}

/// The slopes of the weights, from sums over samples and steps, both in the order of `layout`.
///
/// `sums` holds in the place of a unit's `w1` the sums of `m g x`, in that of its `b1` the sum of
/// `m g` and in the place of `b2` the sum of `g`, where `m` is 1 while the unit is active, `g` the
/// slope of the loss by the state's step and `x` the inputs. The slopes take their place.
pub(super) fn slopes_of_weights<T: Real>(
    layout: &ParameterLayout,
    parameters: &[T],
    sums: &mut [T],
) {
    let step = T::of(STEP.0);
    for compartment in Compartment::ALL {
        let span = layout.of(compartment);
        let inputs = span.inputs;
        for unit in 0..span.hidden {
            let (row, b, v) =
                (span.w1().start + unit * inputs, span.b1().start + unit, span.w2().start + unit);
            // v enters as v (w . x + b) while the unit is active.
            let mut by_v = parameters[b] * sums[b];
            for index in row..row + inputs {
                by_v = by_v + parameters[index] * sums[index];
                sums[index] = step * parameters[v] * sums[index];
            }
            sums[b] = step * parameters[v] * sums[b];
            sums[v] = step * by_v;
        }
        sums[span.b2()] = step * sums[span.b2()];
    }
}
