//! The repair behind `verify --repair`: each sub-network changed as little as its properties take.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result};
use conformance::{
    OneHiddenLayer, Property, PropertyKind, Region, RepairRule, Repaired, paper_properties, repair,
};
use nn_statespace::{HiddenLayerNetwork, ModelCard, PerCompartment, PopulationModel};
use ode_sim::development_set::Subset;
use ode_sim::{DevelopmentPlan, DevelopmentSet};
use physiology::{Compartment, Plant as _, States, StepInput};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use crate::held_out_windows::{Scored, score};
use crate::output::OutputFolder;
use crate::progress::{Progress, note};
use crate::stages::train;
use crate::stages::verify::network;

/// Simulated steps at which outputs are to stay as they are.
const POINTS: usize = 4000;

/// Repairs a model over a region, writes it and what it cost, and returns it.
pub(crate) fn repaired(
    model: &PopulationModel,
    region: &Region,
    limit: Duration,
    seed: u64,
    output: &OutputFolder,
) -> Result<PopulationModel> {
    let set = DevelopmentSet::new(DevelopmentPlan::quick(seed)).context("the development set")?;
    let rows = simulated_rows(&set, seed)?;
    let properties: Vec<Property> = paper_properties()
        .into_iter()
        .filter(|property| property.kind == PropertyKind::Physical)
        .collect();
    let progress = Progress::begin("repair", Compartment::ALL.len());
    let mut told = BTreeMap::new();
    let mut all_proved = true;
    let networks = PerCompartment::try_from_fn(|compartment| -> Result<HiddenLayerNetwork> {
        let asked: Vec<Property> =
            properties.iter().filter(|p| p.network == compartment.name()).cloned().collect();
        let points = points_of(model, compartment, &rows);
        let rule = RepairRule::working(limit, seed);
        let clock = Instant::now();
        let before = network(model, compartment)?;
        let found = repair(&before, &asked, region, &points, &rule, &|| clock.elapsed())
            .with_context(|| format!("network {compartment}"))?;
        progress.advance(&format!("{compartment}, {} rounds", found.rounds));
        all_proved &= found.proved;
        told.insert(compartment.name(), tell(&found));
        let Repaired { network: after, .. } = found;
        Ok(if after == before { model.network(compartment).clone() } else { plain(&after)? })
    })?;
    let card = ModelCard {
        origin: format!("{}; repaired to the signs of physiology", model.card().origin),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        ..model.card().clone()
    };
    let after = PopulationModel::new(
        model.wiring().clone(),
        networks,
        *model.scaler(),
        model.clamp(),
        card,
    )?;
    let cost = cost(&set, model, &after)?;
    output.write(train::MODEL, &after.to_safetensors())?;
    output.write_json(
        "repair.json",
        &serde_json::json!({
            "schema": "repair/1",
            "proved": all_proved,
            "networks": told,
            "held_out_balanced_error_mg_dl": { "before": cost.0, "after": cost.1 },
        }),
    )?;
    progress.finish(&format!(
        "{}; balanced error on held-out days {:.2} mg/dL before and {:.2} after",
        if all_proved {
            "every physical property is proved"
        } else {
            "not every property is proved"
        },
        cost.0,
        cost.1,
    ));
    if !all_proved {
        note("repair: a longer --limit may prove what is left");
    }
    Ok(after)
}

fn tell(found: &Repaired) -> serde_json::Value {
    serde_json::json!({
        "proved": found.proved,
        "rounds": found.rounds,
        "pieces": found.pieces,
        "rms_change_scaled_per_minute": found.change,
    })
}

/// Steps of training weeks, drawn at random.
fn simulated_rows(set: &DevelopmentSet, seed: u64) -> Result<Vec<(States, StepInput)>> {
    let mut rows = Vec::new();
    for index in 0..set.len() {
        let week = set.week(index)?;
        if week.subset == Subset::Train {
            let run = set.run(&week)?;
            let states = run.states.iter().map(|state| set.plant().report(state));
            rows.extend(states.zip(week.inputs.iter().copied()));
        }
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    Ok((0..POINTS).map(|_| rows[rng.random_range(0..rows.len())]).collect())
}

/// What a network sees in these steps.
fn points_of(
    model: &PopulationModel,
    compartment: Compartment,
    rows: &[(States, StepInput)],
) -> Vec<Vec<f64>> {
    use nn_statespace::Signal;
    let scaler = model.scaler();
    rows.iter()
        .map(|(states, input)| {
            let (x, u) = (scaler.scale(states), scaler.scale_input(input));
            let value = |signal: &Signal| match signal {
                Signal::State(state) => x[*state],
                Signal::Insulin => u.insulin,
                Signal::Carbs => u.carbs,
            };
            model.wiring().inputs(compartment).iter().map(value).collect()
        })
        .collect()
}

fn plain(network: &OneHiddenLayer) -> Result<HiddenLayerNetwork> {
    let rows = (0..network.hidden()).flat_map(|unit| network.input_weights(unit).to_vec());
    Ok(HiddenLayerNetwork::new(
        network.inputs().len(),
        rows.collect(),
        network.hidden_biases().to_vec(),
        network.output_weights().to_vec(),
        network.output_bias(),
    )?)
}

/// Balanced error on the held-out weeks of the set, mg/dL, before and after.
fn cost(
    set: &DevelopmentSet,
    before: &PopulationModel,
    after: &PopulationModel,
) -> Result<(f64, f64)> {
    let models = [before.clone(), after.clone()];
    let mut sums = vec![Scored::default(); 3];
    for index in 0..set.len() {
        let week = set.week(index)?;
        if week.subset == Subset::Test {
            for (sum, more) in sums.iter_mut().zip(score(set, &week, &models)?) {
                *sum = std::mem::take(sum).plus(&more);
            }
        }
    }
    Ok((sums[1].balanced_error(), sums[2].balanced_error()))
}
