//! Signatures are the derivative of the replay, along every field and every parameter.

use effects::{Field, Modulation};
use gap::filter::augmented::AugmentedModel;
use gap::filter::calibration::PersonalFactors;
use gap::filter::kalman::{Filtered, filter, replayed};
use gap::filter::tangent::{Direction, Parameter, signatures};
use gap::{NoiseModel, Observations};
use ode_sim::OdeParameters;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::synthetic::{Gap, World, person, with_gaps};

/// A person whose glucose goes from below 70 to above 200 mg/dL, with readings missing.
fn filtered(
    modulations: impl Fn(usize) -> Vec<Modulation>,
) -> (AugmentedModel, Observations, Filtered) {
    let world = World { gap: Gap::Dawn(0.5), days: 4, spread: 0.0 };
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let person = with_gaps(person("p", &PersonalFactors::default(), &world, &mut rng), &mut rng);
    let mut record = Observations::from_person(&person).expect("a good record");
    record.modulations = modulations(record.len());
    let parameters = OdeParameters::nominal().with_sensitivity_scaled(1.1);
    let noise = NoiseModel::working();
    let model = AugmentedModel::new(parameters, record.weight, noise);
    let run = filter(&model, &record).expect("finite");
    let glucose = run.states.iter().map(|s| s.interstitial.0);
    let (low, high) = glucose.fold((400.0f64, 0.0f64), |(low, high), g| (low.min(g), high.max(g)));
    assert!(low < 65.0 && high > 200.0, "from {low} to {high} mg/dL");
    (model, record, run)
}

/// What differs from one step to the next, so that a course out of step is found.
fn course(n: usize, unit: f64) -> Vec<f64> {
    (0..n).map(|k| if k % 5 == 3 { 0.0 } else { unit * (1.0 + (0.7 * k as f64).sin()) }).collect()
}

/// Central differences with this half-width: its square and rounding (1e-13 of 400 mg/dL over it) are both
/// far below the tolerance.
const HALF: f64 = 1e-5;
/// Share of a signature's largest entry: rounding of the central difference, 4e-6 mg/dL, over signatures of
/// some mg/dL, and signatures in single precision, whose rounding the filter carries on.
const TOLERANCE: f64 = 5e-5;
/// As much for fields: counter-regulation depends on interstitial glucose, which is held.
const OF_FIELDS: f64 = 1e-3;

fn check(
    name: &str,
    frozen: &Filtered,
    found: &[f64],
    tolerance: f64,
    moved: impl Fn(f64) -> Vec<Option<f64>>,
) {
    let (above, below) = (moved(HALF), moved(-HALF));
    let largest = found.iter().copied().map(f64::abs).fold(0.0, f64::max);
    assert!(largest > 0.0, "{name}: no signature");
    for (step, value) in found.iter().enumerate() {
        match above[step].zip(below[step]) {
            Some((above, below)) => {
                let slope = (above - below) / (2.0 * HALF);
                assert!(
                    (slope - value).abs() < tolerance * largest,
                    "{name}, step {step}: {value} against {slope} (largest {largest})"
                );
            }
            None => assert!(*value == 0.0 && frozen.innovations[step].is_none(), "{name}, {step}"),
        }
    }
}

#[test]
fn signatures_are_central_differences_of_the_replay() {
    signatures_agree(|_| Vec::new());
}

#[test]
fn signatures_about_modulations_are_central_differences_of_the_replay() {
    signatures_agree(|n| {
        let mut steps = vec![Modulation::NEUTRAL; n];
        for (step, modulation) in steps.iter_mut().enumerate() {
            for (index, field) in Field::ALL.into_iter().enumerate() {
                // What they make depend on glucose is held.
                let held = [Field::LowGlucoseProduction, Field::RenalRate, Field::RenalThreshold];
                if !held.contains(&field) {
                    let wave = (0.3 * step as f64 + index as f64).sin();
                    modulation[field] += 0.2 * unit(field) * (1.0 + wave);
                }
            }
        }
        steps
    });
}

/// Size of a change of a field.
fn unit(field: Field) -> f64 {
    match field {
        Field::ExtraCarbs | Field::RenalThreshold | Field::SensorOffset => 10.0,
        Field::Flux => 1e-3,
        _ => 1.0,
    }
}

/// The innovations of a model with the gains of an earlier run, mg/dL.
fn innovations(
    model: &AugmentedModel,
    record: &Observations,
    frozen: &Filtered,
) -> Vec<Option<f64>> {
    let run = replayed(model, record, frozen).expect("finite");
    run.innovations.iter().map(|innovation| innovation.map(|i| i.value)).collect()
}

fn signatures_agree(modulations: impl Fn(usize) -> Vec<Modulation>) {
    let (model, record, frozen) = filtered(modulations);
    let parameters = [
        Parameter::Action,
        Parameter::Egp0,
        Parameter::TMaxG,
        Parameter::TMaxI,
        Parameter::AG,
        Parameter::F01,
        Parameter::KA1,
        Parameter::KA2,
        Parameter::KA3,
        Parameter::K12,
        Parameter::KE,
        Parameter::VG,
    ];
    let courses: Vec<Vec<f64>> =
        Field::ALL.into_iter().map(|field| course(record.len(), unit(field))).collect();
    let fields = Field::ALL.into_iter().zip(&courses);
    let mut directions: Vec<Direction> =
        fields.map(|(field, course)| Direction::Course(vec![(field, course.clone())])).collect();
    directions.extend(parameters.map(Direction::Parameter));
    // A direction may change several fields at once.
    let all: Vec<(Field, Vec<f64>)> = Field::ALL.into_iter().zip(courses.clone()).collect();
    directions.push(Direction::Course(all));
    let found = signatures(&model, &record, &frozen, &directions).expect("finite");

    let modulated = |fields: &[Field], by: f64| {
        let mut moved = record.clone();
        moved.modulations.resize(record.len(), Modulation::NEUTRAL);
        for field in fields {
            for (m, value) in moved.modulations.iter_mut().zip(&courses[*field as usize]) {
                m[*field] += by * value;
            }
        }
        innovations(&model, &moved, &frozen)
    };
    for (field, found) in Field::ALL.into_iter().zip(&found) {
        check(&format!("{field:?}"), &frozen, found, OF_FIELDS, |by| modulated(&[field], by));
    }
    for (index, parameter) in parameters.into_iter().enumerate() {
        let found = &found[courses.len() + index];
        check(&format!("{parameter:?}"), &frozen, found, TOLERANCE, |by| {
            let moved = model.with_parameters(|p| parameter.raised(p, by));
            innovations(&moved, &record, &frozen)
        });
    }
    let together = found.last().expect("asked for");
    check("all fields", &frozen, together, OF_FIELDS, |by| modulated(&Field::ALL, by));
}
