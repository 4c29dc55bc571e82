//! `verify --twin`: in which direction a person's twin moves with insulin action and with glucose, over the person's own box.

use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail};
use cohort::{MissingDoses, Person};
use conformance::{
    CrossCheck, DeepLimits, DeepNetwork, Direction, Limits, Property, PropertyKind, Region,
    Verdict, verify,
};
use nn_statespace::{PopulationModel, ScaledStates, Signal};
use physiology::{Compartment, StepInput};
use twins::{INPUT_NAMES, ReplayStart, Twin, replay};

use crate::cli::VerifyArgs;
use crate::manifest::Manifest;
use crate::models::{read_population, read_twin};
use crate::output::OutputFolder;
use crate::progress::{Progress, note};
use crate::stages::twin::read_cohort;
use crate::stages::verify::network;

/// What dQ1/dt has to do with these states: insulin action lowers glucose, and glucose comes down faster where there is more
/// of it.
const ASKED: [&str; 3] = ["X1", "X3", "Q1"];
/// Boxes that are bounded for a row; a number, not a time, so that the same bound comes out on every machine.
const BOXES: u64 = 20_000;
/// Steps of the record at which slopes are looked for.
const STEPS: usize = 4000;
/// First length of a step that is replayed in exact arithmetic, scaled, and how often it is halved.
const STEP: f64 = 1e-2;
const HALVINGS: i32 = 12;

/// One row of `conformance.json`.
#[derive(Debug, serde::Serialize)]
struct TwinRow {
    person_id: String,
    /// "residual", or "twin": the residual and the population's network of Q1 together.
    network: &'static str,
    input: &'static str,
    property: Direction,
    kind: PropertyKind,
    m_lower: Option<f64>,
    m_upper: f64,
    verdict: Verdict,
    witness: Option<serde_json::Value>,
    seconds: f64,
    nodes: u64,
    /// Share of the record's steps at which the slope goes against the property.
    share_of_steps: f64,
}

/// A step of the record: what the residual network sees, what the population's network of Q1 sees.
struct Seen {
    residual: Vec<f64>,
    population: Vec<f64>,
}

/// Runs the command.
pub(crate) fn run(args: &VerifyArgs) -> Result<()> {
    let (Some(path), Some(folder)) = (&args.twin, &args.cohort) else {
        bail!("--twin needs --cohort, the records of the person whose box is meant");
    };
    if args.repair {
        bail!("--repair mends population models; a twin is not repaired");
    }
    let config = serde_json::json!({ "limit_seconds": args.limit, "boxes": BOXES, "steps": STEPS });
    let manifest = Manifest::new("verify", config, Some(args.seed))
        .with_input(&args.model)?
        .with_input(path)?
        .with_input(folder)?;
    let population = Arc::new(read_population(&args.model)?);
    let twin = read_twin(path, population)?;
    let cohort = read_cohort(folder)?;
    let id = &twin.card.person_id;
    let person = cohort.people.iter().find(|person| person.id == *id).with_context(|| {
        format!("the cohort '{}' has no person '{id}', whose twin this is", folder.display())
    })?;
    let output = OutputFolder::begin(&args.out, manifest)?;
    // Doses reach a twin's networks with its own gains.
    let population = &twin.population;
    let steps = steps_of(person, &twin)?;
    let deep = |matrices: Vec<(Vec<f64>, Vec<f64>)>, names: Vec<String>| {
        DeepNetwork::new(names, matrices).context("the twin's networks")
    };
    let residual = deep(
        twin.residual.matrices().to_vec(),
        INPUT_NAMES.iter().map(|name| (*name).to_owned()).collect(),
    )?;
    let glucose = network(population, Compartment::Q1)?;
    let rows = (0..glucose.hidden()).flat_map(|unit| glucose.input_weights(unit).to_vec());
    let shallow = deep(
        vec![
            (rows.collect(), glucose.hidden_biases().to_vec()),
            (glucose.output_weights().to_vec(), vec![glucose.output_bias()]),
        ],
        glucose.inputs().to_vec(),
    )?;
    let (lower, upper) = extremes(steps.iter().map(|seen| seen.residual.as_slice()));
    let bounds = INPUT_NAMES.iter().zip(lower.iter().zip(&upper));
    let region = Region::scaled(bounds.map(|(name, (l, u))| (*name, [*l, *u])))?;

    let clock = Instant::now();
    let limit = Duration::from_secs_f64(args.limit);
    let progress = Progress::begin("verify", ASKED.len());
    let mut found: Vec<TwinRow> = Vec::new();
    for input in ASKED {
        let began = clock.elapsed();
        let direction = Direction::Decreasing;
        let property = Property {
            network: Compartment::Q1.name().to_owned(),
            input: input.to_owned(),
            direction,
            kind: PropertyKind::Physical,
        };
        let still = Limits {
            relative_gap: 1e-2,
            nodes: u64::MAX,
            time: limit,
            cross_check: CrossCheck::None,
        };
        let of_population = verify(&glucose, &property, &region, &still, &|| clock.elapsed())?;
        // For the twin the residual may rise by what the population falls.
        let enough = (-of_population.m_upper).min(0.0);
        let limits = DeepLimits { enough, nodes: BOXES, time: limit };
        let of_residual =
            residual
                .largest_slope(input, direction, (&lower, &upper), &limits, &|| clock.elapsed())?;
        let seconds = clock.elapsed().saturating_sub(began).as_secs_f64();
        let (residual_upper, sum) =
            upper_bounds(of_residual.m_upper, of_population.m_upper, twin.residual.keeps_signs());
        for (name, networks, m_upper) in [
            ("residual", [Some(&residual), None], residual_upper),
            ("twin", [Some(&residual), Some(&shallow)], sum),
        ] {
            let (attained, failing) = attained(&steps, networks, input, &upper)?;
            let verdict = match &attained {
                _ if m_upper <= 0.0 => Verdict::Proved,
                Some((slope, _)) if *slope > 0.0 => Verdict::Violated,
                _ => Verdict::Undecided,
            };
            found.push(TwinRow {
                person_id: id.clone(),
                network: name,
                input,
                property: direction,
                kind: PropertyKind::Physical,
                m_lower: attained.as_ref().map(|(slope, _)| *slope),
                m_upper,
                verdict,
                witness: attained.map(|(_, witness)| witness),
                seconds,
                nodes: of_residual.nodes,
                share_of_steps: failing,
            });
        }
        progress.advance(&format!("dQ1/dt by {input}"));
    }
    let table = table(&found);
    let count = |verdict| found.iter().filter(|row| row.verdict == verdict).count();
    let summary = format!(
        "{} proved, {} violated, {} undecided of {} rows",
        count(Verdict::Proved),
        count(Verdict::Violated),
        count(Verdict::Undecided),
        found.len()
    );
    output.write_json("conformance.json", &serde_json::json!({ "rows": found }))?;
    output.write_json(
        "region.json",
        &serde_json::json!({
            "unit": "scaled",
            "bounds": region.iter().collect::<std::collections::BTreeMap<_, _>>(),
        }),
    )?;
    output.write("conformance.txt", table.as_bytes())?;
    let place = output.finish()?;
    note(table);
    progress.finish(&format!("{summary}, {}", place.join("conformance.json").display()));
    Ok(())
}

/// Bounds of the residual network's slope and of the sum with the population network's. Weights that keep
/// signs prove what boxes leave open by their rounding: every property asked here is among those signs.
fn upper_bounds(residual: f64, population: f64, keeps_signs: bool) -> (f64, f64) {
    let residual = if keeps_signs { residual.min(0.0) } else { residual };
    let sum = (residual + population).next_up();
    // No sum of two numbers that are not positive is positive.
    (residual, if residual <= 0.0 && population <= 0.0 { sum.min(0.0) } else { sum })
}

/// The person's record along the population model, glucose as the sensor read it where it did (as in training).
fn steps_of(person: &Person, twin: &Twin) -> Result<Vec<Seen>> {
    let population: &PopulationModel = &twin.population;
    let start = ReplayStart::SteadyState;
    let rows = replay(person, population, population, start, MissingDoses::Zero)
        .with_context(|| format!("person {}", person.id))?;
    let first = person.record.len() - rows.len();
    let inputs = person
        .inputs(first..person.record.len(), MissingDoses::Zero)
        .with_context(|| format!("person {}", person.id))?;
    let scaler = population.scaler();
    let glucose = scaler.of(Signal::State(Compartment::Q1));
    let stride = rows.len().div_ceil(STEPS).max(1);
    Ok(rows
        .iter()
        .zip(&inputs)
        .enumerate()
        .step_by(stride)
        .map(|(step, (row, input))| {
            let mut state: ScaledStates = scaler.scale(&row.states);
            if let Some(reading) = person.record.cgm()[first + step] {
                state[Compartment::Q1] = (reading - glucose.centre) / glucose.scale;
            }
            seen(twin, population, &state, input)
        })
        .collect())
}

fn seen(
    twin: &Twin,
    population: &PopulationModel,
    state: &ScaledStates,
    input: &StepInput,
) -> Seen {
    Seen {
        residual: twin.residual_inputs(state, input).to_vec(),
        population: population.seen_by(
            Compartment::Q1,
            state,
            population.scaler().scale_input(input),
        ),
    }
}

/// Least and greatest value of each input.
fn extremes<'a>(points: impl Iterator<Item = &'a [f64]>) -> (Vec<f64>, Vec<f64>) {
    let (mut lower, mut upper) = (Vec::new(), Vec::new());
    for point in points {
        if lower.is_empty() {
            (lower, upper) = (point.to_vec(), point.to_vec());
        }
        for ((lower, upper), x) in lower.iter_mut().zip(&mut upper).zip(point) {
            *lower = f64::min(*lower, *x);
            *upper = f64::max(*upper, *x);
        }
    }
    (lower, upper)
}

/// The largest slope against a decreasing property over a step from one of the record's, with its witness, in exact
/// arithmetic, and the share of steps at which the slope rises.
fn attained(
    steps: &[Seen],
    [residual, population]: [Option<&DeepNetwork>; 2],
    input: &str,
    upper: &[f64],
) -> Result<(Option<(f64, serde_json::Value)>, f64)> {
    let place = |network: &DeepNetwork| network.inputs().iter().position(|name| name == input);
    let residual = residual.context("a residual network")?;
    let tested = place(residual).context("an input of the residual")?;
    let slope_over = |seen: &Seen, length: f64| -> Result<f64> {
        let moved = |point: &[f64], at: usize| {
            let mut to = point.to_vec();
            to[at] += length;
            to
        };
        let mut rise = residual.exact_rise(&seen.residual, &moved(&seen.residual, tested))?;
        if let Some(population) = population {
            let at = place(population).context("an input of the population's network")?;
            let more = population.exact_rise(&seen.population, &moved(&seen.population, at))?;
            rise = (rise + more).next_down();
        }
        Ok(rise / length)
    };
    // A look at all with a short step, then the best with several lengths.
    let short = STEP * 0.5_f64.powi(HALVINGS / 2);
    let inside: Vec<&Seen> =
        steps.iter().filter(|seen| seen.residual[tested] + STEP <= upper[tested]).collect();
    use rayon::prelude::*;
    let slopes: Vec<f64> =
        inside.par_iter().map(|seen| slope_over(seen, short)).collect::<Result<_>>()?;
    let failing =
        slopes.iter().filter(|slope| **slope > 0.0).count() as f64 / slopes.len().max(1) as f64;
    let best = (0..inside.len()).max_by(|a, b| slopes[*a].total_cmp(&slopes[*b]));
    let Some(best) = best.map(|k| inside[k]) else { return Ok((None, failing)) };
    let mut found: Option<(f64, serde_json::Value)> = None;
    for halvings in 0..=HALVINGS {
        let length = STEP * 0.5_f64.powi(halvings);
        let slope = slope_over(best, length)?.next_down();
        if found.as_ref().is_none_or(|(known, _)| slope > *known) {
            let point: serde_json::Map<String, serde_json::Value> = residual
                .inputs()
                .iter()
                .zip(&best.residual)
                .map(|(name, x)| (name.clone(), (*x).into()))
                .collect();
            let from = best.residual[tested];
            let witness = serde_json::json!({ "point": point, "from": from, "to": from + length });
            found = Some((slope, witness));
        }
    }
    Ok((found, failing))
}

fn table(rows: &[TwinRow]) -> String {
    use std::fmt::Write as _;
    let mut text = format!(
        "{:<9} {:<6} {:<11} {:<10} {:>14} {:>14} {:>9} {:>9}  {}\n",
        "network",
        "input",
        "property",
        "verdict",
        "M at least",
        "M at most",
        "of steps",
        "boxes",
        "seconds"
    );
    for row in rows {
        writeln!(
            text,
            "{:<9} {:<6} {:<11} {:<10} {:>14.7} {:>14.7} {:>8.3}% {:>9}  {:.1}",
            row.network,
            row.input,
            "decreasing",
            format!("{:?}", row.verdict).to_lowercase(),
            row.m_lower.unwrap_or(f64::NAN),
            row.m_upper,
            100.0 * row.share_of_steps,
            row.nodes,
            row.seconds,
        )
        .expect("writing to a String cannot fail");
    }
    text
}
