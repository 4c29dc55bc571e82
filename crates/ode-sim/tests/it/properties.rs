//! Properties that hold for any inputs.

use ode_sim::pump::INCREMENT;
use ode_sim::sensor::{DISPLAY_RANGE, Reading};
use ode_sim::{
    EgpMode, Integrator, OdeParameters, OdePlant, OdeState, Pump, Sensor, SensorModel, steady_state,
};
use physiology::{
    Compartment, Exercise, FastCarbs, Grams, Kilograms, MgPerDl, Minutes, OpenLoop, Plant, STEP,
    StepInput, Units, UnitsPerHour, simulate,
};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha12Rng;

fn inputs(max_bolus: f64) -> impl Strategy<Value = Vec<StepInput>> {
    let exercise = proptest::option::weighted(0.2, (0.0..100.0, 0.0..1.0_f64));
    let step = (0.0..4.0, 0.0..1.0, 0.0..max_bolus, 0.0..1.0, 0.0..120.0, 0.0..20.0_f64, exercise)
        .prop_map(|(basal, bolus_if, bolus, carbs_if, carbs, rescue, exercise)| StepInput {
            basal: UnitsPerHour(basal),
            bolus: Units(if bolus_if > 0.97 { bolus } else { 0.0 }),
            carbs: Grams(if carbs_if > 0.97 { carbs } else { 0.0 }),
            rescue: FastCarbs {
                amount: Grams(if carbs_if < 0.02 { rescue } else { 0.0 }),
                eaten_before: Minutes(5.0),
            },
            exercise: exercise.map(|(vo2max_percent, active_muscle_share)| Exercise {
                vo2max_percent,
                active_muscle_share,
            }),
            ..StepInput::default()
        });
    proptest::collection::vec(step, 50..200)
}

fn run(integrator: Integrator, egp: EgpMode, inputs: &[StepInput]) -> Vec<OdeState> {
    let plant =
        OdePlant { parameters: OdeParameters::nominal(), weight: Kilograms(70.0), integrator, egp };
    let start = steady_state::at_glucose(&plant.parameters, plant.weight, MgPerDl(120.0))
        .expect("a basal rate holds it");
    simulate(&plant, start.state, &mut OpenLoop::new(inputs), inputs.len()).expect("finite").states
}

fn readings(model: SensorModel, glucose: &[MgPerDl], seed: u64) -> Vec<Reading> {
    let mut rng = ChaCha12Rng::seed_from_u64(seed);
    let mut sensor = Sensor::inserted(model, glucose[0], &mut rng).expect("finite");
    let mut readings = vec![sensor.reading()];
    readings.extend(glucose[1..].iter().map(|g| sensor.next(*g, &mut rng).expect("finite")));
    readings
}

const INSULIN_AND_GUT: [Compartment; 8] = [
    Compartment::S1,
    Compartment::S2,
    Compartment::I,
    Compartment::X1,
    Compartment::X2,
    Compartment::X3,
    Compartment::C1,
    Compartment::C2,
];

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(64)
    })]

    #[test]
    fn insulin_and_gut_are_never_negative(inputs in inputs(8.0)) {
        // One Euler step of 5 min is a sum of positive terms in the linear states, as long as
        // every rate is below 0.2/min; the largest, k_e, is 0.138/min.
        for integrator in [Integrator::ForwardEuler, Integrator::RungeKutta4 { substeps: 1 }] {
            for state in run(integrator, EgpMode::NonNegative, &inputs) {
                for compartment in INSULIN_AND_GUT {
                    prop_assert!(state.vector()[compartment] >= 0.0, "{compartment}");
                }
                prop_assert!(state.rescue.c1 >= 0.0 && state.rescue.c2 >= 0.0);
            }
        }
    }

    #[test]
    fn glucose_stays_positive_where_production_does(inputs in inputs(8.0)) {
        // X1 stays below 1/min here: RK4 at one minute keeps the sign.
        let integrator = Integrator::RungeKutta4 { substeps: 5 };
        for state in run(integrator, EgpMode::NonNegative, &inputs) {
            prop_assert!(state.q1 > 0.0 && state.q2 >= 0.0);
        }
    }

    #[test]
    fn egp_modes_agree_until_production_would_turn_negative(inputs in inputs(2.0)) {
        let integrator = Integrator::ForwardEuler;
        let free = run(integrator, EgpMode::Reproduction, &inputs);
        let clamped = run(integrator, EgpMode::NonNegative, &inputs);
        for (a, b) in free.iter().zip(&clamped) {
            prop_assert_eq!(a, b);
            if a.x3 > 1.0 {
                break;
            }
        }
    }

    #[test]
    fn a_pump_gives_what_was_ordered(orders in inputs(8.0)) {
        let mut pump = Pump::new(INCREMENT).expect("positive");
        let (mut ordered, mut given) = (0.0, 0.0);
        for order in &orders {
            let delivered = pump.deliver(order).expect("doses that can be");
            ordered += order.basal.during(STEP).0;
            given += delivered.basal.during(STEP).0;
            // Less than one increment is owed; 1e-10: rounding of the sums.
            prop_assert!((-1e-10..INCREMENT.0 + 1e-10).contains(&(ordered - given)));
            let rounding = (delivered.bolus.0 - order.bolus.0).abs();
            prop_assert!(rounding <= 0.5 * INCREMENT.0 + 1e-12);
            for amount in [delivered.basal.during(STEP).0, delivered.bolus.0] {
                let increments = amount / INCREMENT.0;
                prop_assert!((increments - increments.round()).abs() < 1e-9, "{amount} U");
            }
            prop_assert_eq!(delivered.carbs, order.carbs);
        }
    }

    #[test]
    fn a_sensor_shows_what_its_display_can(seed in any::<u64>(), level in 20.0..500.0_f64) {
        for model in [SensorModel::dexcom_g5(), SensorModel::dexcom_g6()] {
            for reading in readings(model, &[MgPerDl(level); 50], seed) {
                prop_assert!((DISPLAY_RANGE.0..=DISPLAY_RANGE.1).contains(&reading.shown.0));
                let within = (DISPLAY_RANGE.0..=DISPLAY_RANGE.1).contains(&reading.raw.0);
                prop_assert_eq!(within, reading.raw == reading.shown);
            }
        }
    }
}

#[test]
fn doses_that_are_not_numbers_stop_the_plant_with_the_compartment() {
    let nan = f64::NAN;
    let snack = FastCarbs { amount: Grams(nan), eaten_before: Minutes(0.0) };
    // (input, compartment at fault); a snack arrives in Q1.
    let cases = [
        (StepInput { basal: UnitsPerHour(nan), ..StepInput::default() }, Compartment::S1),
        (StepInput { bolus: Units(nan), ..StepInput::default() }, Compartment::S1),
        (StepInput { carbs: Grams(nan), ..StepInput::default() }, Compartment::C1),
        (StepInput { rescue: snack, ..StepInput::default() }, Compartment::Q1),
    ];
    let start = OdeState { q1: 1.0, ..OdeState::default() };
    let integrators = [
        Integrator::ForwardEuler,
        Integrator::RungeKutta4 { substeps: 2 },
        Integrator::Adaptive { rtol: 1e-6, atol: 1e-9 },
    ];
    for integrator in integrators {
        let plant = OdePlant {
            integrator,
            ..OdePlant::reproduction(OdeParameters::nominal(), Kilograms(70.0))
        };
        for (input, compartment) in &cases {
            let error = plant.step(&start, input).expect_err("not a number");
            assert_eq!(error.compartment, *compartment, "{integrator:?}");
        }
    }
}

#[test]
fn a_g6_on_a_simulated_day_errs_as_much_as_one_does() {
    let plant = OdePlant::reproduction(OdeParameters::nominal(), Kilograms(76.3));
    let start = steady_state::at_glucose(&plant.parameters, plant.weight, MgPerDl(130.0))
        .expect("a basal rate holds it");
    let mut inputs = vec![StepInput { basal: start.basal, ..StepInput::default() }; 10 * 288];
    for day in 0..10 {
        for (step, carbs) in [(90, 45.0), (150, 60.0), (222, 70.0)] {
            inputs[day * 288 + step].carbs = Grams(carbs);
            inputs[day * 288 + step].bolus = Units(carbs / 13.0);
        }
    }
    let run =
        simulate(&plant, start.state, &mut OpenLoop::new(&inputs), inputs.len()).expect("finite");
    let glucose = run.glucose(&plant);
    let readings = readings(SensorModel::dexcom_g6(), &glucose, 1);
    let differences = glucose.iter().zip(&readings).map(|(g, r)| (r.shown.0 / g.0 - 1.0).abs());
    let mard = differences.sum::<f64>() / glucose.len() as f64;
    // Published mean absolute relative differences of the G6 lie between 8 and 10 %.
    assert!((0.05..0.13).contains(&mard), "{mard}");
}
