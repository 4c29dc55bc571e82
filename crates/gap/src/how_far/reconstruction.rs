//! Hidden events and random factors, reconstructed from the readings that they have changed.
//!
//! With the filter's gains frozen, every place where an event could start and every day or meal that could
//! have a factor of its own is a direction in the innovations. Events are found one after the other,
//! the likeliest first, as long as an event is likelier than none; each gets its posterior mean times its
//! probability. Random factors get their joint posterior mean. How frequent and how strong both are
//! comes from training days.

use std::ops::Range;

use effects::{Course, EventShape, Field, Form, Modulation};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};

use super::refit::{Fit, model, stretch};
use crate::design::{packed, unit_steps};
use crate::error::GapError;
use crate::filter::augmented::AugmentedModel;
use crate::filter::calibration::CalibrationRule;
use crate::filter::kalman::{Filtered, Innovation, filter};
use crate::filter::observations::Observations;
use crate::filter::scored::normalised;
use crate::filter::tangent::{Direction, signatures};
use crate::filter::whitening::huber_weight;
use crate::log_sum::{log_sum, raised};

/// Steps that the filter's answer to a change is followed beyond its end: 6 h.
const ANSWER: usize = 6 * STEPS_PER_HOUR;
/// Fewest steps between places where an event may start: half an hour.
const GRID: usize = STEPS_PER_HOUR / 2;
/// Most directions that one kind of event takes.
const MOST_LANES: usize = 24;
/// Days of record that the published frequency of events counts for.
const PRIOR_DAYS: f64 = 7.0;
/// Events or units that the strength found on the whole record counts for.
const PRIOR_UNITS: f64 = 5.0;

/// An event or a factor that was reconstructed: what it does to a field in one step of the record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hidden {
    step: usize,
    field: Field,
    /// What the field is multiplied by, and what is added then.
    factor: f64,
    added: f64,
}

/// Adds hidden changes to modulations of the whole record. A factor does not turn negative.
pub(super) fn add(hidden: &[Hidden], modulations: &mut [Modulation]) {
    for Hidden { step, field, factor, added } in hidden {
        let Some(modulation) = modulations.get_mut(*step) else { continue };
        modulation[*field] = modulation[*field] * factor + added;
        if field.neutral() > 0.0 {
            modulation[*field] = modulation[*field].max(0.0);
        }
    }
}

/// How frequent and how strong an effect's hidden changes are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Strength {
    /// Events a day; of no meaning for random factors.
    per_day: f64,
    /// Size of events over the published one; variance of the logarithm of random factors over the published
    /// one.
    size: f64,
}

/// What training days say about [`Strength`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct StrengthSums {
    days: f64,
    /// Events, each by its probability, or units of a random factor.
    count: f64,
    /// Sum of relative sizes of events, or of relative squares for random factors.
    sum: f64,
}

impl StrengthSums {
    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            days: self.days + other.days,
            count: self.count + other.count,
            sum: self.sum + other.sum,
        }
    }

    /// The strength after these days when it was `before` them.
    pub(super) fn strength(&self, before: Strength) -> Strength {
        Strength {
            per_day: (self.count + PRIOR_DAYS * before.per_day) / (self.days + PRIOR_DAYS),
            size: (self.sum + PRIOR_UNITS * before.size) / (self.count + PRIOR_UNITS),
        }
    }
}

/// The strength of a hidden effect of amplitude `amplitude`, which is the frequency of events, or the spread of a
/// random factor, over the published one; a negative one is none.
pub(super) fn published(form: &Form, amplitude: f64) -> Strength {
    match form {
        Form::Events(shape) => Strength { per_day: shape.per_day * amplitude, size: 1.0 },
        _ => Strength { per_day: 0.0, size: amplitude.max(0.0).powi(2) },
    }
}

/// A stretch of a record in the units of whitened innovations.
pub(super) struct Linear<'a> {
    range: Range<usize>,
    fit: &'a Fit,
    model: AugmentedModel,
    record: Observations,
    filtered: Filtered,
    /// 0 where not scored.
    residuals: Vec<f64>,
    /// 0 where not scored.
    weights: Vec<f64>,
    scored: Vec<bool>,
}

impl<'a> Linear<'a> {
    /// Filters a stretch under modulations of the whole record.
    ///
    /// # Errors
    /// As [`filter`].
    pub(super) fn new(
        observations: &Observations,
        person: &AugmentedModel,
        range: &Range<usize>,
        modulations: &[Modulation],
        fit: &'a Fit,
        rule: &CalibrationRule,
    ) -> Result<Self, GapError> {
        let model = model(person, &fit.factors);
        let record = stretch(observations, range, modulations);
        let filtered = filter(&model, &record)?;
        let scored = rule.scored(observations, range);
        let residuals = fit.whitening.standardised(&normalised(&filtered.innovations, &scored));
        Ok(Self {
            range: range.clone(),
            fit,
            model,
            record,
            filtered,
            weights: residuals.iter().map(|w| w.map_or(0.0, |w| huber_weight(w, 1.0))).collect(),
            residuals: residuals.into_iter().map(|w| w.unwrap_or(0.0)).collect(),
            scored,
        })
    }

    /// Changes of the innovations, mg/dL, in units of whitened ones; 0 where not scored.
    fn whitened(&self, values: &[f64]) -> Vec<f64> {
        let change = |(own, value): (&Option<Innovation>, &f64)| {
            own.map(|own| Innovation { value: *value, ..own })
        };
        let changes: Vec<_> = self.filtered.innovations.iter().zip(values).map(change).collect();
        let whitened = self.fit.whitening.standardised(&normalised(&changes, &self.scored));
        whitened.into_iter().map(|w| w.unwrap_or(0.0)).collect()
    }

    /// Answers to changes of one field; changes whose answers do not meet share a pass.
    fn answers(&self, field: Field, changes: &[Pulse]) -> Result<Vec<Response>, GapError> {
        let n = self.range.len();
        let reach = |change: &Pulse| {
            let start = change.start - self.range.start;
            start..(start + change.course.len() + ANSWER).min(n)
        };
        let lanes = packed(changes.iter().map(reach));
        let mut courses = vec![vec![0.0; n]; lanes.iter().max().map_or(0, |last| last + 1)];
        for (lane, change) in lanes.iter().zip(changes) {
            for (value, add) in courses[*lane][reach(change)].iter_mut().zip(&change.course) {
                *value += add;
            }
        }
        let directions: Vec<Direction> =
            courses.into_iter().map(|course| Direction::Course(vec![(field, course)])).collect();
        let raw = signatures(&self.model, &self.record, &self.filtered, &directions)?;
        let whitened: Vec<Vec<f64>> = raw.iter().map(|values| self.whitened(values)).collect();
        let answer = |(lane, change): (&usize, &Pulse)| {
            let steps = reach(change);
            Response { values: whitened[*lane][steps.clone()].to_vec(), steps }
        };
        Ok(lanes.iter().zip(changes).map(answer).collect())
    }

    /// Weighted product of two answers.
    fn shared(&self, a: &Response, b: &Response) -> f64 {
        let both = a.steps.start.max(b.steps.start)..a.steps.end.min(b.steps.end);
        let value = |of: &Response, step: usize| of.values[step - of.steps.start];
        both.map(|step| self.weights[step] * value(a, step) * value(b, step)).sum()
    }

    /// Minus the weighted product of an answer with the residuals.
    fn score(&self, answer: &Response) -> f64 {
        let steps = answer.steps.clone().zip(&answer.values);
        steps.map(|(step, value)| -self.weights[step] * value * self.residuals[step]).sum()
    }

    /// Takes a change into the residuals.
    fn explain(&mut self, answer: &Response, amount: f64) {
        let residuals = &mut self.residuals[answer.steps.clone()];
        for (residual, value) in residuals.iter_mut().zip(&answer.values) {
            *residual += amount * value;
        }
    }

    /// Reconstructs what an effect did in the steps of `within` (of the whole record), takes it out of the
    /// residuals, and counts it.
    ///
    /// # Errors
    /// As [`signatures`].
    pub(super) fn reconstruct(
        &mut self,
        form: &Form,
        strength: Strength,
        within: &Range<usize>,
        course: &Course,
    ) -> Result<(Vec<Hidden>, StrengthSums), GapError> {
        let days = within.len() as f64 / STEPS_PER_DAY as f64;
        let mut sums = StrengthSums { days, ..StrengthSums::default() };
        let hidden = match form {
            Form::Driven => return Ok((Vec::new(), StrengthSums::default())),
            Form::Events(shape) => self.events(shape, strength, within, &mut sums)?,
            Form::Random { field, unit, log_sd } => {
                let units = unit_steps(*unit, within.clone(), course);
                self.factors(*field, &units, *log_sd, strength, &mut sums)?
            }
        };
        Ok((hidden, sums))
    }

    fn events(
        &mut self,
        shape: &EventShape,
        strength: Strength,
        within: &Range<usize>,
        sums: &mut StrengthSums,
    ) -> Result<Vec<Hidden>, GapError> {
        let longest = shape.profiles.iter().map(Vec::len).max().unwrap_or(0);
        let grid = (longest + ANSWER).div_ceil(MOST_LANES).max(GRID);
        let mut onsets: Vec<usize> =
            shape.onsets.iter().copied().filter(|onset| within.contains(onset)).collect();
        onsets.dedup_by_key(|onset| *onset / grid);
        let mut hidden = Vec::new();
        if onsets.is_empty() || strength.per_day <= 0.0 || strength.size <= 0.0 {
            return Ok(hidden);
        }
        // Every profile at every onset.
        let pulses: Vec<Pulse> = onsets
            .iter()
            .flat_map(|start| shape.profiles.iter().map(move |profile| (*start, profile)))
            .map(|(start, profile)| Pulse { start, course: profile.clone() })
            .collect();
        let field = shape.field;
        let answers = self.answers(field, &pulses)?;
        let chance = (strength.per_day * sums.days / pulses.len() as f64).clamp(1e-6, 0.5);
        let prior_odds = (chance / (1.0 - chance)).ln();
        let usual: f64 = shape.sizes.iter().map(|(size, weight)| size * weight).sum();
        let sizes: Vec<(f64, f64)> =
            shape.sizes.iter().map(|(size, weight)| (size * strength.size, weight.ln())).collect();
        // `None` where one was found at the same onset.
        let mut events: Vec<Option<Event>> =
            answers.iter().map(|answer| Some(self.event(answer, &sizes))).collect();
        for _ in &onsets {
            let open = (0..events.len()).filter_map(|k| Some((k, events[k]?)));
            let best = open.max_by(|(_, a), (_, b)| a.log_odds.total_cmp(&b.log_odds));
            let likely = best.filter(|(_, event)| event.log_odds + prior_odds > 0.0);
            let Some((best, Event { log_odds, size })) = likely else { break };
            let probability = 1.0 / (1.0 + (-log_odds - prior_odds).exp());
            let amount = probability * size;
            let Pulse { start, course } = &pulses[best];
            for (step, value) in (*start..).zip(course) {
                hidden.push(Hidden { step, field, factor: 1.0, added: amount * value });
            }
            sums.count += probability;
            sums.sum += amount / usual;
            let found = &answers[best];
            self.explain(found, amount);
            for ((event, pulse), answer) in events.iter_mut().zip(&pulses).zip(&answers) {
                let meets =
                    answer.steps.start < found.steps.end && found.steps.start < answer.steps.end;
                if pulse.start == *start {
                    *event = None;
                } else if meets && event.is_some() {
                    *event = Some(self.event(answer, &sizes));
                }
            }
        }
        Ok(hidden)
    }

    /// The evidence for an event with this answer. `sizes` are those it could have, each with the logarithm of its
    /// prior weight.
    fn event(&self, answer: &Response, sizes: &[(f64, f64)]) -> Event {
        let (information, score) = (self.shared(answer, answer), self.score(answer));
        let log = |(size, log): &(f64, f64)| log + size * score - 0.5 * size * size * information;
        let logs: Vec<f64> = sizes.iter().map(log).collect();
        let weights = raised(&logs);
        let total: f64 = weights.iter().sum();
        let size = sizes.iter().zip(&weights).map(|((size, _), w)| size * w).sum::<f64>() / total;
        Event { log_odds: log_sum(&logs), size }
    }

    fn factors(
        &mut self,
        field: Field,
        units: &[Range<usize>],
        log_sd: f64,
        strength: Strength,
        sums: &mut StrengthSums,
    ) -> Result<Vec<Hidden>, GapError> {
        let sd = log_sd * strength.size.sqrt();
        let mut hidden = Vec::new();
        if units.is_empty() || sd <= 0.0 {
            return Ok(hidden);
        }
        // The slope along the logarithm of a factor is the factor that is there.
        let there = |step: usize| self.record.modulation(step - self.range.start)[field];
        let pulse = |steps: &Range<usize>| Pulse {
            start: steps.start,
            course: steps.clone().map(there).collect(),
        };
        let pulses: Vec<Pulse> = units.iter().map(pulse).collect();
        let answers = self.answers(field, &pulses)?;
        let n = units.len();
        let precision = Mat::from_fn(n, n, |row, column| {
            let prior = if row == column { sd.powi(-2) } else { 0.0 };
            self.shared(&answers[row], &answers[column]) + prior
        });
        let right = Mat::from_fn(n, 1, |row, _| self.score(&answers[row]));
        let factor = precision
            .llt(Side::Lower)
            .map_err(|_| GapError::Singular { person: self.record.person.clone() })?;
        let mean = factor.solve(&right);
        let covariance = factor.solve(&Mat::<f64>::identity(n, n));
        for (row, steps) in units.iter().enumerate() {
            let log = mean[(row, 0)];
            let factor = log.exp();
            hidden.extend(steps.clone().map(|step| Hidden { step, field, factor, added: 0.0 }));
            self.explain(&answers[row], log);
            sums.count += 1.0;
            sums.sum += (log * log + covariance[(row, row)]) / log_sd.powi(2);
        }
        Ok(hidden)
    }
}

/// A change of one field over some steps of the record, from its start on.
struct Pulse {
    start: usize,
    course: Vec<f64>,
}

/// What a change does to the whitened innovations in some steps of the stretch.
struct Response {
    steps: Range<usize>,
    values: Vec<f64>,
}

/// An event that could be at a place.
#[derive(Clone, Copy)]
struct Event {
    /// Log of the evidence for an event there over none.
    log_odds: f64,
    /// Posterior mean size if there is one.
    size: f64,
}

#[cfg(test)]
mod tests {
    use effects::RandomUnit;

    use super::*;

    #[test]
    fn an_amplitude_is_a_frequency_of_events_and_a_spread_of_factors() {
        let (field, profiles) = (Field::ExtraCarbs, vec![vec![25.0]]);
        let sizes = vec![(1.0, 1.0)];
        let events =
            Form::Events(EventShape { field, profiles, onsets: Vec::new(), per_day: 0.4, sizes });
        let random = Form::Random { field: Field::GutTime, unit: RandomUnit::Day, log_sd: 0.2 };
        assert_eq!(published(&events, 0.25), Strength { per_day: 0.1, size: 1.0 });
        assert_eq!(published(&random, 0.25), Strength { per_day: 0.0, size: 0.0625 });
        assert_eq!(published(&random, -0.25), Strength { per_day: 0.0, size: 0.0 });
    }
}
