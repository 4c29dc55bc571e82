//! A whole person: body, habits, settings, effects; and their days.

use cohort::{Channel, Person, Record, Therapy};
use physiology::{BeatsPerMinute, Grams, MgPerDl, StepInput};

use crate::background::Background;
use crate::behaviour::{Habits, Life};
use crate::calendar::Calendar;
use crate::effects::{Amplitudes, Forms, Shapes, conditions};
use crate::error::WorldError;
use crate::everyday::{self, Everyday};
use crate::generator::Generator;
use crate::living::{self, Injected, Living, Logged};
use crate::physique::Physique;
use crate::reactions::reactions;
use crate::stream::{Concept, WORLD, stream};
use crate::therapy::{Regime, TherapySettings};
use crate::warp::Warps;

/// Glucose at the start of the record.
pub(crate) const FIRST_GLUCOSE: MgPerDl = MgPerDl(140.0);

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
        let rng = |concept| stream(seed, index, concept);
        let body = Physique::sample(generator, index, &mut rng(Concept::Body))?;
        let found = body
            .settings_by_trial(Warps::NONE)
            .map_err(|source| WorldError::Body { person: index, source })?;
        Ok(Self {
            seed,
            index,
            id: format!("P{:02}", index + 1),
            body,
            habits: Habits::sample(&mut rng(Concept::Habits)),
            settings: found.in_use(&mut rng(Concept::Settings)),
            regime,
            amplitudes: Amplitudes::sample(&mut rng(Concept::Effects)),
            shapes: Shapes::sample(&mut rng(Concept::Shapes)),
            background: Background::REALISTIC,
            everyday: Everyday::NARROW,
        })
    }

    /// As [`Self::sample_from`], with everyday variation, habits, counting and forms of effects
    /// from wide priors, for the hand of the generator.
    ///
    /// # Errors
    /// As [`Self::sample_from`], and [`WorldError::NoSettings`] where trials on the body give
    /// settings outside the usual range.
    pub fn sample_widely(
        generator: Generator,
        seed: u64,
        index: usize,
        regime: Regime,
    ) -> Result<Self, WorldError> {
        let narrow = Self::sample_from(generator, seed, index, regime)?;
        let everyday = Everyday::sample(generator, seed, index);
        let forms = Forms::sample(generator, &mut stream(seed, WORLD, Concept::Forms));
        // Warps are reduced if no clinic would believe the settings they give.
        let (warps, found) = [1.0, 0.5, 0.25, 0.0]
            .into_iter()
            .find_map(|share| {
                let warps = everyday.warps.flattened(share);
                let found = narrow.body.settings_by_trial(warps).ok()?;
                found.are_usual().then_some((warps, found))
            })
            .ok_or(WorldError::NoSettings { person: index })?;
        Ok(Self {
            habits: everyday::habits(narrow.habits, seed, index),
            settings: found.in_use(&mut stream(seed, index, Concept::Settings)),
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
        let in_body = |source: ode_sim::OdeError| WorldError::Body { person: self.index, source };
        let rng = |concept| stream(self.seed, self.index, concept);
        let life = self.life(calendar);
        let happenings = self.happenings(&life);
        let course = conditions(&life, &happenings, &self.shapes, &self.amplitudes);
        let reactions = reactions(&calendar, &mut rng(Concept::Reactions));
        let sensors = self.sensors(&life, &happenings, &self.amplitudes);
        let (settings, regime) = (self.settings, self.regime);
        let mut living = Living::new(
            &life,
            self.logging(&self.amplitudes),
            &reactions,
            sensors,
            living::Therapy {
                settings,
                regime,
                rescues: self.everyday.rescues,
                injected: self.injected(calendar),
            },
        )
        .map_err(in_body)?;
        let run = self
            .body
            .run(
                &course,
                self.shapes.forms.in_body(self.amplitudes),
                self.everyday.warps,
                FIRST_GLUCOSE,
                &mut living,
                calendar.steps(),
            )
            .map_err(in_body)?;
        let mut glucose = run.glucose;
        glucose.truncate(calendar.steps());
        let (log, slow_rescues) = living.into_log().map_err(in_body)?;
        let recorded = self.recorded(&life, &log)?;
        Ok(LivedDays { recorded, inputs: run.inputs, glucose, life, slow_rescues })
    }

    /// What is injected over a calendar, for a person who injects.
    fn injected(&self, calendar: Calendar) -> Option<Injected> {
        let pen = self.everyday.pen;
        let mut rng = stream(self.seed, self.index, Concept::Injections);
        (self.regime == Regime::Mdi)
            .then(|| Injected { pen, rates: pen.rates(&self.settings, &calendar, &mut rng) })
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
