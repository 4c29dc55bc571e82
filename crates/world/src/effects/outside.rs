//! Effects that no library of a diagnosis names. It should call them unknown, at the right port.
//!
//! Each has a size at amplitude 1 with its source, times at which it would act, and what it does to
//! the [`Condition`] of a step (or to the sensor).

mod event;

pub use event::Event;

use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use self::event::{on_some_days, perhaps};
use super::port::effect_table;
use super::{Amplitudes, Condition};
use crate::behaviour::{Life, MealKind, Night};
use crate::stream::{Concept, stream};

effect_table! {
    /// An effect outside the library.
    OutsideEffect {
        /// Hours of stress at any time: more endogenous glucose.
        Stress: "stress", Egp,
            "endogenous glucose production 35 % higher for 6 to 10 h, 3 days in 10";
        /// Hot baths in the evening: insulin is absorbed faster.
        HotBath: "hot_bath", InsulinAbsorption,
            "time of insulin absorption 45 % shorter for 1 to 2 h, 6 evenings in 10";
        /// High glucose slows the stomach.
        SlowStomach: "slow_stomach", GutAbsorption,
            "time of meal absorption 35 % longer per 100 mg/dL above 140 mg/dL";
        /// Weeks of lower insulin action in a monthly cycle.
        MenstrualCycle: "menstrual_cycle", InsulinAction,
            "insulin action 20 % lower for 12 of 28 days";
        /// Two or three days of low insulin action.
        Illness: "illness", InsulinAction,
            "insulin action 35 % lower for 2 to 3 days, twice in four weeks";
        /// Glucose made of the protein of dinners, hours later.
        LateProtein: "late_protein", GlucoseFlux,
            "0.006 mmol/kg/min of glucose from 1.5 to 5.5 h after four dinners in ten";
        /// Insulin acts less on the liver in the night after fat evenings.
        FattyEvenings: "fatty_evenings", InsulinActionLiver,
            "insulin action on the liver 40 % lower for 8 to 13 h after 35 % of evenings";
        /// Sites that lose a part of the insulin for the whole life of a set.
        HardenedSites: "hardened_sites", InsulinInput,
            "22 % of the insulin lost from three sets in ten";
        /// A drug that sensors take for glucose.
        Paracetamol: "paracetamol", Sensor,
            "readings up to 50 mg/dL too high for 6 h on a quarter of days";
        /// Morning coffee: lower insulin action for hours.
        Caffeine: "caffeine", InsulinAction,
            "insulin action 24 % lower for 5 to 8 h after waking, 9 days in 10";
    }
}

/// Rise of the production, as a share: stress raised glucose after a meal by 27 mg/dL within two
/// hours (Wiesli et al., Diabetes Care 2005;28:1910), and adrenaline at levels of stress raises the
/// production by up to twice for an hour and by less later (Rizza et al., J Clin Invest
/// 1980;65:682).
const STRESS: f64 = 0.35;
/// Shortening of the time of insulin absorption, as a logarithm: by 45 %. A sauna raised the
/// disappearance of insulin from its site by 110 % (Koivisto, Br Med J 1980;280:1411), a hot bath
/// nearly as much (Berger et al., Diabetes Care 1982;5:77).
const HOT_BATH: f64 = 0.6;
/// Lengthening of the time of meal absorption per 100 mg/dL, as a logarithm: 35 %. With type 1
/// diabetes half of a liquid meal had left the stomach after 41 min at 144 mg/dL and after 29 min
/// at 72 mg/dL (Schvarcz et al., Gastroenterology 1997;113:60); higher glucose slows it further
/// (Fraser et al., Diabetologia 1990;33:675).
const SLOW_STOMACH: f64 = 0.30;
/// Fall of the action through the luteal phase, as a logarithm: 20 %; insulin sensitivity falls by
/// about that in women with type 1 diabetes, in some by more and in some not at all (Brown et al.,
/// J Diabetes Sci Technol 2015;9:1192).
const MENSTRUAL_CYCLE: f64 = 0.22;
/// Fall of the action, as a logarithm: 35 %. Acute infections with fever lowered the glucose that
/// insulin disposes of by half (Yki-Jarvinen et al., J Clin Endocrinol Metab 1989;69:317); these
/// are milder ones.
const ILLNESS: f64 = 0.43;
/// Glucose made of the protein of a large dinner, mmol/kg/min: over four hours this comes to 15 to
/// 20 g in an adult. Protein of 75 g beside a meal raised glucose from 150 to 300 min after it, by
/// 5 mmol/L on average (Paterson et al., Diabet Med 2017;34:851); these dinners hold about half of
/// that.
const LATE_PROTEIN: f64 = 0.006;
/// Fall of the action on the liver, as a logarithm: 40 %. Fatty acids keep insulin from suppressing
/// the production (Boden et al., Am J Physiol Endocrinol Metab 2002;283:E12), and fat dinners asked
/// for 42 % more insulin (Wolpert et al., Diabetes Care 2013;36:810).
const FATTY_EVENINGS: f64 = 0.51;
/// Loss of insulin, as a logarithm: 22 %, as after injections into lipohypertrophic tissue (Famulla
/// et al., Diabetes Care 2016;39:1486).
const HARDENED_SITES: f64 = 0.25;
/// Rise of the reading at its height, mg/dL: 61 mg/dL two hours after 1 g (Maahs et al., Diabetes
/// Care 2015;38:e158); some take less.
const PARACETAMOL: f64 = 50.0;
/// Fall of the action in the periphery, as a logarithm: 24 %. Caffeine of 5 mg/kg lowered the
/// glucose disposal of a clamp by that (Greer et al., Diabetes 2001;50:2349); two strong cups hold
/// about as much.
const CAFFEINE: f64 = 0.27;

/// Length of a cycle and of its phase of lower action, days.
const CYCLE: f64 = 28.0;
const PHASE: f64 = 12.0;
/// Days of which one begins an illness; high, so that short records hold one.
const HEALTHY_DAYS: f64 = 14.0;

impl OutsideEffect {
    /// When it would act in a life. Shares and hours without a source are assumed.
    fn events(self, life: &Life, rng: &mut ChaCha8Rng) -> Vec<Event> {
        match self {
            // Six to ten hours that begin between 7:00 and 22:00, three days in ten.
            Self::Stress => on_some_days(life, 0.3, (7.0, 22.0), (6.0, 10.0), 0.75, rng),
            // One to two hours from between 18:30 and 22:30 on, six evenings in ten.
            Self::HotBath => on_some_days(life, 0.6, (18.5, 22.5), (1.0, 2.0), 0.25, rng),
            // At all times.
            Self::SlowStomach => {
                let hours = 24.0 * life.calendar.steps() as f64 / STEPS_PER_DAY as f64;
                vec![Event { from: 0, hours, edge: 0.0, size: 1.0 }]
            }
            Self::MenstrualCycle => luteal_phases(life, rng),
            Self::Illness => illnesses(life, rng),
            // From 1.5 to 5.5 h after the dinners that are rich in protein, four in ten.
            Self::LateProtein => {
                let dinners = life.meals.iter().filter(|m| m.kind == MealKind::Dinner);
                let late = (1.5 * STEPS_PER_HOUR as f64) as i64;
                dinners
                    .filter_map(|m| perhaps(0.4, 0.75, rng, |_| (m.step as i64 + late, 4.0)))
                    .collect()
            }
            // Eight to thirteen hours from between 20:00 and 22:30 on, 35 % of evenings.
            Self::FattyEvenings => on_some_days(life, 0.35, (20.0, 22.5), (8.0, 13.0), 1.5, rng),
            Self::HardenedSites => hardened_sites(life, rng),
            // Six hours from any time awake on, a quarter of days.
            Self::Paracetamol => on_some_days(life, 0.25, (7.0, 23.0), (5.0, 7.0), 2.0, rng),
            Self::Caffeine => coffees(life, rng),
        }
    }

    /// Acts on the body with a strength: amplitude times the course of an event.
    fn act(self, condition: &mut Condition, strength: f64) {
        match self {
            Self::Stress => condition.production *= 1.0 + STRESS * strength,
            // To a fifth at most.
            Self::HotBath => condition.insulin_time *= (-HOT_BATH * strength).max(-1.6).exp(),
            Self::SlowStomach => condition.gut_time_per_glucose += SLOW_STOMACH * strength,
            Self::MenstrualCycle | Self::Illness => {
                let fall = if self == Self::Illness { ILLNESS } else { MENSTRUAL_CYCLE };
                condition.action *= (-fall * strength).exp();
                // The liver takes part by half.
                condition.liver_action *= (-0.5 * fall * strength).exp();
            }
            Self::LateProtein => condition.glucose_flux += LATE_PROTEIN * strength,
            Self::FattyEvenings => condition.liver_action *= (-FATTY_EVENINGS * strength).exp(),
            Self::HardenedSites => condition.bioavailability *= (-HARDENED_SITES * strength).exp(),
            Self::Paracetamol => {} // acts on the sensor alone
            Self::Caffeine => condition.action *= (-CAFFEINE * strength).exp(),
        }
    }
}

/// Phases of twelve days in 28, from a random day of the cycle on.
fn luteal_phases(life: &Life, rng: &mut ChaCha8Rng) -> Vec<Event> {
    let mut day = -rng.random_range(0.0..CYCLE);
    let mut phases = Vec::new();
    while day < life.calendar.days() as f64 {
        let from = life.calendar.signed_step(0, 24.0 * day);
        let size = rng.random_range(0.75..1.25);
        phases.push(Event { from, hours: 24.0 * PHASE, edge: 36.0, size });
        day += CYCLE;
    }
    phases
}

/// Two to three days within each two weeks.
fn illnesses(life: &Life, rng: &mut ChaCha8Rng) -> Vec<Event> {
    let blocks = (life.calendar.days() as f64 / HEALTHY_DAYS).ceil() as usize;
    (0..blocks)
        .map(|block| {
            let day = HEALTHY_DAYS * block as f64 + rng.random_range(1.0..HEALTHY_DAYS - 4.0);
            let from = life.calendar.signed_step(0, 24.0 * day);
            let (hours, size) = (rng.random_range(48.0..72.0), rng.random_range(0.75..1.25));
            Event { from, hours, edge: 8.0, size }
        })
        .collect()
}

/// For as long as a set at such a site is worn, three sets in ten.
fn hardened_sites(life: &Life, rng: &mut ChaCha8Rng) -> Vec<Event> {
    let changes = life.sets.changes();
    let until = changes.iter().skip(1).copied().chain([life.calendar.steps() as i64]);
    let worn = changes.iter().zip(until);
    worn.filter_map(|(from, until)| {
        let hours = (until - from) as f64 / STEPS_PER_HOUR as f64;
        perhaps(0.3, 0.0, rng, |_| (*from, hours))
    })
    .collect()
}

/// From a quarter to three quarters of an hour after waking, on nine days in ten. Caffeine acts for
/// 5 to 8 h: half-lives of 3 to 7 h after a peak within the first hour (Blanchard & Sawers, Eur J
/// Clin Pharmacol 1983;24:93).
fn coffees(life: &Life, rng: &mut ChaCha8Rng) -> Vec<Event> {
    let coffee = |night: &Night| {
        perhaps(0.9, 1.0, rng, |rng| {
            let after = rng.random_range(0.25..0.75) * STEPS_PER_HOUR as f64;
            (night.wake + after as i64, rng.random_range(5.0..8.0))
        })
    };
    life.nights.iter().filter_map(coffee).collect()
}

/// When each effect outside the library would act in one life.
#[derive(Debug, Clone, PartialEq)]
pub struct Events([Vec<Event>; OutsideEffect::ALL.len()]);

impl Events {
    /// Draws the events of a life of person `person` of the world with this seed.
    #[must_use]
    pub(super) fn sample(life: &Life, seed: u64, person: usize) -> Self {
        let mut rng = stream(seed, person, Concept::Outside);
        Self(OutsideEffect::ALL.map(|effect| effect.events(life, &mut rng)))
    }

    /// The events of one effect.
    #[must_use]
    pub fn of(&self, effect: OutsideEffect) -> &[Event] {
        &self.0[effect as usize]
    }

    /// The steps of a record at which an effect acts, each with the strength.
    fn strengths(
        &self,
        effect: OutsideEffect,
        amplitudes: &Amplitudes,
        steps: usize,
    ) -> impl Iterator<Item = (usize, f64)> {
        let amplitude = amplitudes.of_outside(effect);
        let events = self.of(effect).iter().filter(move |_| amplitude != 0.0);
        events.flat_map(move |event| {
            event.steps(steps).map(move |step| (step, amplitude * event.course(step)))
        })
    }
}

/// Lets the effects act on the body's course.
pub(super) fn act(course: &mut [Condition], events: &Events, amplitudes: &Amplitudes) {
    for effect in OutsideEffect::ALL {
        for (step, strength) in events.strengths(effect, amplitudes, course.len()) {
            effect.act(&mut course[step], strength);
        }
    }
}

/// Lets the effects act on what is added to the sensor: gain and offset, mg/dL, one pair a step.
pub(super) fn act_on_sensor(added: &mut [(f64, f64)], events: &Events, amplitudes: &Amplitudes) {
    let steps = added.len();
    for (step, strength) in events.strengths(OutsideEffect::Paracetamol, amplitudes, steps) {
        added[step].1 += PARACETAMOL * strength;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Port;

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
    }

    #[test]
    fn paracetamol_raises_the_reading_and_nothing_else() {
        let hour = Event { from: 0, hours: 1.0, edge: 0.0, size: 1.0 };
        let events = Events(OutsideEffect::ALL.map(|_| vec![hour]));
        let mut added = [(0.0, 0.0); 13];
        let taken = Amplitudes::NONE.with_outside(OutsideEffect::Paracetamol, 1.0);
        act_on_sensor(&mut added, &events, &taken);
        assert_eq!((added[11], added[12]), ((0.0, PARACETAMOL), (0.0, 0.0)));
        act_on_sensor(&mut added, &events, &Amplitudes::NONE);
        assert_eq!(added[11], (0.0, PARACETAMOL));
    }
}
