//! What is delivered is what is recorded, and what is recorded reaches the body.

use chrono::NaiveDate;
use physiology::{Compartment, OpenLoop, Plant, STEP, StepInput, Units, UnitsPerHour, simulate};
use world::{Background, Body, Calendar, Effect, Physique, Regime, VirtualPerson};

fn calendar() -> Calendar {
    Calendar::new(NaiveDate::from_ymd_opt(2024, 1, 8).expect("a date"), 14)
}

#[test]
fn recorded_insulin_is_the_insulin_delivered() {
    for regime in [Regime::OpenLoopPump, Regime::Aid] {
        let person = VirtualPerson::sample(11, 0, regime).expect("a person");
        let days = person.live(calendar()).expect("two weeks");
        let record = &days.recorded.record;
        let (mut delivered, mut ordered) = (0.0, 0.0);
        for (step, input) in days.inputs.iter().enumerate() {
            assert_eq!(record.bolus()[step], Some(input.bolus.0));
            for amount in [input.bolus.0, input.basal.during(STEP).0] {
                let increments = amount / 0.05;
                assert!((increments - increments.round()).abs() < 1e-9, "step {step}: {amount} U");
            }
            delivered += input.basal.during(STEP).0;
            ordered += record.basal()[step].expect("always recorded") / 12.0;
            // The pump owes less than one increment at any time.
            assert!((-1e-6..0.05).contains(&(ordered - delivered)), "step {step}");
        }
        assert!(days.inputs.iter().map(|i| i.bolus.0).sum::<f64>() > 50.0);
    }
}

#[test]
fn without_counting_errors_and_omissions_the_log_holds_what_was_eaten() {
    let mut person = VirtualPerson::sample(11, 1, Regime::OpenLoopPump).expect("a person");
    person.background = Background::ERRORS_IN_EFFECT;
    for effect in [Effect::CarbMiscount, Effect::MissedMeals, Effect::UnloggedRescueCarbs] {
        person.amplitudes = person.amplitudes.without(effect);
    }
    let days = person.live(calendar()).expect("two weeks");
    for (step, input) in days.inputs.iter().enumerate() {
        let eaten = input.carbs.0 + input.rescue.amount.0;
        let logged = days.recorded.record.carbs()[step].expect("always recorded");
        assert!((logged - eaten).abs() <= 0.5, "step {step}: {logged} for {eaten}"); // whole grams
    }
}

#[test]
fn omissions_lower_the_log_and_nothing_else_does() {
    let mut person = VirtualPerson::sample(11, 1, Regime::OpenLoopPump).expect("a person");
    person.amplitudes =
        person.amplitudes.without(Effect::CarbMiscount).with(Effect::MissedMeals, 5.0);
    let days = person.live(calendar()).expect("two weeks");
    let logged = days.recorded.record.carbs();
    let unlogged = days.life.meals.iter().filter(|m| logged[m.step] == Some(0.0)).count() as f64;
    let share = unlogged / days.life.meals.len() as f64;
    // 5 x 0.07 of about 55 meals: SD 6.4 %, three of them.
    assert!((0.15..0.55).contains(&share), "{share}");
}

#[test]
fn insulin_is_conserved_on_its_way_through_the_body() {
    let person = VirtualPerson::sample(11, 2, Regime::OpenLoopPump).expect("a person");
    let Physique::Hovorka(drawn) = person.body else { panic!("drawn as such") };
    let body = Body::undisturbed(drawn);
    let (start, _) = body.at_rest(physiology::MgPerDl(140.0)).expect("a steady state");
    let mut inputs = vec![StepInput { basal: UnitsPerHour(0.8), ..StepInput::default() }; 288];
    inputs[24].bolus = Units(4.0);
    let run = simulate(&body, start, &mut OpenLoop::new(&inputs), 288).expect("finite");
    let states = run.report(&body);
    let p = drawn.model;
    let held = |k: usize| {
        let x = &states[k];
        x[Compartment::S1] + x[Compartment::S2] + p.v_i * x[Compartment::I]
    };
    let eliminated: f64 = states
        .windows(2)
        .map(|w| 0.5 * STEP.0 * p.k_e * p.v_i * (w[0][Compartment::I] + w[1][Compartment::I]))
        .sum();
    let delivered: f64 =
        inputs.iter().map(|i| i.insulin().during(STEP).0).sum::<f64>() * 1000.0 / drawn.weight.0;
    let balance = delivered - eliminated - (held(288) - held(0));
    // Trapezoids of 5 min over a curve with time constants of 40 min and more.
    assert!((balance / delivered).abs() < 2e-3, "{balance} of {delivered}");
    assert!(body.glucose(&run.states[288]).0 > 0.0);
}
