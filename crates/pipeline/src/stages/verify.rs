//! `verify`: the conformance of a population network over a box.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail, ensure};
use conformance::milp::{Form, MilpLimits, solve_step};
use conformance::{
    ConformanceError, Limits, Property, PropertyKind, Region, Row, Scaling, Signal, Verdict,
    paper_properties, share_of_points, share_of_region, step_bracket, verify, with_physical,
    with_slice,
};
use contract::{Certificates, Conformance, Document as _, RegionFile};
use nn_statespace::{PopulationModel, Signal as NetworkSignal};
use physiology::Compartment;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

use crate::bounds::within;
use crate::conformance_text::{counted, percent, table};
use crate::files::{read_bytes, read_population};
use crate::paper_conformance::{beside_the_paper, summary as by_network};
use crate::stages::repair::repaired;
use crate::subnetworks::{network, network_of, proved};
use crate::{Manifest, OutputFolder, Progress};
use development::SimulatedSteps;

/// Programmes of the paper's question.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MilpForm {
    /// The largest slope.
    Gradient,
    /// The largest movement over a step, in one copy of the network.
    Difference,
    /// The same in two copies, as in the paper; slow.
    TwoCopies,
    /// None.
    None,
}

/// Settings of `verify`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Population model.
    pub model: PathBuf,
    /// Box over which to verify; the range of the model's training data if not given.
    pub region: Option<PathBuf>,
    /// Widen every interval of the box at both ends by this share of its length: the paper's generalisation region.
    pub widen: f64,
    /// Longest step for the paper's z, scaled; ten times the smallest change of the input between simulated steps if
    /// not given.
    pub delta: Option<f64>,
    /// Programme that HiGHS solves beside the certified search, for networks of up to four inputs.
    pub milp: MilpForm,
    /// Time limit of one row, s.
    pub limit: f64,
    /// Change the model as little as it takes to have every physical property, and verify what comes out.
    pub repair: bool,
    /// Output folder.
    pub out: PathBuf,
    /// Seed of the sampled share of the box.
    pub seed: u64,
}

/// Relative gap at which a row counts as solved: of networks of at most [`MILP_INPUTS`] inputs, and of larger ones,
/// where the last digits would take most of the time.
const RELATIVE_GAP: f64 = 1e-9;
const RELATIVE_GAP_OF_LARGE: f64 = 1e-2;
/// Longest time limit of a row, s: a week.
const LONGEST_LIMIT: f64 = 604_800.0;
/// Most by which a box is widened, in its own lengths; the paper's is a tenth.
const WIDEST: f64 = 100.0;
/// Farthest bound from 0, scaled: beyond, no solver tells differences.
const FARTHEST: f64 = 1e6;
/// Longest step, scaled: a thousand interquartile ranges.
const LONGEST_STEP: f64 = 1000.0;
/// Points at which the violating share of the box is sampled.
const SHARE_POINTS: usize = 100_000;
/// Places of the slice through a counterexample.
const SLICE_POINTS: usize = 121;
/// Networks up to this many inputs are also solved as a MILP.
const MILP_INPUTS: usize = 4;

/// The region that is used: the one asked for, or the one that training wrote beside the model.
fn region_path(args: &Settings) -> Result<PathBuf> {
    let beside = args.model.with_file_name(RegionFile::FILE);
    match &args.region {
        Some(path) => Ok(path.clone()),
        None if beside.is_file() => Ok(beside),
        None => bail!(
            "there is no {} beside '{}'; give the box with --region",
            RegionFile::FILE,
            args.model.display()
        ),
    }
}

/// The tables as text, within the output folder.
pub(crate) const TEXT: &str = "conformance.txt";

/// The manifest of a run with these arguments.
pub(crate) fn manifest(args: &Settings) -> Result<Manifest> {
    let config = serde_json::json!({
        "limit_seconds": args.limit,
        "relative_gap": RELATIVE_GAP,
        "relative_gap_of_large_networks": RELATIVE_GAP_OF_LARGE,
        "share_points": SHARE_POINTS,
        "milp_up_to_inputs": MILP_INPUTS,
        "milp": args.milp,
        "widen": args.widen,
        "delta": args.delta,
        "repair": args.repair,
    });
    Manifest::new("verify", config, Some(args.seed))
        .with_model(&args.model)?
        .with_input(&region_path(args)?)
}

/// Refuses a time limit of a row, s, that no search can keep.
pub(crate) fn check_limit(limit: f64) -> Result<()> {
    let can_be = limit > 0.0 && limit <= LONGEST_LIMIT;
    ensure!(can_be, "--limit {limit} must be above 0 and at most {LONGEST_LIMIT} s");
    Ok(())
}

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    check_limit(args.limit)?;
    within("--widen", args.widen, 0.0, WIDEST)?;
    if let Some(delta) = args.delta {
        ensure!(
            delta > 0.0 && delta <= LONGEST_STEP,
            "--delta {delta} must be above 0 and at most {LONGEST_STEP}"
        );
    }
    let mut model = read_population(&args.model)?;
    let manifest = manifest(args)?;
    let region = read_region(&region_path(args)?, &model)?.widened(args.widen)?;
    let output = OutputFolder::begin(&args.out, manifest)?;
    if args.repair {
        let limit = Duration::from_secs_f64(args.limit);
        model = repaired(&model, &region, limit, args.seed, &output)?;
        // The region goes with the model, as training leaves it.
        let bounds = std::fs::read(region_path(args)?).context("the region")?;
        output.write(RegionFile::FILE, &bounds)?;
    }

    let steps = SimulatedSteps::new(args.seed)?;
    let clock = Instant::now();
    let properties = paper_properties();
    let progress = Progress::begin("verify", properties.len());
    let mut rows = Vec::with_capacity(properties.len());
    for property in &properties {
        let row = verify_row(&model, property, &region, &steps, args, &|| clock.elapsed())
            .with_context(|| format!("network {}, input {}", property.network, property.input))?;
        progress.advance(&format!("{} against {}", property.network, property.input));
        rows.push(row);
    }
    let bytes = if args.repair { model.to_safetensors() } else { read_bytes(&args.model)? };
    let (proofs, took) = proved(&mut rows, &properties, &model, &bytes, &region)?;
    let summary = counted(&rows, &proofs, took);
    let table = format!(
        "{}\n{}\n{}",
        table(&rows, [4, 10], ["net", "of box", "of steps"], cells),
        by_network(&rows),
        beside_the_paper(&rows, args.widen > 0.0)
    );
    let schema = Conformance::SCHEMA.to_owned();
    output.write_document(&Conformance { rows, schema })?;
    output.write(Certificates::FILE, &proofs.file)?;
    let place = output.finish_with_table(TEXT, &table)?;
    progress.finish(&format!("{summary}, {}", place.join("conformance.json").display()));
    Ok(())
}

fn verify_row(
    model: &PopulationModel,
    property: &Property,
    region: &Region,
    steps: &SimulatedSteps,
    args: &Settings,
    clock: &(dyn Fn() -> Duration + Sync),
) -> Result<Row> {
    let (compartment, network) = network_of(model, property)?;
    let time = Duration::from_secs_f64(args.limit);
    let small = network.inputs().len() <= MILP_INPUTS;
    let relative_gap = if small { RELATIVE_GAP } else { RELATIVE_GAP_OF_LARGE };
    let milp = MilpLimits { time, relative_gap: RELATIVE_GAP };
    let cross_check = (small && args.milp == MilpForm::Gradient).then_some(milp);
    let limits = Limits { relative_gap, nodes: u64::MAX, time, cross_check };
    let mut row = verify(&network, property, region, &limits, clock)?;
    let input = NetworkSignal::from_name(&property.input)
        .with_context(|| format!("there is no signal '{}'", property.input))?;
    let delta = args.delta.or_else(|| steps.paper_step(model, input));
    if let Some(delta) = delta {
        row.step = Some(step_bracket(&network, property, region, &row, delta)?);
        let form = match args.milp {
            MilpForm::Difference => Some(Form::Difference),
            MilpForm::TwoCopies => Some(Form::TwoCopies),
            MilpForm::Gradient | MilpForm::None => None,
        };
        if let Some(form) = form.filter(|_| small) {
            row.milp_step =
                Some(solve_step(&network, property, region, delta, form, &milp, clock)?);
        }
    }
    let output = NetworkSignal::State(compartment);
    row.smallest_change = steps.smallest_rate(output);
    let seen = steps.seen_by(model, compartment);
    row.share_of_points =
        Some(share_of_points(&network, property, seen.iter().map(Vec::as_slice))?);
    row = with_physical(row, scaling(model, output), scaling(model, input))?;
    if row.verdict == Verdict::Violated && row.kind == PropertyKind::Physical {
        row = with_slice(row, &network, region, SLICE_POINTS)?;
    }
    let mut rng = ChaCha8Rng::seed_from_u64(args.seed);
    row.share_of_region = match share_of_region(&network, property, region, SHARE_POINTS, &mut rng)
    {
        Ok(share) => Some(share),
        // A polytope too thin for a single draw has no share that could be told.
        Err(ConformanceError::Limit { limit: "points", .. }) => None,
        Err(error) => return Err(error.into()),
    };
    Ok(row)
}

fn scaling(model: &PopulationModel, signal: NetworkSignal) -> Scaling {
    let constants = model.scaler().of(signal);
    Scaling { centre: constants.centre, scale: constants.scale }
}

fn read_region(path: &Path, model: &PopulationModel) -> Result<Region> {
    let shown = || format!("the region '{}'", path.display());
    let signals = NetworkSignal::all().map(|signal| Signal {
        name: signal.name().to_owned(),
        scaling: Some(scaling(model, signal)),
    });
    let signals: Vec<Signal> = signals.collect();
    let region = Region::from_json(read_bytes(path)?.as_slice(), &signals).with_context(shown)?;
    for compartment in Compartment::ALL {
        for signal in network(model, compartment)?.inputs() {
            let bounds = region.bounds(signal).with_context(|| {
                format!("no bounds for '{signal}', an input of network {compartment}; add them")
            });
            let [lower, upper] = bounds.with_context(shown)?;
            ensure!(
                lower.abs().max(upper.abs()) <= FARTHEST,
                "{}: the bounds of '{signal}', {lower:?} and {upper:?} scaled, are more than {FARTHEST} \
                 from 0; check the unit",
                shown()
            );
        }
    }
    Ok(region)
}

/// The shares of a row, and its time with what to know of its sign, as cells of a table.
fn cells(row: &Row) -> [String; 3] {
    let aside = match row.kind {
        PropertyKind::Physical => "",
        PropertyKind::OppositeInformational => "  (opposite sign, informational)",
    };
    let [of_box, of_steps] = [&row.share_of_region, &row.share_of_points]
        .map(|share| percent(share.as_ref().map(|s| s.value)));
    [of_box, of_steps, format!("{:.2}{aside}", row.seconds)]
}
