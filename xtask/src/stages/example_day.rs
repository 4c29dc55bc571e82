//! One held-out day of one person, measured and simulated, for the report.

use std::collections::BTreeMap;
use std::sync::Arc;

use anyhow::{Context as _, Result};
use cohort::{Cohort, MissingDoses, Person};
use evaluation::{Evaluation, Method, ode_baseline};
use nn_statespace::PopulationModel;
use physiology::{MgPerDl, OpenLoop, Plant, STEPS_PER_DAY, StepInput, simulate};
use serde::Serialize;
use twins::{PersonWindows, Protocol, Startable, Twin, window_starts};

/// `example_day.json`: every series has one value a step.
#[derive(Debug, Serialize)]
pub(crate) struct ExampleDay {
    person_id: String,
    date: String,
    time: Vec<String>,
    cgm: Vec<Option<f64>>,
    population: Vec<f64>,
    twin: Vec<f64>,
    ode: Vec<f64>,
    insulin_u_h: Vec<f64>,
    carbs_g: Vec<f64>,
    heart_rate_over_baseline: Vec<Option<f64>>,
    sleep_efficiency: Vec<Option<f64>>,
    chosen: String,
}

/// Which day to show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Chosen {
    person: usize,
    start: usize,
}

/// The day to show: of the person with the median error of the twin, the first complete calendar
/// day after the training days. Nothing about how the day itself comes out enters the choice.
pub(crate) fn choose(
    cohort: &Cohort,
    twins: &BTreeMap<String, Twin>,
    evaluation: &Evaluation,
    protocol: &Protocol,
) -> Option<Chosen> {
    let mut judged: Vec<(f64, usize)> = evaluation
        .people
        .iter()
        .filter_map(|found| {
            let (index, person) = cohort.find(&found.person_id)?;
            let rmse = found.of(Method::Twin)?.rmse;
            twins.contains_key(&person.id).then_some((rmse, index))
        })
        .collect();
    judged.sort_by(|a, b| a.0.total_cmp(&b.0));
    // From the median upwards, then downwards, should the first have no complete day.
    let middle = judged.len() / 2;
    let order = (middle..judged.len()).chain((0..middle).rev());
    order.map(|place| judged[place].1).find_map(|person| {
        let start = complete_day(&cohort.people[person], protocol)?;
        Some(Chosen { person, start })
    })
}

/// First step of the first calendar day after the training days whose readings are all there.
fn complete_day(person: &Person, protocol: &Protocol) -> Option<usize> {
    let record = &person.record;
    let first_test = protocol.training_days_of(record) * STEPS_PER_DAY;
    (first_test..record.len().checked_sub(STEPS_PER_DAY)? + 1)
        .filter(|k| record.time(*k).format("%H:%M").to_string() == "00:00")
        .find(|k| record.cgm()[*k..*k + STEPS_PER_DAY].iter().all(Option::is_some))
}

/// Runs the day under the twin, the population model and the ODE.
pub(crate) fn simulate_day(
    cohort: &Cohort,
    twins: &BTreeMap<String, Twin>,
    population: &Arc<PopulationModel>,
    chosen: &Chosen,
    protocol: &Protocol,
) -> Result<ExampleDay> {
    let person = &cohort.people[chosen.person];
    let twin = twins.get(&person.id).context("the example day's person has a twin")?;
    let cut = PersonWindows::new(chosen.person, person, protocol)?;
    let range = chosen.start..chosen.start + STEPS_PER_DAY;
    let inputs = person.inputs(range.clone(), MissingDoses::Zero)?;
    let ode = ode_baseline(person.weight);
    let network = start(&**population, person, &cut, protocol, chosen.start)?;
    let record = &person.record;
    Ok(ExampleDay {
        person_id: person.id.clone(),
        date: record.time(chosen.start).format("%Y-%m-%d").to_string(),
        time: range.clone().map(|k| record.time(k).format("%H:%M").to_string()).collect(),
        cgm: record.cgm()[range].to_vec(),
        population: glucose(&**population, network, &inputs)?,
        twin: glucose(twin, network, &inputs)?,
        ode: glucose(&ode, start(&ode, person, &cut, protocol, chosen.start)?, &inputs)?,
        insulin_u_h: inputs.iter().map(|input| input.insulin().0).collect(),
        carbs_g: inputs.iter().map(|input| input.carbs.0).collect(),
        heart_rate_over_baseline: inputs
            .iter()
            .map(|input| input.context.heart_rate_over_baseline.map(|rate| rate.0))
            .collect(),
        sleep_efficiency: inputs.iter().map(|input| input.context.sleep_efficiency).collect(),
        chosen: "person with the median twin error, first complete day after training".to_owned(),
    })
}

fn start<P: Startable>(
    plant: &P,
    person: &Person,
    cut: &PersonWindows,
    protocol: &Protocol,
    step: usize,
) -> Result<P::State> {
    let found = starts(plant, person, cut, protocol, &[step])?;
    found.into_iter().next().context("one start was asked for")
}

/// The states of a plant at the start of each of `steps`.
pub(crate) fn starts<P: Startable>(
    plant: &P,
    person: &Person,
    cut: &PersonWindows,
    protocol: &Protocol,
    steps: &[usize],
) -> Result<Vec<P::State>> {
    let found = window_starts(plant, person, &cut.inputs, steps, protocol.start, cut.mean_basal)?;
    Ok(found.states)
}

/// Glucose at the start of each step, mg/dL.
pub(crate) fn glucose<P: Plant>(
    plant: &P,
    start: P::State,
    inputs: &[StepInput],
) -> Result<Vec<f64>> {
    let run = simulate(plant, start, &mut OpenLoop::new(inputs), inputs.len())?;
    let mut glucose: Vec<f64> = run.glucose(plant).into_iter().map(MgPerDl::value).collect();
    glucose.truncate(inputs.len());
    Ok(glucose)
}
