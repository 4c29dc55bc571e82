//! Fits of people whose body is known.

use chrono::NaiveDate;
use cohort::{Channel, Person, Record, Therapy};
use nn_statespace::PopulationModel;
use ode_sim::personal::PersonalFactors;
use ode_sim::{OdeParameters, OdePlant, steady_state};
use ode_twins::{
    Candidate, FitRecipe, FitWindows, Sampling, SensitivitySearch, closest, fit_person,
    maximum_a_posteriori, sample_posterior, search_sensitivities,
};
use physiology::{Grams, Kilograms, MgPerDl, OpenLoop, StepInput, Units, UnitsPerHour, simulate};
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;
use twins::{PersonWindows, Protocol, TwinLoss, WindowStart};

const DAYS: usize = 12;
const WEIGHT: Kilograms = Kilograms(70.0);

fn protocol() -> Protocol {
    Protocol { training_days: 8, ..Protocol::quick() }
}

/// A person whose glucose is that of an ODE body, with a slow random error on top that the fit must
/// live with.
fn person(parameters: OdeParameters, wander: f64) -> Person {
    let plant = OdePlant::reproduction(parameters, WEIGHT);
    let start = steady_state::at_glucose(&parameters, WEIGHT, MgPerDl(140.0)).expect("held");
    let steps = DAYS * 288;
    let mut inputs = vec![StepInput::default(); steps];
    for (step, input) in inputs.iter_mut().enumerate() {
        input.basal = UnitsPerHour(start.basal.0);
        let of_day = step % 288;
        let day = step / 288;
        for (index, (at, grams)) in [(90, 45.0), (150, 70.0), (228, 60.0)].into_iter().enumerate() {
            if of_day == at + (7 * day + index) % 11 {
                input.carbs = Grams(grams + 5.0 * (day % 4) as f64);
                // Sometimes too much, sometimes too little.
                let ratio = 9.0 + 2.0 * ((day + index) % 3) as f64;
                input.bolus = Units(input.carbs.0 / ratio);
            }
        }
    }
    let run = simulate(&plant, start.state, &mut OpenLoop::new(&inputs), steps).expect("finite");
    let glucose = run.glucose(&plant);
    let begin = NaiveDate::from_ymd_opt(2026, 3, 2).and_then(|d| d.and_hms_opt(0, 0, 0));
    let mut record = Record::new(begin.expect("a date"), steps).expect("on the grid");
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut slow = 0.0;
    for (step, input) in inputs.iter().enumerate() {
        // Ornstein-Uhlenbeck over four hours, of standard deviation `wander`.
        slow = 0.98 * slow + 0.2 * wander * rng.random_range(-1.0..1.0_f64) * 3.0_f64.sqrt();
        record.channel_mut(Channel::Cgm)[step] = Some((glucose[step].0 + slow).clamp(40.0, 400.0));
        record.channel_mut(Channel::Basal)[step] = Some(input.basal.0);
        record.channel_mut(Channel::Bolus)[step] = Some(input.bolus.0);
        record.channel_mut(Channel::Carbs)[step] = Some(input.carbs.0);
    }
    Person {
        id: "made".to_owned(),
        weight: Some(WEIGHT),
        therapy: Therapy::OpenLoopPump,
        heart_rate_baseline: None,
        record,
    }
}

fn windows<'a>(
    person: &'a Person,
    cut: &'a PersonWindows,
    population: &PopulationModel,
) -> FitWindows<'a> {
    // The records are long enough to know what insulin and food is on board.
    let start = WindowStart::Carried;
    FitWindows::training(person, cut, start, TwinLoss::PAPER, population).expect("some")
}

#[test]
fn factors_of_a_known_body_are_found_within_their_posterior() {
    let truth = PersonalFactors([-0.35, 0.12, 0.2, -0.1, 0.1, 0.0]);
    let person = person(truth.applied_to(&OdeParameters::nominal()), 8.0);
    let cut = PersonWindows::new(0, &person, &protocol()).expect("cut");
    let population = PopulationModel::shipped().expect("read");
    let windows = windows(&person, &cut, &population).apart(1);
    let before = windows.simulated(&OdePlant::reproduction(OdeParameters::nominal(), WEIGHT));
    assert!(before.is_ok());
    let mode = maximum_a_posteriori(&windows).expect("found");
    assert!(mode.converged, "{mode:?}");
    let posterior = sample_posterior(&windows, &mode, &Sampling::quick(), 3).expect("sampled");
    let found = posterior.diagnostics;
    assert!(found.r_hat < 1.1 && found.ess_bulk > 60.0, "{found:?}");
    for (k, truth) in truth.0.into_iter().enumerate() {
        let (mean, sd) = (posterior.mean[k], posterior.sd[k]);
        // Six factors, none beyond 3.5 standard deviations; starts carry the wander into the states.
        assert!((mean - truth).abs() < 3.5 * sd + 0.02, "{k}: {mean} ± {sd}, {truth}");
        assert!(sd < 0.3 && sd > 1e-3);
    }
    // Chains come from the seed alone.
    let again = sample_posterior(&windows, &mode, &Sampling::quick(), 3).expect("sampled");
    assert_eq!(posterior, again);
    let other = sample_posterior(&windows, &mode, &Sampling::quick(), 4).expect("sampled");
    assert_ne!(posterior.mean, other.mean);
    let alone = Sampling { chains: 1, ..Sampling::quick() };
    let error = sample_posterior(&windows, &mode, &alone, 3).expect_err("one chain");
    assert_eq!(error.to_string(), "chains = 1 must be at least 2");
}

#[test]
fn the_closest_is_the_body_itself_and_the_search_approaches_it() {
    let nominal = OdeParameters::nominal();
    let truth = OdeParameters {
        s_f1: 0.7 * nominal.s_f1,
        s_f2: 1.6 * nominal.s_f2,
        s_f3: 0.8 * nominal.s_f3,
        ..nominal
    };
    let person = person(truth, 0.0);
    let cut = PersonWindows::new(0, &person, &protocol()).expect("cut");
    let population = PopulationModel::shipped().expect("read");
    let windows = windows(&person, &cut, &population);
    let body = |id: &str, parameters| Candidate { id: id.to_owned(), parameters, weight: WEIGHT };
    let mut candidates =
        vec![body("nominal", nominal), body("weak", nominal.with_sensitivity_scaled(0.5))];
    let without = closest(&windows, &candidates).expect("one");
    candidates.push(body("truth", truth));
    let with = closest(&windows, &candidates).expect("one");
    assert_eq!(candidates[with.place].id, "truth");
    assert!(with.loss < without.loss);
    let found =
        search_sensitivities(&windows, &SensitivitySearch::paper(), 5).expect("evaluations");
    // Sensitivities stand in for each other: 40 evaluations do not find the valley's ground.
    assert!(found.loss < 0.6 * without.loss, "{found:?} {with:?} {without:?}");
    assert_eq!(found.evaluations, 40);
    let again = search_sensitivities(&windows, &SensitivitySearch::paper(), 5).expect("the same");
    assert_eq!(found, again);
    for range in [(0.0, 5.0), (2.0, 1.0), (0.2, f64::INFINITY), (f64::NAN, 5.0)] {
        let search = SensitivitySearch { range, ..SensitivitySearch::quick() };
        let error = search_sensitivities(&windows, &search, 5).expect_err("no range");
        assert!(error.to_string().starts_with("least factor = "), "{error}");
    }
}

#[test]
fn all_fits_of_a_person_survive_a_file() {
    let person = person(OdeParameters::nominal().with_sensitivity_scaled(0.8), 5.0);
    let cut = PersonWindows::new(0, &person, &protocol()).expect("cut");
    let population = PopulationModel::shipped().expect("read");
    let candidates = ode_sim::population(9, 5).expect("people");
    let recipe = FitRecipe {
        protocol: protocol(),
        loss: TwinLoss::PAPER,
        candidates: candidates
            .into_iter()
            .map(|p| Candidate {
                id: p.index.to_string(),
                parameters: p.parameters,
                weight: p.weight,
            })
            .collect(),
        search: SensitivitySearch { explore: 5, propose: 2, range: (0.3, 3.0) },
        sampling: Sampling { chains: 2, tune: 20, draws: 20, kept: 5 },
        posterior_stride: 2,
        seed: 1,
    };
    let fits = fit_person(0, &person, &cut, &population, &recipe).expect("fitted");
    let text = serde_json::to_string(&fits).expect("JSON");
    let back: ode_twins::OdeFits = serde_json::from_str(&text).expect("JSON");
    assert_eq!(fits, back);
    assert_eq!(fits.posterior.draws.len(), 5);
    // The fit by six factors beats the guess by three on the loss of neither: it is judged anew.
    assert!(fits.maximum_a_posteriori.loss.is_finite());
    let none = FitRecipe { candidates: Vec::new(), ..recipe };
    let error = fit_person(0, &person, &cut, &population, &none).expect_err("no candidate");
    assert!(error.to_string().contains("none of 0 candidates"), "{error}");
}
