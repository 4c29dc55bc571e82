//! `verify --twin`: in which direction a person's twin moves with insulin action and with glucose, over the person's own box.
//! A row each for the residual network, the population's network of Q1, and their sum.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result};
use cohort::{MissingDoses, Person};
use conformance::{
    DeepLimits, DeepNetwork, Direction, Grounds, Limits, Property, PropertyKind, Region, Row,
    SlopeBound, Summand, bounds_of_sum, extremes, verify, verify_recorded,
};
use contract::{Certificates, Conformance, Document as _};
use nn_statespace::PopulationModel;
use physiology::Compartment;
use twins::{INPUT_NAMES, ReplayStart, Twin, replay};

use crate::conformance_text::{counted, percent, table};
use crate::files::{read_bytes, read_population, read_twin};
use crate::people::read_cohort;
use crate::stages::verify::{TEXT, check_limit};
use crate::subnetworks::{network, proved};
use crate::{Manifest, OutputFolder, Progress};

/// Settings of `verify` on a person's twin.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Population model that the twin belongs to.
    pub model: PathBuf,
    /// The twin.
    pub twin: PathBuf,
    /// The cohort with that person's record.
    pub cohort: PathBuf,
    /// Time limit of one row, s.
    pub limit: f64,
    /// Output folder.
    pub out: PathBuf,
    /// Seed, for the manifest alone: nothing is sampled.
    pub seed: u64,
}

/// What dQ1/dt has to do with these states: insulin action lowers glucose, and glucose comes down faster where there is more
/// of it.
const ASKED: [&str; 3] = ["X1", "X3", "Q1"];
/// Boxes that are bounded for a row; a number, not a time, so that the same bound comes out on every machine.
const BOXES: u64 = 20_000;
/// Most steps of the record at which slopes are looked for.
const STEPS: usize = 4000;
/// A step of the record: what the residual network sees, what the population's network of Q1 sees.
struct Seen {
    residual: Vec<f64>,
    population: Vec<f64>,
}

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    check_limit(args.limit)?;
    let (path, folder) = (&args.twin, &args.cohort);
    let config = serde_json::json!({ "limit_seconds": args.limit, "boxes": BOXES, "steps": STEPS });
    let manifest = Manifest::new("verify", config, Some(args.seed))
        .with_model(&args.model)?
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
    let q1 = population.network(Compartment::Q1);
    let hidden = (q1.w1().to_vec(), q1.b1().to_vec());
    let shallow = deep(vec![hidden, (q1.w2().to_vec(), vec![q1.b2()])], glucose.inputs().to_vec())?;
    // The box is that of every step; slopes are looked for at some.
    let (lower, upper) = extremes(steps.iter().map(|seen| seen.residual.as_slice()));
    let stride = steps.len().div_ceil(STEPS).max(1);
    let bounds = INPUT_NAMES.iter().zip(lower.iter().zip(&upper));
    let region = Region::scaled(bounds.map(|(name, (l, u))| (*name, [*l, *u])))?;

    let points = |of: fn(&Seen) -> &Vec<f64>| -> Vec<Vec<f64>> {
        steps.iter().step_by(stride).map(|seen| of(seen).clone()).collect()
    };
    let seen = points(|seen| &seen.residual);
    let beside = points(|seen| &seen.population);
    let own = Summand { network: &residual, points: &seen };
    let other = Summand { network: &shallow, points: &beside };
    let clock = Instant::now();
    let limit = Duration::from_secs_f64(args.limit);
    let progress = Progress::begin("verify", ASKED.len());
    let bytes = read_bytes(&args.model)?;
    let properties = ASKED.map(|input| Property {
        network: Compartment::Q1.name().to_owned(),
        input: input.to_owned(),
        direction: Direction::Decreasing,
        kind: PropertyKind::Physical,
    });
    let still = Limits { relative_gap: 1e-2, nodes: u64::MAX, time: limit, cross_check: None };
    let mut of_population = properties
        .iter()
        .map(|property| verify(&glucose, property, &region, &still, &|| clock.elapsed()))
        .collect::<Result<Vec<Row>, _>>()?;
    let (proofs, took) = proved(&mut of_population, &properties, population, &bytes, &region)?;
    let mut found: Vec<Row> = Vec::new();
    for (input, of_population) in ASKED.into_iter().zip(of_population) {
        let began = clock.elapsed();
        // For the twin the residual may rise by what the population falls.
        let enough = (-of_population.m_upper).min(0.0);
        let limits = DeepLimits { enough, nodes: BOXES, time: limit };
        let of_residual = residual.largest_slope(
            input,
            Direction::Decreasing,
            (&lower, &upper),
            &limits,
            &|| clock.elapsed(),
        )?;
        let seconds = clock.elapsed().saturating_sub(began).as_secs_f64();
        let keeps = twin.residual.keeps_signs();
        let (own_upper, sum) = bounds_of_sum(of_residual.m_upper, of_population.m_upper, keeps);
        let bound = |m_upper: f64, grounds: Option<Grounds>| SlopeBound {
            m_upper,
            grounds,
            nodes: of_residual.nodes,
            stop: of_residual.stop,
            seconds,
        };
        let certified = of_population.grounds == Some(Grounds::Certificate);
        let by_signs = keeps.then_some(Grounds::Construction);
        let by_both = (keeps && certified).then_some(Grounds::Summands);
        let index = INPUT_NAMES.iter().position(|name| *name == input);
        let end = upper[index.context("an input of the residual")?];
        for row in [
            verify_recorded("residual", input, &[own], end, bound(own_upper, by_signs))?,
            of_population,
            verify_recorded("twin", input, &[own, other], end, bound(sum, by_both))?,
        ] {
            found.push(Row { person_id: Some(id.clone()), ..row });
        }
        progress.advance(&format!("dQ1/dt by {input}"));
    }
    let table = table(&found, [9, 6], ["network", "of steps", "boxes"], |row| {
        [percent(row.share_of_steps), row.nodes.to_string(), format!("{:.1}", row.seconds)]
    });
    let summary = counted(&found, &proofs, took);
    let schema = Conformance::SCHEMA.to_owned();
    output.write_document(&Conformance { rows: found, schema })?;
    output.write_document(&region.file())?;
    output.write(Certificates::FILE, &proofs.file)?;
    let place = output.finish_with_table(TEXT, &table)?;
    progress.finish(&format!("{summary}, {}", place.join("conformance.json").display()));
    Ok(())
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
    Ok(rows
        .iter()
        .zip(&inputs)
        .enumerate()
        .map(|(step, (row, input))| {
            let mut states = row.states;
            if let Some(reading) = person.record.cgm()[first + step] {
                states[Compartment::Q1] = reading;
            }
            let state = scaler.scale(&states);
            Seen {
                residual: twin.residual_inputs(&state, input).to_vec(),
                population: population.seen_by(Compartment::Q1, &state, scaler.scale_input(input)),
            }
        })
        .collect())
}
