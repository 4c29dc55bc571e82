//! The networks as bodies inside the diagnosis' filter.

use std::sync::Arc;

use gap::Body;
use gap::filter::body::sees;
use nn_statespace::{
    GLUCOSE_RANGE, GlucoseClamp, PerCompartment, PopulationModel, ScaledStates, Scaler, Signal,
};
use physiology::{Compartment, MgPerDl, States, StepInput};
use twins::Twin;

use crate::error::PlantsError;

/// The population network.
#[derive(Debug)]
pub struct NetworkBody(pub Arc<PopulationModel>);

/// The population network with a person's residual network.
#[derive(Debug)]
pub struct TwinBody(pub Arc<Twin>);

/// Refuses a model whose networks see more than the equations of their compartments do.
///
/// # Errors
/// [`PlantsError::Wiring`] naming the first that does.
pub fn check_wiring(model: &PopulationModel) -> Result<(), PlantsError> {
    for compartment in Compartment::ALL {
        for signal in model.wiring().inputs(compartment) {
            let known = match signal {
                Signal::State(state) => sees(compartment).any(|input| input == *state),
                Signal::Insulin => compartment == Compartment::S1,
                Signal::Carbs => compartment == Compartment::C1,
            };
            if !known {
                return Err(PlantsError::Wiring { compartment, signal: *signal });
            }
        }
    }
    Ok(())
}

impl Body for NetworkBody {
    fn rate(&self, compartment: Compartment, x: &States, input: &StepInput) -> f64 {
        let scaler = self.0.scaler();
        let (x, u) = (scaler.scale(x), scaler.scale_input(input));
        self.0.rate(compartment, &x, u) * scale(scaler, compartment)
    }

    fn slopes(&self, compartment: Compartment, x: &States, input: &StepInput) -> (f64, States) {
        let scaler = self.0.scaler();
        let (rate, slopes) =
            self.0.rate_and_slopes(compartment, &scaler.scale(x), scaler.scale_input(input));
        unscaled(scaler, compartment, rate, &slopes)
    }

    fn glucose_range(&self) -> Option<(MgPerDl, MgPerDl)> {
        range(&self.0)
    }
}

impl Body for TwinBody {
    fn rate(&self, compartment: Compartment, x: &States, input: &StepInput) -> f64 {
        let population = &self.0.population;
        let scaler = population.scaler();
        let x = scaler.scale(x);
        let own = population.rate(compartment, &x, scaler.scale_input(input));
        let rate = match compartment {
            Compartment::Q1 => own + self.0.residual_rate(&x, input),
            _ => own,
        };
        rate * scale(scaler, compartment)
    }

    fn slopes(&self, compartment: Compartment, x: &States, input: &StepInput) -> (f64, States) {
        let population = &self.0.population;
        let scaler = population.scaler();
        let x: ScaledStates = scaler.scale(x);
        let (mut rate, mut slopes) =
            population.rate_and_slopes(compartment, &x, scaler.scale_input(input));
        if compartment == Compartment::Q1 {
            let (residual, by) = self.0.residual_rate_and_slopes(&x, input);
            rate += residual;
            for (state, slope) in by.iter() {
                slopes[state] += slope;
            }
        }
        unscaled(scaler, compartment, rate, &slopes)
    }

    fn glucose_range(&self) -> Option<(MgPerDl, MgPerDl)> {
        range(&self.0.population)
    }
}

fn range(model: &PopulationModel) -> Option<(MgPerDl, MgPerDl)> {
    match model.clamp() {
        GlucoseClamp::Reproduction => Some(GLUCOSE_RANGE),
        GlucoseClamp::Off => None,
    }
}

fn scale(scaler: &Scaler, compartment: Compartment) -> f64 {
    scaler.of(Signal::State(compartment)).scale
}

/// A scaled rate and its slopes in physical units.
fn unscaled(
    scaler: &Scaler,
    compartment: Compartment,
    rate: f64,
    slopes: &PerCompartment<f64>,
) -> (f64, States) {
    let own = scale(scaler, compartment);
    let mut physical = States::default();
    for (state, slope) in slopes.iter() {
        if *slope != 0.0 {
            physical[state] = slope * own / scale(scaler, state);
        }
    }
    (rate * own, physical)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    use effects::Modulation;
    use gap::NoiseModel;
    use gap::filter::augmented::AugmentedModel;
    use gap::filter::calibration::PersonalFactors;
    use gap::filter::state::STATES;
    use nn_statespace::training::initial_networks;
    use nn_statespace::{CentreAndScale, ModelCard, Widths, Wiring};
    use ode_sim::OdeParameters;
    use physiology::{Context, Grams, Kilograms, Plant, Units, UnitsPerHour};
    use twins::{HIDDEN, INPUTS, InputSet, ResidualNetwork, TwinCard};

    /// Untrained networks with scales as they are in use, so that every input matters.
    fn population(clamp: GlucoseClamp) -> PopulationModel {
        use Compartment::{C1, C2, I, Q1, Q2, S1, S2, X1, X2, X3};
        let wiring = Wiring::paper();
        let networks = initial_networks(&wiring, &Widths::quick(), 0.02, 5);
        let states = PerCompartment::from_fn(|compartment| {
            let (centre, scale) = match compartment {
                S1 | S2 => (12.0, 6.0),
                I => (9.0, 4.0),
                X1 | X2 => (0.01, 0.006),
                X3 => (0.4, 0.2),
                Q1 => (130.0, 50.0),
                Q2 => (1.0, 0.5),
                C1 => (0.0, 1.0),
                C2 => (0.01, 0.01),
            };
            CentreAndScale { centre, scale }
        });
        let pair = |centre: f64, scale: f64| CentreAndScale { centre, scale };
        let scaler = Scaler::new(states, pair(1.0, 0.5), pair(0.0, 1.0)).expect("positive");
        let card = ModelCard {
            origin: "a test".to_owned(),
            version: "0".to_owned(),
            training_data_sha256: None,
            training: None,
        };
        PopulationModel::new(wiring, networks, scaler, clamp, card).expect("fits")
    }

    /// Every weight of the residual network differs from zero, and every input counts.
    fn twin() -> Twin {
        let shapes =
            [(INPUTS, HIDDEN[0]), (HIDDEN[0], HIDDEN[1]), (HIDDEN[1], HIDDEN[2]), (HIDDEN[2], 1)];
        let values = |layer: usize, count: usize, size: f64| -> Vec<f64> {
            let wave = |k: usize| size * (1.7 * (k * k % 9973) as f64 + layer as f64).sin();
            (0..count).map(wave).collect()
        };
        let weights: Vec<Vec<f64>> = shapes
            .iter()
            .enumerate()
            .map(|(layer, (inputs, outputs))| {
                values(layer, inputs * outputs, (3.0 / *inputs as f64).sqrt())
            })
            .collect();
        let biases: Vec<Vec<f64>> = shapes
            .iter()
            .enumerate()
            .map(|(layer, (_, outputs))| values(layer + 4, *outputs, 0.1))
            .collect();
        let (w, b) = (weights, biases);
        let residual = ResidualNetwork::from_tensors(
            [&w[0], &w[1], &w[2], &w[3]],
            [&b[0], &b[1], &b[2], &b[3]],
        )
        .expect("shapes");
        Twin {
            population: Arc::new(population(GlucoseClamp::Off)),
            residual,
            heart_rate_scaler: None,
            inputs: InputSet::All,
            card: TwinCard {
                person_id: "p".to_owned(),
                origin: "a test".to_owned(),
                version: "0".to_owned(),
                training_data_sha256: None,
                training: None,
            },
        }
    }

    fn bodies() -> BTreeMap<&'static str, Arc<dyn Body>> {
        let population = |clamp| Arc::new(population(clamp));
        BTreeMap::from([
            ("network", Arc::new(NetworkBody(population(GlucoseClamp::Off))) as Arc<dyn Body>),
            ("confined", Arc::new(NetworkBody(population(GlucoseClamp::Reproduction)))),
            ("twin", Arc::new(TwinBody(Arc::new(twin())))),
        ])
    }

    fn input() -> StepInput {
        StepInput {
            basal: UnitsPerHour(0.9),
            bolus: Units(0.1),
            carbs: Grams(2.0),
            context: Context { hour: 7, weekend: true, ..Context::default() },
            ..StepInput::default()
        }
    }

    fn model(body: Arc<dyn Body>) -> AugmentedModel {
        let (nominal, weight) = (OdeParameters::nominal(), Kilograms(76.3));
        AugmentedModel::new(nominal, weight, NoiseModel::working()).with_body(body)
    }

    /// A body whose slopes are differences.
    #[derive(Debug)]
    struct Differenced(Arc<dyn Body>);

    impl Body for Differenced {
        fn rate(&self, compartment: Compartment, x: &States, input: &StepInput) -> f64 {
            self.0.rate(compartment, x, input)
        }
    }

    #[test]
    fn slopes_are_those_of_differences() {
        let mut x = States::default();
        for (index, compartment) in Compartment::ALL.into_iter().enumerate() {
            x[compartment] = [11.0, 9.0, 8.0, 0.008, 0.012, 0.3, 150.0, 0.9, 0.4, 0.008][index];
        }
        for (name, body) in bodies() {
            let differenced = Differenced(Arc::clone(&body));
            for compartment in Compartment::ALL {
                let (rate, slopes) = body.slopes(compartment, &x, &input());
                assert_eq!(rate, body.rate(compartment, &x, &input()), "{name} {compartment}");
                let (_, expected) = differenced.slopes(compartment, &x, &input());
                for (state, expected) in expected.iter() {
                    // Piecewise linear: exact but for rounding of the differences.
                    let tolerance = 1e-6 * (expected.abs() + 1e-6);
                    let found = slopes[state];
                    assert!(
                        (found - expected).abs() < tolerance,
                        "{name}: {compartment} by {state}: {found} against {expected}"
                    );
                }
            }
            let own: f64 = body.slopes(Compartment::Q1, &x, &input()).1[Compartment::C2];
            assert!(own != 0.0, "{name}: nothing to compare");
        }
    }

    /// The wiring of the networks is that of the transition: all other entries are zero.
    #[test]
    fn the_sparse_transition_is_the_derivative_of_the_step() {
        let factors = PersonalFactors([0.2, 0.1, -0.15, 0.2, -0.1, 0.12]);
        for (name, body) in bodies() {
            let model = model(body).with_parameters(|p| factors.applied_to(p));
            let (state, _) = model.start(UnitsPerHour(1.0), MgPerDl(150.0));
            let (_, transition) =
                model.linearised(&state, &input(), &Modulation::NEUTRAL).expect("finite");
            let x = state.vector();
            for column in 0..STATES {
                let h = 1e-6 * x[column].abs().max(1e-3);
                let moved = |by: f64| {
                    let mut y = x;
                    y[column] += by;
                    let moved = state.with_vector(&y);
                    model.step(&moved, &input(), &Modulation::NEUTRAL).expect("finite").vector()
                };
                let (above, below) = (moved(h), moved(-h));
                for row in 0..STATES {
                    let slope = (above[row] - below[row]) / (2.0 * h);
                    let found = transition.get(row, column);
                    // Rounding of values up to 200, through hidden layers of 128 units, over 2h.
                    let tolerance = 1e-5 * found.abs().max(1.0) + 1e-13 * 200.0 / h;
                    assert!(
                        (slope - found).abs() < tolerance,
                        "{name}: row {row} column {column}: {found} against {slope}"
                    );
                }
            }
        }
    }

    /// Without personal factors, flux and modulation the body inside the filter is the plant itself.
    #[test]
    fn the_body_runs_as_the_plant_does() {
        let twin = Arc::new(twin());
        let network = Arc::clone(&twin.population);
        let same =
            |name: &str, body: Arc<dyn Body>, step: &dyn Fn(&ScaledStates) -> ScaledStates| {
                let model = model(body);
                let (mut state, _) = model.start(UnitsPerHour(1.0), MgPerDl(140.0));
                let mut expected = network.scaler().scale(&model.report(&state));
                for k in 0..30 {
                    state = model.step(&state, &input(), &Modulation::NEUTRAL).expect("finite");
                    expected = step(&expected);
                    let physical = network.scaler().unscale(&expected);
                    for (compartment, found) in model.report(&state).iter() {
                        let expected = physical[compartment];
                        // Thirty steps of scaling there and back.
                        let tolerance = 1e-9 * expected.abs().max(1.0);
                        assert!(
                            (found - expected).abs() < tolerance,
                            "{name}, step {k}, {compartment}: {found} against {expected}"
                        );
                    }
                }
                expected[Compartment::Q1]
            };
        let alone = same("network", Arc::new(NetworkBody(Arc::clone(&network))), &|x| {
            network.step(x, &input()).expect("finite")
        });
        let with = same("twin", Arc::new(TwinBody(Arc::clone(&twin))), &|x| {
            twin.step(x, &input()).expect("finite")
        });
        assert!((alone - with).abs() > 1e-3, "the residual adds nothing");
    }

    #[test]
    fn networks_that_see_more_than_their_equations_are_refused() {
        let paper = |c: Compartment| Wiring::paper().inputs(c).to_vec();
        let mut inputs = PerCompartment::from_fn(paper);
        inputs[Compartment::X1].push(Signal::State(Compartment::Q1));
        let wiring = Wiring::new(inputs).expect("no input twice");
        let networks = initial_networks(&wiring, &Widths::quick(), 1.0, 5);
        let known = population(GlucoseClamp::Off);
        let card = known.card().clone();
        let scaler = *known.scaler();
        let model = PopulationModel::new(wiring, networks, scaler, GlucoseClamp::Off, card);
        let error = check_wiring(&model.expect("fits")).expect_err("X1 does not see Q1");
        assert!(error.to_string().starts_with("network X1 of the model sees Q1"), "{error}");
        check_wiring(&known).expect("the paper's wiring");
    }
}
