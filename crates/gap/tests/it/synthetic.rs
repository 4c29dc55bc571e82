//! People made with the ODE plant: three meals a day with boluses, dosing errors, an
//! Ornstein-Uhlenbeck flux and a sensor.

use cohort::{Channel, Cohort, Person, Record, Therapy};
use gap::NoiseModel;
use gap::filter::calibration::PersonalFactors;
use ode_sim::{EgpMode, Integrator, OdeParameters, OdePlant, steady_state};
use physiology::{Grams, Kilograms, MgPerDl, Plant, STEP, StepInput, Units};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// What differs from the filter's own model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Gap {
    /// Nothing.
    None,
    /// Endogenous production up by this share from 03:00 to 08:00.
    Dawn(f64),
    /// Endogenous production up by this share at 06:00, a cosine bump from 03:00 to 09:00.
    MorningBump(f64),
}

/// A world's settings.
#[derive(Debug, Clone, Copy)]
pub(crate) struct World {
    pub(crate) gap: Gap,
    pub(crate) days: usize,
    /// Standard deviations of people's log factors, as shares of the calibration's prior.
    pub(crate) spread: f64,
}

pub(crate) fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// A cohort; person `i` has a stream of their own. The noise is what the filter expects.
pub(crate) fn cohort(world: &World, people: usize, seed: u64) -> Cohort {
    cohort_under(world, people, seed, &NoiseModel::working())
}

/// A cohort under some noise.
pub(crate) fn cohort_under(world: &World, people: usize, seed: u64, noise: &NoiseModel) -> Cohort {
    let people = (0..people)
        .map(|index| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(index as u64);
            let mut factors = PersonalFactors::default();
            for (value, factor) in factors.0.iter_mut().zip(gap::filter::calibration::Factor::ALL) {
                *value = world.spread * factor.prior_sd() * normal(&mut rng);
            }
            person_under(&format!("p{index}"), &factors, world, noise, &mut rng)
        })
        .collect();
    Cohort { people }
}

/// One person; the record starts on Monday 2024-03-04 at midnight.
pub(crate) fn person(
    id: &str,
    factors: &PersonalFactors,
    world: &World,
    rng: &mut ChaCha8Rng,
) -> Person {
    person_under(id, factors, world, &NoiseModel::working(), rng)
}

/// One person under some noise.
fn person_under(
    id: &str,
    factors: &PersonalFactors,
    world: &World,
    noise: &NoiseModel,
    rng: &mut ChaCha8Rng,
) -> Person {
    let weight = Kilograms(76.3);
    let parameters = factors.applied_to(&OdeParameters::nominal());
    let plant = OdePlant {
        parameters,
        weight,
        integrator: Integrator::ForwardEuler,
        egp: EgpMode::NonNegative,
    };
    let rest = steady_state::at_glucose(&parameters, weight, MgPerDl(130.0)).expect("a basal rate");
    // Total insulin is 1.78 times basal; ICR = 1700/(3 TDI).
    let ratio = 1700.0 / (3.0 * 1.78 * 24.0 * rest.basal.0);
    let steps = 288 * world.days;
    let start = "2024-03-04T00:00:00".parse().expect("a literal time");
    let mut record = Record::new(start, steps).expect("on the grid");

    // A unit lowers glucose by 1700/TDI mg/dL; half of the excess over 140 is corrected at meals.
    let correction = 1700.0 / (1.78 * 24.0 * rest.basal.0);
    let (mut carbs, mut bolus) = (vec![0.0; steps], vec![0.0; steps]);
    for day in 0..world.days {
        for (hour, size) in [(7.5, 45.0), (12.5, 60.0), (18.5, 70.0)] {
            let at = day * 288 + ((hour + 0.5 * normal(rng)) * 12.0).round() as usize;
            let grams = (size + 15.0 * normal(rng)).clamp(15.0, 120.0).round();
            carbs[at] = grams;
            bolus[at] = (grams / ratio * 20.0).round() / 20.0;
        }
    }

    let (mut state, mut flux, mut sensor, mut sensor_before) = (rest.state, 0.0, 0.0, 0.0);
    let mut interstitial = 130.0;
    let (decay, lag) = (noise.flux_decay(), noise.lag_decay());
    for step in 0..steps {
        let reading = interstitial + sensor + noise.reading_sd * normal(rng);
        if bolus[step] > 0.0 {
            let extra = 0.5 * (reading.clamp(40.0, 400.0) - 140.0) / correction;
            bolus[step] = ((bolus[step] + extra).max(0.0) * 20.0).round() / 20.0;
        }
        record.channel_mut(Channel::Cgm)[step] = Some(reading.clamp(40.0, 400.0));
        record.channel_mut(Channel::Basal)[step] = Some(rest.basal.0);
        record.channel_mut(Channel::Bolus)[step] = Some(bolus[step]);
        record.channel_mut(Channel::Carbs)[step] = Some(carbs[step]);
        // What is eaten and delivered differs from what is logged.
        let eaten = carbs[step] * (1.0 + noise.carb_count_cv * normal(rng)).max(0.1);
        let delivered = (1.0 + noise.insulin_cv * normal(rng)).max(0.1);
        let input = StepInput {
            basal: rest.basal * delivered,
            bolus: Units(bolus[step] * delivered),
            carbs: Grams(eaten),
            ..StepInput::default()
        };
        let missing = match world.gap {
            Gap::Dawn(size) if (3..8).contains(&record.hour(step)) => {
                size * parameters.egp_0 * (1.0 - state.x3).max(0.0)
            }
            Gap::MorningBump(size) => {
                let distance = ((step % 288) as f64 / 12.0 - 6.0) / 3.0;
                let bump = 0.5 * (1.0 + (std::f64::consts::PI * distance.clamp(-1.0, 1.0)).cos());
                size * bump * parameters.egp_0 * (1.0 - state.x3).max(0.0)
            }
            _ => 0.0,
        };
        let before = plant.glucose(&state).0;
        let jolt = noise.glucose_sd * normal(rng) / STEP.0;
        state = plant.advance(&state, &input, flux + missing + jolt).expect("finite");
        for effect in [&mut state.x1, &mut state.x2, &mut state.x3] {
            *effect *= 1.0 + noise.effect_cv * normal(rng);
        }
        let plasma = 0.5 * (before + plant.glucose(&state).0);
        interstitial = plasma + (interstitial - plasma) * lag;
        let share = (1.0 - decay * decay).sqrt();
        flux = flux * decay + noise.flux_sd * share * normal(rng);
        let [first, second] = noise.sensor_coefficients();
        let expected = first * sensor + second * sensor_before;
        (sensor_before, sensor) = (sensor, expected + noise.sensor_noise().sqrt() * normal(rng));
    }
    Person {
        id: id.to_owned(),
        weight: Some(weight),
        therapy: Therapy::OpenLoopPump,
        heart_rate_baseline: None,
        record,
    }
}

/// Removes readings: single ones at random and one gap of six hours.
pub(crate) fn with_gaps(mut person: Person, rng: &mut ChaCha8Rng) -> Person {
    let cgm = person.record.channel_mut(Channel::Cgm);
    for value in cgm.iter_mut() {
        if rng.random_range(0.0..1.0) < 0.05 {
            *value = None;
        }
    }
    cgm[600..672].fill(None);
    person
}
