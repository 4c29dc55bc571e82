//! Effects that no library of a diagnosis names. It should call them unknown, at the right port.
//!
//! As for the named effects, each has a file with its size at amplitude 1 and its source.

mod caffeine;
mod event;
mod fatty_evenings;
mod hardened_sites;
mod hot_bath;
mod illness;
mod late_protein;
mod menstrual_cycle;
mod paracetamol;
mod slow_stomach;
mod stress;

pub use event::Event;

use super::{Amplitudes, Condition, Port};
use crate::behaviour::Life;
use crate::stream::{Concept, stream};

/// An effect outside the library.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum OutsideEffect {
    /// Hours of stress at any time: more endogenous glucose.
    Stress,
    /// Hot baths in the evening: insulin is absorbed faster.
    HotBath,
    /// High glucose slows the stomach.
    SlowStomach,
    /// Weeks of lower insulin action in a monthly cycle.
    MenstrualCycle,
    /// Two or three days of low insulin action.
    Illness,
    /// Glucose made of the protein of dinners, hours later.
    LateProtein,
    /// Insulin acts less on the liver in the night after fat evenings.
    FattyEvenings,
    /// Sites that lose a part of the insulin for the whole life of a set.
    HardenedSites,
    /// A drug that sensors take for glucose.
    Paracetamol,
    /// Morning coffee: lower insulin action for hours.
    Caffeine,
}

impl OutsideEffect {
    /// Every effect outside the library.
    pub const ALL: [Self; 10] = [
        Self::Stress,
        Self::HotBath,
        Self::SlowStomach,
        Self::MenstrualCycle,
        Self::Illness,
        Self::LateProtein,
        Self::FattyEvenings,
        Self::HardenedSites,
        Self::Paracetamol,
        Self::Caffeine,
    ];

    /// The name that labels use.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stress => "stress",
            Self::HotBath => "hot_bath",
            Self::SlowStomach => "slow_stomach",
            Self::MenstrualCycle => "menstrual_cycle",
            Self::Illness => "illness",
            Self::LateProtein => "late_protein",
            Self::FattyEvenings => "fatty_evenings",
            Self::HardenedSites => "hardened_sites",
            Self::Paracetamol => "paracetamol",
            Self::Caffeine => "caffeine",
        }
    }

    /// Where it acts.
    #[must_use]
    pub const fn port(self) -> Port {
        match self {
            Self::Stress => Port::Egp,
            Self::HotBath => Port::InsulinAbsorption,
            Self::SlowStomach => Port::GutAbsorption,
            Self::MenstrualCycle | Self::Illness | Self::Caffeine => Port::InsulinAction,
            Self::LateProtein => Port::GlucoseFlux,
            Self::FattyEvenings => Port::InsulinActionLiver,
            Self::HardenedSites => Port::InsulinInput,
            Self::Paracetamol => Port::Sensor,
        }
    }

    /// What an amplitude of 1 does, in one line for the labels of a world.
    #[must_use]
    pub const fn size_at_one(self) -> &'static str {
        match self {
            Self::Stress => "endogenous glucose production 35 % higher for 6 to 10 h, 3 days in 10",
            Self::HotBath => {
                "time of insulin absorption 45 % shorter for 1 to 2 h, 6 evenings in 10"
            }
            Self::SlowStomach => {
                "time of meal absorption 35 % longer per 100 mg/dL above 140 mg/dL"
            }
            Self::MenstrualCycle => "insulin action 20 % lower for 12 of 28 days",
            Self::Illness => "insulin action 35 % lower for 2 to 3 days, twice in four weeks",
            Self::LateProtein => {
                "0.006 mmol/kg/min of glucose from 1.5 to 5.5 h after four dinners in ten"
            }
            Self::FattyEvenings => {
                "insulin action on the liver 40 % lower for 8 to 13 h after 35 % of evenings"
            }
            Self::HardenedSites => "22 % of the insulin lost from three sets in ten",
            Self::Paracetamol => "readings up to 50 mg/dL too high for 6 h on a quarter of days",
            Self::Caffeine => "insulin action 24 % lower for 5 to 8 h after waking, 9 days in 10",
        }
    }

    /// When it would act in a life.
    fn events(self, life: &Life, rng: &mut rand_chacha::ChaCha8Rng) -> Vec<Event> {
        match self {
            Self::Stress => stress::events(life, rng),
            Self::HotBath => hot_bath::events(life, rng),
            Self::SlowStomach => slow_stomach::events(life),
            Self::MenstrualCycle => menstrual_cycle::events(life, rng),
            Self::Illness => illness::events(life, rng),
            Self::LateProtein => late_protein::events(life, rng),
            Self::FattyEvenings => fatty_evenings::events(life, rng),
            Self::HardenedSites => hardened_sites::events(life, rng),
            Self::Paracetamol => paracetamol::events(life, rng),
            Self::Caffeine => caffeine::events(life, rng),
        }
    }

    /// Acts on the body with a strength: amplitude times the course of an event.
    fn act(self, condition: &mut Condition, strength: f64) {
        match self {
            Self::Stress => stress::act(condition, strength),
            Self::HotBath => hot_bath::act(condition, strength),
            Self::SlowStomach => slow_stomach::act(condition, strength),
            Self::MenstrualCycle => menstrual_cycle::act(condition, strength),
            Self::Illness => illness::act(condition, strength),
            Self::LateProtein => late_protein::act(condition, strength),
            Self::FattyEvenings => fatty_evenings::act(condition, strength),
            Self::HardenedSites => hardened_sites::act(condition, strength),
            Self::Caffeine => caffeine::act(condition, strength),
            Self::Paracetamol => {} // acts on the sensor alone
        }
    }
}

/// When each effect outside the library would act in one life.
#[derive(Debug, Clone, PartialEq)]
pub struct Events([Vec<Event>; OutsideEffect::ALL.len()]);

impl Events {
    /// Draws the events of a life of person `person` of the world with this seed.
    #[must_use]
    pub(super) fn sample(life: &Life, seed: u64, person: usize) -> Self {
        let mut rng = stream(seed, person, Concept::Outside);
        let mut events = std::array::from_fn(|_| Vec::new());
        for effect in OutsideEffect::ALL {
            events[effect as usize] = effect.events(life, &mut rng);
        }
        Self(events)
    }

    /// The events of one effect.
    #[must_use]
    pub fn of(&self, effect: OutsideEffect) -> &[Event] {
        &self.0[effect as usize]
    }
}

/// Lets the effects act on the body's course.
pub(super) fn act(course: &mut [Condition], events: &Events, amplitudes: &Amplitudes) {
    for effect in OutsideEffect::ALL {
        let amplitude = amplitudes.of_outside(effect);
        if amplitude == 0.0 {
            continue;
        }
        for event in events.of(effect) {
            for step in event.steps(course.len()) {
                effect.act(&mut course[step], amplitude * event.course(step));
            }
        }
    }
}

/// Lets the effects act on the offset of the sensor, mg/dL, one value a step.
pub(super) fn act_on_sensor(offset: &mut [f64], events: &Events, amplitudes: &Amplitudes) {
    let amplitude = amplitudes.of_outside(OutsideEffect::Paracetamol);
    if amplitude == 0.0 {
        return;
    }
    for event in events.of(OutsideEffect::Paracetamol) {
        for step in event.steps(offset.len()) {
            offset[step] += paracetamol::offset(amplitude * event.course(step));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effects_stand_in_their_order_and_share_no_name_with_the_library() {
        for (index, effect) in OutsideEffect::ALL.into_iter().enumerate() {
            assert_eq!(effect as usize, index);
            assert!(crate::Effect::ALL.iter().all(|named| named.name() != effect.name()));
        }
    }

    #[test]
    fn each_acts_at_its_port_and_nowhere_else() {
        for effect in OutsideEffect::ALL {
            let drawn = Condition::AS_DRAWN;
            let mut c = drawn;
            effect.act(&mut c, 0.0);
            assert_eq!(c, drawn, "{}", effect.name());
            effect.act(&mut c, 0.7);
            let moved = [
                (Port::InsulinInput, c.bioavailability != drawn.bioavailability),
                (Port::InsulinAbsorption, c.insulin_time != drawn.insulin_time),
                (Port::InsulinAction, c.action != drawn.action),
                (Port::InsulinActionLiver, c.liver_action != drawn.liver_action),
                (Port::Egp, c.production != drawn.production),
                (
                    Port::GutAbsorption,
                    c.gut_time_per_glucose != drawn.gut_time_per_glucose
                        || c.gut_time != drawn.gut_time,
                ),
                (Port::GlucoseFlux, c.glucose_flux != drawn.glucose_flux),
            ];
            for (port, moves) in moved {
                // A lower action of insulin everywhere is named after its larger part.
                let with_liver =
                    effect.port() == Port::InsulinAction && port == Port::InsulinActionLiver;
                assert!(moves == (port == effect.port()) || with_liver, "{}", effect.name());
            }
        }
        assert!(paracetamol::offset(1.0) > 0.0);
    }
}
