//! What exact courses would name in the worlds of a check.
//!
//! Worked out after the labels were opened, from the worlds themselves: no diagnosis sees any of it.

use anyhow::{Context as _, Result};
use contract::blind_check::ExactCourse;
use effects::{Card, EffectId, Port, Prior, Relations};
use gap::{DiagnosisConfig, GapError, Ode, ceiling};
use world::blind::{PlannedEffect, RealisedWorld};

use crate::Progress;
use crate::stages::sealed::SealedCheck;

/// Effects that do not act whose courses are tried in each world without an effect.
const IDLE: usize = 3;
/// Mean absolute course below which an effect finds no occasion in a world, mg/dL.
const NO_OCCASION: f64 = 0.25;

/// The evidence of exact courses: of the effect in worlds with one effect, and of some effects that do not act in
/// worlds without any. `worlds` stand in the order of the check.
pub(super) fn exact_courses(
    sealed: &SealedCheck<'_>,
    worlds: &[RealisedWorld],
) -> Result<Vec<ExactCourse>> {
    let mut nulls = 0;
    let asked: Vec<(usize, Vec<PlannedEffect>)> = worlds
        .iter()
        .enumerate()
        .filter_map(|(index, world)| match world.effects.as_slice() {
            [] => {
                nulls += 1;
                Some((index, idle(nulls - 1)))
            }
            [_] => Some((index, Vec::new())),
            _ => None,
        })
        .collect();
    let progress = Progress::begin("ceiling", asked.len());
    let courses = progress.each(asked.len(), |place| {
        let (index, idle) = &asked[place];
        let id = sealed.id(*index);
        of_world(&id, &worlds[*index], idle).with_context(|| format!("ceiling of world {id}"))
    })?;
    progress.finish(&format!("{} worlds", asked.len()));
    Ok(courses.into_iter().flatten().collect())
}

/// The effects that are tried in one null world: each in turn.
fn idle(null: usize) -> Vec<PlannedEffect> {
    let all: Vec<PlannedEffect> = PlannedEffect::all().filter(|e| e.in_library()).collect();
    (0..IDLE).map(|k| all[(IDLE * null + k) % all.len()]).collect()
}

fn of_world(id: &str, world: &RealisedWorld, idle: &[PlannedEffect]) -> Result<Vec<ExactCourse>> {
    let lived = world.clone().live()?;
    let cohort = lived.cohort();
    let mut courses = lived.exact_courses(&cohort, idle)?;
    courses.retain(|course| course.acts || course.size() >= NO_OCCASION);
    let library = effects::library();
    let asked = courses
        .iter()
        .map(|course| {
            let card = card(course.effect)
                .with_context(|| format!("no port is that of {}", course.effect.name()))?;
            Ok(ceiling::ExactCourse { card, people: course.people.clone() })
        })
        .collect::<Result<Vec<_>>>()?;
    let config = DiagnosisConfig::working();
    let found: Vec<(f64, f64)> =
        match ceiling::exact_course_evidence(&cohort, &asked, &library, &Ode, &config) {
            Ok(found) => found.into_iter().map(|found| (found.gain, found.amplitude)).collect(),
            // A diagnosis would fail, too: nothing is above a bar.
            Err(GapError::NobodyLeft { .. }) => Vec::new(),
            Err(error) => return Err(error.into()),
        };
    let rows = courses.iter().enumerate().map(|(index, course)| {
        let (gain_nats, amplitude) = found.get(index).copied().unzip();
        let effect = course.effect.name().to_owned();
        ExactCourse { id: id.to_owned(), effect, acts: course.acts, gain_nats, amplitude }
    });
    Ok(rows.collect())
}

/// The card of an effect. One outside the library has none of its own: nothing rivals it, and people differ in it by
/// half.
fn card(effect: PlannedEffect) -> Option<Card> {
    if let Some(known) = effects::find(effect.name()) {
        return Some(known.card());
    }
    Some(Card {
        id: EffectId::new(effect.name()),
        port: Port::from_name(effect.port().name())?,
        summary: "an effect outside the library",
        size_at_one: "as it acts in its world",
        source: "its world",
        signature: "its exact course",
        channels: &[],
        confusable_with: &[],
        relations: Relations::USUAL,
        prior: Prior { median: 1.0, log_sd: 0.5, largest: 3.0 },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use gap::Diagnoser;
    use world::blind::{Nuisances, Plan, PlannedWorld, Variation};
    use world::{Effect, Generator, OutsideEffect};

    fn planned(effects: Vec<(PlannedEffect, f64)>, generator: Generator) -> RealisedWorld {
        let drawn = Plan { nulls: 1, ..Plan::check(0, 0) }.worlds(1).swap_remove(0);
        let nuisances = Nuisances::default();
        let variation = Variation::Narrow;
        let (people, days) = (3, 7);
        let drawn =
            PlannedWorld { effects, generator, nuisances, variation, people, days, ..drawn };
        drawn.realise().expect("a world").world
    }

    #[test]
    fn the_exact_course_gains_at_least_what_the_library_does() {
        for (effect, generator) in [
            (Effect::Dawn, Generator::Hovorka),
            (Effect::SetAgeing, Generator::Padova),
            (Effect::SlowMeals, Generator::Padova),
        ] {
            let effect = PlannedEffect::Named(effect);
            let world = planned(vec![(effect, 10.0)], generator);
            let [exact] = &of_world("world_0001", &world, &[]).expect("evidence")[..] else {
                panic!("one course")
            };
            let cohort = world.clone().live().expect("days").cohort();
            let (library, config) = (effects::library(), DiagnosisConfig::working());
            let answer = Diagnoser::new(&library, &config).run(&cohort, 1).expect("an answer");
            let library = answer.candidates.iter().find(|c| c.effect == effect.name());
            let share = exact.amplitude.expect("an estimate");
            let (exact, library) =
                (exact.gain_nats.expect("a gain"), library.map_or(0.0, |c| c.gain_nats));
            // One nat of room: folds of one day choose shapes and amplitudes each on its own.
            assert!(exact > library - 1.0, "{}: {exact} {library}", effect.name());
            assert!(exact > 4.0, "{}: {exact}", effect.name());
            // All of the course is there; filter and calibration have taken up to half of it.
            assert!((0.4..1.5).contains(&share), "{}: {share}", effect.name());
        }
    }

    #[test]
    fn the_exact_course_of_an_effect_outside_the_library_is_found() {
        let effect = PlannedEffect::Outside(OutsideEffect::Caffeine);
        let world = planned(vec![(effect, 15.0)], Generator::Hovorka);
        let [exact] = &of_world("world_0001", &world, &[]).expect("evidence")[..] else {
            panic!("one course")
        };
        assert_eq!((exact.effect.as_str(), exact.acts), ("caffeine", true));
        assert!(exact.gain_nats.is_some_and(|gain| gain > 4.0), "{exact:?}");
        let all = PlannedEffect::all().filter_map(card).count();
        assert_eq!(all, PlannedEffect::all().count());
    }

    #[test]
    fn the_course_of_an_effect_that_does_not_act_gains_next_to_nothing() {
        for generator in Generator::ALL {
            let world = planned(Vec::new(), generator);
            let tried = [Effect::Dawn, Effect::SetAgeing, Effect::SlowMeals, Effect::Exercise];
            let found =
                of_world("world_0001", &world, &tried.map(PlannedEffect::Named)).expect("evidence");
            assert_eq!(found.len(), tried.len());
            let none = |course: &ExactCourse| course.gain_nats.is_some_and(|gain| gain < 4.0);
            assert!(found.iter().all(|course| !course.acts && none(course)), "{found:?}");
        }
    }
}
