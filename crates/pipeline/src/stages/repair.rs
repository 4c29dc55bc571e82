//! The repair behind `verify --repair`: each sub-network changed as little as its properties take.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result};
use conformance::{
    OneHiddenLayer, PropertyKind, Region, RepairRule, Repaired, paper_properties, repair,
};
use contract::repair::{BeforeAfter, RepairedNetwork};
use contract::{Document as _, Repair};
use nn_statespace::{ModelCard, PerCompartment, PopulationModel};
use ode_sim::{DevelopmentPlan, DevelopmentSet};
use physiology::Compartment;

use crate::stages::train;
use crate::subnetworks::network;
use crate::{OutputFolder, Progress, note};
use development::held_out::balanced_errors;
use development::{TrajectoryCost, with_network};

/// Repairs a model over a region, writes it and what it cost, and returns it.
pub(crate) fn repaired(
    model: &PopulationModel,
    region: &Region,
    limit: Duration,
    seed: u64,
    output: &OutputFolder,
) -> Result<PopulationModel> {
    let set = DevelopmentSet::new(DevelopmentPlan::paper(seed)).context("the development set")?;
    let trajectories = TrajectoryCost::new(&set, seed)?;
    let progress = Progress::begin("repair", Compartment::ALL.len());
    let mut networks = BTreeMap::new();
    let mut all_proved = true;
    // One after the other: each is judged in the company of those already mended.
    let mut after = model.clone();
    for compartment in Compartment::ALL {
        let mut asked = paper_properties();
        asked.retain(|property| {
            property.kind == PropertyKind::Physical && property.network == compartment.name()
        });
        let rule = RepairRule::working(limit, seed);
        let clock = Instant::now();
        let before = network(model, compartment)?;
        let cost = |changed: &OneHiddenLayer| trajectories.of(&after, compartment, changed);
        let found = repair(&before, &asked, region, &cost, &rule, &|| clock.elapsed())
            .with_context(|| format!("network {compartment}"))?;
        progress.advance(&format!("{compartment}, {} rounds", found.rounds));
        all_proved &= found.proved;
        networks.insert(compartment.name().to_owned(), told(&found));
        if found.network != before {
            after = with_network(&after, compartment, &found.network)?;
        }
    }
    let card = ModelCard {
        origin: format!("{}; repaired to the signs of physiology", model.card().origin),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        ..model.card().clone()
    };
    let after = PopulationModel::new(
        model.wiring().clone(),
        PerCompartment::from_fn(|compartment| after.network(compartment).clone()),
        *model.scaler(),
        model.clamp(),
        card,
    )?;
    let errors = balanced_errors(&set, &[model.clone(), after.clone()], seed)?;
    output.write(train::MODEL, &after.to_safetensors())?;
    output.write_document(&Repair {
        held_out_balanced_error_mg_dl: BeforeAfter { before: errors[0], after: errors[1] },
        networks,
        proved: all_proved,
        schema: Repair::SCHEMA.to_owned(),
    })?;
    progress.finish(&format!(
        "{}; balanced error on held-out days {:.2} mg/dL before and {:.2} after",
        if all_proved {
            "every physical property is proved"
        } else {
            "not every property is proved"
        },
        errors[0],
        errors[1],
    ));
    if !all_proved {
        note("repair: a longer --limit may prove what is left");
    }
    Ok(after)
}

fn told(found: &Repaired) -> RepairedNetwork {
    RepairedNetwork {
        by_unit: found.by_unit,
        pieces: found.pieces,
        proved: found.proved,
        rounds: found.rounds,
        training_windows_mse: BeforeAfter { before: found.cost_before, after: found.cost },
    }
}
