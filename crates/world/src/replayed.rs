//! Recorded days lived again by a body: real behaviour, doses and wear with a simulated glucose.
//!
//! Insulin, carbohydrate, heart rate, steps, sleep and set changes of a person stay as recorded,
//! gaps included. The sensor readings are replaced by those of a body of any kind under exactly
//! these inputs. Effects act on that body as in a made world. So their truth is known, while
//! everything else that a diagnosis sees, apart from glucose, is real.
//!
//! Insulin was given for another glucose than the simulated one and does not react to it. Two
//! things keep the body in range, both found without any effect. One is the strength of insulin
//! action, such that mean glucose is the recorded one. The other is a
//! [restoring](ReplayedPerson::restoring) change of that action from day to day, made only on days
//! that would leave the range. It stands for what the real person's controller reacted to, and a
//! plant sees it as day-to-day variability.
//!
//! Two kinds of effects are not in a record and so never act here: alcohol, and what [`available`]
//! leaves out because its channel was not recorded. Counting errors change what is eaten, not what
//! is logged. Missed meals and unlogged rescue carbohydrate are eaten in addition to what the
//! record holds.

mod days;
mod doses;
mod fit;
mod info;
mod recorded_life;
mod replaying;
mod restoring;
mod toward;

use cohort::{Channel, Cohort, Person};
use physiology::MgPerDl;
use rayon::prelude::*;

use crate::background::Background;
use crate::behaviour::Life;
use crate::devices::WornSensors;
use crate::effects::{
    Amplitudes, Effect, Happenings, OutsideEffect, Port, Shapes, Spreads, sensing,
};
use crate::error::WorldError;
use crate::everyday::SensorKind;
use crate::generator::Generator;
use crate::physique::{Course, Physique};
use crate::stream::{Concept, stream};
use crate::virtual_person::LivedDays;
use crate::wear::SensorWear;

pub use info::ReplayedInfo;

use days::Days;
use doses::Doses;
use recorded_life::RecordedLife;

/// A person of a cohort whose recorded days a body lives again.
#[derive(Debug, Clone, PartialEq)]
pub struct ReplayedPerson {
    /// Seed of the world.
    pub seed: u64,
    /// Index of the person in the world, counted from 0.
    pub index: usize,
    /// The person as recorded.
    pub original: Person,
    /// The body, with the insulin action that was found for the record.
    pub body: Physique,
    /// What acts beyond the equations, and how strongly.
    pub amplitudes: Amplitudes,
    /// The forms that effects take.
    pub shapes: Shapes,
    /// What is there whether an effect acts or not.
    pub background: Background,
    /// Logarithm of the restoring factor on insulin action, by day of the record.
    pub restoring: Vec<f64>,
}

/// Why a record could not be lived again.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotReplayed {
    /// Fewer days than a search needs.
    #[error("{days:.1} days recorded; at least {fewest} are needed")]
    TooShort {
        /// Days recorded.
        days: f64,
        /// Days needed.
        fewest: f64,
    },
    /// No basal insulin in most of the record, as with injections.
    #[error("basal insulin is recorded in {percent:.0} % of the steps; 80 % are needed")]
    NoBasal {
        /// Share of the steps with a basal rate, per cent.
        percent: f64,
    },
    /// No carbohydrate in most of the days.
    #[error("carbohydrate is logged on {percent:.0} % of the days; 60 % are needed")]
    NoCarbohydrate {
        /// Share of the days with carbohydrate, per cent.
        percent: f64,
    },
    /// No body of the drawn kind stays within a believable range on these doses.
    #[error(
        "on the recorded doses glucose averages {mean:.0} mg/dL (recorded {target:.0}) with \
         {within:.0} % within 40 to 400 mg/dL and a restoring change of {restoring:.2}: no body fits"
    )]
    NoBody {
        /// Mean glucose of the best body, mg/dL.
        mean: f64,
        /// Mean that was sought, mg/dL.
        target: f64,
        /// Share of the steps within 40 to 400 mg/dL, per cent.
        within: f64,
        /// Spread of the restoring change between days (log).
        restoring: f64,
    },
    /// The body could not be drawn or simulated.
    #[error("{0}")]
    Failed(String),
}

/// The effects that can act on a person's replayed days: all except those that depend on what is
/// not recorded.
///
/// Never alcohol. Sleep loss if sleep is recorded and a night a week is an hour short. Exercise and
/// its aftermath if heart rate shows a session a week. Ageing and failing sets if set changes are
/// recorded.
#[must_use]
pub fn available(original: &Person) -> Vec<Effect> {
    let life = RecordedLife::new(0, 0, original).life;
    let weekly = |count: usize| count > 0 && 7 * count >= life.calendar.days();
    let sleep = weekly(life.nights.iter().filter(|night| night.hours_short > 1.0).count());
    let heart = weekly(life.sessions.len());
    let sets = life.sets.count() > 0;
    Effect::ALL
        .into_iter()
        .filter(|effect| match effect {
            Effect::Alcohol => false,
            Effect::SleepLoss => sleep,
            Effect::Exercise | Effect::PostExerciseSensitivity => heart,
            Effect::SetAgeing | Effect::SetFailure => sets,
            _ => true,
        })
        .collect()
}

impl ReplayedPerson {
    /// Finds a body of a generator that can live the recorded days.
    ///
    /// The search finds the action of insulin first without effects, with the restoring change, and
    /// then again with `amplitudes`, so that mean glucose is the recorded one within 110 to 190
    /// mg/dL.
    ///
    /// # Errors
    /// [`NotReplayed`] with the reason.
    pub fn fit(
        generator: Generator,
        seed: u64,
        index: usize,
        original: &Person,
        amplitudes: Amplitudes,
    ) -> Result<Self, NotReplayed> {
        fit::fit(generator, seed, index, original, amplitudes)
    }

    /// The same person with other amplitudes, and with the insulin action that restores mean
    /// glucose. Body and restoring change stay as they are.
    ///
    /// # Errors
    /// [`NotReplayed`] with the reason.
    pub fn with_amplitudes(&self, amplitudes: Amplitudes) -> Result<Self, NotReplayed> {
        fit::with_amplitudes(self, amplitudes)
    }

    /// Lives the recorded days with the person's amplitudes, shapes and body.
    ///
    /// The record of the result starts and ends with the original. Its readings are whole mg/dL
    /// wherever the original has one. Inputs, glucose and the record count steps from the start of
    /// the record; the life counts them from the midnight before.
    ///
    /// # Errors
    /// If the body's model fails or a dose is not finite.
    pub fn live(&self) -> Result<LivedDays, WorldError> {
        let (course, life, offset) = self.course(self.amplitudes)?;
        let glucose = course.glucose;
        let mut recorded = self.original.clone();
        let readings = self.sensed(&life, offset, &glucose, &self.amplitudes)?;
        for (slot, reading) in recorded.record.channel_mut(Channel::Cgm).iter_mut().zip(readings) {
            *slot = slot.and(Some(reading.0.round()));
        }
        let slow_rescues = Vec::new(); // treatments are in the record or fast
        Ok(LivedDays { recorded, inputs: course.inputs, glucose, life, slow_rescues })
    }

    /// How far the effects that `without` switches off (or weakens) move glucose: the mean absolute
    /// difference between the days lived with both amplitudes, on the same doses and the same log.
    ///
    /// The glucose is the true one, or what the sensor shows if an effect on the sensor differs.
    ///
    /// # Errors
    /// As [`Self::live`].
    pub fn shift(&self, without: &Amplitudes) -> Result<MgPerDl, WorldError> {
        let (with, life, offset) = self.course(self.amplitudes)?;
        let (other, other_life, _) = self.course(*without)?;
        if !sensors_differ(&self.amplitudes, without) {
            return Ok(mean_difference(&with.glucose, &other.glucose));
        }
        let shown = self.sensed(&life, offset, &with.glucose, &self.amplitudes)?;
        let other_shown = self.sensed(&other_life, offset, &other.glucose, without)?;
        Ok(mean_difference(&shown, &other_shown))
    }

    fn recorded_life(&self) -> RecordedLife {
        RecordedLife::new(self.seed, self.index, &self.original)
    }

    fn happenings(&self, life: &Life) -> Happenings {
        let mut happenings = Happenings::sample(life, self.seed, self.index);
        let spreads = &Spreads::NARROW;
        self.body.vary(&mut happenings, &life.calendar, spreads, self.seed, self.index);
        happenings
    }

    /// The course of the body, the life as it was truly lived, and the number of steps from the
    /// start of the life to that of the record.
    fn course(&self, amplitudes: Amplitudes) -> Result<(Course, Life, usize), WorldError> {
        let doses = Doses::of(&self.original).map_err(|source| WorldError::Record {
            person: self.index,
            source: Box::new(source),
        })?;
        let days = Days::new(self, &self.recorded_life(), &doses, amplitudes);
        let mut course = days.lived(self.body, &self.restoring)?;
        course.glucose.truncate(self.original.record.len());
        let offset = days.inputs.offset;
        Ok((course, days.inputs.life, offset))
    }

    /// What the sensors show of a course of glucose, not rounded; no reading is lost.
    fn sensed(
        &self,
        life: &Life,
        offset: usize,
        glucose: &[MgPerDl],
        amplitudes: &Amplitudes,
    ) -> Result<Vec<MgPerDl>, WorldError> {
        let mut rng = stream(self.seed, self.index, Concept::Sensor);
        let kind = SensorKind::PUBLISHED;
        let wear = SensorWear::sample(&life.calendar, &kind, &mut rng).without_losses();
        let sensing = sensing(life, &wear, &self.happenings(life), &self.shapes, amplitudes);
        let own = stream(self.seed, self.index, Concept::SensorKind);
        let mut sensors = WornSensors::new(kind, wear, sensing, rng, own);
        let first = glucose.first().copied().unwrap_or_default();
        let mut shown = Vec::with_capacity(offset + glucose.len());
        // Worn from the midnight before the record on.
        for (step, now) in
            std::iter::repeat_n(first, offset).chain(glucose.iter().copied()).enumerate()
        {
            let reading = sensors
                .sense(step, now)
                .map_err(|source| WorldError::Body { person: self.index, source })?;
            shown.push(reading.unwrap_or(now));
        }
        Ok(shown.split_off(offset))
    }
}

/// The people of a cohort whose days a generator could live again.
#[derive(Debug, Clone, PartialEq)]
pub struct Replayed {
    /// Those that could, in the order of the cohort.
    pub people: Vec<ReplayedPerson>,
    /// Those that could not, with the reason.
    pub skipped: Vec<(String, NotReplayed)>,
}

impl Replayed {
    /// Finds a body for everybody; person k of the cohort is person k of the world.
    ///
    /// The result depends on the seed alone, for any number of threads.
    #[must_use]
    pub fn fit(generator: Generator, seed: u64, cohort: &Cohort, amplitudes: Amplitudes) -> Self {
        let fitted: Vec<_> = cohort
            .people
            .par_iter()
            .enumerate()
            .map(|(index, person)| {
                ReplayedPerson::fit(generator, seed, index, person, amplitudes)
                    .map_err(|reason| (person.id.clone(), reason))
            })
            .collect();
        let (mut people, mut skipped) = (Vec::new(), Vec::new());
        for person in fitted {
            match person {
                Ok(person) => people.push(person),
                Err(reason) => skipped.push(reason),
            }
        }
        Self { people, skipped }
    }

    /// The cohort that a study would see: the recorded people with the readings of their bodies.
    ///
    /// # Errors
    /// As [`ReplayedPerson::live`].
    pub fn cohort(&self) -> Result<Cohort, WorldError> {
        let people = self
            .people
            .par_iter()
            .map(|person| Ok(person.live()?.recorded))
            .collect::<Result<_, WorldError>>()?;
        Ok(Cohort { people })
    }
}

/// Whether an effect on the sensor differs.
fn sensors_differ(one: &Amplitudes, other: &Amplitudes) -> bool {
    let named = |e: &Effect| e.port() == Port::Sensor && one.of(*e) != other.of(*e);
    let outside =
        |e: &OutsideEffect| e.port() == Port::Sensor && one.of_outside(*e) != other.of_outside(*e);
    Effect::ALL.iter().any(named) || OutsideEffect::all().any(|e| outside(&e))
}

/// Mean absolute difference; 0 for no values.
fn mean_difference(one: &[MgPerDl], other: &[MgPerDl]) -> MgPerDl {
    let sum: f64 = one.iter().zip(other).map(|(a, b)| (a.0 - b.0).abs()).sum();
    MgPerDl(sum / (one.len() as f64).max(1.0))
}
