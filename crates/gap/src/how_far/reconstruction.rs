//! Hidden events and random factors, reconstructed from the readings that they have changed.
//!
//! With the filter's gains frozen, every place where an event could start and every day or meal that could
//! have a factor of its own is a direction in the innovations. Events are found one after the other,
//! the likeliest first, as long as an event is likelier than none; each gets its posterior mean times its
//! probability. Random factors get their joint posterior mean. How frequent and how strong both are
//! comes from training days.

use std::ops::Range;

use effects::{Course, EventShape, Field, Form, Modulation, RandomUnit};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};

use super::hidden::{Change, Hidden};
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

/// How frequent and how strong an effect's hidden changes are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Strength {
    /// Events a day; of no meaning for random factors.
    pub(super) per_day: f64,
    /// Size of events over the published one; standard deviation of the logarithm of random factors over
    /// the published one.
    pub(super) amplitude: f64,
}

/// What training days say about [`Strength`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct StrengthSums {
    days: f64,
    /// Events, each by its probability, or units of a random factor.
    count: f64,
    /// Sum of relative sizes of events, or of their squares for random factors.
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
    pub(super) fn strength(&self, form: &Form, before: Strength) -> Strength {
        let n = self.count + PRIOR_UNITS;
        let amplitude = match form {
            Form::Random { .. } => ((self.sum + PRIOR_UNITS * before.amplitude.powi(2)) / n).sqrt(),
            _ => (self.sum + PRIOR_UNITS * before.amplitude) / n,
        };
        let per_day = (self.count + PRIOR_DAYS * before.per_day) / (self.days + PRIOR_DAYS);
        Strength { per_day, amplitude }
    }
}

/// The strength of an effect of amplitude `amplitude`, which is the frequency of events, or the spread of a random
/// factor, over the published one; `None` for a driven one.
pub(super) fn published(form: &Form, amplitude: f64) -> Option<Strength> {
    match form {
        Form::Driven => None,
        Form::Events(shape) => {
            Some(Strength { per_day: shape.per_day * amplitude, amplitude: 1.0 })
        }
        Form::Random { .. } => Some(Strength { per_day: 0.0, amplitude }),
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

    /// Changes of the innovations, mg/dL, in units of whitened ones; `None` where not scored.
    fn whitened(&self, values: &[f64]) -> Vec<Option<f64>> {
        let change = |(own, value): (&Option<Innovation>, &f64)| {
            own.map(|own| Innovation { value: *value, ..own })
        };
        let changes: Vec<_> = self.filtered.innovations.iter().zip(values).map(change).collect();
        self.fit.whitening.standardised(&normalised(&changes, &self.scored))
    }

    /// Answers to changes of one field; changes whose answers do not meet share a pass.
    fn answers(&self, field: Field, changes: &[Pulse]) -> Result<Vec<Response>, GapError> {
        let n = self.range.len();
        let reach =
            |change: &Pulse| change.start..(change.start + change.course.len() + ANSWER).min(n);
        let lanes = packed(changes.iter().map(reach));
        let mut courses = vec![vec![0.0; n]; lanes.iter().max().map_or(0, |last| last + 1)];
        for (lane, change) in lanes.iter().zip(changes) {
            for (value, add) in courses[*lane][change.start..].iter_mut().zip(&change.course) {
                *value += add;
            }
        }
        let directions: Vec<Direction> =
            courses.into_iter().map(|course| Direction::Course(vec![(field, course)])).collect();
        let raw = signatures(&self.model, &self.record, &self.filtered, &directions)?;
        let whitened: Vec<Vec<Option<f64>>> =
            raw.iter().map(|values| self.whitened(values)).collect();
        let answer = |(lane, change): (&usize, &Pulse)| Response {
            start: change.start,
            values: whitened[*lane][reach(change)].iter().map(|w| w.unwrap_or(0.0)).collect(),
        };
        Ok(lanes.iter().zip(changes).map(answer).collect())
    }

    /// Weighted square of an answer, and minus its weighted product with the residuals.
    fn information_and_score(&self, answer: &Response) -> (f64, f64) {
        let (mut information, mut score) = (0.0, 0.0);
        for (offset, value) in answer.values.iter().enumerate() {
            let step = answer.start + offset;
            information += self.weights[step] * value * value;
            score -= self.weights[step] * value * self.residuals[step];
        }
        (information, score)
    }

    /// Takes a change into the residuals.
    fn explain(&mut self, answer: &Response, amount: f64) {
        for (residual, value) in self.residuals[answer.start..].iter_mut().zip(&answer.values) {
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
        match form {
            Form::Driven => Ok((Vec::new(), StrengthSums::default())),
            Form::Events(shape) => self.events(shape, strength, within),
            Form::Random { field, unit, log_sd } => {
                self.factors(*field, *unit, log_sd * strength.amplitude, *log_sd, within, course)
            }
        }
    }

    fn events(
        &mut self,
        shape: &EventShape,
        strength: Strength,
        within: &Range<usize>,
    ) -> Result<(Vec<Hidden>, StrengthSums), GapError> {
        let longest = shape.profiles.iter().map(Vec::len).max().unwrap_or(0);
        let grid = (longest + ANSWER).div_ceil(MOST_LANES).max(GRID);
        let mut onsets: Vec<usize> = Vec::new();
        for onset in shape.onsets.iter().filter(|o| within.contains(*o)) {
            if onsets.last().is_none_or(|last| onset / grid != last / grid) {
                onsets.push(*onset);
            }
        }
        let days = within.len() as f64 / STEPS_PER_DAY as f64;
        let mut tally = StrengthSums { days, ..StrengthSums::default() };
        let mut hidden = Vec::new();
        if onsets.is_empty() || strength.per_day <= 0.0 || strength.amplitude <= 0.0 {
            return Ok((hidden, tally));
        }
        // Every profile at every onset.
        let places: Vec<(usize, &Vec<f64>)> = onsets
            .iter()
            .flat_map(|onset| shape.profiles.iter().map(move |profile| (*onset, profile)))
            .collect();
        let pulses: Vec<Pulse> = places
            .iter()
            .map(|(onset, profile)| Pulse {
                start: onset - self.range.start,
                course: (*profile).clone(),
            })
            .collect();
        let answers = self.answers(shape.field, &pulses)?;
        let chance = (strength.per_day * days / places.len() as f64).clamp(1e-6, 0.5);
        let prior_odds = (chance / (1.0 - chance)).ln();
        let usual: f64 = shape.sizes.iter().map(|(size, weight)| size * weight).sum();
        let mut state: Vec<Event> = answers
            .iter()
            .map(|answer| Event::of(self, answer, shape, strength.amplitude))
            .collect();
        for _ in &onsets {
            let best = (0..state.len())
                .filter(|k| !state[*k].taken)
                .max_by(|a, b| state[*a].log_odds.total_cmp(&state[*b].log_odds));
            let Some(best) = best.filter(|k| state[*k].log_odds + prior_odds > 0.0) else { break };
            let probability = 1.0 / (1.0 + (-state[best].log_odds - prior_odds).exp());
            let amount = probability * state[best].size;
            let (onset, profile) = places[best];
            for (event, place) in state.iter_mut().zip(&places) {
                event.taken |= place.0 == onset;
            }
            for (offset, value) in profile.iter().enumerate() {
                hidden.push((onset + offset, shape.field, Change::Added(amount * value)));
            }
            tally.count += probability;
            tally.sum += amount / usual;
            self.explain(&answers[best], amount);
            let touched = answers[best].start..answers[best].start + answers[best].values.len();
            for (event, answer) in state.iter_mut().zip(&answers) {
                let meets = answer.start < touched.end
                    && touched.start < answer.start + answer.values.len();
                if meets && !event.taken {
                    *event = Event::of(self, answer, shape, strength.amplitude);
                }
            }
        }
        Ok((hidden, tally))
    }

    fn factors(
        &mut self,
        field: Field,
        unit: RandomUnit,
        sd: f64,
        published_sd: f64,
        within: &Range<usize>,
        course: &Course,
    ) -> Result<(Vec<Hidden>, StrengthSums), GapError> {
        let units = unit_steps(unit, within.clone(), course);
        let days = within.len() as f64 / STEPS_PER_DAY as f64;
        let mut tally = StrengthSums { days, ..StrengthSums::default() };
        let mut hidden = Vec::new();
        if units.is_empty() || sd <= 0.0 {
            return Ok((hidden, tally));
        }
        let pulses: Vec<Pulse> = units
            .iter()
            .map(|steps| Pulse {
                start: steps.start - self.range.start,
                // The slope along the logarithm of a factor is the factor that is there.
                course: steps
                    .clone()
                    .map(|step| self.record.modulation(step - self.range.start)[field])
                    .collect(),
            })
            .collect();
        let answers = self.answers(field, &pulses)?;
        let n = units.len();
        let mut precision = Mat::<f64>::zeros(n, n);
        let mut right = Mat::<f64>::zeros(n, 1);
        for (row, answer) in answers.iter().enumerate() {
            let (information, score) = self.information_and_score(answer);
            precision[(row, row)] = information + sd.powi(-2);
            right[(row, 0)] = score;
            for (column, other) in answers.iter().enumerate().take(row) {
                let shared = self.shared(answer, other);
                precision[(row, column)] = shared;
                precision[(column, row)] = shared;
            }
        }
        let factor = precision
            .llt(Side::Lower)
            .map_err(|_| GapError::Singular { person: self.record.person.clone() })?;
        let mean = factor.solve(&right);
        let covariance = factor.solve(&Mat::<f64>::identity(n, n));
        for (row, steps) in units.iter().enumerate() {
            let log = mean[(row, 0)];
            for step in steps.clone() {
                hidden.push((step, field, Change::Factor(log.exp())));
            }
            self.explain(&answers[row], log);
            tally.count += 1.0;
            tally.sum += (log * log + covariance[(row, row)]) / published_sd.powi(2);
        }
        Ok((hidden, tally))
    }

    /// Weighted product of two answers.
    fn shared(&self, a: &Response, b: &Response) -> f64 {
        let from = a.start.max(b.start);
        let to = (a.start + a.values.len()).min(b.start + b.values.len());
        (from..to)
            .map(|step| self.weights[step] * a.values[step - a.start] * b.values[step - b.start])
            .sum()
    }
}

/// A change of one field over some steps, from an offset in the stretch.
struct Pulse {
    start: usize,
    course: Vec<f64>,
}

/// What a change does to the whitened innovations from its start on.
struct Response {
    start: usize,
    values: Vec<f64>,
}

/// A place where an event could be.
struct Event {
    /// Log of the evidence for an event there over none.
    log_odds: f64,
    /// Posterior mean size if there is one.
    size: f64,
    taken: bool,
}

impl Event {
    fn of(linear: &Linear<'_>, answer: &Response, shape: &EventShape, amplitude: f64) -> Self {
        let (information, score) = linear.information_and_score(answer);
        let (sizes, logs): (Vec<f64>, Vec<f64>) = shape
            .sizes
            .iter()
            .map(|(size, weight)| {
                let size = size * amplitude;
                (size, weight.ln() + size * score - 0.5 * size * size * information)
            })
            .unzip();
        let weights = raised(&logs);
        let total: f64 = weights.iter().sum();
        let size = sizes.iter().zip(&weights).map(|(size, w)| size * w).sum::<f64>() / total;
        Self { log_odds: log_sum(&logs), size, taken: false }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_amplitude_is_a_frequency_of_events_and_a_spread_of_factors() {
        let (field, profiles) = (Field::ExtraCarbs, vec![vec![25.0]]);
        let sizes = vec![(1.0, 1.0)];
        let events =
            Form::Events(EventShape { field, profiles, onsets: Vec::new(), per_day: 0.4, sizes });
        let random = Form::Random { field: Field::GutTime, unit: RandomUnit::Day, log_sd: 0.2 };
        let strength = |per_day, amplitude| Some(Strength { per_day, amplitude });
        assert_eq!(published(&events, 0.25), strength(0.1, 1.0));
        assert_eq!(published(&random, 0.25), strength(0.0, 0.25));
        assert_eq!(published(&Form::Driven, 0.25), None);
    }
}
