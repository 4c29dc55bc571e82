//! Windows over scaled runs, by index.

use std::io::Write;

use physiology::Compartment;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefMutIterator, ParallelIterator};

use super::compact_run::CompactRun;
use crate::error::ModelError;
use crate::kernel::{Real, Sequence};
use crate::per_compartment::PerCompartment;
use crate::scaler::Scaler;
use crate::signal::Signal;
use crate::training::windows::{INPUTS, SIGNALS, STATES};
use crate::training::{CarbStart, Run};

/// Windows of equal length over runs in scaled units.
///
/// A window is a run and a first step: however much windows overlap, a row is stored once, 48 bytes
/// a step, and a window takes 8 more.
#[derive(Debug, Clone)]
pub struct WindowSet {
    scaler: Scaler,
    length: usize,
    /// After scaling.
    runs: Vec<CompactRun>,
    /// Run and first step of each window.
    starts: Vec<(u32, u32)>,
    /// Lowest and highest scaled value of each signal over all rows.
    bounds: Bounds,
    /// Lowest scaled value of each state over all rows; 0 for C1.
    minima: PerCompartment<f64>,
}

impl WindowSet {
    /// Scales `runs` and cuts them into windows of `length` steps that start `stride` steps apart; a
    /// run's tail that does not fill a window is not used. The paper takes 60 steps, 15 apart for
    /// training (75 % overlap) and 60 apart for validation.
    ///
    /// # Errors
    /// [`ModelError::Windows`] if `length` or `stride` is 0, a run's lengths do not fit together
    /// or no run holds a window; [`ModelError::NotFinite`] if a value is not a finite number.
    pub fn new(
        scaler: &Scaler,
        runs: &[Run<'_>],
        length: usize,
        stride: usize,
        carb_start: CarbStart,
    ) -> Result<Self, ModelError> {
        let mut bounds = NO_BOUNDS;
        let mut scaled = Vec::with_capacity(runs.len());
        for (index, run) in runs.iter().enumerate() {
            let (mut states, mut inputs) = run.rows(index)?;
            let own = scale(&mut states, &mut inputs, scaler, carb_start, index)?;
            bounds = wider(&bounds, &own);
            scaled.push(CompactRun::rounded((states, inputs)));
        }
        Self::cut(scaler, scaled, &bounds, length, stride)
    }

    /// As [`new`](Self::new), but scales runs where they lie, on all threads: nothing is copied. Values
    /// were rounded to single precision before scaling and are again after it.
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    pub fn in_place(
        scaler: &Scaler,
        mut runs: Vec<CompactRun>,
        length: usize,
        stride: usize,
        carb_start: CarbStart,
    ) -> Result<Self, ModelError> {
        let bounds = runs
            .par_iter_mut()
            .enumerate()
            .map(|(index, CompactRun { states, inputs })| {
                scale(states, inputs, scaler, carb_start, index)
            })
            .try_reduce(|| NO_BOUNDS, |a, b| Ok(wider(&a, &b)))?;
        Self::cut(scaler, runs, &bounds, length, stride)
    }

    fn cut(
        scaler: &Scaler,
        runs: Vec<CompactRun>,
        bounds: &Bounds,
        length: usize,
        stride: usize,
    ) -> Result<Self, ModelError> {
        let problem = |run, problem| ModelError::Windows { run, problem };
        if length == 0 || stride == 0 {
            return Err(problem(0, "length and stride must be at least one step"));
        }
        let mut starts = Vec::new();
        for (index, run) in runs.iter().enumerate() {
            let steps = run.steps();
            let (Ok(place), Ok(_)) = (u32::try_from(index), u32::try_from(steps)) else {
                return Err(problem(index, "more than 2^32 runs or steps"));
            };
            if let Some(last) = steps.checked_sub(length) {
                starts.extend((0..=last).step_by(stride).map(|step| (place, step as u32)));
            }
        }
        if starts.is_empty() {
            return Err(problem(runs.len(), "no run is as long as a window"));
        }
        let minima = PerCompartment::from_fn(|compartment| match compartment {
            Compartment::C1 => 0.0,
            _ => bounds[Signal::State(compartment).row()].0,
        });
        Ok(Self { scaler: *scaler, length, runs, starts, bounds: *bounds, minima })
    }

    /// Number of windows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.starts.len()
    }

    /// Whether there are no windows; never true, since none cannot be built.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.starts.is_empty()
    }

    /// Steps in a window.
    #[must_use]
    pub fn length(&self) -> usize {
        self.length
    }

    /// The scaler of the rows.
    #[must_use]
    pub fn scaler(&self) -> &Scaler {
        &self.scaler
    }

    /// The lowest scaled value of each state over all rows, and 0 for C1: min(x^i) of the paper.
    #[must_use]
    pub fn minima(&self) -> &PerCompartment<f64> {
        &self.minima
    }

    /// The lowest and highest scaled value of a signal over all rows.
    #[must_use]
    pub fn bounds(&self, signal: Signal) -> (f64, f64) {
        self.bounds[signal.row()]
    }

    /// Bytes that rows and windows take.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let rows: usize = self.runs.iter().map(|run| run.states.len() + run.inputs.len()).sum();
        size_of::<f32>() * rows + size_of::<(u32, u32)>() * self.starts.len()
    }

    /// The scaled states of a window, row-major, shape (length + 1, 10), time along the rows.
    ///
    /// # Panics
    /// If there is no such window.
    #[must_use]
    pub fn states(&self, window: usize) -> &[f32] {
        let (run, step) = self.starts[window];
        let step = step as usize;
        &self.runs[run as usize].states[step * STATES..(step + self.length + 1) * STATES]
    }

    /// The scaled inputs of a window, row-major, shape (length, 2), time along the rows.
    ///
    /// # Panics
    /// If there is no such window.
    #[must_use]
    pub fn inputs(&self, window: usize) -> &[f32] {
        let (run, step) = self.starts[window];
        let step = step as usize;
        &self.runs[run as usize].inputs[step * INPUTS..(step + self.length) * INPUTS]
    }

    /// The first `steps` steps of a window, with the states that should follow each.
    ///
    /// # Panics
    /// If there is no such window or it has fewer steps.
    #[must_use]
    pub fn sequence(&self, window: usize, steps: usize) -> Sequence<'_, f32> {
        let (initial, truth) = self.states(window).split_at(STATES);
        let inputs = &self.inputs(window)[..steps * INPUTS];
        Sequence { initial, inputs, truth: &truth[..steps * STATES] }
    }

    /// Writes everything that training sees, little-endian, so that a hash of it names the data.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write_canonical(&self, mut writer: impl Write) -> std::io::Result<()> {
        writer.write_all(&(self.length as u64).to_le_bytes())?;
        let starts = self.starts.iter().flat_map(|(run, step)| [run, step]);
        writer.write_all(&starts.flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>())?;
        self.runs.iter().try_for_each(|run| run.write_values(&mut writer))
    }
}

/// Lowest and highest value of each signal.
type Bounds = [(f64, f64); SIGNALS];

/// The bounds of nothing.
const NO_BOUNDS: Bounds = [(f64::INFINITY, f64::NEG_INFINITY); SIGNALS];

fn wider(a: &Bounds, b: &Bounds) -> Bounds {
    std::array::from_fn(|k| (a[k].0.min(b[k].0), a[k].1.max(b[k].1)))
}

/// Scales the rows of a run where they lie; the bounds of each signal. `run` names it in errors.
fn scale<T: Real>(
    states: &mut [T],
    inputs: &mut [T],
    scaler: &Scaler,
    carb_start: CarbStart,
    run: usize,
) -> Result<Bounds, ModelError> {
    let mut bounds = NO_BOUNDS;
    let signals: Vec<Signal> = Signal::all().collect();
    let (of_states, of_inputs) = signals.split_at(STATES);
    for (rows, signals) in [(states, of_states), (inputs, of_inputs)] {
        for (step, row) in rows.chunks_exact_mut(signals.len()).enumerate() {
            for (slot, signal) in row.iter_mut().zip(signals) {
                let value = match (signal, carb_start) {
                    (Signal::State(Compartment::C1), CarbStart::Zero) => 0.0,
                    _ => scaler.scale_value(*signal, slot.to_f64()),
                };
                if !(value as f32).is_finite() {
                    let tensor = format!("run {run}, {signal}");
                    return Err(ModelError::NotFinite { tensor, index: step });
                }
                *slot = T::of(value);
                let (lowest, highest) = bounds[signal.row()];
                bounds[signal.row()] = (lowest.min(value), highest.max(value));
            }
        }
    }
    Ok(bounds)
}

#[cfg(test)]
mod tests {
    use super::super::compact_run::tests::example;
    use super::*;
    use crate::scaler::DoseGains;

    const LENGTH: usize = 6;
    const STRIDE: usize = 2;

    fn compact(given: &[(Vec<physiology::States>, Vec<physiology::StepInput>)]) -> Vec<CompactRun> {
        let run = |(states, inputs): &(Vec<_>, Vec<_>)| CompactRun::new(Run { states, inputs });
        given.iter().map(|given| run(given).expect("finite")).collect()
    }

    #[test]
    fn windows_scaled_in_place_are_those_of_a_copy() {
        // Of single precision already, so that nothing is rounded twice. One is too short.
        let given = [example(1, 20), example(2, 5), example(3, 13)];
        let runs: Vec<Run<'_>> =
            given.iter().map(|(states, inputs)| Run { states, inputs }).collect();
        let scaler = Scaler::fit(&runs).expect("finite");
        for carb_start in [CarbStart::Reported, CarbStart::Zero] {
            let expected =
                WindowSet::new(&scaler, &runs, LENGTH, STRIDE, carb_start).expect("windows");
            let set = WindowSet::in_place(&scaler, compact(&given), LENGTH, STRIDE, carb_start)
                .expect("windows");
            assert_eq!((set.len(), set.length()), (8 + 4, LENGTH));
            assert_eq!(set.len(), expected.len());
            for window in 0..set.len() {
                assert_eq!(set.states(window), expected.states(window));
                assert_eq!(set.inputs(window), expected.inputs(window));
                let (ours, theirs) = (set.sequence(window, 4), expected.sequence(window, 4));
                assert_eq!((ours.initial, ours.inputs), (theirs.initial, theirs.inputs));
                assert_eq!(ours.truth, theirs.truth);
            }
            assert_eq!(set.minima(), expected.minima());
            assert_eq!(set.scaler(), expected.scaler());
        }
    }

    #[test]
    fn doses_are_scaled_after_their_gains() {
        let given = [example(1, 20)];
        let runs = [Run { states: &given[0].0, inputs: &given[0].1 }];
        let gains = DoseGains { insulin: 2.0, carbs: 0.5 };
        let scaler = Scaler::fit(&runs).expect("finite").with_dose_gains(gains).expect("positive");
        let scaled = given[0].1[..LENGTH].iter().map(|input| scaler.scale_input(input));
        let expected: Vec<f32> =
            scaled.flat_map(|scaled| [scaled.insulin as f32, scaled.carbs as f32]).collect();
        let carb_start = CarbStart::Reported;
        for set in [
            WindowSet::new(&scaler, &runs, LENGTH, STRIDE, carb_start),
            WindowSet::in_place(&scaler, compact(&given), LENGTH, STRIDE, carb_start),
        ] {
            assert_eq!(set.expect("windows").inputs(0), expected);
        }
    }

    #[test]
    fn overlapping_windows_share_their_rows() {
        let given = [example(1, 20)];
        let runs = compact(&given);
        let scaler = Scaler::fit(&[Run { states: &given[0].0, inputs: &given[0].1 }]);
        let set =
            WindowSet::in_place(&scaler.expect("finite"), runs, LENGTH, 1, CarbStart::Reported)
                .expect("windows");
        assert_eq!(set.len(), 15);
        assert_eq!(set.bytes(), 4 * (21 * 10 + 20 * 2) + 8 * 15);
        assert!(std::ptr::eq(&set.states(0)[STATES], &set.states(1)[0]));
        assert!(std::ptr::eq(&set.inputs(0)[INPUTS], &set.inputs(1)[0]));
    }

    #[test]
    fn bounds_hold_every_row() {
        let given = [example(1, 20), example(2, 31)];
        let runs: Vec<Run<'_>> =
            given.iter().map(|(states, inputs)| Run { states, inputs }).collect();
        let scaler = Scaler::fit(&runs).expect("finite");
        let set = WindowSet::in_place(&scaler, compact(&given), LENGTH, 1, CarbStart::Reported)
            .expect("windows");
        for compartment in Compartment::ALL {
            let values = given.iter().flat_map(|(states, _)| states);
            let scaled = values.map(|x| scaler.scale(x)[compartment]);
            let expected = scaled.fold((f64::MAX, f64::MIN), |b, x| (b.0.min(x), b.1.max(x)));
            assert_eq!(set.bounds(Signal::State(compartment)), expected, "{compartment}");
        }
        assert_eq!(set.bounds(Signal::Carbs), (0.0, 30.0), "a range of 0 keeps its unit");
    }

    #[test]
    fn canonical_bytes_follow_data_and_windows() {
        let given = [example(1, 20)];
        let scaler = Scaler::fit(&[Run { states: &given[0].0, inputs: &given[0].1 }]);
        let scaler = scaler.expect("finite");
        let bytes = |given: &[_], stride| {
            let set =
                WindowSet::in_place(&scaler, compact(given), LENGTH, stride, CarbStart::Reported)
                    .expect("windows");
            let mut bytes = Vec::new();
            set.write_canonical(&mut bytes).expect("a vector takes all");
            bytes
        };
        assert_eq!(bytes(&given, 2), bytes(&given, 2));
        assert_ne!(bytes(&given, 2), bytes(&given, 3));
        assert_ne!(bytes(&given, 2), bytes(&[example(2, 20)], 2));
    }

    #[test]
    fn what_cannot_be_cut_is_refused() {
        let given = [example(1, 5)];
        let scaler = Scaler::fit(&[Run { states: &given[0].0, inputs: &given[0].1 }]);
        let scaler = scaler.expect("finite");
        for (length, stride) in [(6, 1), (0, 1), (1, 0)] {
            let cut =
                WindowSet::in_place(&scaler, compact(&given), length, stride, CarbStart::Reported);
            assert!(matches!(cut, Err(ModelError::Windows { .. })), "{length}, {stride}");
        }
    }
}
