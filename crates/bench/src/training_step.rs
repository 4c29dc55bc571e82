//! `bench --what training-step`: what one update of the population network costs.
//!
//! The paper's batch, length and widths: our kernel, on each set of instructions that the machine has,
//! beside the same computation as a plain candle graph and, where it is installed, PyTorch. All take
//! turns, so that the load of the moment falls on each alike; PyTorch, a process of its own, follows.

use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context as _, Result, ensure};
use candle_core::{DType, Device, Tensor};
use candle_nn::{AdamW, Optimizer as _, ParamsAdamW};
use contract::Document as _;
use contract::bench::{StepRow, TrainingStepBench};
use nn_statespace::kernel::{FusedRollOut, Instructions, Sequence};
use nn_statespace::training::loss::{Loss, LossConfig};
use nn_statespace::training::{
    Advance, CarbStart, LossTerms, RollOut, Run, Stage, TrainingConfig, TrainingRun, WindowSet,
    initial_networks,
};
use nn_statespace::{Scaler, Widths, Wiring};
use ode_sim::{DevelopmentPlan, DevelopmentSet, OdeState};
use physiology::{Plant as _, States, Trajectory};

use pipeline::{Manifest, OutputFolder, Progress, note};

use crate::peer::{self, Peer};

/// Windows of a batch and steps of a window (paper).
const BATCH: usize = 128;
const STEPS: usize = 60;
/// Steps between the starts of windows (paper).
const STRIDE: usize = 15;
/// Times that each engine takes its turn; the first ones warm it up.
const ROUNDS: usize = 40;
const WARM_UP: usize = 5;
/// The speed that is aimed at, against PyTorch.
const TARGET: f64 = 25.0;
/// Windows and epochs of the paper's training.
const PAPER_WINDOWS: f64 = 1e6;
const PAPER_EPOCHS: f64 = 15.0;
/// Weights of the ten networks.
const PARAMETERS: usize = 6782;

const WHOLE: &str = "update";
const GRADIENT: &str = "gradient";

/// Times engines and writes `bench.json` and `bench.txt` into the folder `out`.
pub fn run(out: &Path, seed: u64) -> Result<()> {
    let most = rayon::current_num_threads();
    let config = serde_json::json!({
        "what": "training_step", "batch": BATCH, "steps": STEPS, "threads": most, "rounds": ROUNDS,
    });
    let output = OutputFolder::begin(out, Manifest::new("bench", config, Some(seed)))?;
    let windows = windows(seed)?;
    let mut rows = Vec::new();
    let mut counts = vec![1, most];
    counts.dedup();
    for threads in counts {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        rows.extend(pool.install(|| engines(&windows, seed, threads))?);
        rows.extend(pytorch(threads)?);
    }
    let text = format!("{}\n", text(&rows));
    output.write_document(&TrainingStepBench {
        batch: BATCH,
        rows,
        schema: TrainingStepBench::SCHEMA.to_owned(),
        steps: STEPS,
        what: "training_step".to_owned(),
    })?;
    let place = output.finish_with_table("bench.txt", &text)?;
    note(format!("bench: {}", place.join(TrainingStepBench::FILE).display()));
    Ok(())
}

/// Two batches of windows of the development set.
fn windows(seed: u64) -> Result<WindowSet> {
    let set = DevelopmentSet::new(DevelopmentPlan::quick(seed)).context("the development set")?;
    // As many steps of each of two weeks as hold one batch.
    let steps = STEPS + (BATCH - 1) * STRIDE;
    let weeks = set.simulate(0..2).context("simulating two weeks")?;
    let report = |(_, run): (_, Trajectory<OdeState>)| {
        let states = run.states.iter().take(steps + 1).map(|x| set.plant().report(x));
        (states.collect(), run.inputs)
    };
    let reported: Vec<(Vec<States>, _)> = weeks.into_iter().map(report).collect();
    let runs = reported.iter().map(|(states, inputs)| {
        let inputs = inputs.get(..steps).context("a week is longer than a batch's windows")?;
        Ok(Run { states, inputs })
    });
    let runs: Vec<Run<'_>> = runs.collect::<Result<_>>()?;
    let scaler = Scaler::fit(&runs).context("the scaler")?;
    let windows = WindowSet::new(&scaler, &runs, STEPS, STRIDE, CarbStart::Reported)?;
    ensure!(windows.len() == 2 * BATCH, "{} windows instead of two batches", windows.len());
    Ok(windows)
}

/// Something to be timed: its name, the part of an update it does, and a turn of it. A turn returns
/// whether it counts.
struct Engine<'a> {
    name: String,
    part: &'static str,
    turn: Box<dyn FnMut() -> Result<bool> + 'a>,
}

impl Engine<'_> {
    /// Milliseconds of the next turn that counts.
    fn milliseconds(&mut self) -> Result<f64> {
        loop {
            let clock = Instant::now();
            if (self.turn)()? {
                return Ok(1e3 * clock.elapsed().as_secs_f64());
            }
        }
    }
}

fn engines(windows: &WindowSet, seed: u64, threads: usize) -> Result<Vec<StepRow>> {
    let mut engines = vec![graph(windows, seed)?, kernel(windows, seed)?];
    for instructions in Instructions::available() {
        engines.push(gradient(windows, seed, instructions)?);
    }
    let progress = Progress::begin("bench", ROUNDS);
    let mut times = vec![Vec::new(); engines.len()];
    for round in 0..WARM_UP + ROUNDS {
        for (engine, times) in engines.iter_mut().zip(&mut times) {
            let milliseconds = engine.milliseconds()?;
            if round >= WARM_UP {
                times.push(milliseconds);
            }
        }
        if round >= WARM_UP {
            progress.advance("rounds");
        }
    }
    progress.finish(&format!("training step timed on {threads} threads"));
    let rows = engines.into_iter().zip(times).map(|(engine, mut times)| {
        times.sort_by(f64::total_cmp);
        let (part, median_ms, least_ms) = (engine.part.to_owned(), times[ROUNDS / 2], times[0]);
        StepRow { engine: engine.name, threads, part, median_ms, least_ms }
    });
    Ok(rows.collect())
}

/// What training does: an update of a run.
fn kernel(windows: &WindowSet, seed: u64) -> Result<Engine<'_>> {
    let stage = Stage { epochs: usize::MAX, ..TrainingConfig::paper(seed).stages[0] };
    let config = TrainingConfig { stages: vec![stage], ..TrainingConfig::paper(seed) };
    let mut run = TrainingRun::begin(&config, &Widths::paper(), windows, windows)?;
    // The second update of an epoch comes with a validation, which is not what is timed.
    let turn = move || Ok(run.advance()? == Advance::Batch);
    Ok(Engine { name: "our kernel".to_owned(), part: WHOLE, turn: Box::new(turn) })
}

/// The gradient alone, with one set of instructions.
fn gradient(windows: &WindowSet, seed: u64, instructions: Instructions) -> Result<Engine<'_>> {
    let (wiring, widths) = (Wiring::paper(), Widths::paper());
    let mut kernel = FusedRollOut::new(&wiring, &widths).with_instructions(instructions);
    let networks = initial_networks(&wiring, &widths, 0.1, seed);
    let parameters: Vec<f32> = kernel.layout().flatten(&networks)?;
    let batch: Vec<Sequence<'_, f32>> = (0..BATCH).map(|w| windows.sequence(w, STEPS)).collect();
    let config = LossConfig::paper();
    let loss = LossTerms::new(&config, windows.scaler(), windows.minima(), BATCH * STEPS);
    let mut slopes = vec![0.0; parameters.len()];
    let turn = move || {
        kernel.gradient(&parameters, &batch, &loss, &mut slopes)?;
        Ok(true)
    };
    let name = format!("our kernel, {instructions:?}").to_lowercase();
    Ok(Engine { name, part: GRADIENT, turn: Box::new(turn) })
}

/// The same as a plain graph, with candle's optimiser.
fn graph(windows: &WindowSet, seed: u64) -> Result<Engine<'_>> {
    let (wiring, widths) = (Wiring::paper(), Widths::paper());
    let networks = initial_networks(&wiring, &widths, 0.1, seed);
    let graph = RollOut::new(&wiring, &networks, DType::F32)?;
    let loss = Loss::new(LossConfig::paper(), windows.scaler(), windows.minima(), DType::F32)?;
    let settings = ParamsAdamW { lr: 1e-3, weight_decay: 0.0, ..ParamsAdamW::default() };
    let mut optimiser = AdamW::new(graph.variables(), settings)?;
    let turn = move || {
        let (mut initial, mut inputs, mut truth) = (Vec::new(), Vec::new(), Vec::new());
        for window in 0..BATCH {
            initial.extend_from_slice(windows.sequence(window, STEPS).initial);
        }
        for step in 0..STEPS {
            for window in 0..BATCH {
                let sequence = windows.sequence(window, STEPS);
                inputs.extend_from_slice(&sequence.inputs[step * 2..][..2]);
                truth.extend_from_slice(&sequence.truth[step * 10..][..10]);
            }
        }
        let initial = Tensor::from_vec(initial, (BATCH, 10), &Device::Cpu)?;
        let inputs = Tensor::from_vec(inputs, (STEPS, BATCH, 2), &Device::Cpu)?;
        let truth = Tensor::from_vec(truth, (STEPS, BATCH, 10), &Device::Cpu)?;
        let total = loss.total(&graph.simulate(&initial, &inputs)?, &truth)?;
        optimiser.step(&total.backward()?)?;
        Ok(true)
    };
    Ok(Engine { name: "candle graph".to_owned(), part: WHOLE, turn: Box::new(turn) })
}

/// PyTorch, if it is installed.
fn pytorch(threads: usize) -> Result<Option<StepRow>> {
    let numbers = [("threads", threads), ("batch", BATCH), ("steps", STEPS), ("rounds", ROUNDS)];
    let options = numbers.map(|(name, number)| (name, number.to_string()));
    let peer = peer::times("training_step.py", &options, PARAMETERS)?;
    Ok(peer.map(|Peer { engine, median_ms, least_ms, .. }| StepRow {
        engine,
        threads,
        part: WHOLE.to_owned(),
        median_ms,
        least_ms,
    }))
}

fn text(rows: &[StepRow]) -> String {
    let mut text = format!(
        "One training step of {BATCH} windows of {STEPS} steps, the paper's widths, f32, ms:\n  \
         threads  engine                          part        median     least"
    );
    for StepRow { engine, threads, part, median_ms, least_ms } in rows {
        let _ = write!(
            text,
            "\n{threads:>9}  {engine:<30}  {part:<9} {median_ms:>8.2}  {least_ms:>8.2}"
        );
    }
    let most = rows.iter().map(|row| row.threads).max();
    let of = |name: &str| {
        let mut whole = rows.iter().filter(|row| row.part == WHOLE && Some(row.threads) == most);
        whole.find(|row| row.engine.starts_with(name))
    };
    if let Some(ours) = of("our kernel") {
        for (name, target) in [("candle", None), ("PyTorch", Some(TARGET))] {
            let Some(theirs) = of(name) else { continue };
            let (median, least) =
                (theirs.median_ms / ours.median_ms, theirs.least_ms / ours.least_ms);
            let _ = write!(
                text,
                "\n{}: {median:.0} times our time by medians, {least:.0} by the least, on {} threads",
                theirs.engine, ours.threads
            );
            if let Some(target) = target {
                let _ = write!(text, "; the target is {target}");
            }
        }
        let minutes = PAPER_WINDOWS / BATCH as f64 * PAPER_EPOCHS * ours.median_ms / 1e3 / 60.0;
        let _ = write!(
            text,
            "\nA million windows, {PAPER_EPOCHS} epochs: {minutes:.1} minutes of updates at this speed"
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn engines_take_turns_and_are_compared_on_the_most_threads() {
        let windows = windows(1).expect("two weeks");
        let mut kernel = kernel(&windows, 1).expect("fits");
        assert!(kernel.milliseconds().expect("a step") > 0.0);
        let row = |engine: &str, threads, part: &str, median_ms| {
            let engine = engine.to_owned();
            StepRow { engine, threads, part: part.to_owned(), median_ms, least_ms: median_ms / 2.0 }
        };
        let rows = [
            row("candle graph", 1, WHOLE, 90.0),
            row("our kernel", 1, WHOLE, 3.0),
            row("candle graph", 2, WHOLE, 100.0),
            row("our kernel", 2, WHOLE, 2.0),
            row("our kernel, avx2", 2, GRADIENT, 1.0),
            row("PyTorch 2 eager", 2, WHOLE, 60.0),
        ];
        let text = text(&rows);
        assert!(text.contains("candle graph: 50 times our time by medians"), "{text}");
        assert!(text.contains("PyTorch 2 eager: 30 times"), "{text}");
        assert!(text.contains("epochs: 3.9 minutes"), "{text}"); // 1e6 / 128 x 15 x 2 ms
    }
}
