//! Records of the nominal plant itself, for the tests of the parts.

use cohort::{Channel, Person, Record, Therapy};
use ode_sim::{OdeParameters, OdePlant, steady_state};
use physiology::{Grams, Kilograms, MgPerDl, OpenLoop, StepInput, Units, simulate};

pub(crate) const WEIGHT: Kilograms = Kilograms(76.3);

/// A body of nominal parameters, from its steady state at 120 mg/dL, under its basal rate, with
/// meals (step, g) and boluses (step, U); the sensor shows glucose 10 min late, in whole mg/dL.
pub(crate) fn person(steps: usize, meals: &[(usize, f64)], boluses: &[(usize, f64)]) -> Person {
    let plant = OdePlant::reproduction(OdeParameters::nominal(), WEIGHT);
    let start = steady_state::at_glucose(&plant.parameters, WEIGHT, MgPerDl(120.0))
        .expect("a glucose that can be held");
    let mut inputs = vec![StepInput { basal: start.basal, ..StepInput::default() }; steps];
    for (step, grams) in meals {
        inputs[*step].carbs = Grams(*grams);
    }
    for (step, units) in boluses {
        inputs[*step].bolus = Units(*units);
    }
    let run = simulate(&plant, start.state, &mut OpenLoop::new(&inputs), steps)
        .expect("doses that a body can live with");
    let glucose = run.glucose(&plant);
    let mut record = Record::new("2024-03-08T00:00:00".parse().expect("a literal time"), steps)
        .expect("on the grid");
    for step in 0..steps {
        record.channel_mut(Channel::Cgm)[step] = Some(glucose[step.saturating_sub(2)].0.round());
        record.channel_mut(Channel::Basal)[step] = Some(start.basal.0);
        record.channel_mut(Channel::Bolus)[step] = Some(inputs[step].bolus.0);
        record.channel_mut(Channel::Carbs)[step] = Some(0.0);
    }
    Person {
        id: "a".into(),
        weight: Some(WEIGHT),
        therapy: Therapy::OpenLoopPump,
        heart_rate_baseline: None,
        record,
    }
}
