//! The published weights, read without Python, against traces that other code computed from them.

use std::path::Path;

use nn_statespace::import::{self, DenseLayer};
use nn_statespace::initial_state::{InitialStateTable, SteadyStateOutcome, steady_state};
use nn_statespace::{GlucoseClamp, PopulationModel, ScaledStates, Signal, Widths};
use physiology::{
    Compartment, Grams, MgPerDl, NonFinite, OpenLoop, Plant, States, StepInput, UnitsPerHour,
    simulate,
};

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

fn table(folder: &Path) -> InitialStateTable {
    InitialStateTable::read(&*bytes(folder, "initSteadyStates.csv")).expect("the table is read")
}

/// A column of a plain CSV file as numbers.
fn column(folder: &Path, file: &str, name: &str) -> Vec<f64> {
    let text = String::from_utf8(bytes(folder, file)).expect("text");
    let mut lines = text.lines();
    let index = lines
        .next()
        .and_then(|header| header.split(',').position(|field| field == name))
        .expect("the column is there");
    lines
        .map(|line| line.split(',').nth(index).and_then(|f| f.parse().ok()).expect("a number"))
        .collect()
}

/// The inputs of the example day.
fn example_day(folder: &Path) -> Vec<StepInput> {
    column(folder, "example_subjectX.csv", "input_insulin_ODEPop")
        .into_iter()
        .zip(column(folder, "example_subjectX.csv", "input_meal_carbs_ODEPop"))
        .map(|(insulin, carbs)| StepInput {
            basal: UnitsPerHour(insulin),
            carbs: Grams(carbs),
            ..StepInput::default()
        })
        .collect()
}

/// Compares simulated states with a trace: largest deviations of Q1 in mg/dL and of any state
/// relative to its value or, where that is smaller, its scale.
fn deviations(
    folder: &Path,
    trace: &str,
    model: &PopulationModel,
    states: &[States],
) -> (f64, f64) {
    let (mut glucose, mut relative) = (0.0_f64, 0.0_f64);
    for compartment in Compartment::ALL {
        let scale = model.scaler().of(Signal::State(compartment)).scale;
        let expected = column(folder, trace, compartment.name());
        assert_eq!(expected.len(), 288, "a day");
        for (step, expected) in expected.into_iter().enumerate() {
            let difference = (states[step][compartment] - expected).abs();
            if compartment == Compartment::Q1 {
                glucose = glucose.max(difference);
            }
            relative = relative.max(difference / scale.max(expected.abs()));
        }
    }
    (glucose, relative)
}

#[test]
fn the_example_day_is_replayed() {
    let Some(folder) = reference_data::find("t1dsim_ai", "the_example_day_is_replayed") else {
        return;
    };
    let model = published(&folder);
    assert_eq!(model.widths(), Widths::paper());
    assert_eq!(model.clamp(), GlucoseClamp::Reproduction);
    let inputs = example_day(&folder);
    let first_reading = column(&folder, "example_subjectX.csv", "cgm")[0];
    let initial = table(&folder).row(MgPerDl(first_reading)).expect("within the table");
    let run = simulate(&model, initial, &mut OpenLoop::new(&inputs), inputs.len()).expect("finite");
    let states = run.report(&model);
    let (glucose, relative) = deviations(&folder, "trace_population.csv", &model, &states);
    // The trace is printed to nine digits: half a unit of the last is 5e-7 mg/dL and 5e-9.
    assert!(glucose < 1e-6 && relative < 1e-8, "{glucose} mg/dL, {relative}");
}

/// The population model with the individual network of person 0826 in its place.
struct Twin<'a> {
    model: &'a PopulationModel,
    layers: [DenseLayer; 4],
    /// Heart rate (scaled), weekend, cos and sin of the hour, sleep efficiency, by step.
    context: Vec<[f64; 5]>,
}

impl Plant for Twin<'_> {
    type State = (usize, ScaledStates);

    fn step(&self, state: &Self::State, input: &StepInput) -> Result<Self::State, NonFinite> {
        let (step, x) = state;
        let mut signal: Vec<f64> = {
            use Compartment::{C2, Q1, Q2, X1, X3};
            [Q1, Q2, X1, X3, C2].map(|c| x[c]).into_iter().chain(self.context[*step]).collect()
        };
        for (depth, layer) in self.layers.iter().enumerate() {
            let rows = layer.weight.chunks_exact(layer.inputs).zip(&layer.bias);
            signal = rows
                .map(|(row, bias)| row.iter().zip(&signal).fold(*bias, |sum, (w, s)| sum + w * s))
                .map(|value| if depth + 1 < self.layers.len() { value.max(0.0) } else { value })
                .collect();
        }
        Ok((step + 1, self.model.step_with_residual(x, input, signal[0])?))
    }

    fn glucose(&self, state: &Self::State) -> MgPerDl {
        self.model.glucose(&state.1)
    }

    fn report(&self, state: &Self::State) -> States {
        self.model.report(&state.1)
    }
}

#[test]
fn the_residual_network_enters_before_the_clamp() {
    let Some(folder) = reference_data::find("t1dsim_ai", "the_residual_network") else { return };
    let model = published(&folder);
    let heart_rate = import::heart_rate_scaler(&bytes(&folder, "Model0826/scaler_robust.pkl"))
        .expect("the published scaler is read");
    let day = |name| column(&folder, "example_subjectX.csv", name);
    let context: Vec<[f64; 5]> = (0..288)
        .map(|step| {
            let bpm = day("heart_rate_WRTbaseline")[step];
            [
                (bpm - heart_rate.centre) / heart_rate.scale,
                day("feat_is_weekend")[step],
                day("feat_hour_of_day_cos")[step],
                day("feat_hour_of_day_sin")[step],
                day("sleep_efficiency")[step],
            ]
        })
        .collect();
    let layers = import::individual_network(&bytes(&folder, "Model0826/individual_model.pt"))
        .expect("the published network is read");
    let parameters: usize = layers.iter().map(|l| l.weight.len() + l.bias.len()).sum();
    assert_eq!(parameters, 11_777); // 10-128-64-32-1
    let twin = Twin { model: &model, layers, context };
    let inputs = example_day(&folder);
    let initial = (0, table(&folder).row(MgPerDl(128.0)).expect("within the table"));
    let run = simulate(&twin, initial, &mut OpenLoop::new(&inputs), inputs.len()).expect("finite");
    let states = run.report(&twin);
    let (glucose, relative) = deviations(&folder, "trace_twin_0826.csv", &model, &states);
    // Nine printed digits; the features of the file carry as many.
    assert!(glucose < 1e-6 && relative < 1e-8, "{glucose} mg/dL, {relative}");
}

#[test]
fn published_weights_survive_our_weight_file() {
    let Some(folder) = reference_data::find("t1dsim_ai", "published_weights_survive") else {
        return;
    };
    let model = published(&folder);
    let back = PopulationModel::from_safetensors(&model.to_safetensors()).expect("just written");
    assert_eq!(back, model);
}

#[test]
fn candle_reads_the_same_tensors() {
    let Some(folder) = reference_data::find("t1dsim_ai", "candle_reads_the_same") else { return };
    let model = published(&folder);
    let theirs = candle_core::pickle::PthTensors::new(folder.join(WEIGHTS), None)
        .expect("candle reads the published file");
    let tensor = |name: String| -> Vec<f64> {
        let tensor = theirs.get(&name).expect("readable").expect("present");
        let flat = tensor.flatten_all().and_then(|t| t.to_vec1::<f32>()).expect("f32");
        flat.into_iter().map(f64::from).collect()
    };
    for compartment in Compartment::ALL {
        let network = model.network(compartment);
        assert_eq!(network.w1(), tensor(format!("net_d{compartment}.0.weight")));
        assert_eq!(network.b1(), tensor(format!("net_d{compartment}.0.bias")));
        assert_eq!(network.w2(), tensor(format!("net_d{compartment}.2.weight")));
        assert_eq!([network.b2()], *tensor(format!("net_d{compartment}.2.bias")));
    }
}

#[test]
fn steady_states_stand_still_where_the_weights_have_them() {
    let Some(folder) = reference_data::find("t1dsim_ai", "steady_states_stand_still") else {
        return;
    };
    let model = published(&folder);
    let table = table(&folder);
    for glucose in [40.0, 60.0, 70.0, 85.0, 100.0, 120.0, 140.0, 160.0, 180.0, 200.0, 215.0] {
        let ours = steady_state(&model, MgPerDl(glucose)).expect("a glucose");
        assert_eq!(ours.outcome, SteadyStateOutcome::Found, "{glucose}");
        assert!(ours.residual < 1e-11, "{glucose}: {}", ours.residual);
        // Nothing moves in the plant either: five minutes of the residual and rounding.
        let held = StepInput { basal: ours.basal, ..StepInput::default() };
        let next = model.step(&ours.states, &held).expect("finite");
        for (compartment, value) in next.iter() {
            assert!((value - ours.states[compartment]).abs() < 1e-10, "{glucose} {compartment}");
        }
        // The authors' rows carry phantom carbohydrate; ours do not.
        let theirs = table.row(MgPerDl(glucose)).expect("a row");
        assert!((theirs[Compartment::C1] - 1.3625).abs() < 1e-4);
        assert!(ours.states[Compartment::C1].abs() < 0.02);
    }
}

#[test]
fn above_218_the_published_weights_have_no_steady_state() {
    let Some(folder) = reference_data::find("t1dsim_ai", "no_steady_state_above_218") else {
        return;
    };
    // An independent scan over basal rates, with every root of each network in turn, finds that
    // glucose falls whatever the rate: at 220 mg/dL by at least 3e-4 scaled units a minute.
    let model = published(&folder);
    for glucose in [225.0, 250.0, 300.0, 400.0] {
        let nearest = steady_state(&model, MgPerDl(glucose)).expect("a glucose");
        assert_eq!(nearest.outcome, SteadyStateOutcome::NotFound, "{glucose}");
        assert!(nearest.residual > 1e-6 && nearest.residual < 1e-2, "{glucose}");
    }
}
