//! The published weights, read without Python, against traces computed from them by other code.

use std::path::Path;

use nn_statespace::initial_state::{InitialStateTable, SteadyStateOutcome, steady_state};
use nn_statespace::{PopulationModel, Signal, import};
use physiology::{Compartment, Grams, MgPerDl, OpenLoop, StepInput, UnitsPerHour, simulate};

const WEIGHTS: &str = "population_model_05022024_epoch_15.pt";

fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).expect("the reference folder is complete")
}

fn published(folder: &Path) -> PopulationModel {
    import::population(
        &bytes(folder, WEIGHTS),
        &bytes(folder, "scaler_states.pkl"),
        &bytes(folder, "scaler_inputs.pkl"),
    )
    .expect("the published files are read")
}

/// A column of a plain CSV file as numbers.
fn column(folder: &Path, file: &str, name: &str) -> Vec<f64> {
    let text = String::from_utf8(bytes(folder, file)).expect("text");
    let mut lines = text.lines();
    let place = lines
        .next()
        .and_then(|header| header.split(',').position(|field| field == name))
        .expect("the column is there");
    lines
        .map(|line| line.split(',').nth(place).and_then(|f| f.parse().ok()).expect("a number"))
        .collect()
}

#[test]
fn the_example_day_is_replayed() {
    let Some(folder) = reference_data::find("t1dsim_ai", "the_example_day_is_replayed") else {
        return;
    };
    let model = published(&folder);
    let table = InitialStateTable::read(&*bytes(&folder, "initSteadyStates.csv")).expect("read");
    let day = |name| column(&folder, "example_subjectX.csv", name);
    let inputs: Vec<StepInput> = day("input_insulin_ODEPop")
        .into_iter()
        .zip(day("input_meal_carbs_ODEPop"))
        .map(|(insulin, carbs)| StepInput {
            basal: UnitsPerHour(insulin),
            carbs: Grams(carbs),
            ..StepInput::default()
        })
        .collect();
    let initial = table.row(MgPerDl(day("cgm")[0])).expect("within the table");
    let run = simulate(&model, initial, &mut OpenLoop::new(&inputs), inputs.len()).expect("finite");
    let states = run.report(&model);
    let mut worst_glucose: f64 = 0.0;
    let mut worst: f64 = 0.0;
    for compartment in Compartment::ALL {
        let reference = column(&folder, "trace_population.csv", compartment.name());
        let scale = model.scaler().of(Signal::State(compartment)).scale;
        for (step, expected) in reference.iter().enumerate() {
            let difference = (states[step][compartment] - expected).abs();
            if compartment == Compartment::Q1 {
                worst_glucose = worst_glucose.max(difference);
            }
            worst = worst.max(difference / scale.max(expected.abs()));
        }
    }
    println!("largest deviation: {worst_glucose:.2e} mg/dL, {worst:.2e} relative");
    // The trace is printed to nine digits: 5e-7 mg/dL at 128.
    assert!(worst_glucose < 1e-6, "{worst_glucose} mg/dL");
    assert!(worst < 1e-8, "{worst} relative");
}

#[test]
fn steady_states_of_the_published_weights() {
    let Some(folder) = reference_data::find("t1dsim_ai", "steady_states") else { return };
    let model = published(&folder);
    let table = InitialStateTable::read(&*bytes(&folder, "initSteadyStates.csv")).expect("read");
    for glucose in [40.0, 70.0, 100.0, 120.0, 140.0, 160.0, 180.0, 220.0, 250.0, 300.0, 400.0] {
        let ours = steady_state(&model, MgPerDl(glucose)).expect("a glucose");
        let theirs = table.row(MgPerDl(glucose)).expect("a row");
        println!(
            "{glucose} {:?} basal {:.4} residual {:.2e}",
            ours.outcome, ours.basal.0, ours.residual
        );
        for (c, v) in ours.states.iter() {
            print!(" {c} {v:.4}/{:.4}", theirs[c]);
        }
        println!();
        assert_eq!(ours.outcome == SteadyStateOutcome::Found, glucose < 219.0);
    }
}
