//! Calibration recovers the parameters of people made with the plant.

use ::cohort::{Channel, ImportFormat, Person, import};
use gap::filter::augmented::AugmentedModel;
use gap::filter::calibration::{Calibration, Factor, PersonalFactors, calibrate};
use gap::{CalibrationRule, Diagnoser, DiagnosisConfig, NoiseModel, Observations};
use ode_sim::OdeParameters;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::synthetic::{Gap, World, cohort, normal, person};

fn calibrated(planted: &PersonalFactors, rng: &mut ChaCha8Rng) -> Calibration {
    let world = World { gap: Gap::None, days: 14, spread: 0.0 };
    let person = person("p", planted, &world, rng);
    let observations = Observations::from_person(&person).expect("a good record");
    from(&OdeParameters::nominal(), &observations)
}

/// Calibrates by the working rule from these parameters.
fn from(population: &OdeParameters, observations: &Observations) -> Calibration {
    let model = AugmentedModel::new(*population, observations.weight, NoiseModel::working());
    calibrate(&model, observations, &CalibrationRule::working()).expect("calibrates")
}

#[test]
fn planted_parameters_are_recovered_within_their_posterior_spread() {
    let people = 12;
    let (mut squares, mut misses) = ([0.0; 6], [0.0; 6]);
    for seed in 0..people {
        let mut rng = ChaCha8Rng::seed_from_u64(100 + seed);
        let mut planted = PersonalFactors::default();
        for (value, factor) in planted.0.iter_mut().zip(Factor::ALL) {
            *value = 0.7 * factor.prior_sd() * normal(&mut rng);
        }
        let found = calibrated(&planted, &mut rng);
        assert!(found.converged, "person {seed} after {}", found.iterations);
        assert!(found.at_bound.is_empty(), "person {seed}: {:?}", found.at_bound);
        assert!((found.scale - 1.0).abs() < 0.05, "person {seed}: scale {}", found.scale);
        for (k, factor) in Factor::ALL.into_iter().enumerate() {
            let miss = found.factors.0[k] - planted.0[k];
            squares[k] += (miss / found.sd[k]).powi(2) / people as f64;
            misses[k] += (miss / factor.prior_sd()).powi(2) / people as f64;
        }
    }
    for (k, factor) in Factor::ALL.into_iter().enumerate() {
        // A mean of 12 squares of standard normals exceeds 2.74 once in a thousand.
        assert!(squares[k] < 2.74, "{factor:?}: mean squared z {}", squares[k]);
    }
    // The record tells much about these three: people differ by 0.7 prior standard deviations and
    // less than two thirds of that is left (measured: 0.37). EGP0 and F01 act almost alike and stay near the prior.
    for factor in [Factor::Action, Factor::TMaxG, Factor::TMaxI] {
        let left = misses[factor as usize].sqrt();
        assert!(left < 0.45, "{factor:?}: {left} prior standard deviations are left");
    }
}

/// People of bodies that are not the plant's: another generator made them, and their meals and doses are what
/// people do.
#[test]
fn people_of_other_bodies_settle_at_one_place() {
    let folder =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/embedded/cohort");
    let cohort = ::cohort::read_folder(&folder).expect("the fixture");
    let population = OdeParameters::nominal();
    for mut person in cohort.people {
        let steps = person.record.len().min(14 * 288);
        person.record = person.record.slice(0..steps).expect("not empty");
        let observations = Observations::from_person(&person).expect("a good record");
        let found = from(&population, &observations);
        // Two to seven are needed.
        assert!(found.converged && found.iterations < 15, "{}: {}", person.id, found.iterations);
        // Beginning elsewhere, and with a prior a little elsewhere, finds the same person.
        let nudge = PersonalFactors([0.05, 0.0, 0.05, -0.05, 0.0, 0.0]);
        let again = from(&nudge.applied_to(&population), &observations);
        for (k, factor) in Factor::ALL.into_iter().enumerate() {
            let moved = again.factors.0[k] + nudge.0[k] - found.factors.0[k];
            // What the nudge pulls, a quarter of a prior standard deviation, and a tenth of a posterior one at
            // steps that shrink slowly.
            assert!(moved.abs() < found.sd[k], "{} {factor:?}: {moved}", person.id);
        }
    }
}

#[test]
fn a_person_whom_the_plant_does_not_describe_is_reported() {
    let world = World { gap: Gap::None, days: 8, spread: 0.7 };
    let mut made = cohort(&world, 3, 5);
    // A sensor that scatters by 8 mg/dL more than any that the filter expects.
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    for reading in made.people[1].record.channel_mut(Channel::Cgm).iter_mut().flatten() {
        *reading = (*reading + 8.0 * normal(&mut rng)).round().clamp(41.0, 399.0);
    }
    let diagnosis = Diagnoser::new(&effects::library(), &DiagnosisConfig::working())
        .run(&made, 1)
        .expect("diagnosed");
    let doubts = diagnosis.data_quality.iter().filter(|finding| finding.check == "plant_misfit");
    let doubted: Vec<_> = doubts.map(|finding| (&finding.person_id, &finding.finding)).collect();
    assert_eq!(doubted.len(), 1, "{doubted:?}");
    assert!(doubted[0].0 == "p1" && doubted[0].1.contains("lacking: structure"), "{doubted:?}");
}

/// Struck from the log: every twentieth meal from the fourth, twelfth or eighteenth on.
#[test]
fn a_struck_meal_moves_no_factor_of_real_people_by_more_than_its_uncertainty() {
    let studies = [("hupa_ucm", ImportFormat::HupaUcm), ("t1d_uom", ImportFormat::T1dUom)];
    for (name, format) in studies {
        let Some(folder) = reference_data::find(name, "struck meals") else { continue };
        let cohort = import(format, &folder).expect("imports").cohort;
        for person in &cohort.people {
            let carbs = person.record.channel(Channel::Carbs).iter().enumerate();
            let meals: Vec<usize> =
                carbs.filter(|(_, c)| c.is_some_and(|c| c > 0.0)).map(|(step, _)| step).collect();
            if meals.is_empty() {
                continue;
            }
            let found = of(person);
            assert!(found.converged && found.at_bound.is_empty(), "{}", person.id);
            for first in [3, 11, 17] {
                let mut struck = person.clone();
                let log = struck.record.channel_mut(Channel::Carbs);
                for step in meals.iter().skip(first.min(meals.len() - 1)).step_by(20) {
                    log[*step] = Some(0.0);
                }
                let again = of(&struck);
                assert!(again.converged, "{} without meals from the {first}th on", person.id);
                for (k, factor) in Factor::ALL.into_iter().enumerate() {
                    let moved = (again.factors.0[k] - found.factors.0[k]).abs() / found.sd[k];
                    assert!(
                        moved <= 1.0,
                        "{} {factor:?}: {moved} SD, from meal {first}",
                        person.id
                    );
                }
            }
        }
    }
}

fn of(person: &Person) -> Calibration {
    let observations = Observations::from_person(person).expect("a good record");
    from(&OdeParameters::nominal(), &observations)
}
