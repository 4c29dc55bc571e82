//! `trajectories`: whether a model answers to doses as a person does, beside the ODE.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context as _, Result};
use behaviour::{Check, CheckRule, Rest, Subject, Trajectories, check};
use contract::Document as _;
use nn_statespace::initial_state::{SteadyStateOutcome, steady_state};
use nn_statespace::{PopulationModel, ScaledStates};
use ode_sim::{OdeParameters, OdePlant};
use physiology::{Kilograms, MgPerDl};

use crate::files::{read_population, read_twin};
use crate::{Manifest, OutputFolder, note};

/// Settings of `trajectories`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Population model.
    pub model: PathBuf,
    /// A person's twin on that model.
    pub twin: Option<PathBuf>,
    /// Output folder.
    pub out: PathBuf,
}

/// Body weight of the ODE, kg: the nominal one of the paper's simulator.
const WEIGHT: Kilograms = Kilograms(76.3);

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    let rule = CheckRule::working();
    let config = serde_json::json!({
        "starts_mg_dl": rule.starts.iter().map(|start| start.0).collect::<Vec<f64>>(),
        "tolerance_mg_dl": rule.tolerance,
        "without_insulin_mg_dl": rule.without_insulin.0,
        "reference_weight_kg": WEIGHT.0,
    });
    let manifest = Manifest::new("trajectories", config, None)
        .with_model(&args.model)?
        .with_inputs(&args.twin)?;
    let population = Arc::new(read_population(&args.model)?);
    let report = match &args.twin {
        None => checked(population.as_ref(), &population, &rule),
        Some(path) => {
            let twin = read_twin(path, population)?;
            checked(&twin, &twin.population, &rule)
        }
    }?;
    let output = OutputFolder::begin(&args.out, manifest)?;
    let text = text(&report);
    output.write_document(&report)?;
    let place = output.finish_with_table("trajectories.txt", &text)?;
    let count = report.findings.iter().filter(|finding| finding.passed).count();
    note(format!(
        "trajectories: {count} of {} checks passed, {}",
        report.findings.len(),
        place.join(Trajectories::FILE).display()
    ));
    Ok(())
}

/// A network, with or without a person's residual, beside the nominal ODE. A twin starts where its population
/// network rests.
fn checked<P>(plant: &P, population: &PopulationModel, rule: &CheckRule) -> Result<Trajectories>
where
    P: physiology::Plant<State = ScaledStates>,
{
    let rest = |glucose: MgPerDl| {
        let found = steady_state(population, glucose).map_err(|error| error.to_string())?;
        let is_steady = found.outcome == SteadyStateOutcome::Found;
        let basal = physiology::UnitsPerHour(found.basal.0.max(0.0));
        Ok(Rest { state: found.states, basal, is_steady })
    };
    let parameters = OdeParameters::nominal();
    let ode = OdePlant::reproduction(parameters, WEIGHT);
    let ode_rest = |glucose: MgPerDl| {
        let found = ode_sim::steady_state::at_glucose(&parameters, WEIGHT, glucose)
            .map_err(|error| error.to_string())?;
        Ok(Rest { state: found.state, basal: found.basal, is_steady: true })
    };
    let model = Subject { plant, rest: &rest };
    let reference = Subject { plant: &ode, rest: &ode_rest };
    check(&model, &reference, rule).context("the checks could not be made")
}

fn name(check: Check) -> (&'static str, &'static str) {
    match check {
        Check::ZeroInsulin => ("a day without insulin ends above 250 mg/dL", "x basal"),
        Check::Basal => ("more basal never ends higher", "x basal"),
        Check::Bolus => ("a larger bolus never raises glucose", "U"),
        Check::Carbs => ("more carbohydrate never lowers it", "g"),
        Check::CarbRatio => ("more insulin for a meal never stays higher", "g/U"),
    }
}

fn text(report: &Trajectories) -> String {
    let mut text = String::from("Trajectories beside the ODE's, mg/dL:");
    for finding in &report.findings {
        let (asked, unit) = name(finding.check);
        let (verdict, w) = (if finding.passed { "pass" } else { "FAIL" }, &finding.worst);
        let _ = write!(
            text,
            "\n  {verdict}  {asked:<44} off by {:>6.1}: from {:.0}, {} to {} {unit}, {:.0} min on {:.1} and {:.1} ({} cases)",
            finding.worst_mg_dl.max(0.0),
            w.start_mg_dl,
            w.less,
            w.more,
            w.minutes,
            w.glucose_less_mg_dl,
            w.glucose_more_mg_dl,
            finding.cases,
        );
    }
    if !report.starts_not_at_rest.is_empty() {
        let starts: Vec<String> =
            report.starts_not_at_rest.iter().map(|start| format!("{start:.0}")).collect();
        let _ = write!(
            text,
            "\n  no steady state at {} mg/dL: the nearest state was used",
            starts.join(", ")
        );
    }
    text
}
