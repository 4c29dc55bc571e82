//! Where windows start, and the replay of a record.

use cohort::{Channel, MissingDoses, Person};
use nn_statespace::{GlucoseClamp, PopulationModel, ScaledStates};
use ode_sim::{OdeParameters, OdePlant};
use physiology::{Compartment, Kilograms, MgPerDl, OpenLoop, UnitsPerHour, simulate};
use twins::{ReplayStart, ResidualNetwork, Startable, WindowStart, replay, settled, window_starts};

use crate::synthetic::{cohort_of, planted, population, twin_of};

/// Three days that follow the population model exactly.
fn person() -> Person {
    let truth = twin_of(ResidualNetwork::zeros(), GlucoseClamp::Reproduction);
    cohort_of(&truth, 1, 3).people.remove(0)
}

/// The ODE model with population parameters.
fn ode() -> OdePlant {
    OdePlant::reproduction(OdeParameters::nominal(), Kilograms(76.3))
}

fn carried(model: &PopulationModel, person: &Person, steps: &[usize]) -> Vec<ScaledStates> {
    let inputs = person.inputs(0..person.record.len(), MissingDoses::Zero).expect("finite values");
    let basal = UnitsPerHour(1.0);
    window_starts(model, person, &inputs, steps, WindowStart::Carried, basal)
        .expect("starts")
        .states
}

fn largest_difference(a: &ScaledStates, b: &ScaledStates) -> f64 {
    a.iter().zip(b.iter()).fold(0.0, |largest, ((_, x), (_, y))| largest.max((x - y).abs()))
}

#[test]
fn a_carried_start_is_the_state_the_record_has_reached() {
    let model = population(GlucoseClamp::Reproduction);
    let person = person();
    let inputs = person.inputs(0..864, MissingDoses::Error).expect("complete");
    let run = simulate(&*model, ScaledStates::default(), &mut OpenLoop::new(&inputs), 863)
        .expect("finite");
    let steps = [300, 300, 863];
    for (state, step) in carried(&model, &person, &steps).iter().zip(steps) {
        // Both begin differently (medians, settled); the slowest rate, 0.02 a minute, leaves
        // exp(-0.02 x 1500) = 1e-13 of that after 300 steps.
        assert!(largest_difference(state, &run.states[step]) < 1e-10, "{step}");
    }
}

#[test]
fn a_step_without_recorded_doses_begins_a_new_run() {
    let model = population(GlucoseClamp::Reproduction);
    let mut gap = person();
    gap.record.channel_mut(Channel::Bolus)[400] = None;
    let glucose = MgPerDl(gap.record.cgm()[401].expect("a reading"));
    let fresh = settled(&*model, glucose, UnitsPerHour(1.0)).expect("finite");
    let found = carried(&model, &gap, &[400, 401, 863]);
    assert_eq!(found[1], fresh);
    assert_ne!(found[0], fresh);
    // Before the gap and long after it, the gap does not matter.
    let whole = carried(&model, &person(), &[400, 863]);
    assert_eq!(found[0], whole[0]);
    assert!(largest_difference(&found[2], &whole[1]) < 1e-10); // as above
}

#[test]
fn a_missing_reading_is_bridged_inside_a_run_and_refused_as_a_start() {
    let model = population(GlucoseClamp::Reproduction);
    let mut gap = person();
    gap.record.channel_mut(Channel::Cgm)[500] = None;
    let (bridged, whole) = (carried(&model, &gap, &[520]), carried(&model, &person(), &[520]));
    // The record is the model's own run, so that it bridges the gap exactly, up to rounding.
    assert!(largest_difference(&bridged[0], &whole[0]) < 1e-12);
    let inputs = gap.inputs(0..864, MissingDoses::Zero).expect("finite values");
    for start in [WindowStart::Carried, WindowStart::SteadyState] {
        let found = window_starts(&*model, &gap, &inputs, &[500], start, UnitsPerHour(1.0));
        let message = found.expect_err("no reading").to_string();
        assert!(message.contains("person 'p0', step 500"), "{message}");
    }
}

#[test]
fn steady_starts_carry_the_reading_and_stand_still() {
    let person = person();
    let inputs = person.inputs(0..864, MissingDoses::Zero).expect("finite values");
    let steps: Vec<usize> = (0..864).step_by(60).collect();
    let ode = ode();
    let starts =
        window_starts(&ode, &person, &inputs, &steps, WindowStart::SteadyState, UnitsPerHour(1.0))
            .expect("starts");
    for (state, step) in starts.states.iter().zip(&steps) {
        let reading = MgPerDl(person.record.cgm()[*step].expect("a reading"));
        assert_eq!(*state, ode.with_glucose(state, reading));
        let (exact, _) = ode.at_steady_state(reading).expect("a steady state");
        // Solved at the reading rounded to 1 mg/dL: plasma insulin moves by less than 0.2 mU/L.
        assert!((state.i - exact.i).abs() < 0.2, "{} {}", state.i, exact.i);
    }
}

#[test]
fn a_glucose_without_a_steady_state_starts_without_insulin_and_without_a_jump() {
    let ode = ode();
    let (state, at_rest) = ode.at_steady_state(MgPerDl(406.0)).expect("a start");
    assert!(!at_rest);
    assert_eq!(state, ode.with_glucose(&ode.neutral(), MgPerDl(406.0)));
    // The last glucose that has a steady state, by halving.
    let (mut low, mut high) = (400.0, 406.0);
    while high - low > 1e-9 {
        let middle = 0.5 * (low + high);
        let at_rest = ode.at_steady_state(MgPerDl(middle)).expect("a start").1;
        if at_rest { low = middle } else { high = middle }
    }
    let below = ode.at_steady_state(MgPerDl(low)).expect("a steady state").0;
    let above = ode.at_steady_state(MgPerDl(high)).expect("a start").0;
    for (a, b) in below.vector().0.into_iter().zip(above.vector().0) {
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }
}

#[test]
fn a_replay_follows_the_record_from_its_first_reading() {
    let twin = twin_of(planted(), GlucoseClamp::Reproduction);
    let mut person = cohort_of(&twin, 1, 3).people.remove(0);
    person.record.channel_mut(Channel::Cgm)[..5].fill(None);
    let start = ReplayStart::SteadyState;
    let rows = replay(&person, &twin, &twin.population, start, MissingDoses::Error).expect("rows");
    assert_eq!(rows.len(), 864 - 5);
    assert_eq!((rows[0].step, rows[0].time), (0, person.record.time(5)));
    let first = person.record.cgm()[5].expect("a reading");
    assert!((rows[0].states[Compartment::Q1] - first).abs() < 1e-9); // scaling there and back
    let last = person.record.cgm()[863].expect("a reading");
    // The record is the twin's own run; what the start forgets has decayed after two days.
    assert!((rows[858].states[Compartment::Q1] - last).abs() < 1e-3);
    person.record.channel_mut(Channel::Carbs)[70] = None;
    let error = replay(&person, &twin, &twin.population, start, MissingDoses::Error);
    assert!(error.expect_err("a missing dose").to_string().contains("carbs_g"));
    person.record.channel_mut(Channel::Cgm).fill(None);
    assert!(replay(&person, &twin, &twin.population, start, MissingDoses::Zero).is_err());
}
