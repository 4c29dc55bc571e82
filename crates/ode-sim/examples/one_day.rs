//! A virtual person's day under each integrator: glucose every two hours, and the time a day takes.
//!
//! `cargo run -p ode-sim --example one_day`

use std::time::Instant;

use ode_sim::{EgpMode, Integrator, OdeError, OdePlant, VirtualPerson, steady_state};
use physiology::{Grams, MgPerDl, OpenLoop, STEPS_PER_DAY, StepInput, simulate};

#[expect(clippy::print_stdout, reason = "an example shows its result")]
fn main() -> Result<(), OdeError> {
    let person = VirtualPerson::draw(1, 0)?;
    println!(
        "{:.1}, basal {:.2}, total {:.1} a day, ratio {:.1}",
        person.weight, person.basal, person.total_daily_insulin, person.ratio
    );
    let mut inputs = vec![StepInput { basal: person.basal, ..StepInput::default() }; STEPS_PER_DAY];
    for (step, carbs) in [(90, 45.0), (150, 60.0), (222, 70.0)] {
        inputs[step].carbs = Grams(carbs);
        inputs[step].bolus = physiology::Units(carbs / person.ratio.0);
    }
    let start = steady_state::at_glucose(&person.parameters, person.weight, MgPerDl(130.0))?;
    let integrators = [
        Integrator::ForwardEuler,
        Integrator::RungeKutta4 { substeps: 1 },
        Integrator::RungeKutta4 { substeps: 5 },
        Integrator::Adaptive { rtol: 1e-6, atol: 1e-9 },
    ];
    for integrator in integrators {
        let plant = OdePlant {
            parameters: person.parameters,
            weight: person.weight,
            integrator,
            egp: EgpMode::NonNegative,
        };
        let run = || simulate(&plant, start.state, &mut OpenLoop::new(&inputs), STEPS_PER_DAY);
        let repeats = 200;
        let clock = Instant::now();
        for _ in 0..repeats {
            std::hint::black_box(run()?);
        }
        let microseconds = 1e6 * clock.elapsed().as_secs_f64() / f64::from(repeats);
        println!("{integrator:?}: {microseconds:.0} us a day");
        let glucose = run()?.glucose(&plant);
        let shown: Vec<String> =
            glucose.iter().step_by(24).map(|g| format!("{:.1}", g.0)).collect();
        println!("  {}", shown.join(" "));
    }
    Ok(())
}
