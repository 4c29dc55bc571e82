//! Trains a small model on a toy plant, writes and reads its weight file, and shows an hour-by-hour
//! roll-out with and without a meal. Needs no data and about twenty seconds.

use nn_statespace::training::{
    CarbStart, LearningRate, Provenance, Run, Stage, TrainingConfig, WindowSet, train,
};
use nn_statespace::{PopulationModel, Scaler, Widths};
use physiology::{Compartment, Grams, OpenLoop, States, StepInput, Units, UnitsPerHour, simulate};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

#[expect(clippy::print_stdout, reason = "an example shows its result")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let days: Vec<(Vec<States>, Vec<StepInput>)> = (0..60).map(toy_day).collect();
    let runs: Vec<Run<'_>> = days.iter().map(|(states, inputs)| Run { states, inputs }).collect();
    let (train_on, judge_on) = runs.split_at(50);
    let scaler = Scaler::fit(train_on)?;
    let training = WindowSet::new(&scaler, train_on, 60, 15, CarbStart::Reported)?;
    let validation = WindowSet::new(&scaler, judge_on, 60, 60, CarbStart::Reported)?;
    let stage = |epochs, steps, first| Stage {
        epochs,
        steps,
        learning_rate: LearningRate { first, decay: 0.06 },
    };
    let config = TrainingConfig {
        stages: vec![stage(10, 6, 1e-2), stage(60, 60, 5e-3)],
        batch: 64,
        ..TrainingConfig::quick(1)
    };
    let provenance = Provenance { origin: "a toy plant".to_owned(), training_data_sha256: None };
    let trained = train(&config, &Widths::quick(), &training, &validation, provenance, |epoch| {
        if epoch.epoch % 10 == 9 {
            let error = epoch.validation.balanced();
            println!("epoch {:3}  loss {:.4}  {error:.1} mg/dL", epoch.epoch, epoch.training_loss);
        }
    })?;
    let model = PopulationModel::from_safetensors(&trained.model.to_safetensors())?;
    let start = model.scaler().scale(&judge_on[0].states[0]);
    let mut inputs = vec![StepInput { basal: UnitsPerHour(1.0), ..StepInput::default() }; 60];
    let fasting = simulate(&model, start, &mut OpenLoop::new(&inputs), 60)?.glucose(&model);
    inputs[6].carbs = Grams(60.0);
    inputs[6].bolus = Units(1.0);
    let fed = simulate(&model, start, &mut OpenLoop::new(&inputs), 60)?.glucose(&model);
    for hour in 0..=5 {
        println!(
            "{hour} h  fasting {:.0}  after 60 g and 1 U {:.0}",
            fasting[12 * hour],
            fed[12 * hour]
        );
    }
    Ok(())
}

/// A day of ten linear compartments, wired as the model is, with three meals.
fn toy_day(day: u64) -> (Vec<States>, Vec<StepInput>) {
    use Compartment::{C1, C2, I, Q1, Q2, S1, S2, X1, X2, X3};
    let mut rng = ChaCha8Rng::seed_from_u64(day);
    let first_meal = rng.random_range(0..60);
    let mut x = States::default();
    let settled = [(S1, 50.0), (S2, 50.0), (I, 10.0), (X1, 0.1), (X2, 0.1), (X3, 0.1), (Q2, 6.0)];
    for (compartment, value) in settled.into_iter().chain([(Q1, rng.random_range(80.0..250.0))]) {
        x[compartment] = value;
    }
    let mut states = vec![x];
    let mut inputs = Vec::new();
    for step in 0..288 {
        let mut input = StepInput { basal: UnitsPerHour(1.0), ..StepInput::default() };
        if step % 60 == first_meal {
            input.carbs = Grams(rng.random_range(15.0..90.0));
            input.bolus = Units(input.carbs.0 / rng.random_range(40.0..80.0));
        }
        let mut next = x;
        next[C1] += input.carbs.0 / 20.0 - 5.0 * x[C1] / 40.0;
        next[C2] += 5.0 * (x[C1] - x[C2]) / 40.0;
        next[S1] += 5.0 * (input.insulin().0 - x[S1] / 50.0);
        next[S2] += 5.0 * (x[S1] - x[S2]) / 50.0;
        next[I] += 5.0 * (0.01 * x[S2] - 0.05 * x[I]);
        for state in [X1, X2, X3] {
            next[state] += 5.0 * 0.02 * (0.01 * x[I] - x[state]);
        }
        let rate = 2.4 * x[C2] - 6.0 * x[X1] - 3.0 * x[X3] + 0.2 * x[Q2] - 0.03 * x[Q1] + 3.3;
        next[Q1] += 5.0 * rate;
        next[Q2] += 5.0 * (0.002 * x[Q1] - 0.04 * x[Q2] + 0.1 * x[X1] - 0.1 * x[X2]);
        x = next;
        states.push(x);
        inputs.push(input);
    }
    (states, inputs)
}
