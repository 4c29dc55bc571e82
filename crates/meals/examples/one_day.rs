//! A day with a meal that was logged, one that was forgotten and a correction: their fates.
//!
//! Run with `cargo run -p meals --example one_day`.

use std::error::Error;
use std::io::Write as _;

use cohort::{Channel, Person, Record, Therapy};
use meals::reconcile::{ReconcileSettings, Rule, reconcile};
use meals::{Detector, PlantSettings};
use ode_sim::{OdeParameters, OdePlant, steady_state};
use physiology::{Grams, Kilograms, MgPerDl, OpenLoop, StepInput, Units, simulate};

const STEPS: usize = 288;

fn main() -> Result<(), Box<dyn Error>> {
    let plant = OdePlant::reproduction(OdeParameters::nominal(), Kilograms(76.3));
    let start = steady_state::at_glucose(&plant.parameters, plant.weight, MgPerDl(130.0))?;
    let mut inputs = vec![StepInput { basal: start.basal, ..StepInput::default() }; STEPS];
    for (step, grams, units) in [(90, 60.0, 4.0), (160, 40.0, 0.0), (220, 0.0, 1.0)] {
        inputs[step].carbs = Grams(grams);
        inputs[step].bolus = Units(units);
    }
    let run = simulate(&plant, start.state, &mut OpenLoop::new(&inputs), STEPS)?;
    let mut record = Record::new("2024-03-08T00:00:00".parse()?, STEPS)?;
    for (step, glucose) in run.glucose(&plant).iter().take(STEPS).enumerate() {
        let logged = if step == 90 { 45.0 } else { 0.0 };
        for (channel, value) in [
            (Channel::Cgm, glucose.0.round()),
            (Channel::Basal, inputs[step].basal.0),
            (Channel::Bolus, inputs[step].bolus.0),
            (Channel::Carbs, logged),
        ] {
            record.channel_mut(channel)[step] = Some(value);
        }
    }
    let person = Person {
        id: "a".into(),
        weight: Some(plant.weight),
        therapy: Therapy::OpenLoopPump,
        heart_rate_baseline: None,
        record,
    };
    let found = Detector::Plant(PlantSettings::working()).detect(&person)?;
    let mut out = std::io::stdout().lock();
    for rule in [Rule::Published, Rule::Additive] {
        writeln!(out, "{rule:?}")?;
        for event in reconcile(&person, &found, &ReconcileSettings::new(rule))?.events {
            writeln!(
                out,
                "  {} {:<9} {:>5.1}  {}",
                event.time.format("%H:%M"),
                format!("{:?}", event.kind).to_lowercase(),
                event.size.unwrap_or(f64::NAN),
                event.fate.name()
            )?;
        }
    }
    Ok(())
}
