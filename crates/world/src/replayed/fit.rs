//! The search for a body that can live a recorded person's days.

use cohort::Person;
use physiology::{Kilograms, MgPerDl, STEP, STEPS_PER_DAY};

use super::doses::Doses;
use super::{Days, NotReplayed, ReplayedPerson};
use crate::background::Background;
use crate::effects::{Amplitudes, Condition, Shapes};
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
/// Logarithms of the factor on insulin action between which it is sought.
const SCALES: (f64, f64) = (-1.6, 1.6);
/// Hour of the day about which one day's restoring change passes into the next's, steps.
const CHANGE: usize = 3 * physiology::STEPS_PER_HOUR;
/// Largest restoring change (log), and the largest spread between days that is believed.
const LARGEST_CHANGE: f64 = 0.9;
const LARGEST_SPREAD: f64 = 0.45;
/// Range in which a day's mean and its 5th and 95th percentiles shall lie, mg/dL.
const DAY_MEANS: (f64, f64) = (95.0, 230.0);
const DAY_EXTREMES: (f64, f64) = (55.0, 340.0);
/// Least share of the steps within 40 to 400 mg/dL, and largest distance of the mean from the one
/// sought, mg/dL.
const WITHIN: f64 = 0.97;
const OFF_TARGET: f64 = 15.0;
/// Fall of mean glucose with the logarithm of insulin action, mg/dL, of the order that bodies of
/// either kind have, and the range of it; the searches step by it.
const SLOPE: f64 = 200.0;
const SLOPES: (f64, f64) = (80.0, 500.0);
/// Simulations of a search, and the further ones with effects.
const ROUNDS: usize = 9;
const ROUNDS_WITH_EFFECTS: usize = 3;
/// Bodies that are tried.
const BODIES: usize = 4;

/// The log factor on insulin action of a step, passing from day to day within two hours about 3:00.
pub(super) fn change_at(restoring: &[f64], step: usize) -> f64 {
    let of = |day: usize| restoring.get(day).or(restoring.last()).copied().unwrap_or(0.0);
    let day = step / STEPS_PER_DAY;
    let into = (step % STEPS_PER_DAY) as f64 - CHANGE as f64;
    let share = (into / (2.0 * physiology::STEPS_PER_HOUR as f64) + 0.5).clamp(0.0, 1.0);
    let before = if day == 0 { of(0) } else { of(day - 1) };
    before + share * (of(day) - before)
}

/// Lets the restoring change act on the conditions of a record that starts at `offset`.
pub(super) fn restore(conditions: &mut [Condition], offset: usize, restoring: &[f64]) {
    for (step, condition) in conditions.iter_mut().enumerate() {
        let factor = change_at(restoring, step + offset).exp();
        condition.action *= factor;
        condition.liver_action *= factor;
    }
}

/// Glucose at the start, mg/dL: the first reading, within what bodies can rest at.
pub(super) fn first_glucose(person: &Person) -> f64 {
    person.record.cgm().iter().flatten().next().copied().unwrap_or(140.0).clamp(90.0, 160.0)
}

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
    let search = Search {
        plain: Days::new(&person, &life, &doses, Amplitudes::NONE),
        acting: (amplitudes != Amplitudes::NONE)
            .then(|| Days::new(&person, &life, &doses, amplitudes)),
        days: life.life.calendar.days(),
        daily_insulin: doses.inputs.iter().map(|i| i.insulin().during(STEP).0).sum::<f64>() / days,
        target: target(original),
    };
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

impl Search<'_> {
    /// The drawn body with the insulin action that the record asks for, and its restoring change.
    fn run(&self, drawn: Physique) -> Result<(Physique, Vec<f64>), NotReplayed> {
        let mut toward = Toward::new(self.first_scale(drawn)?);
        let mut restoring = vec![0.0; self.days];
        for round in 0..ROUNDS {
            let glucose = simulated(&self.plain, drawn, toward.scale, &restoring)?;
            if round > 0 {
                self.restore_days(&glucose, &mut restoring);
            }
            toward.step(mean(&glucose) - self.target);
        }
        let mut last = simulated(&self.plain, drawn, toward.scale, &restoring)?;
        self.judge(&last, &restoring)?;
        if let Some(acting) = &self.acting {
            for _ in 0..ROUNDS_WITH_EFFECTS {
                last = simulated(acting, drawn, toward.scale, &restoring)?;
                toward.step(mean(&last) - self.target);
            }
            last = simulated(acting, drawn, toward.scale, &restoring)?;
            self.judge(&last, &restoring)?;
        }
        Ok((drawn.with_action_scaled(toward.scale.exp()), restoring))
    }

    /// Log action with which half of the recorded insulin would be the body's basal need.
    fn first_scale(&self, drawn: Physique) -> Result<f64, NotReplayed> {
        let need = drawn
            .basal_at(MgPerDl(self.target))
            .map_err(|error| NotReplayed::Failed(error.to_string()))?;
        let scale = (2.0 * 24.0 * need.0 / self.daily_insulin.max(1.0)).ln();
        Ok(scale.clamp(SCALES.0, SCALES.1))
    }

    /// Changes the action of days that leave the range, no further than needed.
    fn restore_days(&self, glucose: &[f64], restoring: &mut [f64]) {
        for (day, change) in restoring.iter_mut().enumerate() {
            let from = (day * STEPS_PER_DAY + CHANGE).saturating_sub(self.plain.offset);
            let to = ((day + 1) * STEPS_PER_DAY + CHANGE).saturating_sub(self.plain.offset);
            let Some(within) = glucose.get(from..to.min(glucose.len())) else { continue };
            if within.len() < STEPS_PER_DAY / 4 {
                continue;
            }
            let mut sorted = within.to_vec();
            sorted.sort_by(f64::total_cmp);
            let at = |share: f64| sorted[(share * (sorted.len() - 1) as f64) as usize];
            let level = mean(within);
            let beyond = |value: f64, (low, high): (f64, f64)| {
                (value - high).max(0.0) + (value - low).min(0.0)
            };
            let (lowest, highest) = (at(0.05), at(0.95));
            let mut step = beyond(level, DAY_MEANS) / SLOPE;
            if lowest < DAY_EXTREMES.0 {
                step -= (DAY_EXTREMES.0 - lowest) / SLOPE;
            } else if highest > DAY_EXTREMES.1 {
                step += 0.5 * (highest - DAY_EXTREMES.1) / SLOPE;
            }
            *change = (*change + step.clamp(-0.25, 0.25)).clamp(-LARGEST_CHANGE, LARGEST_CHANGE);
        }
    }

    /// Whether a course is believable.
    fn judge(&self, glucose: &[f64], restoring: &[f64]) -> Result<(), NotReplayed> {
        let n = glucose.len() as f64;
        let within = glucose.iter().filter(|g| (40.0..=400.0).contains(*g)).count() as f64 / n;
        let level = mean(glucose);
        let days = restoring.len() as f64;
        let middle = restoring.iter().sum::<f64>() / days;
        let spread = (restoring.iter().map(|c| (c - middle).powi(2)).sum::<f64>() / days).sqrt();
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

/// Mean of values taken within what a sensor shows, so that one runaway day does not rule it.
fn mean(glucose: &[f64]) -> f64 {
    glucose.iter().map(|g| g.clamp(40.0, 400.0)).sum::<f64>() / glucose.len() as f64
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

/// A secant search for the log action, with the slope kept within what bodies have.
struct Toward {
    scale: f64,
    slope: f64,
    last: Option<(f64, f64)>,
}

impl Toward {
    fn new(scale: f64) -> Self {
        Self { scale, slope: SLOPE, last: None }
    }

    /// One step, given how far the mean is too high, mg/dL.
    fn step(&mut self, excess: f64) {
        if let Some((scale, before)) = self.last
            && (self.scale - scale).abs() > 0.005
        {
            self.slope = ((before - excess) / (self.scale - scale)).clamp(SLOPES.0, SLOPES.1);
        }
        self.last = Some((self.scale, excess));
        let step = (excess / self.slope).clamp(-0.5, 0.5);
        self.scale = (self.scale + step).clamp(SCALES.0, SCALES.1);
    }
}
