//! Analytic derivatives against central differences, in f64.

use ode_sim::equations::{Forcing, derivative, jacobian};
use ode_sim::exercise::Multipliers;
use ode_sim::{EgpMode, Integrator, OdeParameters, OdePlant, OdeState, OdeVector};
use physiology::{Compartment, Grams, Kilograms, StepInput, Units, UnitsPerHour};
use proptest::prelude::*;

/// A state anywhere in the range of physiology, glucose and X3 away from the kinks.
fn states() -> impl Strategy<Value = OdeVector> {
    let glucose = prop_oneof![2.0..4.4, 4.6..8.9, 9.1..25.0_f64];
    let x3 = prop_oneof![0.0..0.95, 1.05..2.0_f64];
    (
        (0.0..200.0, 0.0..200.0, 0.0..150.0, 0.0..0.3, 0.0..0.03_f64),
        (x3, glucose, 0.0..4.0, 0.0..8.0, 0.0..8.0_f64),
    )
        .prop_map(|((s1, s2, i, x1, x2), (x3, g, q2, c1, c2))| {
            OdeVector([s1, s2, i, x1, x2, x3, g * 0.16, q2, c1, c2])
        })
}

fn forcings() -> impl Strategy<Value = Forcing> {
    (0.0..40.0, -0.02..0.05, 1.0..3.5, 1.0..2.2, 1.0..1.3_f64).prop_map(
        |(insulin, glucose_flux, pgu, piu, hgp)| Forcing {
            insulin,
            glucose_flux,
            exercise: Multipliers {
                peripheral_glucose_uptake: pgu,
                peripheral_insulin_uptake: piu,
                hepatic_glucose_production: hgp,
            },
        },
    )
}

/// A step for central differences: the cube root of rounding times the size of the state.
fn nudge(value: f64) -> f64 {
    6e-6 * value.abs().max(1e-2)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_jacobian_is_the_derivative_of_the_derivative(x in states(), forcing in forcings()) {
        let p = OdeParameters::nominal();
        for egp in [EgpMode::Reproduction, EgpMode::NonNegative] {
            let analytic = jacobian(&p, &x, &forcing, egp);
            for by in Compartment::ALL {
                let h = nudge(x[by]);
                let at = |shift: f64| {
                    let mut y = x;
                    y[by] += shift;
                    derivative(&p, &y, &forcing, egp)
                };
                let (above, below) = (at(h), at(-h));
                for of in Compartment::ALL {
                    let difference = (above[of] - below[of]) / (2.0 * h);
                    // The equations are at most quadratic, so only rounding of the values is left.
                    let rounding = 1e-15 * (above[of].abs() + 1.0) / h;
                    let error = (analytic[(of, by)] - difference).abs();
                    prop_assert!(error < 1e-9 + 4.0 * rounding, "d{of}/d{by}: {error}");
                }
            }
        }
    }

    #[test]
    fn the_transition_is_the_derivative_of_the_step(x in states(), bolus in 0.0..5.0_f64) {
        let input = StepInput {
            basal: UnitsPerHour(1.0),
            bolus: Units(bolus),
            carbs: Grams(30.0),
            ..StepInput::default()
        };
        // Glucose may cross a kink within a step, so `smooth` keeps every stage above the kinks.
        let cases = [
            (Integrator::ForwardEuler, 1e-7),
            (Integrator::RungeKutta4 { substeps: 1 }, 1e-7),
            (Integrator::RungeKutta4 { substeps: 3 }, 1e-7),
            // The derivative of a finer RK4 stands in for the adaptive method's own.
            (Integrator::Adaptive { rtol: 1e-11, atol: 1e-14 }, 1e-4),
        ];
        for (integrator, tolerance) in cases {
            let plant = OdePlant {
                parameters: OdeParameters::nominal(),
                weight: Kilograms(70.0),
                integrator,
                egp: EgpMode::Reproduction,
            };
            let state = OdeState::default().with_vector(&smooth(x));
            let (following, transition) = plant.linearised(&state, &input, 0.0).expect("finite");
            prop_assert_eq!(following, plant.advance(&state, &input, 0.0).expect("finite"));
            for by in Compartment::ALL {
                let h = nudge(state.vector()[by]);
                let at = |shift: f64| {
                    let mut y = state.vector();
                    y[by] += shift;
                    plant.advance(&state.with_vector(&y), &input, 0.0).expect("finite").vector()
                };
                let (above, below) = (at(h), at(-h));
                for of in Compartment::ALL {
                    let difference = (above[of] - below[of]) / (2.0 * h);
                    let analytic = transition[(of, by)];
                    let rounding = 1e-14 * above[of].abs() / h;
                    let error = (analytic - difference).abs();
                    prop_assert!(
                        error < tolerance * (1.0 + analytic.abs()) + rounding,
                        "{integrator:?}, {of} by {by}: {analytic} against {difference}"
                    );
                }
            }
        }
    }
}

/// The state with glucose 60 mmol/L higher and X1 of at most 0.1 per minute, so that every stage of
/// a step lies above the renal threshold of 9 mmol/L: over 5 minutes, with what plasma insulin adds
/// to X1, at most 0.62 of Q1 is taken up at that rate, and losses beside it are below 3 mmol/L.
fn smooth(mut x: OdeVector) -> OdeVector {
    x[Compartment::Q1] += 0.16 * 60.0;
    x[Compartment::X1] /= 3.0;
    x
}
