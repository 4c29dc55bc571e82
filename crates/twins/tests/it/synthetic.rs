//! A small population model with the right signs, days with meals and exercise, and networks that
//! are not zero, for tests that need no data from outside.

use std::sync::Arc;

use cohort::{Channel, Cohort, MissingDoses, Person, Record, Therapy};
use nn_statespace::{
    CentreAndScale, GlucoseClamp, HiddenLayerNetwork, ModelCard, PerCompartment, PopulationModel,
    ScaledStates, Scaler, Wiring,
};
use physiology::{
    BeatsPerMinute, Compartment, Context, Grams, OpenLoop, StepInput, Units, UnitsPerHour, simulate,
};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use twins::{InputSet, ResidualNetwork, Twin, TwinCard};

/// Linear compartments as networks of paired rectifiers: relu(x) - relu(-x) = x.
pub(crate) fn population(clamp: GlucoseClamp) -> Arc<PopulationModel> {
    use Compartment::{C1, C2, I, Q1, Q2, S1, S2, X1, X2, X3};
    let wiring = Wiring::paper();
    // Slopes by input in the wiring's order, per minute.
    let slopes = |c: Compartment| -> Vec<f64> {
        match c {
            S1 => vec![-0.02, 0.02],
            S2 => vec![0.02, -0.02],
            I => vec![0.03, -0.03],
            X1 | X2 | X3 => vec![0.02, -0.02],
            // X1, X3, Q1, Q2, C2
            Q1 => vec![-0.006, -0.008, -0.004, 0.003, 0.03],
            // X1, X2, Q1, Q2
            Q2 => vec![0.004, -0.004, 0.01, -0.02],
            C1 => vec![-0.04, 0.01],
            C2 => vec![0.04, -0.03],
        }
    };
    let networks = PerCompartment::from_fn(|c| {
        let slopes = slopes(c);
        let n = slopes.len();
        let (mut w1, mut w2) = (Vec::new(), Vec::new());
        for (i, slope) in slopes.iter().enumerate() {
            for sign in [1.0, -1.0] {
                w1.extend((0..n).map(|j| if i == j { sign } else { 0.0 }));
                w2.push(sign * slope);
            }
        }
        HiddenLayerNetwork::new(n, w1, vec![0.0; 2 * n], w2, 0.0).expect("shapes fit")
    });
    let states = PerCompartment::from_fn(|c| match c {
        Q1 => CentreAndScale { centre: 130.0, scale: 80.0 },
        _ => CentreAndScale { centre: 1.0, scale: 0.5 },
    });
    let insulin = CentreAndScale { centre: 1.0, scale: 0.5 };
    let carbs = CentreAndScale { centre: 0.0, scale: 1.0 };
    let scaler = Scaler::new(states, insulin, carbs).expect("positive scales");
    let card = ModelCard {
        origin: "made for a test".to_owned(),
        version: "0".to_owned(),
        training_data_sha256: None,
        training: None,
    };
    Arc::new(PopulationModel::new(wiring, networks, scaler, clamp, card).expect("shapes fit"))
}

/// Steps with a bolus and a meal every five hours and exercise now and then.
pub(crate) fn exercising_day(steps: usize) -> Vec<StepInput> {
    (0..steps)
        .map(|k| StepInput {
            basal: UnitsPerHour(1.0),
            bolus: Units(if k % 60 == 10 { 3.0 } else { 0.0 }),
            carbs: Grams(if k % 60 == 12 { 30.0 } else { 0.0 }),
            context: Context {
                heart_rate_over_baseline: Some(BeatsPerMinute(if k % 100 > 80 {
                    45.0
                } else {
                    2.0
                })),
                hour: (k / 12 % 24) as u8,
                weekend: k / 288 % 7 > 4,
                sleep_efficiency: Some(if k / 12 % 24 < 7 { 0.95 } else { 0.0 }),
            },
            ..StepInput::default()
        })
        .collect()
}

/// The untrained network with a last layer that is not zero.
pub(crate) fn trained_looking(seed: u64) -> ResidualNetwork {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = |n: usize, size: f64| -> Vec<f64> {
        (0..n).map(|_| rng.random_range(-size..size)).collect()
    };
    let weights = [draw(1280, 0.3), draw(8192, 0.09), draw(2048, 0.12), draw(32, 0.05)];
    let biases = [draw(128, 0.3), draw(64, 0.09), draw(32, 0.12), draw(1, 0.01)];
    ResidualNetwork::from_tensors(
        weights.each_ref().map(Vec::as_slice),
        biases.each_ref().map(Vec::as_slice),
    )
    .expect("shapes fit")
}

/// A person whose glucose drifts up by 0.005 scaled units a minute, falls by 0.01 for each unit of
/// scaled heart rate above the median, and by 0.006 for each unit of Q1 above its own.
pub(crate) fn planted() -> ResidualNetwork {
    let (mut w0, mut w1) = (vec![0.0; 1280], vec![0.0; 8192]);
    let (mut w2, mut w3) = (vec![0.0; 2048], vec![0.0; 32]);
    for (unit, input, slope) in [(0, 5, -0.01), (1, 0, -0.006)] {
        w0[unit * 10 + input] = 1.0;
        w1[unit * 128 + unit] = 1.0;
        w2[unit * 64 + unit] = 1.0;
        w3[unit] = slope;
    }
    let biases = [vec![0.0; 128], vec![0.0; 64], vec![0.0; 32], vec![0.005]];
    ResidualNetwork::from_tensors([&w0, &w1, &w2, &w3], biases.each_ref().map(Vec::as_slice))
        .expect("shapes fit")
}

/// A twin on the synthetic population model.
pub(crate) fn twin_of(residual: ResidualNetwork, clamp: GlucoseClamp) -> Twin {
    Twin {
        population: population(clamp),
        residual,
        heart_rate_scaler: None,
        inputs: InputSet::All,
        card: TwinCard {
            person_id: "a".to_owned(),
            origin: "made for a test".to_owned(),
            version: "0".to_owned(),
            ..TwinCard::default()
        },
    }
}

/// A cohort of people whose glucose follows `truth` on the synthetic population model, without
/// noise: `days` days of [`exercising_day`], each person starting a little later in it.
pub(crate) fn cohort_of(truth: &Twin, people: usize, days: usize) -> Cohort {
    let start: chrono::NaiveDateTime = "2024-03-04T00:00:00".parse().expect("a literal time");
    let steps = days * physiology::STEPS_PER_DAY;
    let person = |index: usize| {
        let mut record = Record::new(start, steps).expect("on the grid");
        let doses = exercising_day(steps + 37 * index).split_off(37 * index);
        for (channel, value) in [
            (Channel::Basal, &(|i: &StepInput| i.basal.0) as &dyn Fn(&StepInput) -> f64),
            (Channel::Bolus, &|i: &StepInput| i.bolus.0),
            (Channel::Carbs, &|i: &StepInput| i.carbs.0),
            (Channel::HeartRate, &|i: &StepInput| {
                i.context.heart_rate_over_baseline.map_or(0.0, |rate| rate.0)
            }),
            (Channel::SleepEfficiency, &|i: &StepInput| i.context.sleep_efficiency.unwrap_or(0.0)),
        ] {
            let column = record.channel_mut(channel);
            for (slot, input) in column.iter_mut().zip(&doses) {
                *slot = Some(value(input));
            }
        }
        let mut person = Person {
            id: format!("p{index}"),
            weight: None,
            therapy: Therapy::OpenLoopPump,
            heart_rate_baseline: Some(BeatsPerMinute(0.0)),
            record,
        };
        let inputs = person.inputs(0..steps, MissingDoses::Error).expect("complete");
        let run = simulate(truth, ScaledStates::default(), &mut OpenLoop::new(&inputs), steps - 1)
            .expect("finite");
        let glucose = run.glucose(truth);
        for (slot, value) in person.record.channel_mut(Channel::Cgm).iter_mut().zip(glucose) {
            *slot = Some(value.0);
        }
        person
    };
    Cohort { people: (0..people).map(person).collect() }
}
