//! The search for a body that can live a recorded person's days.

use cohort::Person;
use physiology::{Kilograms, MgPerDl, STEP, STEPS_PER_DAY};

use super::days::Days;
use super::doses::Doses;
use super::recorded_life::RecordedLife;
use super::restoring::{LARGEST_SPREAD, mean, mend, spread};
use super::toward::Toward;
use super::{NotReplayed, ReplayedPerson};
use crate::background::Background;
use crate::effects::{Amplitudes, Shapes};
use crate::error::WorldError;
use crate::generator::Generator;
use crate::physique::Physique;
use crate::stream::{Concept, stream};

/// Fewest days.
const FEWEST_DAYS: f64 = 3.0;
/// Least share of the steps with a basal rate, and of the days with carbohydrate.
const BASAL_RECORDED: f64 = 0.8;
const CARBS_RECORDED: f64 = 0.6;
/// Means that are sought, mg/dL: the recorded one within these.
const TARGETS: (f64, f64) = (110.0, 190.0);
/// Least share of the steps within 40 to 400 mg/dL, and largest distance of the mean from the one
/// sought, mg/dL.
const WITHIN: f64 = 0.97;
const OFF_TARGET: f64 = 15.0;
/// Simulations of a search, those at its end that change the mean alone, and the further ones with
/// effects.
const ROUNDS: usize = 10;
const ROUNDS_AFTER: usize = 3;
const ROUNDS_WITH_EFFECTS: usize = 3;
/// Bodies that are tried.
const BODIES: usize = 4;

/// See [`ReplayedPerson::fit`].
pub(super) fn fit(
    generator: Generator,
    seed: u64,
    index: usize,
    original: &Person,
    amplitudes: Amplitudes,
) -> Result<ReplayedPerson, NotReplayed> {
    let failed = |error: WorldError| NotReplayed::Failed(error.to_string());
    let days = original.record.len() as f64 / STEPS_PER_DAY as f64;
    if days < FEWEST_DAYS {
        return Err(NotReplayed::TooShort { days, fewest: FEWEST_DAYS });
    }
    let doses = Doses::of(original).map_err(|error| NotReplayed::Failed(error.to_string()))?;
    if doses.basal_recorded < BASAL_RECORDED {
        return Err(NotReplayed::NoBasal { percent: 100.0 * doses.basal_recorded });
    }
    let fed = doses
        .inputs
        .chunks(STEPS_PER_DAY)
        .filter(|day| day.iter().any(|input| input.carbs.0 > 0.0))
        .count() as f64
        / days.ceil();
    if fed < CARBS_RECORDED {
        return Err(NotReplayed::NoCarbohydrate { percent: 100.0 * fed });
    }

    let mut bodies = stream(seed, index, Concept::Body);
    let mut person = ReplayedPerson {
        seed,
        index,
        original: original.clone(),
        body: Physique::sample(generator, index, &mut bodies).map_err(failed)?,
        amplitudes,
        shapes: Shapes::sample(&mut stream(seed, index, Concept::Shapes)),
        background: Background::REALISTIC,
        restoring: Vec::new(),
    };
    let life = person.recorded_life();
    let search = Search::new(&person, &life, &doses);
    let weighed = |body: Physique| {
        let drawn = body.weight();
        body.with_weight(original.weight.map_or(drawn, |w| Kilograms(w.0.clamp(35.0, 160.0))))
    };
    let mut found = search.run(weighed(person.body));
    for _ in 1..BODIES {
        if found.is_ok() {
            break;
        }
        let next = Physique::sample(generator, index, &mut bodies).map_err(failed)?;
        found = search.run(weighed(next));
    }
    let (body, restoring) = found?;
    person.body = body;
    person.restoring = restoring;
    Ok(person)
}

/// See [`ReplayedPerson::with_amplitudes`].
pub(super) fn with_amplitudes(
    person: &ReplayedPerson,
    amplitudes: Amplitudes,
) -> Result<ReplayedPerson, NotReplayed> {
    let doses =
        Doses::of(&person.original).map_err(|error| NotReplayed::Failed(error.to_string()))?;
    let mut other = ReplayedPerson { amplitudes, ..person.clone() };
    let life = person.recorded_life();
    let search = Search::new(&other, &life, &doses);
    let acting = search.acting.as_ref().unwrap_or(&search.plain);
    other.body = search.adjusted(acting, person.body, &person.restoring)?;
    Ok(other)
}

/// Mean glucose that is sought, mg/dL.
fn target(person: &Person) -> f64 {
    let readings: Vec<f64> = person.record.cgm().iter().flatten().copied().collect();
    let mean = readings.iter().sum::<f64>() / readings.len() as f64;
    if mean.is_finite() { mean.clamp(TARGETS.0, TARGETS.1) } else { 0.5 * (TARGETS.0 + TARGETS.1) }
}

/// The days of one person without and with effects, and what is sought.
struct Search<'a> {
    plain: Days<'a>,
    acting: Option<Days<'a>>,
    days: usize,
    daily_insulin: f64,
    target: f64,
}

impl<'a> Search<'a> {
    fn new(person: &ReplayedPerson, life: &RecordedLife, doses: &'a Doses) -> Self {
        let acting = person.amplitudes != Amplitudes::NONE;
        let days = doses.len() as f64 / STEPS_PER_DAY as f64;
        let insulin: f64 = doses.inputs.iter().map(|input| input.insulin().during(STEP).0).sum();
        Self {
            plain: Days::new(person, life, doses, Amplitudes::NONE),
            acting: acting.then(|| Days::new(person, life, doses, person.amplitudes)),
            days: life.life.calendar.days(),
            daily_insulin: insulin / days,
            target: target(&person.original),
        }
    }

    /// The drawn body with the insulin action that the record needs, and its restoring change.
    fn run(&self, drawn: Physique) -> Result<(Physique, Vec<f64>), NotReplayed> {
        let mut toward = Toward::new(self.first_scale(drawn)?);
        let mut restoring = vec![0.0; self.days];
        for round in 0..ROUNDS {
            let glucose = simulated(&self.plain, drawn, toward.scale, &restoring)?;
            if (1..ROUNDS - ROUNDS_AFTER).contains(&round) {
                mend(&mut restoring, &glucose, self.plain.inputs.offset);
            }
            toward.step(mean(&glucose) - self.target);
        }
        self.judge(&simulated(&self.plain, drawn, toward.scale, &restoring)?, &restoring)?;
        let found = drawn.with_action_scaled(toward.scale.exp());
        let body = match &self.acting {
            Some(acting) => self.adjusted(acting, found, &restoring)?,
            None => found,
        };
        Ok((body, restoring))
    }

    /// A found body with the insulin action that restores the mean while effects act.
    fn adjusted(
        &self,
        acting: &Days<'_>,
        found: Physique,
        restoring: &[f64],
    ) -> Result<Physique, NotReplayed> {
        let mut toward = Toward::new(0.0);
        for _ in 0..ROUNDS_WITH_EFFECTS {
            let glucose = simulated(acting, found, toward.scale, restoring)?;
            toward.step(mean(&glucose) - self.target);
        }
        self.judge(&simulated(acting, found, toward.scale, restoring)?, restoring)?;
        Ok(found.with_action_scaled(toward.scale.exp()))
    }

    /// Log action with which half of the recorded insulin would be the body's basal need.
    fn first_scale(&self, drawn: Physique) -> Result<f64, NotReplayed> {
        let need = drawn
            .basal_at(MgPerDl(self.target))
            .map_err(|error| NotReplayed::Failed(error.to_string()))?;
        let scale = (2.0 * 24.0 * need.0 / self.daily_insulin.max(1.0)).ln();
        Ok(scale)
    }

    /// Whether a course is believable.
    fn judge(&self, glucose: &[f64], restoring: &[f64]) -> Result<(), NotReplayed> {
        let n = glucose.len() as f64;
        let within = glucose.iter().filter(|g| (40.0..=400.0).contains(*g)).count() as f64 / n;
        let level = mean(glucose);
        let spread = spread(restoring);
        let off = (level - self.target).abs();
        if within < WITHIN || off > OFF_TARGET || spread > LARGEST_SPREAD {
            return Err(NotReplayed::NoBody {
                mean: level,
                target: self.target,
                within: 100.0 * within,
                restoring: spread,
            });
        }
        Ok(())
    }
}

/// Glucose of a drawn body, mg/dL, with its insulin action scaled.
fn simulated(
    days: &Days<'_>,
    drawn: Physique,
    scale: f64,
    restoring: &[f64],
) -> Result<Vec<f64>, NotReplayed> {
    let run = days
        .lived(drawn.with_action_scaled(scale.exp()), restoring)
        .map_err(|error| NotReplayed::Failed(error.to_string()))?;
    Ok(run.glucose.iter().map(|g| g.0).collect())
}
