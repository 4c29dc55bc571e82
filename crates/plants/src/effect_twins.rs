//! Twins whose plant has the effects that a diagnosis names, beside twins that must absorb them: the experiment of
//! decision 0024.

use std::collections::BTreeMap;
use std::sync::Arc;

use cohort::{Cohort, Person, Window};
use effects::{Course, find};
use gap::Diagnosis;
use nn_statespace::{GLUCOSE_RANGE, PopulationModel, ScaledStates};
use physiology::{Kilograms, MgPerDl, STEPS_PER_DAY};
use rayon::prelude::*;
use stats::{Outcomes, agreement};
use twins::{
    HeartRateScaler, InputSet, PersonWindows, PreparedWindow, Protocol, ResidualNetwork,
    SteadyStates, TrainingPlan, TwinLoss, inputs_within, measured, train, window_courses,
    window_loss, window_starts_with,
};

use crate::error::PlantsError;
use crate::modulated_network::{Acting, Active, ModulatedNetwork, cannot_be_input, course_of};

/// What is compared. The residual network sees everything or the states alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kind {
    /// What it is called.
    pub name: &'static str,
    /// Whether the effect is an input.
    pub effect: bool,
    /// What the residual network sees; `None` without one.
    pub residual: Option<InputSet>,
}

/// Effect absent or an input, by what the residual network sees.
pub const KINDS: [Kind; 6] = [
    Kind { name: "population", effect: false, residual: None },
    Kind { name: "population + effect", effect: true, residual: None },
    Kind { name: "twin", effect: false, residual: Some(InputSet::All) },
    Kind { name: "twin + effect", effect: true, residual: Some(InputSet::All) },
    Kind { name: "twin, states only", effect: false, residual: Some(InputSet::None) },
    Kind { name: "twin, states only, + effect", effect: true, residual: Some(InputSet::None) },
];

/// Everybody with the resting heart rate that their training days show, so that the diagnosis of these days and the
/// windows of the whole record see one course of exercise.
#[must_use]
pub fn resting_as_in_training(cohort: &Cohort, protocol: &Protocol) -> Cohort {
    let trained = training_days(cohort, protocol).people;
    let people = cohort.people.iter().map(|person| {
        let own = trained.iter().find(|trained| trained.id == person.id);
        let heart_rate_baseline = own.and_then(Person::resting_heart_rate);
        Person { heart_rate_baseline, ..person.clone() }
    });
    Cohort { people: people.collect() }
}

/// Everybody's training days alone.
#[must_use]
pub fn training_days(cohort: &Cohort, protocol: &Protocol) -> Cohort {
    let people = cohort.people.iter().filter_map(|person| {
        let steps = protocol.training_days_of(&person.record) * STEPS_PER_DAY;
        Some(Person { record: person.record.slice(0..steps)?, ..person.clone() })
    });
    Cohort { people: people.collect() }
}

/// The named effects that can be inputs, each with the variant that fits the training windows best, and the others with
/// the reason.
///
/// # Errors
/// Windows that cannot be run.
pub fn acting(
    diagnosis: &Diagnosis,
    people: &[Subject<'_>],
    population: &Arc<PopulationModel>,
) -> Result<(Vec<Acting>, BTreeMap<String, String>), PlantsError> {
    let courses: Vec<Course> = people.iter().map(|subject| subject.course.clone()).collect();
    let (mut acting, mut left_out) = (Vec::new(), BTreeMap::new());
    for named in &diagnosis.effects {
        let Some(effect) = find(&named.effect) else {
            left_out.insert(named.effect.clone(), "it is not in the library".to_owned());
            continue;
        };
        if let Some(reason) = cannot_be_input(effect.as_ref(), &courses) {
            left_out.insert(named.effect.clone(), reason.to_owned());
            continue;
        }
        let mut best = (f64::INFINITY, 0);
        for variant in 0..effect.variants() {
            let losses: Vec<f64> = people
                .par_iter()
                .map(|subject| {
                    let amplitude = amplitude(diagnosis, &named.effect, &subject.person.id);
                    let acting = [(effect.as_ref(), variant, amplitude)];
                    subject.loss_under(population, &Active::new(&subject.course, acting))
                })
                .collect::<Result<_, PlantsError>>()?;
            let loss = losses.iter().sum::<f64>();
            if loss < best.0 {
                best = (loss, variant);
            }
        }
        acting.push(Acting { effect, variant: best.1 });
    }
    Ok((acting, left_out))
}

/// A person's amplitude of an effect; 0 for somebody whom the diagnosis left out.
fn amplitude(diagnosis: &Diagnosis, effect: &str, person: &str) -> f64 {
    let named = diagnosis.effects.iter().find(|found| found.effect == effect);
    let of = named.and_then(|found| found.people.iter().find(|p| p.person_id == person));
    of.map_or(0.0, |found| found.amplitude.max(0.0))
}

/// A person with windows and starts.
pub struct Subject<'a> {
    index: usize,
    /// Who it is.
    pub person: &'a Person,
    cut: PersonWindows,
    course: Course,
    heart_rate: Option<HeartRateScaler>,
    train: Vec<ScaledStates>,
    test: Vec<ScaledStates>,
}

/// Measured outcomes of a person, and outcomes and error by kind.
#[derive(Debug)]
pub struct Judged {
    /// Held-out windows.
    pub windows: usize,
    /// Of the readings.
    pub actual: Outcomes,
    /// Outcomes and root mean squared error, mg/dL, in the order of [`KINDS`].
    pub kinds: Vec<(Outcomes, f64)>,
}

impl<'a> Subject<'a> {
    /// Cuts a person's record; the inner error says why somebody is left out.
    ///
    /// # Errors
    /// Windows or starts that cannot be.
    pub fn new(
        index: usize,
        person: &'a Person,
        protocol: &Protocol,
        steady: &SteadyStates<'_, PopulationModel>,
    ) -> Result<Result<Self, String>, PlantsError> {
        let cut = PersonWindows::new(index, person, protocol)?;
        if let Some(reason) = cut.excluded {
            return Ok(Err(reason.to_string()));
        }
        let starts = |windows: &[Window]| -> Result<Vec<ScaledStates>, PlantsError> {
            let steps: Vec<usize> = windows.iter().map(|window| window.start).collect();
            let (inputs, start) = (&cut.inputs, protocol.start);
            let found = window_starts_with(steady, person, inputs, &steps, start, cut.mean_basal)?;
            Ok(found.states)
        };
        let (train, test) = (starts(&cut.train)?, starts(&cut.test)?);
        let rates = cut.train.iter().flat_map(|window| inputs_within(&cut.inputs, window));
        let heart_rate =
            HeartRateScaler::fit(rates.filter_map(|i| i.context.heart_rate_over_baseline))?;
        let course = course_of(person);
        Ok(Ok(Self { index, person, cut, course, heart_rate, train, test }))
    }

    /// Windows with the effects as inputs.
    fn prepared(
        &self,
        population: &Arc<PopulationModel>,
        windows: &[Window],
        starts: &[ScaledStates],
        active: &Active<'_>,
        inputs: InputSet,
    ) -> Result<Vec<PreparedWindow>, PlantsError> {
        let average = Kilograms(ode_sim::population::MEAN_WEIGHT);
        let network = ModulatedNetwork::new(population, self.person.weight.unwrap_or(average));
        let each = windows.iter().zip(starts);
        each.map(|(window, start)| {
            let steps = inputs_within(&self.cut.inputs, window);
            Ok(PreparedWindow::under(
                population,
                steps.to_vec(),
                &measured(self.person, window)?,
                active.known(&network, start, window, steps)?,
                self.heart_rate.as_ref(),
                inputs,
            )?)
        })
        .collect()
    }

    /// Loss of the population network under effects on the training windows.
    fn loss_under(
        &self,
        population: &Arc<PopulationModel>,
        active: &Active<'_>,
    ) -> Result<f64, PlantsError> {
        let windows =
            self.prepared(population, &self.cut.train, &self.train, active, InputSet::None)?;
        Ok(window_loss(population, &ResidualNetwork::zeros(), &windows, TwinLoss::PAPER)?)
    }

    /// Trains and judges every kind.
    ///
    /// # Errors
    /// A training or a run that fails.
    pub fn judged(
        &self,
        population: &Arc<PopulationModel>,
        acting: &[Acting],
        diagnosis: &Diagnosis,
        plan: &TrainingPlan,
        seed: u64,
    ) -> Result<Judged, PlantsError> {
        let amplitude =
            |acting: &Acting| amplitude(diagnosis, acting.effect.card().id.name(), &self.person.id);
        let effects = acting.iter().map(|a| (a.effect.as_ref(), a.variant, amplitude(a)));
        let (with_effects, nothing) =
            (Active::new(&self.course, effects), Active::new(&self.course, []));
        let glucose = self.cut.test.iter().map(|window| measured(self.person, window));
        let glucose = glucose.collect::<Result<Vec<Vec<f64>>, _>>()?;
        // What a sensor would have read.
        let (low, high) = GLUCOSE_RANGE;
        let read = |glucose: f64| glucose.clamp(low.0, high.0);
        let outcomes = |course: &[f64]| {
            let after = course[1..].iter();
            Outcomes::of(after.map(|glucose| MgPerDl(read(*glucose))))
        };
        let actual: Result<Vec<Outcomes>, _> = glucose.iter().map(|g| outcomes(g)).collect();
        let mut kinds = Vec::with_capacity(KINDS.len());
        for kind in KINDS {
            let active = if kind.effect { &with_effects } else { &nothing };
            let inputs = kind.residual.unwrap_or(InputSet::None);
            let network = match kind.residual {
                None => ResidualNetwork::zeros(),
                Some(_) => {
                    let windows =
                        self.prepared(population, &self.cut.train, &self.train, active, inputs)?;
                    // The same start and order for all kinds of a person.
                    let seed = seed.wrapping_mul(1_000_003).wrapping_add(self.index as u64);
                    let start = ResidualNetwork::untrained(seed);
                    train(population, start, &windows, &[], plan, seed)?.network
                }
            };
            let windows = self.prepared(population, &self.cut.test, &self.test, active, inputs)?;
            let courses = window_courses(population, &network, &windows)?;
            let (mut found, mut simulated, mut reference) = (Vec::new(), Vec::new(), Vec::new());
            for (course, glucose) in courses.iter().zip(&glucose) {
                let course: Vec<f64> = course.iter().map(|glucose| read(glucose.0)).collect();
                found.push(outcomes(&course)?);
                simulated.extend_from_slice(&course[1..]);
                reference.extend_from_slice(&glucose[1..]);
            }
            let error = agreement(&reference, &simulated)?;
            kinds.push((Outcomes::average(&found)?, error.rmse));
        }
        let windows = self.cut.test.len();
        Ok(Judged { windows, actual: Outcomes::average(&actual?)?, kinds })
    }
}
