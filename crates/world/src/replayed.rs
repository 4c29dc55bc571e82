//! Recorded days lived again by a body: real behaviour, doses and wear with a simulated glucose.
//!
//! Insulin, carbohydrate, heart rate, steps, sleep and set changes of a person stay as recorded, gaps
//! included; the sensor readings are replaced by those of a body of either kind under exactly these
//! inputs. Effects act on that body as in a made world, so their truth is known while everything
//! that a diagnosis sees besides glucose is real.
//!
//! Insulin was given to another glucose than the simulated one and does not answer to it. Two things
//! keep the body in range, both found without any effect acting: how strongly insulin acts, such
//! that mean glucose is the recorded one, and a [restoring](ReplayedPerson::restoring) change of
//! that action from day to day, made only on days that would leave the range. It stands for what
//! the real person's controller answered to, and a plant sees it as day-to-day variability.
//!
//! Not in a record, and therefore never acting here: alcohol; what [`available`] leaves out because
//! its channel was not recorded. Counting errors change what is eaten, not what is logged; missed
//! meals and unlogged rescue carbohydrate are eaten beside what the record holds.

mod doses;
mod fit;
mod recorded_life;
mod replaying;

use cohort::{Channel, Person};
use physiology::MgPerDl;

use crate::background::Background;
use crate::behaviour::Life;
use crate::devices::WornSensors;
use crate::effects::{Amplitudes, Condition, Effect, Happenings, Shapes, conditions, sensing};
use crate::error::WorldError;
use crate::generator::Generator;
use crate::physique::{Course, Physique};
use crate::reactions::{Reaction, reactions};
use crate::stream::{Concept, stream};
use crate::virtual_person::LivedDays;
use crate::wear::SensorWear;

use doses::Doses;
use recorded_life::RecordedLife;
use replaying::{Eaten, Replaying};

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

/// The effects that can act on a person's replayed days: all but those that depend on what is not
/// recorded.
///
/// Never alcohol. Sleep loss where sleep is recorded and a night a week is an hour short; exercise
/// and its aftermath where heart rate shows a session a week; ageing and failing sets where set
/// changes are recorded.
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
    /// The action of insulin is sought without effects first, with the restoring change, and then
    /// once more with `amplitudes`, so that mean glucose is the recorded one within 110 to 190
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

    /// Lives the recorded days with the amplitudes, shapes and body at hand.
    ///
    /// The record of the result starts and ends with the original; its readings are whole mg/dL
    /// wherever the original has one. Inputs, glucose and the record count steps from the start of
    /// the record, the life from the midnight before it.
    ///
    /// # Errors
    /// If the body's model fails or a dose is not finite.
    pub fn live(&self) -> Result<LivedDays, WorldError> {
        let doses = Doses::of(&self.original).map_err(|source| WorldError::Record {
            person: self.index,
            source: Box::new(source),
        })?;
        let life = self.recorded_life();
        let days = Days::new(self, &life, &doses, self.amplitudes);
        let course = days.lived(self.body, &self.restoring)?;
        let mut glucose = course.glucose;
        glucose.truncate(self.original.record.len());
        let mut recorded = self.original.clone();
        self.read(&life, &glucose, &mut recorded)?;
        Ok(LivedDays { recorded, inputs: course.inputs, glucose, life: life.life })
    }

    fn recorded_life(&self) -> RecordedLife {
        RecordedLife::new(self.seed, self.index, &self.original)
    }

    fn happenings(&self, life: &Life) -> Happenings {
        let mut happenings = Happenings::sample(life, self.seed, self.index);
        self.body.vary(&mut happenings, &life.calendar, self.seed, self.index);
        happenings
    }

    fn rng(&self, concept: Concept) -> rand_chacha::ChaCha8Rng {
        stream(self.seed, self.index, concept)
    }

    /// Puts the readings of the course into the record.
    fn read(
        &self,
        recorded: &RecordedLife,
        glucose: &[MgPerDl],
        person: &mut Person,
    ) -> Result<(), WorldError> {
        let life = &recorded.life;
        let mut rng = self.rng(Concept::Sensor);
        let wear = SensorWear::sample(&life.calendar, &mut rng).without_losses();
        let happenings = self.happenings(life);
        let sensing = sensing(life, &wear, &happenings, &self.shapes, &self.amplitudes);
        let mut sensors = WornSensors::new(wear, sensing, rng);
        let mut readings = Vec::with_capacity(glucose.len());
        let first = glucose.first().copied().unwrap_or(MgPerDl(0.0));
        for step in 0..recorded.offset + glucose.len() {
            let now = step.checked_sub(recorded.offset).map_or(first, |k| glucose[k]);
            let reading = sensors
                .read(step, now)
                .map_err(|source| WorldError::Body { person: self.index, source })?;
            if step >= recorded.offset {
                readings.push(reading.map(|g| g.0));
            }
        }
        for (slot, reading) in person.record.channel_mut(Channel::Cgm).iter_mut().zip(readings) {
            *slot = slot.and(reading);
        }
        Ok(())
    }
}

/// Everything about the recorded days of a person under given amplitudes but the body.
struct Days<'a> {
    person: usize,
    offset: usize,
    doses: &'a Doses,
    life: Life,
    conditions: Vec<Condition>,
    eaten: Eaten,
    reactions: Vec<Reaction>,
    amplitudes: Amplitudes,
    start: MgPerDl,
}

impl<'a> Days<'a> {
    fn new(
        person: &ReplayedPerson,
        recorded: &RecordedLife,
        doses: &'a Doses,
        amplitudes: Amplitudes,
    ) -> Self {
        let mut life = recorded.life.clone();
        let miscount = amplitudes.of(Effect::CarbMiscount);
        recorded_life::eaten(&mut life, &person.background, person.shapes.counting_bias, miscount);
        let happenings = person.happenings(&life);
        let mut conditions =
            conditions(&recorded.habits, &life, &happenings, &person.shapes, &amplitudes);
        conditions.drain(..recorded.offset);
        Self {
            person: person.index,
            offset: recorded.offset,
            doses,
            conditions,
            eaten: Eaten::new(recorded, &life, &amplitudes),
            reactions: reactions(&life.calendar, &mut person.rng(Concept::Reactions)),
            life,
            amplitudes,
            start: MgPerDl(fit::first_glucose(&person.original)),
        }
    }

    /// The course of a body with a restoring change through these days.
    fn lived(&self, body: Physique, restoring: &[f64]) -> Result<Course, WorldError> {
        let mut conditions = self.conditions.clone();
        fit::restore(&mut conditions, self.offset, restoring);
        let mut source = Replaying::new(self);
        body.run(&conditions, self.amplitudes, self.start, &mut source, self.doses.len())
            .map_err(|source| WorldError::Body { person: self.person, source })
    }
}
