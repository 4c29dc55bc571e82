//! A planned world with its people, the amplitudes that were found, and the days that are lived.

use cohort::Cohort;
use rand_distr::{Distribution as _, LogNormal};
use rayon::prelude::*;

use super::amplitude_search::search;
use super::plan::{PlannedWorld, Variation};
use super::planned_effect::PlannedEffect;
use super::streams::{Purpose, stream};
use crate::calendar::Calendar;
use crate::effects::Amplitudes;
use crate::error::WorldError;
use crate::virtual_person::{LivedDays, VirtualPerson};

/// Spread of the logarithm of amplitudes between people (assumed; as for the named effects).
const SPREAD: f64 = 0.25;
/// Number of other worlds drawn when the bodies of one fail, or an effect finds no occasion in it.
const ATTEMPTS: u64 = 8;
/// Below this shift an effect has found no occasion, mg/dL: nobody drank, fell ill, or wore a set
/// that failed.
const NO_OCCASION: f64 = 0.25;

/// A world and the days that its people live.
#[derive(Debug, Clone, PartialEq)]
pub struct LivedWorld {
    /// The world.
    pub world: RealisedWorld,
    /// The days of each of its people, in their order.
    days: Vec<LivedDays>,
}

/// A world that can be lived.
#[derive(Debug, Clone, PartialEq)]
pub struct RealisedWorld {
    /// The plan. The seed is that of the people; it is another one if those of the planned seed
    /// could not be drawn or gave an effect no occasion.
    pub planned: PlannedWorld,
    /// The people.
    pub people: Vec<VirtualPerson>,
    /// What acts, and how far it moves glucose.
    pub effects: Vec<RealisedEffect>,
}

/// An effect with the values that were reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RealisedEffect {
    /// The effect.
    pub effect: PlannedEffect,
    /// Mean amplitude over the people; 1 is the published size.
    pub amplitude: f64,
    /// Planned mean absolute shift of glucose, mg/dL.
    pub target: f64,
    /// Mean absolute shift of glucose over all people when it acts alone, mg/dL.
    pub achieved: f64,
    /// Whether the largest allowed amplitude falls short of the target.
    pub at_limit: bool,
    /// Its form in this world, in words; for effects of the library.
    pub form: Option<&'static str>,
}

impl PlannedWorld {
    /// The days of every person.
    #[must_use]
    pub fn calendar(&self) -> Calendar {
        Calendar::new(self.start, self.days)
    }

    /// Draws the people, finds the amplitudes, and lives the days.
    ///
    /// # Errors
    /// If no body can be drawn or simulated, from this seed and from a few others.
    pub fn realise(&self) -> Result<LivedWorld, WorldError> {
        let attempt = |attempt: u64| {
            // An odd step runs through all seeds of 53 bits.
            let step = attempt.wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let seed = self.seed.wrapping_add(step) & ((1 << 53) - 1);
            (Self { seed, ..self.clone() }).realise_once()
        };
        let vain = |lived: &LivedWorld| {
            lived.world.effects.iter().any(|found| found.achieved < NO_OCCASION)
        };
        (0..ATTEMPTS)
            .map(attempt)
            .find(|result| result.as_ref().is_ok_and(|lived| !vain(lived)))
            .unwrap_or_else(|| attempt(ATTEMPTS))
    }

    fn realise_once(&self) -> Result<LivedWorld, WorldError> {
        let draw = match self.variation {
            Variation::Narrow => VirtualPerson::sample_from,
            Variation::Wide => VirtualPerson::sample_widely,
        };
        let mut people: Vec<VirtualPerson> = (0..self.people)
            .into_par_iter()
            .map(|index| draw(self.generator, self.seed, index, self.regime))
            .collect::<Result<_, _>>()?;
        let own: Vec<Vec<f64>> = people.iter().map(|person| self.own_amplitudes(person)).collect();
        for person in &mut people {
            person.amplitudes = Amplitudes::NONE;
        }
        let calendar = self.calendar();
        let mut effects = Vec::new();
        // The days of the last effect's best trial, in which it acts alone.
        let mut alone_lived = None;
        for (place, (effect, target)) in self.effects.iter().enumerate() {
            let mut own: Vec<f64> = own.iter().map(|own| own[place]).collect();
            // The common factor is then the mean amplitude.
            let mean = own.iter().sum::<f64>() / own.len() as f64;
            own.iter_mut().for_each(|own| *own /= mean);
            // On the people's own amplitudes, when the effect acts alone.
            let found = search(*target, effect.largest_amplitude(), |factor| {
                let lived = people
                    .par_iter()
                    .zip(&own)
                    .map(|(person, own)| alone(person, *effect, factor * own, calendar))
                    .collect::<Result<Vec<(f64, LivedDays)>, WorldError>>()
                    .ok()?;
                let (shifts, days): (Vec<f64>, Vec<LivedDays>) = lived.into_iter().unzip();
                Some((shifts.iter().sum::<f64>() / shifts.len() as f64, days))
            });
            effects.push(RealisedEffect {
                effect: *effect,
                amplitude: found.factor,
                target: *target,
                achieved: found.shift,
                at_limit: found.at_limit,
                form: effect.form(&people),
            });
            for (person, own) in people.iter_mut().zip(&own) {
                person.amplitudes = effect.set(person.amplitudes, found.factor * own);
            }
            alone_lived = found.found;
        }
        let world = RealisedWorld { planned: self.clone(), people, effects };
        match alone_lived {
            Some(days) if world.effects.len() == 1 => Ok(LivedWorld { world, days }),
            // The bodies must be able to live with all effects together, or with none.
            _ => world.live(),
        }
    }

    /// How strongly each effect acts in one person, relative to others.
    fn own_amplitudes(&self, person: &VirtualPerson) -> Vec<f64> {
        let mut rng = stream(self.seed, Purpose::Amplitudes, person.index);
        let spread = LogNormal::new(0.0, SPREAD).expect("a positive spread");
        self.effects.iter().map(|_| spread.sample(&mut rng).clamp(0.55, 1.8)).collect()
    }
}

impl RealisedWorld {
    /// Lives the days, which are the same every time.
    ///
    /// # Errors
    /// If a body fails under several effects together.
    pub fn live(self) -> Result<LivedWorld, WorldError> {
        let calendar = self.planned.calendar();
        let days = self.people.par_iter().map(|person| person.live(calendar));
        let days = days.collect::<Result<_, WorldError>>()?;
        Ok(LivedWorld { world: self, days })
    }
}

impl LivedWorld {
    /// The cohort that a diagnosis gets.
    #[must_use]
    pub fn cohort(&self) -> Cohort {
        let people = self.days.iter().map(|days| days.recorded.clone()).collect();
        let mut cohort = Cohort { people };
        let planned = &self.world.planned;
        planned.nuisances.take_from(&mut cohort, planned.seed);
        cohort
    }

    /// Everybody with the days that they live.
    pub(super) fn everybody(&self) -> Vec<(&VirtualPerson, &LivedDays)> {
        self.world.people.iter().zip(&self.days).collect()
    }
}

/// Mean absolute shift of one person's glucose, mg/dL, when an effect acts and nothing else does,
/// and the days that they then live.
fn alone(
    person: &VirtualPerson,
    effect: PlannedEffect,
    amplitude: f64,
    calendar: Calendar,
) -> Result<(f64, LivedDays), WorldError> {
    let amplitudes = effect.set(Amplitudes::NONE, amplitude);
    let person = VirtualPerson { amplitudes, ..person.clone() };
    let lived = person.live(calendar)?;
    let shift = person.shift(&lived, &Amplitudes::NONE)?.0;
    if shift.is_finite() {
        return Ok((shift, lived));
    }
    let compartment = physiology::Compartment::Q1;
    Err(person.failed(ode_sim::OdeError::NonFinite { compartment }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blind::{Nuisances, Plan};
    use crate::effects::Effect;
    use crate::generator::Generator;
    use crate::therapy::Regime;
    use cohort::Channel;

    fn planned(effects: Vec<(PlannedEffect, f64)>) -> PlannedWorld {
        PlannedWorld {
            seed: 5,
            effects,
            generator: Generator::Hovorka,
            regime: Regime::OpenLoopPump,
            people: 3,
            days: 7,
            ..Plan::check(1, 0).worlds(5).swap_remove(0)
        }
    }

    #[test]
    fn the_amplitude_reaches_the_planned_shift() {
        let dawn = PlannedEffect::Named(Effect::Dawn);
        let lived = planned(vec![(dawn, 10.0)]).realise().expect("a world");
        let world = &lived.world;
        let [found] = world.effects[..] else { panic!("one effect: {:?}", world.effects) };
        // The end of the search, with all three people.
        assert!((10.0..=10.6).contains(&found.achieved), "{found:?}");
        let person = &world.people[0];
        assert!(lived == world.clone().live().expect("the same days again"));
        let shift = person.shift(&lived.days[0], &Amplitudes::NONE).expect("a shift").0;
        assert!(shift > 4.0, "{shift}");
        let mean: f64 = world.people.iter().map(|p| p.amplitudes.of(Effect::Dawn)).sum::<f64>();
        assert!((mean / 3.0 - found.amplitude).abs() < 1e-12); // rounding
    }

    #[test]
    fn an_effect_changes_values_and_nothing_that_would_give_it_away() {
        let torn =
            Nuisances { without_heart_rate: 1, gaps: true, uneven_days: true, unlogged_sets: true };
        let of = |effects| {
            let world = PlannedWorld { nuisances: torn, ..planned(effects) };
            world.realise().expect("a world").cohort()
        };
        let null = of(Vec::new());
        for effect in [Effect::MissedMeals, Effect::SensorLag, Effect::Exercise] {
            let with = of(vec![(PlannedEffect::Named(effect), 5.0)]);
            assert_ne!(with, null, "{}", effect.name());
            assert_eq!(with.people.len(), null.people.len());
            for (a, b) in with.people.iter().zip(&null.people) {
                assert_eq!((&a.id, a.weight, a.therapy), (&b.id, b.weight, b.therapy));
                assert_eq!(a.heart_rate_baseline, b.heart_rate_baseline);
                assert_eq!((a.record.start(), a.record.len()), (b.record.start(), b.record.len()));
                for channel in Channel::ALL {
                    let present = |record: &cohort::Record| -> Vec<bool> {
                        record.channel(channel).iter().map(Option::is_some).collect()
                    };
                    assert_eq!(present(&a.record), present(&b.record), "{}", channel.name());
                }
            }
        }
        let lacking = null.people.iter().filter(|p| p.heart_rate_baseline.is_none()).count();
        assert_eq!(lacking, 1);
        let sets = null.people.iter().flat_map(|p| p.record.set_change());
        assert!(sets.clone().count() > 0 && sets.flatten().next().is_none());
    }

    #[test]
    fn two_effects_act_together_and_each_is_measured_alone() {
        let two = vec![
            (PlannedEffect::Named(Effect::SetAgeing), 5.0),
            (PlannedEffect::Named(Effect::Dawn), 10.0),
        ];
        let world = planned(two).realise().expect("a world").world;
        for (found, target) in world.effects.iter().zip([5.0, 10.0]) {
            assert!((1.0..=1.06).contains(&(found.achieved / target)), "{found:?}");
        }
        let acting: Vec<&str> = world.people[1].amplitudes.acting().map(|(name, _)| name).collect();
        assert_eq!(acting, ["dawn", "set_ageing"]);
    }
}
