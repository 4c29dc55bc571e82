//! Thresholds for worlds of narrow variation: a test of what an effect does to a finding needs people who differ in
//! little else, and thresholds that were fixed on such people.

use std::sync::LazyLock;

use cohort::Cohort;
use gap::{Diagnoser, DiagnosisConfig, Evidence, Thresholds};
use rayon::prelude::*;
use world::blind::{Nuisances, Plan, PlannedWorld, Variation};
use world::{Generator, VirtualPerson};

/// Null worlds of each of the two hands whose people the tests diagnose.
const NULLS: usize = 12;
const PEOPLE: usize = 5;
const DAYS: usize = 14;
/// Apart from the seeds of every test.
const SEED: u64 = 77_041;

/// The settings in use, with thresholds fixed on null worlds of narrow variation, other people than any test's.
pub(crate) fn config() -> DiagnosisConfig {
    DiagnosisConfig { thresholds: THRESHOLDS.clone(), ..DiagnosisConfig::working() }
}

static THRESHOLDS: LazyLock<Thresholds> = LazyLock::new(|| {
    let nulls = Plan { nulls: 2 * NULLS, ..Plan::check(0, 0) }.worlds(SEED);
    let evidence: Vec<Evidence> = nulls.into_par_iter().enumerate().map(evidence).collect();
    Thresholds::fit("24 null worlds of narrow variation", &evidence)
});

fn evidence((index, drawn): (usize, PlannedWorld)) -> Evidence {
    let generator = [Generator::Hovorka, Generator::Padova][index % 2];
    let nuisances = Nuisances::default();
    let variation = Variation::Narrow;
    let world =
        PlannedWorld { generator, people: PEOPLE, days: DAYS, nuisances, variation, ..drawn };
    let world = world.realise().expect("a world");
    let lived = |person: &VirtualPerson| person.live(world.planned.calendar());
    let people = world.people.iter().map(|p| lived(p).map(|days| days.recorded));
    let people = people.collect::<Result<_, _>>().expect("bodies that live");
    let (library, config) = (effects::library(), DiagnosisConfig::working());
    let diagnosis = Diagnoser::new(&library, &config).by_thresholds().run(&Cohort { people }, SEED);
    diagnosis.expect("a diagnosis").evidence
}
