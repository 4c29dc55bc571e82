//! The published twins against traces computed from the same weights.

use std::path::Path;
use std::sync::Arc;

use nn_statespace::initial_state::{InitialStateTable, steady_state};
use nn_statespace::{PopulationModel, import};
use physiology::{
    BeatsPerMinute, Compartment, Context, Grams, MgPerDl, OpenLoop, Plant, StepInput, UnitsPerHour,
    simulate,
};
use twins::{Twin, published_twin};

/// Columns of a comma-separated table by name.
struct Table {
    header: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Table {
    fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).expect("a readable table");
        let mut lines = text.lines();
        let header = lines.next().expect("a header").split(',').map(str::to_owned).collect();
        let rows = lines
            .map(|line| line.split(',').map(|cell| cell.parse().expect("a number")).collect())
            .collect();
        Self { header, rows }
    }

    fn column(&self, name: &str) -> Vec<f64> {
        let index = self.header.iter().position(|h| h == name).expect("the column");
        self.rows.iter().map(|row| row[index]).collect()
    }
}

fn population(folder: &Path) -> Arc<PopulationModel> {
    let bytes = |name: &str| std::fs::read(folder.join(name)).expect("a readable file");
    let model = import::population(
        &bytes("population_model_05022024_epoch_15.pt"),
        &bytes("scaler_states.pkl"),
        &bytes("scaler_inputs.pkl"),
    );
    Arc::new(model.expect("the published weights"))
}

fn twin(folder: &Path, name: &str) -> Twin {
    let bytes = |file: &str| std::fs::read(folder.join(name).join(file)).expect("a readable file");
    published_twin(
        &bytes("individual_model.pt"),
        &bytes("scaler_robust.pkl"),
        population(folder),
        name,
    )
    .expect("a published twin")
}

fn example_day(folder: &Path) -> (MgPerDl, Vec<StepInput>) {
    let day = Table::read(&folder.join("example_subjectX.csv"));
    let insulin = day.column("input_insulin_ODEPop");
    let carbs = day.column("input_meal_carbs_ODEPop");
    let (hour, weekend) = (day.column("hour_of_day"), day.column("feat_is_weekend"));
    let rate = day.column("heart_rate_WRTbaseline");
    let sleep = day.column("sleep_efficiency");
    let inputs = (0..insulin.len())
        .map(|k| StepInput {
            basal: UnitsPerHour(insulin[k]),
            carbs: Grams(carbs[k]),
            context: Context {
                heart_rate_over_baseline: Some(BeatsPerMinute(rate[k])),
                hour: hour[k] as u8,
                weekend: weekend[k] != 0.0,
                sleep_efficiency: Some(sleep[k]),
            },
            ..StepInput::default()
        })
        .collect();
    (MgPerDl(day.column("cgm")[0]), inputs)
}

#[test]
fn twin_0826_reproduces_its_reference_trace() {
    let Some(folder) =
        reference_data::find("t1dsim_ai", "twin_0826_reproduces_its_reference_trace")
    else {
        return;
    };
    let twin = twin(&folder, "Model0826");
    let (glucose, inputs) = example_day(&folder);
    let table = std::fs::File::open(folder.join("initSteadyStates.csv")).expect("the table");
    let start = InitialStateTable::read(table).expect("a table").row(glucose).expect("in range");
    let steps = inputs.len();
    let run = simulate(&twin, start, &mut OpenLoop::new(&inputs), steps).expect("finite");
    let reference = Table::read(&folder.join("trace_twin_0826.csv"));
    let report = run.report(&twin);
    let mut largest = 0.0_f64;
    for (k, expected) in reference.column("Q1").into_iter().enumerate() {
        largest = largest.max((report[k][Compartment::Q1] - expected).abs());
    }
    // The trace prints nine digits (5e-7 at 400 mg/dL); both sides compute in f64.
    assert!(largest < 1e-5, "largest deviation of Q1 {largest} mg/dL");
    assert_eq!(reference.rows.len(), 288);
    for compartment in Compartment::ALL {
        for (k, expected) in reference.column(compartment.name()).into_iter().enumerate() {
            let found = report[k][compartment];
            // Nine printed digits, a hundredfold for what 288 steps make of rounding.
            let tolerance = 1e-7 * expected.abs().max(1e-3);
            assert!((found - expected).abs() < tolerance, "{compartment} {k}: {found} {expected}");
        }
    }
}

#[test]
fn the_other_twin_loads_and_differs() {
    let Some(folder) = reference_data::find("t1dsim_ai", "the_other_twin_loads_and_differs") else {
        return;
    };
    let (one, other) = (twin(&folder, "Model0826"), twin(&folder, "Model0007"));
    assert_ne!(one.residual, other.residual);
    let (glucose, inputs) = example_day(&folder);
    let start = steady_state(&one.population, glucose).expect("in range").states;
    let run = simulate(&other, start, &mut OpenLoop::new(&inputs), 287).expect("finite");
    for state in &run.states {
        assert!((40.0..=400.0 + 1e-9).contains(&other.glucose(state).0)); // rounding of the scaler
    }
}

#[test]
fn a_published_twin_survives_its_own_file() {
    let Some(folder) = reference_data::find("t1dsim_ai", "a_published_twin_survives_its_own_file")
    else {
        return;
    };
    let twin = twin(&folder, "Model0826");
    let bytes = twin.to_bytes().expect("writable");
    let back = Twin::from_bytes(&bytes, Arc::clone(&twin.population)).expect("readable");
    assert_eq!(back.residual, twin.residual);
    assert_eq!(back.heart_rate_scaler, twin.heart_rate_scaler);
    assert_eq!(back.card, twin.card);
    assert_eq!(back.to_bytes().expect("writable"), bytes);
}
