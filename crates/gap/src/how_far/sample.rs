//! A person for tests: the plant itself, with meals, boluses and bouts of exercise.

use cohort::{Channel, Person, Record, Therapy};
use ode_sim::OdeParameters;
use physiology::{Grams, Kilograms, MgPerDl, StepInput, Units, UnitsPerHour};

use crate::filter::augmented::AugmentedModel;
use crate::filter::noise::NoiseModel;
use crate::filter::scored::Whitening;
use crate::filter::whitening::Autoregression;

/// A whitening that changes nothing.
pub(super) const UNWHITENED: Whitening =
    Whitening { autoregression: Autoregression::WHITE, scale: 1.0 };

/// The working filter with the nominal parameters.
pub(super) fn model(weight: Kilograms) -> AugmentedModel {
    let noise = NoiseModel::working();
    AugmentedModel::new(OdeParameters::nominal(), weight, noise)
}

/// Midnight to midnight, some days long; lows come up.
pub(super) fn person(days: usize) -> Person {
    let steps = 288 * days;
    let start = "2024-03-04T00:00:00".parse().expect("a literal time");
    let mut record = Record::new(start, steps).expect("on the grid");
    let weight = Kilograms(76.3);
    let model = model(weight);
    let basal = UnitsPerHour(1.0);
    let (mut state, _) = model.start(basal, MgPerDl(130.0));
    for step in 0..steps {
        let (slot, day) = (step % 288, step / 288);
        let carbs = match slot {
            90 | 150 | 220 => 40.0 + 5.0 * (day % 3) as f64,
            _ => 0.0,
        };
        let bolus = carbs / if slot == 220 { 6.0 } else { 10.0 };
        let beats = if (204..214).contains(&slot) { 125.0 } else { 65.0 };
        // A slow wander and a fast one: smooth readings would be taken for drawn lines.
        let reading =
            state.interstitial.0 + 4.0 * (step as f64 / 9.0).sin() + (step * step % 7) as f64;
        for (channel, value) in [
            (Channel::Cgm, reading.round().clamp(40.0, 400.0)),
            (Channel::Basal, basal.0),
            (Channel::Bolus, bolus),
            (Channel::Carbs, carbs),
            (Channel::HeartRate, beats),
        ] {
            record.channel_mut(channel)[step] = Some(value);
        }
        let input =
            StepInput { basal, bolus: Units(bolus), carbs: Grams(carbs), ..StepInput::default() };
        let modulation = effects::Modulation::NEUTRAL;
        state = model.step(&state, &input, &modulation).expect("finite");
    }
    Person {
        id: "p".to_owned(),
        weight: Some(weight),
        therapy: Therapy::OpenLoopPump,
        heart_rate_baseline: None,
        record,
    }
}
