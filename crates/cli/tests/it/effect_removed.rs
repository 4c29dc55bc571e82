//! A finding lives and dies with its effect.
//!
//! The same people by the same chance live with an effect, with half and twice of it, and without it. The diagnosis in use
//! must name it where it acts and not where it does not, and must find it the more probable the stronger it is; adding it to the
//! plant must lower the error on held-out days. Some effects always run; all of the lists, on two hands, where `T1D_SLOW` is
//! set.
//!
//! Not in the lists, because the posterior does not name them in these worlds at 12 to 15 mg/dL: `set_ageing`,
//! `insulin_absorption` (the random effect), `sleep_loss`, `slow_meals`. `alcohol` and `set_failure` are named, and no event of
//! theirs is found, so that no error falls; the odds of `sensor_lag` stop growing at its full size.

use chrono::NaiveDate;
use cohort::Cohort;
use gap::Diagnosis;
use gap::{Diagnoser, DiagnosisConfig};
use rayon::prelude::*;
use world::blind::{Nuisances, PlannedEffect, PlannedWorld, RealisedWorld, Variation};
use world::{Amplitudes, Effect, Generator, Regime, VirtualPerson};

/// Environment variable that switches the slow tests on.
const SWITCH: &str = "T1D_SLOW";
const PEOPLE: usize = 5;
const DAYS: usize = 14;
/// Seed of the people and of the bootstrap.
const SEED: u64 = 810_337_201;
/// Of the amplitude at which the effect must be named; 0 is the diagnosis without it.
const SHARES: [f64; 2] = [0.5, 2.0];
/// Difference of two log odds that tells nothing: odds of 1 to 2.7.
const TIE: f64 = 1.0;
/// Horizons at one of which the held-out error must fall, min.
const HORIZONS: [u32; 2] = [60, 300];

/// A finding to be made: whose bodies, what acts, and how far it moves glucose on average, mg/dL.
type Case = (Generator, Effect, f64);

/// Cases that always run.
const QUICK: [Case; 3] = [
    (Generator::Hovorka, Effect::Exercise, 5.0),
    (Generator::Hovorka, Effect::MissedMeals, 12.0),
    (Generator::Padova, Effect::Dawn, 12.0),
];
/// The other cases. Rescue carbohydrate is 4.5 mg/dL in these people if all of it is missing from the log; at 2.5 and 3.5
/// its finding rests on one person, and gets no name. Missed meals of 8 mg/dL are already as good as certain.
const SLOW: [Case; 5] = [
    (Generator::Hovorka, Effect::Dawn, 12.0),
    (Generator::Hovorka, Effect::UnloggedRescueCarbs, 4.0),
    (Generator::Hovorka, Effect::CompressionLows, 2.0),
    (Generator::Padova, Effect::Exercise, 5.0),
    (Generator::Padova, Effect::MissedMeals, 12.0),
];

/// The people of a generator with an effect, or none, as large as planned.
fn realised(generator: Generator, effect: Option<(Effect, f64)>) -> RealisedWorld {
    let planned = PlannedWorld {
        seed: SEED,
        effects: effect
            .map(|(effect, shift)| (PlannedEffect::Named(effect), shift))
            .into_iter()
            .collect(),
        generator,
        regime: match generator {
            Generator::Hovorka => Regime::Aid,
            Generator::Padova | Generator::Minimal | Generator::Saturating => Regime::OpenLoopPump,
        },
        people: PEOPLE,
        days: DAYS,
        start: NaiveDate::from_ymd_opt(2024, 9, 2).expect("a date"),
        nuisances: Nuisances::default(),
        variation: Variation::Narrow,
    };
    let world = planned.realise().expect("bodies that can live with it").world;
    // Otherwise these would be other people than those without the effect.
    assert_eq!(world.planned.seed, SEED, "a body failed, or found no occasion for the effect");
    world
}

/// The diagnosis of a world's people with `share` of their effect.
fn diagnosed(world: &RealisedWorld, share: f64) -> Diagnosis {
    let scaled = |person: &VirtualPerson| {
        let amplitudes = Effect::ALL.into_iter().fold(Amplitudes::NONE, |all, effect| {
            all.with(effect, share * person.amplitudes.of(effect))
        });
        VirtualPerson { amplitudes, ..person.clone() }
    };
    let people = world
        .people
        .par_iter()
        .map(|person| scaled(person).live(world.planned.calendar()).map(|days| days.recorded))
        .collect::<Result<_, _>>()
        .expect("bodies that can live with it");
    let (library, config) = (effects::library(), DiagnosisConfig::working());
    Diagnoser::new(&library, &config).run(&Cohort { people }, SEED).expect("a diagnosis")
}

fn named(diagnosis: &Diagnosis) -> Vec<&str> {
    diagnosis.effects.iter().map(|found| found.effect.as_str()).collect()
}

/// Logarithm of the odds of an effect.
fn log_odds(diagnosis: &Diagnosis, effect: Effect) -> f64 {
    let own = diagnosis.candidates.iter().find(|candidate| candidate.effect == effect.name());
    own.map_or(f64::NEG_INFINITY, |candidate| {
        (candidate.probability / (1.0 - candidate.probability)).ln()
    })
}

/// Whether each gain is above the one before it; one tie is allowed.
fn grows(gains: &[f64]) -> bool {
    let falls = gains.windows(2).any(|pair| pair[1] < pair[0] - TIE);
    let ties = gains.windows(2).filter(|pair| (pair[1] - pair[0]).abs() <= TIE).count();
    !falls && ties <= 1
}

/// Says what is wrong with the findings; nothing if nothing is.
fn faults(cases: &[Case]) -> Vec<String> {
    let mut faults = Vec::new();
    for generator in Generator::ALL {
        let without = diagnosed(&realised(generator, None), 0.0);
        for (_, effect, shift) in cases.iter().filter(|case| case.0 == generator) {
            let world = realised(generator, Some((*effect, *shift)));
            let found = diagnosed(&world, 1.0);
            let place = format!("{} in {}", effect.name(), generator.name());
            if !named(&found).contains(&effect.name()) {
                faults.push(format!("{place} is not named, but {:?}", named(&found)));
            }
            if named(&without).contains(&effect.name()) {
                faults.push(format!("{place} is named where it is not"));
            }
            let [half, twice] = SHARES.map(|share| log_odds(&diagnosed(&world, share), *effect));
            let gains = [log_odds(&without, *effect), half, log_odds(&found, *effect), twice];
            if !grows(&gains) {
                faults.push(format!("{place}: its odds do not grow with it, {gains:?}"));
            }
            let changes: Vec<(u32, f64)> =
                found.how_far.horizons.iter().map(|h| (h.minutes, h.difference.value)).collect();
            if !changes.iter().any(|(minutes, change)| HORIZONS.contains(minutes) && *change < 0.0)
            {
                faults.push(format!("{place}: held-out error does not fall, {changes:?}"));
            }
        }
    }
    faults
}

#[test]
fn a_finding_lives_and_dies_with_its_effect() {
    assert_eq!(faults(&QUICK), Vec::<String>::new());
}

#[test]
fn so_do_the_other_findings() {
    if std::env::var_os(SWITCH).is_none() {
        #[expect(clippy::print_stderr, reason = "a skipped test must say that it was skipped")]
        {
            eprintln!("skipped: set {SWITCH}=1 for the other findings");
        }
        return;
    }
    assert_eq!(faults(&SLOW), Vec::<String>::new());
}

#[test]
fn evidence_grows_or_does_not() {
    assert!(grows(&[0.0, 3.0, 20.0, 60.0]));
    assert!(grows(&[0.0, 0.0, 5.0, 25.0]));
    assert!(!grows(&[0.0, 0.0, 0.0, 25.0]));
    assert!(!grows(&[0.0, 130.0, 133.0, 87.0]));
}
