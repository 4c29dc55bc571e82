//! An effect of a user's own is named where it acts, and not where it does not.
//!
//! The worlds drink coffee in their own way (`crates/world/src/effects/outside.rs`); the effect that is handed
//! to the diagnosis is that of the example (`crates/effects/examples/own_effect/caffeine.rs`). They share the name.

#[path = "../../../effects/examples/own_effect/caffeine.rs"]
mod caffeine;

use caffeine::Caffeine;
use chrono::NaiveDate;
use cohort::Cohort;
use effects::EffectId;
use gap::{Diagnoser, Diagnosis, DiagnosisConfig, GapError};
use rayon::prelude::*;
use world::blind::{Nuisances, PlannedEffect, PlannedWorld, Variation};
use world::{Amplitudes, Generator, OutsideEffect, Regime, VirtualPerson};

/// Size of the worlds, and how far coffee moves glucose there, mg/dL.
const PEOPLE: usize = 5;
const DAYS: usize = 14;
const SHIFT: f64 = 25.0;
const SEED: u64 = 810_337_201;

/// People who drink coffee, and the same people by the same chance without it.
fn with_and_without(generator: Generator, regime: Regime) -> [Cohort; 2] {
    let planned = PlannedWorld {
        seed: SEED,
        effects: vec![(PlannedEffect::Outside(OutsideEffect::Caffeine), SHIFT)],
        generator,
        regime,
        people: PEOPLE,
        days: DAYS,
        start: NaiveDate::from_ymd_opt(2024, 9, 2).expect("a date"),
        nuisances: Nuisances::default(),
        variation: Variation::Narrow,
    };
    let world = planned.realise().expect("bodies that can live with it").world;
    let calendar = world.planned.calendar();
    let lived = |person: VirtualPerson| {
        person.live(calendar).map(|days| days.recorded).expect("a body that can live with it")
    };
    let without =
        |person: &VirtualPerson| VirtualPerson { amplitudes: Amplitudes::NONE, ..person.clone() };
    [
        Cohort { people: world.people.par_iter().cloned().map(lived).collect() },
        Cohort { people: world.people.par_iter().map(without).map(lived).collect() },
    ]
}

fn library() -> Vec<Box<dyn effects::Effect>> {
    let mut library = effects::library();
    library.push(Box::new(Caffeine { habits: vec![vec![7.5], vec![7.5, 13.5]] }));
    library
}

fn diagnosed(cohort: &Cohort) -> Diagnosis {
    let (library, config) = (library(), DiagnosisConfig::working());
    Diagnoser::new(&library, &config).run(cohort, SEED).expect("a diagnosis")
}

fn named(diagnosis: &Diagnosis) -> Vec<&str> {
    diagnosis.effects.iter().map(|found| found.effect.as_str()).collect()
}

#[test]
fn it_is_named_where_it_explains_most_and_nowhere_without_it() {
    let (open, closed) = (Regime::OpenLoopPump, Regime::Aid);
    let (hovorka, padova) = (Generator::Hovorka, Generator::Padova);
    let mut times_named = 0;
    for (generator, regime) in
        [(hovorka, open), (hovorka, closed), (padova, open), (padova, closed)]
    {
        let [with, without] = with_and_without(generator, regime);
        let found = diagnosed(&with);
        let own = found.evidence.gains["caffeine"];
        assert!(own > 20.0, "{generator:?}, {regime:?}: {own} nats");
        assert!(found.notes.iter().any(|note| note.contains("`caffeine`")), "{:?}", found.notes);
        if named(&found).first() == Some(&"caffeine") {
            times_named += 1;
            let horizons = &found.how_far.horizons;
            assert!(
                horizons.iter().any(|h| h.minutes == 300 && h.difference.value < 0.0),
                "{generator:?}, {regime:?}: {horizons:?}"
            );
        } else {
            // A pattern of insulin action over the day has nearly the course of coffee at fixed hours.
            let rival = found.evidence.gains["circadian_sensitivity"];
            assert!(rival > own - 1.0, "{generator:?}, {regime:?}: {own} and {rival} nats");
        }
        let null = diagnosed(&without);
        assert!(
            !named(&null).contains(&"caffeine"),
            "{generator:?}, {regime:?}: {:?}",
            named(&null)
        );
        assert!(null.candidates.iter().any(|candidate| candidate.effect == "caffeine"));
    }
    assert!(times_named >= 2, "named in {times_named} of 4");
}

#[test]
fn names_are_distinct_and_stand_for_nothing_else() {
    let config = DiagnosisConfig::working();
    let mut twice = library();
    twice.push(Box::new(Caffeine { habits: vec![vec![8.0]] }));
    let error = Diagnoser::new(&twice, &config).run(&Cohort::default(), SEED);
    assert_eq!(error, Err(GapError::EffectTwice { effect: EffectId::new("caffeine") }));
}
