//! `steady-state`: where a model stands still, over glucose, beside a published table.
//!
//! The authors' table of initial states is not a steady state: its latent C1 is 1.36 in every row,
//! which the model digests like a meal. This command shows the residual of both, and the meal.

use std::fmt::Write as _;
use std::fs::File;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use contract::steady_state::{PublishedState, SteadyRow};
use contract::{Document as _, SteadyStates};
use nn_statespace::PopulationModel;
use nn_statespace::initial_state::{
    InitialStateTable, StartCheck, SteadyStateOutcome, check_start, steady_state,
};
use physiology::{Compartment, MgPerDl};

use crate::files::read_population;
use crate::{Manifest, OutputFolder, note};

/// Settings of `steady-state`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Population model.
    pub model: PathBuf,
    /// A table of scaled initial states by glucose to compare with.
    pub compare: Option<PathBuf>,
    /// Output folder.
    pub out: PathBuf,
}

/// Glucose values of the table, mg/dL.
const GLUCOSE: [f64; 9] = [60.0, 80.0, 100.0, 115.0, 128.0, 140.0, 160.0, 200.0, 250.0];

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    let manifest =
        Manifest::new("steady-state", serde_json::json!({ "glucose_mg_dl": GLUCOSE }), None)
            .with_model(&args.model)?
            .with_inputs(&args.compare)?;
    let model = read_population(&args.model)?;
    let table = args.compare.as_deref().map(read_table).transpose()?;
    let output = OutputFolder::begin(&args.out, manifest)?;
    let rows = GLUCOSE
        .iter()
        .map(|glucose| row(&model, MgPerDl(*glucose), table.as_ref()))
        .collect::<Result<Vec<SteadyRow>>>()?;
    let text = text(&rows);
    output.write_document(&SteadyStates { rows, schema: SteadyStates::SCHEMA.to_owned() })?;
    let place = output.finish_with_table("steady_state.txt", &text)?;
    note(format!("steady-state: {}", place.join(SteadyStates::FILE).display()));
    Ok(())
}

/// A published table of initial states.
pub(crate) fn read_table(path: &Path) -> Result<InitialStateTable> {
    let file = File::open(path).with_context(|| format!("cannot open '{}'", path.display()))?;
    InitialStateTable::read(file)
        .with_context(|| format!("the table of initial states '{}'", path.display()))
}

fn row(
    model: &PopulationModel,
    glucose: MgPerDl,
    table: Option<&InitialStateTable>,
) -> Result<SteadyRow> {
    let own = steady_state(model, glucose)?;
    let published = table.map(|table| {
        let found = check_start(model, &own, table.row(glucose)?)?;
        let StartCheck { residual, c1, phantom_carbs } = found;
        anyhow::Ok(PublishedState { residual, c1, phantom_carbs_g: phantom_carbs.0 })
    });
    Ok(SteadyRow {
        glucose_mg_dl: glucose.0,
        found: own.outcome == SteadyStateOutcome::Found,
        basal_u_h: own.basal.0,
        residual: own.residual,
        c1: own.states[Compartment::C1],
        published: published.transpose()?,
    })
}

fn text(rows: &[SteadyRow]) -> String {
    let mut text = format!(
        "{:>8} {:>9} {:>10} {:>8} | {:>10} {:>8} {:>14}\n",
        "mg/dL", "basal", "residual", "C1", "published", "C1", "phantom carbs"
    );
    for row in rows {
        let _ = write!(
            text,
            "{:>8.0} {:>5.3} U/h {:>10.1e} {:>8.4} |",
            row.glucose_mg_dl, row.basal_u_h, row.residual, row.c1
        );
        if let Some(PublishedState { residual, c1, phantom_carbs_g }) = &row.published {
            let _ = write!(text, " {residual:>10.1e} {c1:>8.4} {phantom_carbs_g:>12.2} g");
        }
        text.push_str(if row.found { "\n" } else { "  no physical steady state\n" });
    }
    text.push_str("Residuals: largest rate of change, scaled units per minute.\n");
    text
}
