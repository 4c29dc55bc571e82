//! Which worlds a plan holds.

use chrono::{NaiveDate, TimeDelta};
use rand::seq::SliceRandom as _;
use rand::{Rng, RngExt};

use super::nuisances::Nuisances;
use super::planned_effect::PlannedEffect;
use super::streams::{Purpose, stream};
use crate::effects::{Effect, OutsideEffect};
use crate::generator::Generator;
use crate::therapy::Regime;

/// Mean absolute shifts of glucose that single effects shall cause, mg/dL.
pub const SHIFTS: [f64; 4] = [2.5, 5.0, 10.0, 15.0];
/// Shifts of each of two effects, and of effects outside the library: those that a diagnosis can be
/// expected to find.
const LARGER_SHIFTS: [f64; 3] = [5.0, 10.0, 15.0];
/// Share of worlds whose people inject.
const INJECTIONS: f64 = 0.2;
/// Numbers of people.
pub const PEOPLE: [usize; 3] = [3, 5, 10];
/// Numbers of days.
pub const DAYS: [usize; 3] = [7, 14, 28];
/// Separates the seeds of the worlds that train a posterior from those of a check.
const TRAINING: u64 = 0x7472_6169_6e69_6e67;
/// Days on which a record may begin: two years from 2023 on.
const FIRST_DAYS: i64 = 730;

/// The purpose of a plan's worlds. The same seed gives other worlds for another purpose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// A diagnosis is tested on them.
    Check,
    /// They train a posterior.
    Training,
}

/// How many worlds of which kind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plan {
    /// Their purpose.
    pub role: Role,
    /// Worlds with one effect of the library.
    pub singles: usize,
    /// Worlds with two effects of the library.
    pub pairs: usize,
    /// Worlds with an effect outside the library.
    pub outside: usize,
    /// Worlds without an effect.
    pub nulls: usize,
    /// Generators, used in turn.
    pub generators: Vec<Generator>,
    /// How much varies in everyday life, and which forms effects take.
    pub variation: Variation,
}

/// A world to be made.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedWorld {
    /// Seed of its people.
    pub seed: u64,
    /// What acts, with the mean absolute shift of glucose that it shall cause, mg/dL.
    pub effects: Vec<(PlannedEffect, f64)>,
    /// Which bodies.
    pub generator: Generator,
    /// How basal insulin is decided.
    pub regime: Regime,
    /// Number of people.
    pub people: usize,
    /// Days of each, before nuisances.
    pub days: usize,
    /// First day of the record.
    pub start: NaiveDate,
    /// What is missing from the record.
    pub nuisances: Nuisances,
    /// How much varies in everyday life, and which forms effects take.
    pub variation: Variation,
}

/// How much varies in everyday life, and which forms effects take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variation {
    /// As in the people of the embedded cohort, with typical forms.
    Narrow,
    /// From wide priors, with forms of the world's own.
    Wide,
}

impl Plan {
    /// A check of `worlds` worlds in which something acts, in the proportions 40 : 15 : 15 of one
    /// effect, two effects and effects outside the library, and `nulls` in which nothing does. All
    /// generators are used in turn.
    #[must_use]
    pub fn check(worlds: usize, nulls: usize) -> Self {
        // Rounded; of three worlds each kind gets one.
        let outside = (worlds * 15 + 35) / 70;
        let pairs = outside;
        Self {
            role: Role::Check,
            singles: worlds - pairs - outside,
            pairs,
            outside,
            nulls,
            generators: Generator::ALL.to_vec(),
            variation: Variation::Wide,
        }
    }

    /// As [`Self::check`]: worlds of all generators that train a posterior.
    #[must_use]
    pub fn training(worlds: usize, nulls: usize) -> Self {
        Self { role: Role::Training, ..Self::check(worlds, nulls) }
    }

    /// Draws the worlds, in an order that does not reveal what acts.
    ///
    /// Single effects are balanced over the library, and within an effect over shifts and
    /// generators; the rest is drawn.
    #[must_use]
    pub fn worlds(&self, master_seed: u64) -> Vec<PlannedWorld> {
        self.worlds_with(&[], master_seed)
    }

    /// As [`Self::worlds`], with `effects` and their shifts, mg/dL, in each of the `nulls`. Who wears a
    /// pump follows from what acts: an effect on infusion sets needs one.
    #[must_use]
    pub fn worlds_with(
        &self,
        effects: &[(PlannedEffect, f64)],
        master_seed: u64,
    ) -> Vec<PlannedWorld> {
        let master_seed = match self.role {
            Role::Check => master_seed,
            Role::Training => master_seed ^ TRAINING,
        };
        let mut rng = stream(master_seed, Purpose::Plan, 0);
        let truths = self
            .single_effects(&mut rng)
            .into_iter()
            .chain(self.two_effects(&mut rng))
            .chain(outside_effects(self.outside, &mut rng))
            .chain((0..self.nulls).map(|index| (effects.to_vec(), index)));
        let mut worlds: Vec<PlannedWorld> = truths
            .enumerate()
            .map(|(item, (effects, turn))| self.world(master_seed, item, effects, turn))
            .collect();
        worlds.shuffle(&mut stream(master_seed, Purpose::Order, 0));
        worlds
    }

    /// What is drawn for world `item` whatever acts in it.
    fn world(
        &self,
        master_seed: u64,
        item: usize,
        effects: Vec<(PlannedEffect, f64)>,
        turn: usize,
    ) -> PlannedWorld {
        let mut rng = stream(master_seed, Purpose::Plan, item + 1);
        let people = PEOPLE[rng.random_range(0..PEOPLE.len())];
        let regime = if rng.random_bool(0.5) { Regime::OpenLoopPump } else { Regime::Aid };
        let injects = stream(master_seed, Purpose::Injections, item).random_bool(INJECTIONS);
        let regime = if injects && !needs_a_set(&effects) { Regime::Mdi } else { regime };
        let of_turn = self.generators.get(turn % self.generators.len().max(1));
        let from = NaiveDate::from_ymd_opt(2023, 1, 1).expect("a date of the calendar");
        PlannedWorld {
            // 53 bits: every reader of JSON represents such a number exactly.
            seed: rng.random::<u64>() >> 11,
            effects,
            generator: of_turn.copied().unwrap_or(Generator::Hovorka),
            regime,
            people,
            days: DAYS[rng.random_range(0..DAYS.len())],
            start: from + TimeDelta::days(rng.random_range(0..FIRST_DAYS)),
            nuisances: Nuisances::sample(people, &mut rng),
            variation: self.variation,
        }
    }

    /// Passes through the library. In each pass an effect gets another shift, and when a shift
    /// recurs, another generator.
    fn single_effects(&self, rng: &mut impl Rng) -> Vec<Truth> {
        let mut order = Effect::ALL;
        order.shuffle(rng);
        let offsets = order.map(|_| rng.random_range(0..SHIFTS.len()));
        (0..self.singles)
            .map(|k| {
                let (pass, place) = (k / order.len(), k % order.len());
                let shift = SHIFTS[(pass + offsets[place]) % SHIFTS.len()];
                let turn = pass + pass / SHIFTS.len() + place;
                (vec![(PlannedEffect::Named(order[place]), shift)], turn)
            })
            .collect()
    }

    fn two_effects(&self, rng: &mut impl Rng) -> Vec<Truth> {
        (0..self.pairs)
            .map(|turn| {
                let mut effects = Effect::ALL;
                effects.shuffle(rng);
                let two = effects.into_iter().take(2);
                (two.map(|e| (PlannedEffect::Named(e), larger_shift(rng))).collect(), turn)
            })
            .collect()
    }
}

fn outside_effects(worlds: usize, rng: &mut impl Rng) -> Vec<Truth> {
    let mut order = OutsideEffect::ALL;
    order.shuffle(rng);
    (0..worlds)
        .map(|k| {
            let (pass, place) = (k / order.len(), k % order.len());
            let effect = PlannedEffect::Outside(order[place]);
            (vec![(effect, larger_shift(rng))], pass + place)
        })
        .collect()
}

/// What acts, with a number that selects the generator.
type Truth = (Vec<(PlannedEffect, f64)>, usize);

/// Whether one of the effects acts through infusion sets.
fn needs_a_set(effects: &[(PlannedEffect, f64)]) -> bool {
    effects.iter().any(|(effect, _)| {
        matches!(
            effect,
            PlannedEffect::Named(Effect::SetAgeing | Effect::SetFailure)
                | PlannedEffect::Outside(OutsideEffect::HardenedSites)
        )
    })
}

fn larger_shift(rng: &mut impl Rng) -> f64 {
    LARGER_SHIFTS[rng.random_range(0..LARGER_SHIFTS.len())]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::{BTreeMap, BTreeSet};

    #[test]
    fn worlds_have_the_planned_proportions() {
        let plan = Plan::check(252, 150);
        assert_eq!((plan.singles, plan.pairs, plan.outside, plan.nulls), (144, 54, 54, 150));
        let worlds = plan.worlds(3);
        assert_eq!(worlds.len(), 402);
        assert_eq!(worlds.iter().filter(|w| w.effects.is_empty()).count(), 150);
        assert_eq!(worlds.iter().filter(|w| w.effects.len() == 2).count(), 54);
        for few in 0..9 {
            let plan = Plan::check(few, 0);
            assert_eq!(plan.singles + plan.pairs + plan.outside, few);
        }
    }

    #[test]
    fn each_effect_meets_each_shift_once_from_each_generator() {
        let plan = Plan { pairs: 0, outside: 0, nulls: 0, ..Plan::check(504, 0) };
        let mut cells: BTreeMap<(PlannedEffect, u64, Generator), usize> = BTreeMap::new();
        for world in plan.worlds(5) {
            let (effect, shift) = world.effects[0];
            *cells.entry((effect, shift.to_bits(), world.generator)).or_default() += 1;
        }
        assert_eq!(cells.len(), Effect::ALL.len() * SHIFTS.len() * Generator::ALL.len());
        assert!(cells.values().all(|count| *count == 1));
    }

    #[test]
    fn a_plan_is_its_seed_and_nothing_else() {
        let plan = Plan::check(28, 12);
        assert_eq!(plan.worlds(1), plan.worlds(1));
        assert_ne!(plan.worlds(1), plan.worlds(2));
        let narrow = Plan { variation: Variation::Narrow, ..plan.clone() }.worlds(1);
        assert!(narrow.iter().all(|world| world.variation == Variation::Narrow));
        assert!(narrow.iter().zip(plan.worlds(1)).all(|(a, b)| a.seed == b.seed));
        let training = Plan::training(28, 12);
        assert!(training.worlds(1).iter().zip(plan.worlds(1)).all(|(a, b)| a.seed != b.seed));
        let seeds: BTreeSet<u64> = plan.worlds(1).iter().map(|w| w.seed).collect();
        assert_eq!(seeds.len(), 40);
    }

    #[test]
    fn nobody_injects_where_an_effect_acts_through_sets() {
        let plan = Plan { nulls: 60, ..Plan::check(0, 0) };
        let who_injects = |effect| -> Vec<bool> {
            let worlds = plan.worlds_with(&[(PlannedEffect::Named(effect), 10.0)], 1);
            worlds.iter().map(|world| world.regime == Regime::Mdi).collect()
        };
        let nulls: Vec<bool> =
            plan.worlds(1).iter().map(|world| world.regime == Regime::Mdi).collect();
        assert!(nulls.contains(&true));
        assert_eq!(who_injects(Effect::Dawn), nulls);
        for effect in [Effect::SetAgeing, Effect::SetFailure] {
            assert!(!who_injects(effect).contains(&true), "{}", effect.name());
        }
    }

    #[test]
    fn two_effects_differ() {
        for world in Plan::check(140, 60).worlds(8) {
            if let [(one, _), (other, _)] = world.effects[..] {
                assert_ne!(one, other);
            }
        }
    }

    #[test]
    fn the_order_does_not_tell_what_acts() {
        let nulls: Vec<usize> = Plan::check(200, 200)
            .worlds(11)
            .iter()
            .enumerate()
            .filter(|(_, world)| world.effects.is_empty())
            .map(|(index, _)| index)
            .collect();
        let mean = nulls.iter().sum::<usize>() as f64 / nulls.len() as f64;
        // Middle 199.5; the mean of half of 400 positions drawn at random has a SD of 5.8.
        assert!((mean - 199.5).abs() < 20.0, "{mean}");
    }
}
