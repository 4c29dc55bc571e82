//! The roll-out graph against the plant and central differences; training on a small plant.

use candle_core::{DType, Device, Tensor, Var};
use nn_statespace::structure::{products, slope_sign};
use nn_statespace::training::loss::{Loss, LossConfig};
use nn_statespace::training::{
    Advance, CarbStart, EarlyStop, GradientLimit, KeptWeights, LearningRate, ProductPenalty,
    Provenance, RollOut, Run, SlopeRule, Stage, Trained, TrainingConfig, TrainingRun, WindowSet,
    initial_networks, train,
};
use nn_statespace::{
    CentreAndScale, GlucoseClamp, ModelCard, ModelError, PerCompartment, PopulationModel, Scaler,
    Signal, Widths, Wiring,
};
use physiology::{Compartment, Grams, OpenLoop, States, StepInput, Units, UnitsPerHour, simulate};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const STEPS: usize = 12;
const BATCH: usize = 3;

fn tensor(values: Vec<f64>, shape: &[usize]) -> Tensor {
    Tensor::from_vec(values, shape, &Device::Cpu).expect("as many values as places")
}

fn random(rng: &mut ChaCha8Rng, count: usize) -> Vec<f64> {
    (0..count).map(|_| rng.random_range(-1.0..1.0)).collect()
}

fn unit_scaler() -> Scaler {
    let unit = CentreAndScale { centre: 0.0, scale: 1.0 };
    let mut states = PerCompartment::from_fn(|_| unit);
    states[Compartment::Q1] = CentreAndScale { centre: 120.0, scale: 80.0 };
    Scaler::new(states, unit, unit).expect("positive")
}

#[test]
fn the_graph_rolls_out_as_the_plant_does() {
    let (wiring, widths) = (Wiring::paper(), Widths::quick());
    let networks = initial_networks(&wiring, &widths, 0.1, 1);
    let graph = RollOut::new(&wiring, &networks, DType::F64).expect("fits");
    let card = ModelCard {
        origin: "test".to_owned(),
        version: "0".to_owned(),
        training_data_sha256: None,
        training: None,
    };
    let model = PopulationModel::new(wiring, networks, unit_scaler(), GlucoseClamp::Off, card)
        .expect("fits");
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let initial = random(&mut rng, 10);
    let inputs = random(&mut rng, 2 * STEPS);
    let simulated = graph
        .simulate(&tensor(initial.clone(), &[1, 10]), &tensor(inputs.clone(), &[STEPS, 1, 2]))
        .and_then(|states| Ok(states.squeeze(1)?.to_vec2::<f64>()?))
        .expect("shapes fit");
    let mut start = nn_statespace::ScaledStates::default();
    for (compartment, value) in Compartment::ALL.into_iter().zip(initial) {
        start[compartment] = value;
    }
    let steps: Vec<StepInput> = inputs
        .chunks_exact(2)
        .map(|u| StepInput {
            basal: UnitsPerHour(u[0]),
            carbs: Grams(u[1]),
            ..StepInput::default()
        })
        .collect();
    let run = simulate(&model, start, &mut OpenLoop::new(&steps), STEPS).expect("finite");
    for (step, row) in simulated.iter().enumerate() {
        for (compartment, value) in run.states[step + 1].iter() {
            // Rounding of sums in another order, over twelve steps.
            assert!((row[compartment as usize] - value).abs() < 1e-12, "{step} {compartment}");
        }
    }
}

#[test]
fn gradients_agree_with_central_differences() {
    let wiring = Wiring::paper();
    let widths = Widths::new(PerCompartment::from_fn(|_| 4)).expect("positive");
    let networks = initial_networks(&wiring, &widths, 0.3, 3);
    let graph = RollOut::new(&wiring, &networks, DType::F64).expect("fits");
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let initial = tensor(random(&mut rng, BATCH * 10), &[BATCH, 10]);
    let inputs = tensor(random(&mut rng, STEPS * BATCH * 2), &[STEPS, BATCH, 2]);
    let truth = random(&mut rng, STEPS * BATCH * 10).iter().map(|v| 4.0 * v).collect();
    let truth = tensor(truth, &[STEPS, BATCH, 10]);
    // High minima, so that the soft constraint is at work; truth reaches both glucose thresholds.
    let minima = PerCompartment::from_fn(|_| -0.2);
    let loss =
        Loss::new(LossConfig::paper(), &unit_scaler(), &minima, DType::F64).expect("ten columns");
    let value = || -> Tensor {
        let states = graph.simulate(&initial, &inputs).expect("shapes fit");
        loss.total(&states, &truth).expect("shapes fit")
    };
    let gradients = value().backward().expect("differentiable");
    let scalar = || value().to_scalar::<f64>().expect("a scalar");
    let mut compared = 0;
    for variable in graph.variables() {
        let gradient = gradients.get(&variable).expect("the loss depends on it");
        let gradient = gradient.flatten_all().and_then(|g| g.to_vec1::<f64>()).expect("f64");
        let weights = variable.flatten_all().and_then(|w| w.to_vec1::<f64>()).expect("f64");
        let set = |variable: &Var, values: Vec<f64>| {
            variable.set(&tensor(values, variable.dims())).expect("the same shape");
        };
        for (index, slope) in gradient.iter().enumerate() {
            let shifted = |by: f64| {
                let mut values = weights.clone();
                values[index] += by;
                set(&variable, values);
                let value = scalar();
                set(&variable, weights.clone());
                value
            };
            let step = 1e-6;
            let difference = (shifted(step) - shifted(-step)) / (2.0 * step);
            // Second-order error 1e-12 times curvature, rounding 1e-16/1e-6; a weight outside the
            // wiring has no effect at all.
            let error = (difference - slope).abs();
            assert!(error <= 1e-6 * (1.0 + slope.abs()), "{index}: {difference} {slope}");
            compared += usize::from(*slope != 0.0);
        }
    }
    // Nearly all of the wired weights; a few units are off throughout.
    let wired = 4 * (25 + 2 * 10) + 10;
    assert!(compared > wired * 8 / 10 && compared <= wired, "{compared} of {wired}");
}

/// A plant of ten linear compartments with the paper's wiring, in physical units, with noise-free
/// inputs: meals and boluses at random times.
fn linear_runs(seed: u64, runs: usize, steps: usize) -> Vec<(Vec<States>, Vec<StepInput>)> {
    use Compartment::{C1, C2, I, Q1, Q2, S1, S2, X1, X2, X3};
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..runs)
        .map(|_| {
            let inputs: Vec<StepInput> = (0..steps)
                .map(|step| {
                    let meal = step % 48 == 12;
                    let carbs = if meal { rng.random_range(20.0..90.0) } else { 0.0 };
                    let bolus = if meal { carbs / rng.random_range(40.0..80.0) } else { 0.0 };
                    StepInput {
                        basal: UnitsPerHour(1.0),
                        bolus: Units(bolus),
                        carbs: Grams(carbs),
                        ..StepInput::default()
                    }
                })
                .collect();
            let mut x = States::default();
            for (compartment, value) in
                [(S1, 50.0), (S2, 50.0), (I, 10.0), (X1, 0.1), (X2, 0.1), (X3, 0.1), (Q2, 6.0)]
            {
                x[compartment] = value;
            }
            x[Q1] = rng.random_range(80.0..200.0);
            let mut states = vec![x];
            for input in &inputs {
                let mut next = x;
                next[C1] += input.carbs.0 / 20.0 - 5.0 * x[C1] / 40.0;
                next[C2] += 5.0 * (x[C1] - x[C2]) / 40.0;
                next[S1] += 5.0 * (input.insulin().0 - x[S1] / 50.0);
                next[S2] += 5.0 * (x[S1] - x[S2]) / 50.0;
                next[I] += 5.0 * (0.01 * x[S2] - 0.05 * x[I]);
                for state in [X1, X2, X3] {
                    next[state] += 5.0 * 0.02 * (0.01 * x[I] - x[state]);
                }
                next[Q1] += 5.0
                    * (2.4 * x[C2] - 6.0 * x[X1] - 3.0 * x[X3] + 0.2 * x[Q2] - 0.03 * x[Q1] + 3.3);
                next[Q2] += 5.0 * (0.002 * x[Q1] - 0.04 * x[Q2] + 0.1 * x[X1] - 0.1 * x[X2]);
                x = next;
                states.push(x);
            }
            (states, inputs)
        })
        .collect()
}

fn windows(scaler: Option<&Scaler>, seed: u64, stride: usize) -> WindowSet {
    let runs = linear_runs(seed, 4, 288);
    let runs: Vec<Run<'_>> = runs.iter().map(|(states, inputs)| Run { states, inputs }).collect();
    let fitted = Scaler::fit(&runs).expect("finite rows");
    WindowSet::new(scaler.unwrap_or(&fitted), &runs, 24, stride, CarbStart::Reported)
        .expect("runs longer than a window")
}

fn small_config(seed: u64, epochs: usize) -> TrainingConfig {
    TrainingConfig {
        stages: vec![
            Stage { epochs, steps: 4, learning_rate: LearningRate { first: 1e-2, decay: 0.02 } },
            Stage { epochs, steps: 24, learning_rate: LearningRate { first: 5e-3, decay: 0.1 } },
        ],
        batch: 16,
        loss: LossConfig::paper(),
        gradient_limit: GradientLimit::Norm(1.0),
        initial_output_gain: 0.1,
        clamp: GlucoseClamp::Off,
        slopes: SlopeRule::Kept(ProductPenalty::working()),
        keep: KeptWeights::LowestValidationError,
        stop: EarlyStop::Off,
        seed,
    }
}

fn run_training(config: &TrainingConfig) -> Result<Trained, ModelError> {
    let training = windows(None, 21, 3);
    let validation = windows(Some(training.scaler()), 22, 24);
    let provenance = Provenance { origin: "linear plant".to_owned(), training_data_sha256: None };
    let mut told = 0;
    let trained = train(config, &Widths::quick(), &training, &validation, provenance, |report| {
        assert_eq!(report.epoch, told);
        told += 1;
    })?;
    assert_eq!(told, trained.report.epochs.len());
    Ok(trained)
}

/// Root mean square error of saying that glucose stays where it starts, mg/dL.
fn persistence(windows: &WindowSet) -> f64 {
    let glucose = Compartment::Q1 as usize;
    let scale = windows.scaler().of(Signal::State(Compartment::Q1)).scale;
    let squares: Vec<f64> = (0..windows.len())
        .flat_map(|window| {
            let states = windows.states(window);
            let start = f64::from(states[glucose]);
            let rows = states.chunks_exact(10).skip(1);
            rows.map(move |row| (f64::from(row[glucose]) - start).powi(2))
        })
        .collect();
    scale * (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

#[test]
fn training_learns_a_linear_plant() {
    for slopes in [SlopeRule::Free, SlopeRule::Kept(ProductPenalty::working())] {
        learns(slopes);
    }
}

fn learns(slopes: SlopeRule) {
    let trained = run_training(&TrainingConfig { slopes, ..small_config(1, 15) }).expect("trains");
    let epochs = &trained.report.epochs;
    let errors: Vec<f64> = epochs.iter().map(|epoch| epoch.validation.balanced()).collect();
    let kept = errors[trained.report.kept_epoch];
    assert!(errors.iter().all(|error| kept <= *error));
    let last_stage = epochs.iter().filter(|epoch| epoch.stage == 1);
    let losses: Vec<f64> = last_stage.map(|epoch| epoch.training_loss).collect();
    assert!(losses[14] < 0.2 * losses[0], "loss {} to {}", losses[0], losses[14]);
    let scaler = *windows(None, 21, 3).scaler();
    let baseline = persistence(&windows(Some(&scaler), 22, 24));
    // Measured 0.03 to 0.1 of it; a model that misses meals or insulin stays above half.
    assert!(kept < 0.3 * baseline, "{kept} mg/dL, persistence {baseline} mg/dL");
}

/// The worst slope against physiology at random states of the training range, by network and input.
fn worst_slopes(model: &PopulationModel, windows: &WindowSet) -> Vec<(Compartment, Signal, f64)> {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let mut worst = Vec::new();
    for network in Compartment::ALL {
        let inputs = model.wiring().inputs(network);
        let mut most = vec![f64::NEG_INFINITY; inputs.len()];
        for _ in 0..2000 {
            let point: Vec<f64> = inputs
                .iter()
                .map(|signal| {
                    let (low, high) = windows.bounds(*signal);
                    rng.random_range(low..=high)
                })
                .collect();
            let mut slopes = vec![0.0; inputs.len()];
            model.network(network).add_gradient(&point, 1.0, &mut slopes);
            for ((most, slope), signal) in most.iter_mut().zip(slopes).zip(inputs) {
                *most = most.max(-slope * f64::from(slope_sign(network, *signal).factor()));
            }
        }
        worst.extend(inputs.iter().zip(most).map(|(signal, most)| (network, *signal, most)));
    }
    worst
}

#[test]
fn kept_slopes_have_the_signs_of_physiology_and_free_ones_have_not() {
    let windows = windows(None, 21, 3);
    let trained = |slopes| {
        let config = TrainingConfig { slopes, ..small_config(1, 8) };
        worst_slopes(&run_training(&config).expect("trains").model, &windows)
    };
    for (network, signal, most) in trained(SlopeRule::Kept(ProductPenalty::working())) {
        // Sums that stand for products only pay for wrong slopes; the others cannot have them.
        let is_paid =
            products(network).iter().flatten().any(|state| Signal::State(*state) == signal);
        let allowed = if is_paid { 2e-3 } else { 1e-7 }; // rounding of single-precision products
        assert!(most <= allowed, "{network} by {signal}: {most}");
    }
    let free = trained(SlopeRule::Free);
    assert!(free.iter().any(|(_, _, most)| *most > 0.01), "{free:?}");
}

#[test]
fn a_seed_fixes_every_byte() {
    let bytes = |seed| {
        let trained = run_training(&small_config(seed, 2)).expect("trains");
        let curve = serde_json::to_string(&trained.report).expect("plain data");
        (trained.model.to_safetensors(), curve)
    };
    let first = bytes(5);
    assert!(first == bytes(5), "two runs differ");
    assert!(first != bytes(6), "the seed has no effect");
}

/// The model's file and the curves of a run that is taken to its end.
fn finished(mut run: TrainingRun<'_>) -> (Vec<u8>, String) {
    while run.advance().expect("trains") != Advance::Finished {}
    let provenance = Provenance { origin: "linear plant".to_owned(), training_data_sha256: None };
    let trained = run.finish(provenance).expect("epochs are done");
    let curves = serde_json::to_string(&trained.report).expect("plain data");
    (trained.model.to_safetensors(), curves)
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    // The paper's widths and batch: four blocks a batch.
    let training = windows(None, 21, 3);
    let config = TrainingConfig { batch: 128, ..small_config(1, 1) };
    let trained = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let run = TrainingRun::begin(&config, &Widths::paper(), &training, &training);
            finished(run.expect("fits"))
        })
    };
    let one = trained(1);
    for threads in [2, 3] {
        assert!(trained(threads) == one, "{threads} threads give other bytes than one");
    }
}

#[test]
fn a_run_resumed_anywhere_gives_the_same_bytes() {
    let (training, widths) = (windows(None, 21, 12), Widths::quick());
    let validation = windows(Some(training.scaler()), 22, 24);
    // Early stopping as well, so that what it needs to know is written down.
    let config = TrainingConfig { stop: EarlyStop::Patience(1), ..small_config(1, 2) };
    let begin = || TrainingRun::begin(&config, &widths, &training, &validation).expect("fits");
    let whole = finished(begin());
    let mut run = begin();
    let mut stops = 0;
    loop {
        let checkpoint = run.checkpoint();
        let resumed = TrainingRun::resume(&checkpoint, &config, &widths, &training, &validation);
        let resumed = resumed.expect("the same run");
        assert_eq!(resumed.updates(), run.updates());
        assert!(finished(resumed) == whole, "after {stops} updates");
        // From here on it is the run that was resumed from a file each time.
        run = TrainingRun::resume(&checkpoint, &config, &widths, &training, &validation)
            .expect("the same run");
        if run.advance().expect("trains") == Advance::Finished {
            break;
        }
        stops += 1;
    }
    let batches = training.len().div_ceil(config.batch);
    assert!(batches > 2 && stops >= 2 * batches, "{batches} batches, {stops} stops");
    assert_eq!(stops % batches, 0);

    let checkpoint = begin().checkpoint();
    let message = |config: &TrainingConfig, widths: &Widths, validation: &WindowSet| {
        TrainingRun::resume(&checkpoint, config, widths, &training, validation)
            .map(drop)
            .expect_err("another run")
            .to_string()
    };
    let other = small_config(2, 2);
    assert!(message(&other, &widths, &validation).contains("another configuration"));
    assert!(message(&config, &Widths::paper(), &validation).contains("other widths"));
    let other = windows(Some(training.scaler()), 23, 24);
    assert!(message(&config, &widths, &other).contains("other data"));
}

/// A checkpoint that says that so many batches of its epoch are done; one digit.
fn with_batches(checkpoint: &[u8], digit: u8) -> Vec<u8> {
    let key = br#"\"batches\":"#;
    let at = checkpoint.windows(key.len()).position(|bytes| bytes == key);
    let mut changed = checkpoint.to_vec();
    changed[at.expect("a number in the header") + key.len()] = digit;
    changed
}

#[test]
fn a_checkpoint_of_more_batches_than_an_epoch_has_is_refused() {
    let (training, config, widths) = (windows(None, 21, 12), small_config(1, 1), Widths::quick());
    let begun = TrainingRun::begin(&config, &widths, &training, &training).expect("fits");
    let checkpoint = begun.checkpoint();
    // Batches of 16 windows: the sixth is the last one, and shorter.
    assert_eq!(training.len(), 92);
    let resumed = |digit| {
        let changed = with_batches(&checkpoint, digit);
        TrainingRun::resume(&changed, &config, &widths, &training, &training)
    };
    let ended = resumed(b'5').expect("one batch is left").advance().expect("trains");
    assert!(matches!(ended, Advance::Epoch(_)), "{ended:?}");
    for digit in [b'6', b'9'] {
        let error = resumed(digit).map(drop).expect_err("no such batch").to_string();
        assert!(error.contains("more batches than an epoch has"), "{error}");
    }
}

/// Tells a process that this test started where to write its checkpoints.
const CHECKPOINT: &str = "NN_STATESPACE_TEST_CHECKPOINT";

#[test]
fn a_run_that_is_killed_goes_on_to_the_same_bytes() {
    let (training, config, widths) = (windows(None, 21, 3), small_config(3, 2), Widths::quick());
    let begin = || TrainingRun::begin(&config, &widths, &training, &training).expect("fits");
    if let Some(path) = std::env::var_os(CHECKPOINT) {
        let path = std::path::PathBuf::from(path);
        let mut run = begin();
        for update in 1_usize.. {
            run.advance().expect("trains");
            if update.is_multiple_of(7) {
                let beside = path.with_extension("new");
                std::fs::write(&beside, run.checkpoint()).expect("writable");
                std::fs::rename(beside, &path).expect("the same folder");
            }
            if update == 50 {
                // No destructor runs, as when the system ends a process.
                std::process::abort();
            }
        }
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("run.checkpoint");
    let status = std::process::Command::new(std::env::current_exe().expect("this test"))
        .args(["--exact", "training::a_run_that_is_killed_goes_on_to_the_same_bytes"])
        .env(CHECKPOINT, &path)
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .status()
        .expect("starts");
    assert!(!status.success(), "the process ended by itself, or no test has this name");
    let checkpoint = std::fs::read(&path).expect("written before the end");
    let resumed = TrainingRun::resume(&checkpoint, &config, &widths, &training, &training);
    let resumed = resumed.expect("the same run");
    assert_eq!(resumed.updates(), 49);
    assert!(finished(resumed) == finished(begin()));
}

#[test]
fn a_stage_that_gets_no_better_is_left() {
    let mut config = small_config(1, 6);
    // No learning at all in the first stage.
    config.stages[0].learning_rate.first = 0.0;
    config.stop = EarlyStop::Patience(2);
    let trained = run_training(&config).expect("trains");
    let of_first = trained.report.epochs.iter().filter(|epoch| epoch.stage == 0).count();
    assert_eq!(of_first, 3);
    assert!(trained.report.epochs.len() > 3, "the second stage is not left out");
}

#[test]
fn the_authors_codes_model_is_trained_and_runs_with_its_clamp() {
    let paper = TrainingConfig::paper(1);
    let code = TrainingConfig::authors_code(1);
    assert_eq!(code, TrainingConfig { clamp: GlucoseClamp::Reproduction, ..paper });
    // With outputs of full size, roll-outs of random weights leave the monitor's range.
    let config = |clamp| TrainingConfig { clamp, initial_output_gain: 1.0, ..small_config(1, 1) };
    let trained = |clamp| run_training(&config(clamp)).expect("trains");
    let (clamped, free) = (trained(GlucoseClamp::Reproduction), trained(GlucoseClamp::Off));
    assert_eq!(clamped.model.clamp(), GlucoseClamp::Reproduction);
    assert_eq!(free.model.clamp(), GlucoseClamp::Off);
    let network = |trained: &Trained| trained.model.network(Compartment::Q1).clone();
    assert!(network(&clamped) != network(&free), "the clamp has no effect on training");
}

#[test]
fn what_does_not_fit_is_refused() {
    let message = |config: &TrainingConfig| {
        run_training(config).map(drop).expect_err("does not fit").to_string()
    };
    let mut config = small_config(1, 1);
    config.stages[1].steps = 25;
    assert_eq!(message(&config), "training: a stage of 25 steps on windows of 24");
    config.stages.clear();
    assert_eq!(message(&config), "training: no batches or no epochs");
    let mut config = small_config(1, 1);
    config.stages[0].learning_rate.first = 1e30;
    config.gradient_limit = GradientLimit::Off;
    assert!(message(&config).contains("lower the learning rate"), "{}", message(&config));

    let (mut states, inputs) = linear_runs(1, 1, 40).remove(0);
    let window_error = |states: &[States], inputs: &[StepInput], length| {
        let run = [Run { states, inputs }];
        WindowSet::new(&unit_scaler(), &run, length, 6, CarbStart::Zero).map(drop)
    };
    let error = window_error(&states, &inputs[1..], 24).expect_err("one input is missing");
    assert_eq!(error.to_string(), "windows, run 0: there must be one more state than inputs");
    let error = window_error(&states, &inputs, 41).expect_err("40 steps");
    assert_eq!(error.to_string(), "windows, run 1: no run is as long as a window");
    states[17][Compartment::X2] = f64::NAN;
    let error = window_error(&states, &inputs, 24).expect_err("NaN");
    assert_eq!(error.to_string(), "tensor run 0, X2: entry 17 is not a finite number");
}

#[test]
fn windows_overlap_and_stay_within_their_runs() {
    let runs = linear_runs(3, 2, 50);
    let runs: Vec<Run<'_>> = runs.iter().map(|(states, inputs)| Run { states, inputs }).collect();
    let scaler = Scaler::fit(&runs).expect("finite");
    let set = WindowSet::new(&scaler, &runs, 20, 10, CarbStart::Reported).expect("fits");
    assert_eq!(set.len(), 8); // starts 0, 10, 20, 30 of each run
    let expected = scaler.scale(&runs[1].states[10 + 7]);
    let row = &set.states(5)[7 * 10..][..10];
    for (compartment, value) in expected.iter() {
        assert_eq!(row[compartment as usize], value as f32, "{compartment}");
    }
    let expected = scaler.scale_input(&runs[1].inputs[10 + 2]);
    assert_eq!(set.inputs(5)[4..6], [expected.insulin as f32, expected.carbs as f32]);
    assert_eq!(set.minima()[Compartment::C1], 0.0);
    let zero = WindowSet::new(&scaler, &runs, 20, 10, CarbStart::Zero).expect("fits");
    assert!((0..zero.len()).all(|w| zero.states(w)[Compartment::C1 as usize] == 0.0));
    let mut a = Vec::new();
    let mut b = Vec::new();
    set.write_canonical(&mut a).expect("memory");
    zero.write_canonical(&mut b).expect("memory");
    assert!(a != b && a.len() == b.len());
}
