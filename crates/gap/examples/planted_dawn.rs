//! Makes four people whose liver produces 30 % more glucose from 03:00 to 08:00, and asks where the
//! plant, which knows nothing of it, misses them.

use cohort::{Channel, Cohort, Person, Record, Therapy};
use gap::{Diagnoser, DiagnosisConfig};
use ode_sim::{OdeParameters, OdePlant, steady_state};
use physiology::{Grams, Kilograms, MgPerDl, Plant, StepInput, Units};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A person of 14 days with three meals a day and a little sensor noise.
fn person(index: u64) -> Result<Person, Box<dyn std::error::Error>> {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    rng.set_stream(index);
    let weight = Kilograms(76.3);
    let sensitivity = rng.random_range(0.8..1.25);
    let parameters = OdeParameters::nominal().with_sensitivity_scaled(sensitivity);
    let plant = OdePlant::reproduction(parameters, weight);
    let rest = steady_state::at_glucose(&parameters, weight, MgPerDl(125.0))?;
    let mut record = Record::new("2024-03-04T00:00:00".parse()?, 14 * 288)?;
    let mut state = rest.state;
    let (mut drift, mut noise) = (0.0, 0.0);
    for step in 0..record.len() {
        let meal = step % 288 == 90 || step % 288 == 150 || step % 288 == 222;
        let carbs = if meal { rng.random_range(30.0..70.0) } else { 0.0 };
        let bolus = carbs * rest.basal.0 / 12.0;
        let input = StepInput {
            basal: rest.basal,
            bolus: Units(bolus),
            carbs: Grams(carbs),
            ..StepInput::default()
        };
        noise = 0.85 * noise + rng.random_range(-3.0..3.0);
        drift = 0.92 * drift + rng.random_range(-0.0015..0.0015);
        let reading = (plant.glucose(&state).0 + noise).clamp(40.0, 400.0);
        for (channel, value) in [
            (Channel::Cgm, reading),
            (Channel::Basal, input.basal.0),
            (Channel::Bolus, bolus),
            (Channel::Carbs, carbs),
        ] {
            record.channel_mut(channel)[step] = Some(value);
        }
        let early = (3..8).contains(&record.hour(step));
        let dawn = if early { 0.3 * parameters.egp_0 * (1.0 - state.x3) } else { 0.0 };
        state = plant.advance(&state, &input, dawn + drift)?;
    }
    Ok(Person {
        id: format!("person-{index}"),
        weight: Some(weight),
        therapy: Therapy::OpenLoopPump,
        heart_rate_baseline: None,
        record,
    })
}

#[expect(clippy::print_stdout, reason = "an example shows its result")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let people = (0..4).map(person).collect::<Result<_, _>>()?;
    let (library, config) = (effects::library(), DiagnosisConfig::working());
    let diagnosis = Diagnoser::new(&library, &config).run(&Cohort { people }, 1)?;
    println!("verdict: {:?}", diagnosis.verdict);
    for horizon in &diagnosis.baseline {
        let (mae, bias) = (horizon.mae, horizon.bias);
        println!(
            "{:>5} min: MAE {:.1} [{:.1}, {:.1}], bias {:+.1} mg/dL",
            horizon.minutes, mae.value, mae.lower, mae.upper, bias.value
        );
    }
    for cell in diagnosis.cells.iter().take(8) {
        println!(
            "{:?} {}: {:+.1} [{:+.1}, {:+.1}] mg/dL, p = {:.3}, {:.0} % of the gap",
            cell.factor,
            cell.level,
            cell.mean_error_mg_dl,
            cell.lower,
            cell.upper,
            cell.p_adjusted,
            100.0 * cell.share_of_gap
        );
    }
    Ok(())
}
