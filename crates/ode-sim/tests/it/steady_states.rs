//! Steady states over the virtual population and the range of glucose.

use ode_sim::equations::{Forcing, derivative, infusion};
use ode_sim::{EgpMode, Integrator, OdeError, OdeParameters, OdePlant, population, steady_state};
use physiology::{Kilograms, MgPerDl, OpenLoop, Plant, StepInput, simulate};

#[test]
fn every_virtual_person_stands_still_at_every_glucose() {
    let mut most_iterations = 0;
    for person in population(21, 60).expect("a population") {
        let mut last_basal = f64::INFINITY;
        for glucose in (80..=250).step_by(5) {
            let target = MgPerDl(f64::from(glucose));
            let found = steady_state::at_glucose(&person.parameters, person.weight, target)
                .expect("a basal rate holds it");
            // Evaluated here once more, in both modes, rather than believed.
            let forcing =
                Forcing { insulin: infusion(found.basal.0, person.weight.0), ..Forcing::default() };
            for egp in [EgpMode::Reproduction, EgpMode::NonNegative] {
                let dx = derivative(&person.parameters, &found.state.vector(), &forcing, egp);
                let residual = dx.0.iter().fold(0.0_f64, |max, rate| max.max(rate.abs()));
                assert!(residual < 1e-10, "person {}, {target}: {residual}", person.index);
            }
            assert!(found.residual < 1e-10);
            assert!(found.state.vector().0.iter().all(|value| *value >= 0.0));
            assert!(found.basal.0 < last_basal, "more glucose needs less insulin");
            last_basal = found.basal.0;
            most_iterations = most_iterations.max(found.iterations);
            let quick = steady_state::state_at_glucose(&person.parameters, target).expect("held");
            for (a, b) in quick.vector().0.into_iter().zip(found.state.vector().0) {
                // Both within 1e-10 of standing still, of states that relax within hours.
                assert!(
                    (a - b).abs() < 1e-7 * b.abs().max(1e-3),
                    "person {}: {a} {b}",
                    person.index
                );
            }
        }
    }
    assert!(most_iterations <= 12, "Newton converges quadratically: {most_iterations} iterations");
}

#[test]
fn a_steady_state_is_held_by_every_integrator() {
    let integrators = [
        Integrator::ForwardEuler,
        Integrator::RungeKutta4 { substeps: 1 },
        Integrator::Adaptive { rtol: 1e-9, atol: 1e-12 },
    ];
    for integrator in integrators {
        let plant = OdePlant {
            integrator,
            ..OdePlant::reproduction(OdeParameters::nominal(), Kilograms(76.3))
        };
        let found = steady_state::at_glucose(&plant.parameters, plant.weight, MgPerDl(140.0))
            .expect("a basal rate holds it");
        let inputs = vec![StepInput { basal: found.basal, ..StepInput::default() }; 288];
        let run = simulate(&plant, found.state, &mut OpenLoop::new(&inputs), 288).expect("finite");
        for glucose in run.glucose(&plant) {
            // 1440 min of a residual below 1e-10 mmol/kg/min, in mg/dL.
            assert!((glucose.0 - 140.0).abs() < 1e-5, "{integrator:?}: {glucose}");
        }
        assert!((plant.glucose(&found.state).0 - 140.0).abs() < 1e-12); // rounding
    }
}

#[test]
fn what_has_no_steady_state_is_an_error() {
    let p = OdeParameters::nominal();
    let weight = Kilograms(76.3);
    // Without insulin the kidneys hold 9 + 0.0064/(0.003 x 0.16) mmol/L = 402 mg/dL.
    assert!(steady_state::at_glucose(&p, weight, MgPerDl(401.0)).is_ok());
    let error = steady_state::at_glucose(&p, weight, MgPerDl(403.0)).expect_err("too high");
    assert_eq!(error, OdeError::NoBasal { glucose: 403.0 });
    for (weight, glucose) in [(0.0, 100.0), (f64::NAN, 100.0), (70.0, 0.0), (70.0, f64::NAN)] {
        let error = steady_state::at_glucose(&p, Kilograms(weight), MgPerDl(glucose));
        assert!(matches!(error, Err(OdeError::Argument { .. })));
    }
    let broken = OdeParameters { t_max_i: -1.0, ..p };
    let error = steady_state::at_glucose(&broken, weight, MgPerDl(100.0));
    assert!(matches!(error, Err(OdeError::Parameter { name: "t_max_i", .. })));
}
