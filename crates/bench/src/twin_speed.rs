//! `bench --what twins`: what a twin costs to train and to run.
//!
//! A thousand days of one twin, one day by itself, an update on a batch of windows, and the paper's
//! training of the people of the embedded cohort. Beside all but the last, where it is installed, the
//! same in PyTorch. The published package simulates one record a call, so that its thousand days are
//! a thousand times its one day; all of them in one batch are what its users could make of it.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context as _, Result, bail, ensure};
use cohort::{Cohort, MissingDoses};
use contract::Document as _;
use contract::bench::{JobRow, TwinsBench, WholeTraining};
use nn_statespace::PopulationModel;
use nn_statespace::initial_state::steady_state;
use physiology::{MgPerDl, OpenLoop, STEPS_PER_DAY, StepInput, simulate};
use twins::{
    BuiltTwin, Doses, InputSet, KeptEpoch, PreparedWindow, Protocol, ResidualNetwork, TrainingPlan,
    Twin, TwinRecipe, build_twins, simulate_many, train,
};

use pipeline::people::read_cohort;
use pipeline::usage::processor_seconds;
use pipeline::{Manifest, OutputFolder, Progress, note, workspace_root};

use crate::peer;

/// Days of one twin.
const DAYS: usize = 1000;
/// Windows of a batch and steps of a window (paper).
const BATCH: usize = 32;
const STEPS: usize = 59;
/// Turns that are timed.
const ROUNDS: usize = 9;
/// Updates of a turn.
const UPDATES: usize = 20;
/// The speed that is aimed at, against the published code.
const TARGET: f64 = 20.0;
/// Processor seconds that the authors' training of a twin takes.
const AUTHORS_SECONDS: f64 = 4.6 * 60.0;
/// Twins of the paper.
const TWINS: f64 = 394.0;
/// Weights of population and residual network.
const PARAMETERS: usize = 6_782 + 11_777;

const THOUSAND_DAYS: &str = "1,000 days";
const ONE_DAY: &str = "1 day";
const UPDATE: &str = "update";
const OURS: &str = "ours";

/// Times twins and writes `bench.json` and `bench.txt` into the folder `out`.
pub fn run(out: &Path, seed: u64) -> Result<()> {
    let most = rayon::current_num_threads();
    let config = serde_json::json!({
        "what": "twins", "days": DAYS, "batch": BATCH, "steps": STEPS, "threads": most,
    });
    let output = OutputFolder::begin(out, Manifest::new("bench", config, Some(seed)))?;
    let cohort = read_cohort(&workspace_root().join("fixtures/embedded/cohort"))?;
    let population = Arc::new(PopulationModel::shipped().context("the shipped network")?);
    let progress = Progress::begin("bench", 3);
    let whole = whole_training(&cohort, &population, seed, most)?;
    progress.advance("training");
    let twin = whole.1.twin;
    let mut rows = Vec::new();
    let mut counts = vec![1, most];
    counts.dedup();
    for threads in counts {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        rows.push(pool.install(|| days(&twin, &cohort, threads))?);
        rows.extend(pytorch(THOUSAND_DAYS, threads)?);
        progress.advance("days");
    }
    rows.push(one_day(&twin, &cohort)?);
    rows.extend(pytorch(ONE_DAY, 1)?);
    // One person trains on one thread.
    rows.push(updates(&twin, &cohort, seed)?);
    rows.extend(pytorch(UPDATE, 1)?);
    let text = format!("{}\n", text(&rows, &whole.0));
    output.write_document(&TwinsBench {
        rows,
        schema: TwinsBench::SCHEMA.to_owned(),
        training: whole.0,
        what: "twins".to_owned(),
    })?;
    let place = output.finish_with_table("bench.txt", &text)?;
    note(format!("bench: {}", place.join(TwinsBench::FILE).display()));
    Ok(())
}

/// The paper's training of everybody in the embedded cohort; one of the twins.
fn whole_training(
    cohort: &Cohort,
    population: &Arc<PopulationModel>,
    seed: u64,
    threads: usize,
) -> Result<(WholeTraining, BuiltTwin)> {
    let recipe = TwinRecipe {
        population: Arc::clone(population),
        protocol: Protocol::paper(),
        plan: TrainingPlan::paper(),
        inputs: InputSet::All,
        doses: Doses::Population,
        seed,
    };
    let (clock, before) = (Instant::now(), processor_seconds());
    let built = build_twins(cohort, &recipe, &|_| {})?;
    let seconds = clock.elapsed().as_secs_f64();
    let processor_seconds = processor_seconds().zip(before).map(|(after, before)| after - before);
    let windows = built.iter().map(|person| person.windows_train).sum();
    let epochs = recipe.plan.epochs;
    let people = built.len();
    let Some(first) = built.into_iter().find_map(|person| person.result.ok()) else {
        bail!("nobody of the embedded cohort has a twin");
    };
    Ok((WholeTraining { people, threads, seconds, processor_seconds, windows, epochs }, first))
}

/// Days of the cohort's records under one twin, again and again until there are enough.
fn days(twin: &Twin, cohort: &Cohort, threads: usize) -> Result<JobRow> {
    let mut inputs: Vec<Vec<StepInput>> = Vec::new();
    for person in &cohort.people {
        let all = person.inputs(0..person.record.len(), MissingDoses::Zero)?;
        inputs.extend(all.chunks_exact(STEPS_PER_DAY).map(<[StepInput]>::to_vec));
    }
    let starts = vec![steady_state(&twin.population, MgPerDl(120.0))?.states; DAYS];
    let runs: Vec<&[StepInput]> = inputs.iter().map(Vec::as_slice).cycle().take(DAYS).collect();
    let mut found = 0;
    let row = timed(THOUSAND_DAYS, threads, || {
        found = simulate_many(twin, &starts, &runs)?.len();
        Ok(1.0)
    })?;
    ensure!(found == DAYS, "{found} days were simulated");
    Ok(row)
}

/// One day in the simulation loop that everything else uses, in double precision.
fn one_day(twin: &Twin, cohort: &Cohort) -> Result<JobRow> {
    let inputs = cohort.people[0].inputs(0..STEPS_PER_DAY, MissingDoses::Zero)?;
    let start = steady_state(&twin.population, MgPerDl(120.0))?.states;
    timed(ONE_DAY, 1, || {
        for _ in 0..UPDATES {
            simulate(twin, start, &mut OpenLoop::new(&inputs), STEPS_PER_DAY)?;
        }
        Ok(UPDATES as f64)
    })
}

/// Updates on one batch of a person's windows.
fn updates(twin: &Twin, cohort: &Cohort, seed: u64) -> Result<JobRow> {
    let person = &cohort.people[0];
    let inputs = person.inputs(0..person.record.len(), MissingDoses::Zero)?;
    let start = steady_state(&twin.population, MgPerDl(120.0))?.states;
    let windows = (0..BATCH)
        .map(|window| {
            let first = window * STEPS;
            let glucose: Vec<f64> =
                (0..=STEPS).map(|k| 120.0 + 60.0 * (0.1 * (k + window) as f64).sin()).collect();
            let inputs = inputs[first..first + STEPS].to_vec();
            let scaler = twin.heart_rate_scaler.as_ref();
            PreparedWindow::new(&twin.population, inputs, &glucose, start, scaler, InputSet::All)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let plan = TrainingPlan { epochs: UPDATES, keep: KeptEpoch::Last, ..TrainingPlan::paper() };
    timed(UPDATE, 1, || {
        let network = ResidualNetwork::untrained(seed);
        // One batch is one update an epoch; the losses before and after come on top.
        train(&twin.population, network, &windows, &[], &plan, seed)?;
        Ok(UPDATES as f64)
    })
}

/// Milliseconds of a turn for each of the pieces that it says it did.
fn timed(job: &str, threads: usize, mut turn: impl FnMut() -> Result<f64>) -> Result<JobRow> {
    turn()?;
    let before = processor_seconds();
    let (mut times, mut pieces) = (Vec::new(), 0.0);
    for _ in 0..ROUNDS {
        let clock = Instant::now();
        let done = turn()?;
        times.push(1e3 * clock.elapsed().as_secs_f64() / done);
        pieces += done;
    }
    let processor = processor_seconds().zip(before);
    times.sort_by(f64::total_cmp);
    Ok(JobRow {
        job: job.to_owned(),
        engine: OURS.to_owned(),
        threads,
        median_ms: times[times.len() / 2],
        least_ms: times[0],
        processor_ms: processor.map(|(after, before)| 1e3 * (after - before) / pieces),
    })
}

/// PyTorch, if it is installed.
fn pytorch(job: &str, threads: usize) -> Result<Option<JobRow>> {
    let (what, runs, steps) = match job {
        THOUSAND_DAYS => ("days", DAYS, STEPS_PER_DAY),
        ONE_DAY => ("days", 1, STEPS_PER_DAY),
        _ => ("training", BATCH, STEPS),
    };
    let numbers = [("threads", threads), ("runs", runs), ("steps", steps), ("rounds", ROUNDS)];
    let mut options = vec![("what", what.to_owned())];
    options.extend(numbers.map(|(name, number)| (name, number.to_string())));
    let peer = peer::times("twin.py", &options, PARAMETERS)?;
    Ok(peer.map(|peer| JobRow {
        job: job.to_owned(),
        engine: peer.engine,
        threads,
        median_ms: peer.median_ms,
        least_ms: peer.least_ms,
        processor_ms: peer.median_processor_ms,
    }))
}

fn text(rows: &[JobRow], whole: &WholeTraining) -> String {
    let mut text =
        "job         threads  engine                  median ms   least ms  processor ms"
            .to_owned();
    for row in rows {
        let processor = row.processor_ms.map_or_else(String::new, |ms| format!("{ms:.1}"));
        let _ = write!(
            text,
            "\n{:<12}{:>7}  {:<22}{:>11.2}{:>11.2}{processor:>14}",
            row.job, row.threads, row.engine, row.median_ms, row.least_ms
        );
    }
    for ours in rows.iter().filter(|row| row.engine == OURS) {
        let mut same = rows.iter().filter(|r| r.job == ours.job && r.threads == ours.threads);
        let Some(theirs) = same.find(|row| row.engine != OURS) else { continue };
        let _ = write!(
            text,
            "\n{}, {} threads: {} takes {:.0} times our time by medians, {:.0} by the least",
            ours.job,
            ours.threads,
            theirs.engine,
            theirs.median_ms / ours.median_ms,
            theirs.least_ms / ours.least_ms
        );
        if let Some((theirs, ours)) = theirs.processor_ms.zip(ours.processor_ms) {
            let _ = write!(text, ", {:.0} by processor time", theirs / ours);
        }
    }
    let find = |job, ours: bool| {
        let same = rows.iter().filter(|row| row.job == job && (row.engine == OURS) == ours);
        same.min_by(|a, b| a.median_ms.total_cmp(&b.median_ms))
    };
    if let Some((ours, theirs)) = find(THOUSAND_DAYS, true).zip(find(ONE_DAY, false)) {
        let seconds = theirs.median_ms * DAYS as f64 / 1e3;
        let _ = write!(
            text,
            "\n1,000 days one call after the other, as the published package simulates: {seconds:.0} s in \
             PyTorch, {:.0} times our 1,000 days; the target is {TARGET}",
            1e3 * seconds / ours.median_ms
        );
    }
    let each = whole.seconds / whole.people as f64;
    let _ = write!(
        text,
        "\n{} twins, {} windows, {} epochs: {:.1} s on {} threads; {TWINS} would take {:.0} minutes",
        whole.people,
        whole.windows,
        whole.epochs,
        whole.seconds,
        whole.threads,
        TWINS * each / 60.0
    );
    if let Some(processor) = whole.processor_seconds {
        let each = processor / whole.people as f64;
        let _ = write!(
            text,
            "\n{each:.1} s of processor time a twin; the authors' code takes {AUTHORS_SECONDS:.0} s: {:.0} \
             times",
            AUTHORS_SECONDS / each
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_text_compares_like_with_like() {
        let row = |job: &str, engine: &str, threads, median_ms| JobRow {
            job: job.to_owned(),
            engine: engine.to_owned(),
            threads,
            median_ms,
            least_ms: median_ms,
            processor_ms: Some(2.0 * median_ms),
        };
        let rows = [
            row(THOUSAND_DAYS, OURS, 1, 100.0),
            row(THOUSAND_DAYS, "PyTorch", 1, 2500.0),
            row(THOUSAND_DAYS, OURS, 2, 50.0),
            row(ONE_DAY, OURS, 1, 5.0),
            row(ONE_DAY, "PyTorch", 1, 140.0),
            row(UPDATE, OURS, 1, 2.0),
            row(UPDATE, "PyTorch", 1, 180.0),
        ];
        let whole = WholeTraining {
            people: 6,
            threads: 2,
            seconds: 30.0,
            processor_seconds: Some(54.0),
            windows: 4000,
            epochs: 150,
        };
        let text = text(&rows, &whole);
        assert!(text.contains("1,000 days, 1 threads: PyTorch takes 25 times our time"), "{text}");
        assert!(!text.contains("1,000 days, 2 threads"), "{text}");
        assert!(text.contains("140 s in PyTorch, 2800 times our 1,000 days"), "{text}");
        assert!(text.contains("update, 1 threads: PyTorch takes 90 times"), "{text}");
        assert!(text.contains("394 would take 33 minutes"), "{text}");
        assert!(text.contains("9.0 s of processor time a twin"), "{text}");
    }
}
