//! Trains a twin of one synthetic person and judges it on held-out windows.
//!
//! The person follows the synthetic population model of the tests, but exercise lowers their
//! glucose further. Run with `cargo run -p evaluation --example one_person`.

#[expect(dead_code, reason = "tests of the twins use the rest of this module")]
#[path = "../../twins/tests/it/synthetic.rs"]
mod synthetic;

use std::collections::BTreeMap;
use std::error::Error;

use evaluation::{EvaluationSettings, PersonModels, evaluate};
use nn_statespace::GlucoseClamp;
use synthetic::{cohort_of, planted, population, twin_of};
use twins::{Doses, InputSet, Protocol, TrainingPlan, TwinRecipe, WindowStart, build_twin};

fn main() -> Result<(), Box<dyn Error>> {
    let truth = twin_of(planted(), GlucoseClamp::Reproduction);
    let cohort = cohort_of(&truth, 1, 18);
    let recipe = TwinRecipe {
        population: population(GlucoseClamp::Reproduction),
        // The record is long enough to know what insulin and food is on board.
        protocol: Protocol { start: WindowStart::Carried, ..Protocol::quick() },
        plan: TrainingPlan::quick(),
        inputs: InputSet::All,
        doses: Doses::Population,
        seed: 1,
    };
    let person = build_twin(0, &cohort.people[0], &recipe, None)?;
    let built = person.result.map_err(|reason| reason.to_string())?;
    let twins =
        BTreeMap::from([(person.person_id, PersonModels::new(&cohort.people[0], built.twin))]);
    let settings = EvaluationSettings::paper(recipe.protocol, 1);
    let found = evaluate(&cohort, &twins, &recipe.population, &settings)?;
    #[expect(clippy::print_stdout, reason = "an example reports to its reader")]
    for judged in &found.people[0].methods {
        let (label, rmse) = (judged.method.label(), judged.rmse);
        println!("{label:<28} {rmse:5.1} mg/dL over five hours");
    }
    Ok(())
}
