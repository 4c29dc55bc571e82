//! `steady-state`: where a model stands still, over glucose, beside a published table.
//!
//! The authors' table of initial states is not a steady state: its latent C1 is 1.36 in every row,
//! which the model digests like a meal. This command shows the residual of both, and the meal.

use std::fmt::Write as _;
use std::fs::File;
use std::path::Path;

use anyhow::{Context as _, Result};
use nn_statespace::initial_state::{
    InitialStateTable, SteadyState, SteadyStateOutcome, steady_state,
};
use nn_statespace::{PopulationModel, ScaledInputs, ScaledStates, Signal};
use physiology::{Compartment, Grams, MgPerDl, OpenLoop, STEP, STEPS_PER_DAY, StepInput, simulate};

use crate::cli::SteadyStateArgs;
use crate::manifest::Manifest;
use crate::models::read_population;
use crate::output::OutputFolder;
use crate::progress::note;

/// Glucose values of the table, mg/dL.
const GLUCOSE: [f64; 9] = [60.0, 80.0, 100.0, 115.0, 128.0, 140.0, 160.0, 200.0, 250.0];
/// A meal that calibrates the latent compartment, g.
const TEST_MEAL: Grams = Grams(6.0);

/// One row of the comparison.
#[derive(Debug, serde::Serialize)]
struct Row {
    glucose_mg_dl: f64,
    found: bool,
    basal_u_h: f64,
    residual: f64,
    c1: f64,
    published: Option<Published>,
}

/// What a published row amounts to.
#[derive(Debug, serde::Serialize)]
struct Published {
    /// Largest rate of change at the best constant basal rate, scaled units per minute.
    residual: f64,
    c1: f64,
    /// Meal that would put as much glucose into the blood over a day as the excess of C1 does, g.
    phantom_carbs_g: f64,
}

/// Runs the command.
pub(crate) fn run(args: &SteadyStateArgs) -> Result<()> {
    let mut manifest =
        Manifest::new("steady-state", serde_json::json!({ "glucose_mg_dl": GLUCOSE }), None)
            .with_input(&args.model)?;
    let model = read_population(&args.model)?;
    let table = match &args.compare {
        None => None,
        Some(path) => {
            manifest = manifest.with_input(path)?;
            Some(read_table(path)?)
        }
    };
    let output = OutputFolder::begin(&args.out, manifest)?;
    let rows = GLUCOSE
        .iter()
        .map(|glucose| row(&model, MgPerDl(*glucose), table.as_ref()))
        .collect::<Result<Vec<Row>>>()?;
    let text = text(&rows);
    output.write_json(
        "steady_state.json",
        &serde_json::json!({ "schema": "steady_state/1", "rows": rows }),
    )?;
    output.write("steady_state.txt", text.as_bytes())?;
    let place = output.finish()?;
    note(text);
    note(format!("steady-state: {}", place.join("steady_state.json").display()));
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
) -> Result<Row> {
    let own = steady_state(model, glucose)?;
    let published = match table {
        None => None,
        Some(table) => Some(published(model, &own, table.row(glucose)?)?),
    };
    Ok(Row {
        glucose_mg_dl: glucose.0,
        found: own.outcome == SteadyStateOutcome::Found,
        basal_u_h: own.basal.0,
        residual: own.residual,
        c1: own.states[Compartment::C1],
        published,
    })
}

fn published(model: &PopulationModel, own: &SteadyState, start: ScaledStates) -> Result<Published> {
    // The table states no basal rate; it is judged at the rate that suits it best. Only S1 depends
    // on the rate, so that the other nine rates bound the residual from below.
    let carbs = model.scaler().scale_carbs(Grams(0.0));
    let insulin = model.scaler().scale_insulin(own.basal);
    let rates = model.derivative(&start, ScaledInputs { insulin, carbs });
    let residual = Compartment::ALL
        .into_iter()
        .filter(|c| !model.wiring().inputs(*c).contains(&Signal::Insulin))
        .map(|c| rates[c].abs())
        .fold(0.0, f64::max);

    let at_rest = own.states;
    let mut with_their_gut = at_rest;
    with_their_gut[Compartment::C1] = start[Compartment::C1];
    let excess = appeared(model, own, with_their_gut, Grams(0.0))?
        - appeared(model, own, at_rest, Grams(0.0))?;
    let meal =
        appeared(model, own, at_rest, TEST_MEAL)? - appeared(model, own, at_rest, Grams(0.0))?;
    Ok(Published {
        residual,
        c1: start[Compartment::C1],
        phantom_carbs_g: TEST_MEAL.0 * excess / meal,
    })
}

/// Meal glucose that appears over a day from a start, with `carbs` in the first step, mmol/kg.
fn appeared(
    model: &PopulationModel,
    own: &SteadyState,
    start: ScaledStates,
    carbs: Grams,
) -> Result<f64> {
    let mut inputs = vec![StepInput { basal: own.basal, ..StepInput::default() }; STEPS_PER_DAY];
    inputs[0].carbs = carbs;
    let run = simulate(model, start, &mut OpenLoop::new(&inputs), STEPS_PER_DAY)?;
    Ok(run.report(model).iter().map(|states| states[Compartment::C2] * STEP.0).sum())
}

fn text(rows: &[Row]) -> String {
    let mut text = format!(
        "{:>8} {:>9} {:>10} {:>8} | {:>10} {:>8} {:>14}\n",
        "mg/dL", "basal", "residual", "C1", "published", "C1", "phantom carbs"
    );
    for row in rows {
        write!(
            text,
            "{:>8.0} {:>5.3} U/h {:>10.1e} {:>8.4} |",
            row.glucose_mg_dl, row.basal_u_h, row.residual, row.c1
        )
        .expect("writing to a String cannot fail");
        if let Some(published) = &row.published {
            write!(
                text,
                " {:>10.1e} {:>8.4} {:>12.2} g",
                published.residual, published.c1, published.phantom_carbs_g
            )
            .expect("writing to a String cannot fail");
        }
        text.push_str(if row.found { "\n" } else { "  no physical steady state\n" });
    }
    text.push_str("Residuals: largest rate of change, scaled units per minute.\n");
    text
}
