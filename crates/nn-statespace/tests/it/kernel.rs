//! The fused roll-out against the candle graph, against central differences, and against itself on
//! other instructions and other numbers of threads.

use candle_core::{DType, Device, Tensor};
use nn_statespace::GlucoseClamp::{Off, Reproduction};
use nn_statespace::kernel::{FusedRollOut, Instructions, Real, Sequence};
use nn_statespace::training::loss::{Loss, LossConfig};
use nn_statespace::training::{LossTerms, RollOut, initial_networks};
use nn_statespace::{
    CentreAndScale, HiddenLayerNetwork, ModelCard, ModelError, PerCompartment, PopulationModel,
    ScaledStates, Scaler, Signal, Widths, Wiring,
};
use physiology::{Compartment, Grams, OpenLoop, StepInput, UnitsPerHour, simulate};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Random sequences; each array is contiguous, so that one layout serves kernel and graph.
struct Data<T> {
    batch: usize,
    steps: usize,
    /// (batch, 10)
    initial: Vec<T>,
    /// (batch, steps, 2)
    inputs: Vec<T>,
    /// (batch, steps, 10)
    truth: Vec<T>,
}

impl<T: Real> Data<T> {
    fn random(seed: u64, batch: usize, steps: usize) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut draw = |count: usize, most: f32| -> Vec<T> {
            // f32 numbers, so that both precisions see the same data.
            (0..count).map(|_| T::of(f64::from(rng.random_range(-most..most)))).collect()
        };
        Self {
            batch,
            steps,
            initial: draw(batch * 10, 1.0),
            inputs: draw(batch * steps * 2, 1.0),
            truth: draw(batch * steps * 10, 4.0),
        }
    }

    fn sequences(&self) -> Vec<Sequence<'_, T>> {
        let each = self.initial.chunks_exact(10).zip(self.inputs.chunks_exact(self.steps * 2));
        each.zip(self.truth.chunks_exact(self.steps * 10))
            .map(|((initial, inputs), truth)| Sequence { initial, inputs, truth })
            .collect()
    }
}

impl Data<f64> {
    fn tensor(&self, values: &[f64], columns: usize) -> Tensor {
        let shape = (self.batch, values.len() / self.batch / columns, columns);
        let tensor = Tensor::from_slice(values, shape, &Device::Cpu);
        tensor.and_then(|t| t.transpose(0, 1)?.contiguous()).expect("the shape")
    }
}

fn scaler() -> Scaler {
    let unit = CentreAndScale { centre: 0.0, scale: 1.0 };
    let mut states = PerCompartment::from_fn(|_| unit);
    states[Compartment::Q1] = CentreAndScale { centre: 120.0, scale: 80.0 };
    Scaler::new(states, unit, unit).expect("positive")
}

/// High minima, so that the soft constraint is at work; truth reaches both glucose thresholds.
fn minima() -> PerCompartment<f64> {
    PerCompartment::from_fn(|_| -0.2)
}

fn terms<T: Real>(data: &Data<T>) -> LossTerms<T> {
    LossTerms::new(&LossConfig::paper(), &scaler(), &minima(), data.batch * data.steps)
}

fn widths(of: impl FnMut(Compartment) -> usize) -> Widths {
    Widths::new(PerCompartment::from_fn(of)).expect("positive")
}

/// States, loss and slopes of the weights by the graph, in f64.
fn by_graph(
    wiring: &Wiring,
    networks: &PerCompartment<HiddenLayerNetwork>,
    data: &Data<f64>,
) -> (Vec<f64>, f64, PerCompartment<HiddenLayerNetwork>) {
    let graph = RollOut::new(wiring, networks, DType::F64).expect("fits");
    let loss =
        Loss::new(LossConfig::paper(), &scaler(), &minima(), DType::F64).expect("ten columns");
    let initial = data.tensor(&data.initial, 10).squeeze(0).expect("one row");
    let states = graph.simulate(&initial, &data.tensor(&data.inputs, 2)).expect("shapes fit");
    let total = loss.total(&states, &data.tensor(&data.truth, 10)).expect("shapes fit");
    let slopes = graph.slopes(&total.backward().expect("differentiable")).expect("finite");
    let states = states.transpose(0, 1).and_then(|s| s.flatten_all()?.to_vec1()).expect("f64");
    (states, total.to_scalar().expect("a scalar"), slopes)
}

/// The largest difference, over the largest value.
fn apart<T: Real>(ours: &[T], theirs: &[f64]) -> f64 {
    assert_eq!(ours.len(), theirs.len());
    // Where all are 0, ours must be.
    let largest = theirs.iter().fold(1e-30, |most: f64, value| most.max(value.abs()));
    let differences = ours.iter().zip(theirs).map(|(a, b)| (a.to_f64() - b).abs());
    differences.fold(0.0, f64::max) / largest
}

/// Kernel and graph on the same networks and data, for every set of instructions.
fn check<T: Real>(wiring: &Wiring, widths: &Widths, batch: usize, steps: usize, tolerance: f64) {
    let networks = initial_networks(wiring, widths, 0.3, 3);
    let wide = Data::<f64>::random(4, batch, steps);
    let (states, value, slopes) = by_graph(wiring, &networks, &wide);
    let data = Data::<T>::random(4, batch, steps);
    for instructions in Instructions::available() {
        let mut kernel = FusedRollOut::new(wiring, widths).with_instructions(instructions);
        let parameters = kernel.layout().flatten(&networks).expect("of these widths");
        let slopes: Vec<f64> = kernel.layout().flatten(&slopes).expect("of these widths");
        let simulated = kernel.simulate(&parameters, &data.sequences()).expect("fits");
        let mut gradient = vec![T::ZERO; parameters.len()];
        let loss = kernel
            .gradient(&parameters, &data.sequences(), &terms(&data), &mut gradient)
            .expect("fits");
        let place = format!("{instructions:?}, batch {batch}, {steps} steps");
        let error = apart(&simulated, &states);
        assert!(error < tolerance, "{place}: states {error}");
        let error = (loss - value).abs() / value;
        assert!(error < tolerance, "{place}: loss {error}");
        // Each compartment by itself: small slopes do not hide behind large ones.
        for compartment in Compartment::ALL {
            let span = kernel.layout().of(compartment);
            for range in [span.w1(), span.b1(), span.w2(), span.b2()..span.b2() + 1] {
                let error = apart(&gradient[range.clone()], &slopes[range]);
                assert!(error < tolerance, "{place}, {compartment}: slopes {error}");
            }
        }
    }
}

/// Rounding of sums in another order, grown over the steps.
const F64: f64 = 1e-11;
/// The same in single precision against double; a unit near its kink may also be active in one alone.
const F32: f64 = 2e-3;

#[test]
fn any_batch_gives_what_the_graph_gives() {
    let narrow = widths(|c| 4 + c as usize);
    for batch in [1, 2, 31, 32, 33, 63, 64, 65, 128] {
        check::<f64>(&Wiring::paper(), &narrow, batch, 12, F64);
        check::<f32>(&Wiring::paper(), &narrow, batch, 12, F32);
    }
}

#[test]
fn any_width_gives_what_the_graph_gives() {
    for all in [widths(|_| 1), widths(|_| 7), widths(|c| 1 + 3 * c as usize), Widths::paper()] {
        check::<f64>(&Wiring::paper(), &all, 5, 60, F64);
        check::<f32>(&Wiring::paper(), &all, 5, 60, F32);
    }
}

#[test]
fn any_wiring_gives_what_the_graph_gives() {
    use Compartment::{C1, I, Q1, S1};
    // One, three, six and twelve inputs, beside two, four and five.
    let mut signals = PerCompartment::from_fn(|c| Wiring::paper().inputs(c).to_vec());
    signals[S1] = vec![Signal::Insulin];
    signals[C1].push(Signal::State(I));
    signals[Q1].push(Signal::State(I));
    signals[I] = Compartment::ALL.into_iter().rev().map(Signal::State).collect();
    signals[I].extend([Signal::Carbs, Signal::Insulin]);
    let wiring = Wiring::new(signals).expect("no signal twice");
    check::<f64>(&wiring, &widths(|_| 6), 40, 20, F64);
    check::<f32>(&wiring, &widths(|_| 6), 40, 20, F32);
}

#[test]
fn gradients_agree_with_central_differences() {
    for range in [None, Some((-0.6, 0.9))] {
        let (wiring, widths) = (Wiring::paper(), widths(|_| 4));
        let networks = initial_networks(&wiring, &widths, 0.3, 3);
        let data = Data::<f64>::random(5, 3, 12);
        let mut kernel = FusedRollOut::new(&wiring, &widths);
        if let Some(range) = range {
            kernel = kernel.with_glucose_range(range);
        }
        let mut parameters: Vec<f64> = kernel.layout().flatten(&networks).expect("of these widths");
        let (sequences, terms) = (data.sequences(), terms(&data));
        let mut gradient = vec![0.0; parameters.len()];
        kernel.gradient(&parameters, &sequences, &terms, &mut gradient).expect("fits");
        if let Some((lowest, highest)) = range {
            let states = kernel.simulate(&parameters, &sequences).expect("fits");
            let at_bound = states.iter().skip(Compartment::Q1 as usize).step_by(10);
            let at_bound = at_bound.filter(|q1| **q1 == lowest || **q1 == highest).count();
            assert!((3..33).contains(&at_bound), "{at_bound} of 36 values are confined");
        }
        let mut unused = gradient.clone();
        for index in 0..parameters.len() {
            let weight = parameters[index];
            let mut shifted = |by: f64| {
                parameters[index] = weight + by;
                let value = kernel.gradient(&parameters, &sequences, &terms, &mut unused);
                parameters[index] = weight;
                value.expect("fits")
            };
            let step = 1e-6;
            let difference = (shifted(step) - shifted(-step)) / (2.0 * step);
            let slope = gradient[index];
            // Second-order error 1e-12 times curvature, rounding 1e-16/1e-6.
            let error = (difference - slope).abs();
            assert!(error <= 1e-6 * (1.0 + slope.abs()), "{index}: {difference} {slope}");
        }
        let moved = gradient.iter().filter(|slope| **slope != 0.0).count();
        assert!(moved > gradient.len() * 8 / 10, "{moved} of {}", gradient.len());
    }
}

#[test]
fn the_kernel_rolls_out_as_the_plant_does() {
    let (wiring, widths, scaler) = (Wiring::paper(), Widths::quick(), scaler());
    let networks = initial_networks(&wiring, &widths, 1.0, 1);
    let data = Data::<f64>::random(2, 1, 12);
    let card = ModelCard {
        origin: "test".to_owned(),
        version: "0".to_owned(),
        training_data_sha256: None,
        training: None,
    };
    let free = PopulationModel::new(wiring.clone(), networks.clone(), scaler, Off, card);
    let free = free.expect("fits");
    let clamped = free.clone().with_clamp(Reproduction);
    for model in [free, clamped] {
        let mut kernel = FusedRollOut::new(&wiring, &widths);
        if model.clamp() == Reproduction {
            kernel = kernel.with_glucose_range(model.scaled_glucose_range());
        }
        let parameters: Vec<f64> = kernel.layout().flatten(&networks).expect("of these widths");
        let simulated = kernel.simulate(&parameters, &data.sequences()).expect("fits");
        let mut start = ScaledStates::default();
        for (compartment, value) in Compartment::ALL.into_iter().zip(&data.initial) {
            start[compartment] = *value;
        }
        let inputs = data.inputs.chunks_exact(2).map(|u| StepInput {
            basal: UnitsPerHour(u[0]),
            carbs: Grams(u[1]),
            ..StepInput::default()
        });
        let inputs: Vec<StepInput> = inputs.collect();
        let run = simulate(&model, start, &mut OpenLoop::new(&inputs), 12).expect("finite");
        let mut bounds = 0;
        for (step, row) in simulated.chunks_exact(10).enumerate() {
            for (compartment, value) in run.states[step + 1].iter() {
                let place = format!("{:?}, {step}, {compartment}", model.clamp());
                // Rounding of sums in another order, over twelve steps.
                let error = (row[compartment as usize] - value).abs();
                assert!(error < 1e-12 * (1.0 + value.abs()), "{place}: {error}");
            }
            let (lowest, highest) = model.scaled_glucose_range();
            let q1 = row[Compartment::Q1 as usize];
            bounds += usize::from(q1 == lowest || q1 == highest);
        }
        assert_eq!(bounds > 0, model.clamp() == Reproduction, "{bounds} values are confined");
    }
}

/// Loss and gradient as bytes.
fn bytes<T: Real>(instructions: Instructions, threads: usize, batch: usize) -> Vec<u8> {
    let (wiring, widths) = (Wiring::paper(), Widths::paper());
    let networks = initial_networks(&wiring, &widths, 0.3, 3);
    let data = Data::<T>::random(6, batch, 10);
    let mut kernel = FusedRollOut::new(&wiring, &widths).with_instructions(instructions);
    let parameters = kernel.layout().flatten(&networks).expect("of these widths");
    let mut gradient = vec![T::ZERO; parameters.len()];
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let loss = pool.install(|| {
        kernel.gradient(&parameters, &data.sequences(), &terms(&data), &mut gradient).expect("fits")
    });
    let numbers = std::iter::once(loss).chain(gradient.iter().map(|slope| slope.to_f64()));
    numbers.flat_map(f64::to_le_bytes).collect()
}

#[test]
fn neither_threads_nor_the_width_of_vectors_change_a_byte() {
    fn check<T: Real>() {
        for batch in [1, 63, 65, 128] {
            for instructions in Instructions::available() {
                let one = bytes::<T>(instructions, 1, batch);
                for threads in [2, 3] {
                    let more = bytes::<T>(instructions, threads, batch);
                    assert!(more == one, "{instructions:?}, batch {batch}, {threads} threads");
                }
                // Without fused instructions products are rounded before they are added.
                if instructions == Instructions::Avx512 {
                    assert!(bytes::<T>(Instructions::Avx2, 1, batch) == one, "AVX2, batch {batch}");
                }
            }
        }
    }
    check::<f32>();
    check::<f64>();
}

#[test]
fn a_kernel_that_was_used_before_gives_the_same_bytes() {
    let (wiring, widths) = (Wiring::paper(), widths(|_| 9));
    let networks = initial_networks(&wiring, &widths, 0.3, 3);
    let fresh = || FusedRollOut::<f32>::new(&wiring, &widths);
    let parameters: Vec<f32> = fresh().layout().flatten(&networks).expect("of these widths");
    let answer = |kernel: &mut FusedRollOut<f32>, data: &Data<f32>| {
        let mut gradient = vec![f32::NAN; parameters.len()];
        let loss = kernel.gradient(&parameters, &data.sequences(), &terms(data), &mut gradient);
        (loss.expect("fits"), gradient)
    };
    let mut used = fresh();
    // Full blocks before a part of one, long before short, and back.
    for (batch, steps) in [(70, 20), (3, 20), (40, 5), (1, 30), (64, 30), (33, 1)] {
        let data = Data::random(batch as u64, batch, steps);
        assert_eq!(answer(&mut used, &data), answer(&mut fresh(), &data), "{batch}, {steps} steps");
    }
}

/// A change of sequences, parameters and the room for their gradient.
type Edit = dyn Fn(&mut Vec<Sequence<'_, f32>>, &mut Vec<f32>, &mut Vec<f32>);

#[test]
fn what_does_not_fit_is_refused() {
    let (wiring, widths) = (Wiring::paper(), Widths::quick());
    let networks = initial_networks(&wiring, &widths, 0.3, 3);
    let data = Data::<f32>::random(6, 3, 4);
    let mut kernel = FusedRollOut::new(&wiring, &widths);
    let parameters: Vec<f32> = kernel.layout().flatten(&networks).expect("of these widths");
    let mut message = |edit: &Edit| {
        let mut gradient = vec![0.0; parameters.len()];
        let (mut sequences, mut parameters) = (data.sequences(), parameters.clone());
        edit(&mut sequences, &mut parameters, &mut gradient);
        let result = kernel.gradient(&parameters, &sequences, &terms(&data), &mut gradient);
        result.map_err(|error: ModelError| error.to_string())
    };
    assert!(message(&|_, _, _| ()).is_ok());
    let cases: [(&Edit, &str); 7] = [
        (&|s, _, _| s[2].inputs = &s[2].inputs[1..], "inputs of sequence 2: expected shape [8]"),
        (
            &|s, _, _| s[1].initial = &s[1].initial[1..],
            "initial of sequence 1: expected shape [10]",
        ),
        (&|s, _, _| s[1].truth = &[], "truth of sequence 1: expected shape [40], found [0]"),
        (&|s, _, _| s.clear(), "tensor inputs"),
        (&|_, p, _| p[7] = f32::NAN, "tensor parameters: entry 7 is not a finite number"),
        (&|_, p, _| p.truncate(7), "tensor parameters: expected shape"),
        (&|_, _, g| g.truncate(7), "tensor parameters: expected shape"),
    ];
    for (edit, expected) in cases {
        let error = message(edit).expect_err(expected);
        assert!(error.contains(expected), "{error} lacks {expected}");
    }
}

#[test]
fn a_start_that_is_not_a_number_is_seen() {
    let (wiring, widths) = (Wiring::paper(), Widths::quick());
    let networks = initial_networks(&wiring, &widths, 0.3, 3);
    for value in [f32::NAN, f32::INFINITY] {
        let mut data = Data::<f32>::random(6, 3, 4);
        data.initial[10 + Compartment::Q1 as usize] = value;
        let mut kernel = FusedRollOut::new(&wiring, &widths).with_glucose_range((-1.0, 1.0));
        let parameters: Vec<f32> = kernel.layout().flatten(&networks).expect("of these widths");
        let mut gradient = vec![0.0; parameters.len()];
        let loss = kernel.gradient(&parameters, &data.sequences(), &terms(&data), &mut gradient);
        assert!(!loss.expect("fits").is_finite(), "{value}");
    }
}
