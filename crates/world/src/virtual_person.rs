//! A whole person: body, habits, settings, effects; and their days.

use cohort::{Channel, Person, Record, Therapy};
use ode_sim::OdeError;
use physiology::{BeatsPerMinute, Grams, InputSource, MgPerDl, StepInput};
use rand_chacha::ChaCha8Rng;

use crate::background::Background;
use crate::behaviour::{Habits, Life};
use crate::calendar::Calendar;
use crate::devices::WornSensors;
use crate::effects::{Amplitudes, Forms, Happenings, Shapes, conditions, sensing};
use crate::error::WorldError;
use crate::everyday::{self, Everyday};
use crate::generator::Generator;
use crate::living::{self, Injected, Living, Logged};
use crate::logging::Logging;
use crate::padova::action_within_days;
use crate::physique::Physique;
use crate::reactions::reactions;
use crate::stream::{Concept, WORLD, stream};
use crate::therapy::{Aid, Regime, TherapySettings};
use crate::warp::Warps;
use crate::wear::SensorWear;

/// A person of a world.
///
/// Every part is public, so that a counterpart can be made that differs in one of them: another
/// regime, or the same amplitudes [without](Amplitudes::without) an effect. The chance events
/// depend on `seed` and `index` alone and are the same for both.
#[derive(Debug, Clone, PartialEq)]
pub struct VirtualPerson {
    /// Seed of the world.
    pub seed: u64,
    /// Index of the person in the world, counted from 0.
    pub index: usize,
    /// Identifier in the cohort.
    pub id: String,
    /// The body.
    pub body: Physique,
    /// The habits.
    pub habits: Habits,
    /// The settings in use.
    pub settings: TherapySettings,
    /// How basal insulin is decided.
    pub regime: Regime,
    /// What acts beyond the equations, and how strongly.
    pub amplitudes: Amplitudes,
    /// The forms that effects take.
    pub shapes: Shapes,
    /// What is there whether an effect acts or not.
    pub background: Background,
    /// What varies in everyday life.
    pub everyday: Everyday,
}

/// The days of a person: what is recorded, and what truly happened.
#[derive(Debug, Clone, PartialEq)]
pub struct LivedDays {
    /// The person as the cohort knows them.
    pub recorded: Person,
    /// What acted on the body, one entry a step.
    pub inputs: Vec<StepInput>,
    /// True glucose at the start of each step.
    pub glucose: Vec<MgPerDl>,
    /// What the person did.
    pub life: Life,
    /// The chance events.
    pub happenings: Happenings,
    /// Steps at which a low was treated with food that is absorbed as a meal is, with the amount;
    /// it is part of what was eaten then.
    pub slow_rescues: Vec<(usize, Grams)>,
}

impl VirtualPerson {
    /// Draws person `index` of the world with this seed, with a body of [`Generator::Hovorka`].
    ///
    /// # Errors
    /// If no body can be drawn, or its settings cannot be found.
    pub fn sample(seed: u64, index: usize, regime: Regime) -> Result<Self, WorldError> {
        Self::sample_from(Generator::Hovorka, seed, index, regime)
    }

    /// Draws person `index` of the world with this seed, with a body of any kind.
    ///
    /// Habits, amplitudes and the errors of the settings are the same for all kinds.
    ///
    /// # Errors
    /// If no body can be drawn, or its settings cannot be found.
    pub fn sample_from(
        generator: Generator,
        seed: u64,
        index: usize,
        regime: Regime,
    ) -> Result<Self, WorldError> {
        let body = Physique::sample(generator, index, &mut stream(seed, index, Concept::Body))?;
        let found = body
            .settings_by_trial(Warps::NONE)
            .map_err(|source| WorldError::Body { person: index, source })?;
        Ok(Self::of_narrow_habits(seed, index, regime, body, found))
    }

    /// A person with this body, and with settings that err from those that trials on it give.
    fn of_narrow_habits(
        seed: u64,
        index: usize,
        regime: Regime,
        body: Physique,
        by_trial: TherapySettings,
    ) -> Self {
        let rng = |concept| stream(seed, index, concept);
        Self {
            seed,
            index,
            id: format!("P{:02}", index + 1),
            body,
            habits: Habits::sample(&mut rng(Concept::Habits)),
            settings: by_trial.in_use(&mut rng(Concept::Settings)),
            regime,
            amplitudes: Amplitudes::sample(&mut rng(Concept::Effects)),
            shapes: Shapes::sample(&mut rng(Concept::Shapes)),
            background: Background::REALISTIC,
            everyday: Everyday::NARROW,
        }
    }

    /// As [`Self::sample_from`], with everyday variation, habits, counting and forms of effects
    /// from wide priors, for the hand of the generator.
    ///
    /// # Errors
    /// [`WorldError::NoBody`] and [`WorldError::Body`] where no body can be drawn, and
    /// [`WorldError::NoSettings`] where trials on the body fail or give settings outside the usual
    /// range.
    pub fn sample_widely(
        generator: Generator,
        seed: u64,
        index: usize,
        regime: Regime,
    ) -> Result<Self, WorldError> {
        let body = Physique::sample(generator, index, &mut stream(seed, index, Concept::Body))?;
        let everyday = Everyday::sample(generator, seed, index);
        let forms = Forms::sample(generator, &mut stream(seed, WORLD, Concept::Forms));
        // Warps are reduced if no clinic would believe the settings they give.
        let (warps, found) = [1.0, 0.5, 0.25, 0.0]
            .into_iter()
            .find_map(|share| {
                let warps = everyday.warps.flattened(share);
                let found = body.settings_by_trial(warps).ok()?;
                found.are_usual().then_some((warps, found))
            })
            .ok_or(WorldError::NoSettings { person: index })?;
        let narrow = Self::of_narrow_habits(seed, index, regime, body, found);
        Ok(Self {
            habits: everyday::habits(narrow.habits, seed, index),
            shapes: Shapes { forms, ..narrow.shapes },
            background: everyday::background(seed, index),
            everyday: Everyday { warps, ..everyday },
            ..narrow
        })
    }

    /// Lives the days of a calendar.
    ///
    /// # Errors
    /// If the body's model fails or the days do not make a record.
    pub fn live(&self, calendar: Calendar) -> Result<LivedDays, WorldError> {
        let Everyday { hours, pen, rescues, .. } = &self.everyday;
        let life = Life::sample_with(&self.habits, hours, calendar, self.seed, self.index);
        let happenings = self.happenings(&life);
        let reactions = reactions(&calendar, &mut self.rng(Concept::Reactions));
        let injected = || {
            let rng = &mut self.rng(Concept::Injections);
            Injected { pen: *pen, rates: pen.rates(&self.settings, &calendar, rng) }
        };
        let therapy = living::Therapy {
            settings: self.settings,
            aid: (self.regime == Regime::Aid).then(|| Aid::new(self.settings)),
            rescues: *rescues,
            injected: (self.regime == Regime::Mdi).then(injected),
        };
        let sensors = self.sensors(&life, &happenings, &self.amplitudes);
        let logging = self.logging(&self.amplitudes);
        let mut living = Living::new(&life, logging, &reactions, sensors, therapy)
            .map_err(|source| self.failed(source))?;
        let (inputs, glucose) = self.run(&life, &happenings, &self.amplitudes, &mut living)?;
        let Living { log, slow_rescues, failure, .. } = living;
        if let Some(source) = failure {
            return Err(self.failed(source));
        }
        let recorded = self.recorded(&life, &log)?;
        Ok(LivedDays { recorded, inputs, glucose, life, happenings, slow_rescues })
    }

    /// The person's stream for one concept.
    pub(crate) fn rng(&self, concept: Concept) -> ChaCha8Rng {
        stream(self.seed, self.index, concept)
    }

    /// An error of this person's body or devices.
    pub(crate) fn failed(&self, source: OdeError) -> WorldError {
        WorldError::Body { person: self.index, source }
    }

    /// Runs the body through a life in which effects act with `amplitudes`: what acted on it, and
    /// glucose at the start of each step.
    pub(crate) fn run(
        &self,
        life: &Life,
        happenings: &Happenings,
        amplitudes: &Amplitudes,
        source: &mut impl InputSource,
    ) -> Result<(Vec<StepInput>, Vec<MgPerDl>), WorldError> {
        let course = conditions(life, happenings, &self.shapes, amplitudes);
        let in_body = self.shapes.forms.in_body(*amplitudes);
        let run = self.body.run(&course, in_body, self.everyday.warps, source);
        run.map_err(|source| self.failed(source))
    }

    /// The chance events of a life.
    fn happenings(&self, life: &Life) -> Happenings {
        let spreads = &self.everyday.spreads;
        let mut happenings = Happenings::sample_with(life, spreads, self.seed, self.index);
        if let Physique::Padova(_) = self.body {
            let rng = &mut self.rng(Concept::ActionWithinDays);
            happenings.variability.action = action_within_days(&life.calendar, spreads, rng);
        }
        happenings.everyday = self.everyday.course(life, self.seed, self.index);
        happenings
    }

    /// The sensors worn through a life in which effects act with `amplitudes`.
    pub(crate) fn sensors(
        &self,
        life: &Life,
        happenings: &Happenings,
        amplitudes: &Amplitudes,
    ) -> WornSensors {
        let (wear, rng) = self.wear(life);
        let sensing = sensing(life, &wear, happenings, &self.shapes, amplitudes);
        let own = self.rng(Concept::SensorKind);
        WornSensors::new(self.everyday.sensor, wear, sensing, rng, own)
    }

    /// When sensors are worn through a life, and the stream for their errors.
    pub(crate) fn wear(&self, life: &Life) -> (SensorWear, ChaCha8Rng) {
        let mut rng = self.rng(Concept::Sensor);
        (SensorWear::sample(&life.calendar, &self.everyday.sensor, &mut rng), rng)
    }

    /// How the person keeps the log while effects act with `amplitudes`.
    pub(crate) fn logging(&self, amplitudes: &Amplitudes) -> Logging {
        Logging::new(self.background, self.everyday.log, &self.shapes, amplitudes)
    }

    /// The cohort's view of the days.
    fn recorded(&self, life: &Life, log: &[Logged]) -> Result<Person, WorldError> {
        let mut record = Record::new(life.calendar.time(0), log.len()).map_err(|source| {
            WorldError::Record { person: self.index, source: Box::new(source) }
        })?;
        let mut fill = |channel: Channel, value: &dyn Fn(usize) -> Option<f64>| {
            for (step, slot) in record.channel_mut(channel).iter_mut().enumerate() {
                *slot = value(step);
            }
        };
        let readings = self.everyday.sensor.drawn_through(log.iter().map(|l| l.cgm));
        let carbs = self.everyday.log.written(log.iter().map(|l| l.carbs));
        fill(Channel::Cgm, &|s| readings[s].map(|g| g.0.round()));
        // Long-acting injections have no known rate, and there is no set to change.
        let injects = self.regime == Regime::Mdi;
        fill(Channel::Basal, &|s| (!injects).then_some(log[s].basal.0));
        fill(Channel::Bolus, &|s| Some(log[s].bolus.0));
        fill(Channel::Carbs, &|s| Some(carbs[s].0));
        fill(Channel::HeartRate, &|s| life.wearable.heart_rate[s].map(f64::round));
        fill(Channel::Steps, &|s| life.wearable.steps[s]);
        fill(Channel::SleepEfficiency, &|s| {
            let worn = life.wearable.heart_rate[s].is_some();
            worn.then(|| (100.0 * life.asleep[s]).round() / 100.0)
        });
        fill(Channel::SetChange, &|s| {
            (!injects).then(|| f64::from(u8::from(life.sets.changed_at(s))))
        });
        Ok(Person {
            id: self.id.clone(),
            weight: Some(physiology::Kilograms((10.0 * self.body.weight().0).round() / 10.0)),
            therapy: match self.regime {
                Regime::OpenLoopPump => Therapy::OpenLoopPump,
                Regime::Aid => Therapy::Aid,
                Regime::Mdi => Therapy::Mdi,
            },
            heart_rate_baseline: Some(BeatsPerMinute(self.habits.resting_heart_rate.round())),
            record,
        })
    }
}
