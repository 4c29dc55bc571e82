//! Hidden events wherever they could start: what each would do to the whitened innovations.
//!
//! The linear model answers to a course of a field as it does to the pulses that the course is made of. The
//! answers to single pulses are worked out once for each field; many pulses share a direction as long as their
//! answers do not meet. An event of any shape is then a sum of answers.

use effects::{EventShape, Field};
use physiology::STEPS_PER_HOUR;

use crate::tangent::Direction;

/// Hidden events of one effect at every place where one could start.
#[derive(Debug, Clone)]
pub struct EventBank {
    /// Place in the library.
    pub effect: usize,
    /// Its shapes.
    pub shape: EventShape,
    /// Steps at which an event may start.
    pub onsets: Vec<usize>,
    /// What is known of an event of each profile there: by onset, an entry a profile.
    pub known: Vec<Vec<EventScore>>,
}

/// What is known of an event of one onset and profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EventScore {
    /// Information about its amplitude: the weighted square of its signature.
    pub information: f64,
    /// Minus the weighted product of signature and residual.
    pub score: f64,
}

/// The hidden events of every effect that acts by them, and the answers to pulses of the fields that they change.
#[derive(Debug, Clone, Default)]
pub struct HiddenEvents {
    /// Place in the library, and shapes.
    effects: Vec<(usize, EventShape)>,
    fields: Vec<PulseLanes>,
    /// By field and direction; whitened.
    answers: Vec<Vec<Vec<f32>>>,
}

impl HiddenEvents {
    /// Those of a record of so many steps; the answers are yet to come.
    pub(crate) fn of(effects: Vec<(usize, EventShape)>, steps: usize) -> Self {
        let mut fields: Vec<PulseLanes> = Vec::new();
        for (_, shape) in &effects {
            if fields.iter().all(|known| known.field != shape.field) {
                fields.push(PulseLanes::of(shape.field, steps));
            }
        }
        Self { effects, fields, answers: Vec::new() }
    }

    /// The directions of all pulses.
    pub(crate) fn directions(&self) -> impl Iterator<Item = Direction> + '_ {
        self.fields.iter().flat_map(PulseLanes::directions)
    }

    /// Takes the whitened answers to [`Self::directions`].
    pub(crate) fn answered(&mut self, answers: Vec<Vec<f32>>) {
        let mut answers = answers.into_iter();
        self.answers = self
            .fields
            .iter()
            .map(|field| answers.by_ref().take(field.count()).collect())
            .collect();
    }

    /// Scores every event against what the background that `beside` gives for its effect leaves of the residuals.
    pub(crate) fn banks<'a>(
        self,
        beside: impl Fn(usize) -> Beside<'a>,
        weights: &[f64],
    ) -> Vec<EventBank> {
        let Self { effects, fields, answers } = self;
        effects
            .into_iter()
            .filter_map(|(effect, shape)| {
                let place = fields.iter().position(|known| known.field == shape.field)?;
                let answers = answers.get(place)?;
                Some(bank(effect, shape, &fields[place], answers, &beside(effect), weights))
            })
            .collect()
    }
}

/// What is allowed for beside an event: constant directions, fitted to the whole record.
pub(crate) struct Beside<'a> {
    /// What they leave of the residuals.
    pub(crate) left: Vec<f64>,
    /// Their signatures.
    pub(crate) signatures: Vec<&'a [f32]>,
    /// The factor L of their information, prior included, row by row: the lower triangle of (directions, directions).
    pub(crate) factor: Vec<Vec<f64>>,
}

impl Beside<'_> {
    /// Information about an event that they take: `signature`, weighted, from step `start` on.
    fn takes(&self, start: usize, weighted: &[f32]) -> f64 {
        let mut solved: Vec<f64> = Vec::with_capacity(self.factor.len());
        for (signature, row) in self.signatures.iter().zip(&self.factor) {
            let shared = product(weighted, &signature[start..]);
            let before: f64 = row.iter().zip(&solved).map(|(a, b)| a * b).sum();
            solved.push((shared - before) / row[solved.len()]);
        }
        solved.iter().map(|x| x * x).sum()
    }
}

/// Product of two lists in single precision, as both are known; eight sums side by side.
fn product(a: &[f32], b: &[f32]) -> f64 {
    let mut sums = [0.0_f32; 8];
    let n = a.len().min(b.len());
    let (a, b) = (a[..n].chunks_exact(8), b[..n].chunks_exact(8));
    let rest: f32 = a.remainder().iter().zip(b.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a.zip(b) {
        for (sum, (x, y)) in sums.iter_mut().zip(x.iter().zip(y)) {
            *sum += x * y;
        }
    }
    f64::from(sums.iter().sum::<f32>() + rest)
}

/// Directions of the pulses of one field.
#[derive(Debug, Clone)]
struct PulseLanes {
    field: Field,
    /// Length of a pulse, steps.
    pulse: usize,
    /// Steps from its start in which the answer to a pulse is looked for; whole pulses.
    reach: usize,
    steps: usize,
}

impl PulseLanes {
    /// Those of a record of so many steps.
    ///
    /// A short error of the sensor shows at once and is soon forgotten by the filter; of a long one the filter makes
    /// glucose that the plant does not follow. What acts on insulin or production is slow.
    fn of(field: Field, steps: usize) -> Self {
        let (pulse, answer) = match field {
            Field::SensorOffset | Field::SensorLag => (1, 2 * STEPS_PER_HOUR),
            Field::SensorGain => (3, 5 * STEPS_PER_HOUR),
            Field::ExtraCarbs | Field::Flux | Field::CarbAmount => (3, 6 * STEPS_PER_HOUR),
            _ => (6, 6 * STEPS_PER_HOUR),
        };
        Self { field, pulse, reach: pulse + answer, steps }
    }

    /// Number of directions.
    fn count(&self) -> usize {
        self.reach / self.pulse
    }

    /// The directions: pulse k, of height 1, is in direction k modulo their number.
    fn directions(&self) -> impl Iterator<Item = Direction> + '_ {
        (0..self.count()).map(|lane| {
            let mut course = vec![0.0; self.steps];
            for (step, value) in course.iter_mut().enumerate() {
                if (step / self.pulse) % self.count() == lane {
                    *value = 1.0;
                }
            }
            Direction::Course(vec![(self.field, course)])
        })
    }

    /// The answer to pulse `k`, from its start.
    fn answer<'a>(&self, k: usize, answers: &'a [Vec<f32>]) -> &'a [f32] {
        let start = k * self.pulse;
        let column = &answers[k % self.count()];
        &column[start..(start + self.reach).min(column.len())]
    }

    /// A profile as heights of pulses.
    fn pulses(&self, profile: &[f64]) -> Vec<f64> {
        profile
            .chunks(self.pulse)
            .map(|part| part.iter().sum::<f64>() / self.pulse as f64)
            .collect()
    }
}

/// Information and score of every event. `answers` belong to the directions of `lanes`.
fn bank(
    effect: usize,
    shape: EventShape,
    lanes: &PulseLanes,
    answers: &[Vec<f32>],
    beside: &Beside<'_>,
    weights: &[f64],
) -> EventBank {
    let residuals = &beside.left;
    // The background does not answer to short errors of the sensor.
    let answers_back = lanes.pulse > 1;
    let profiles: Vec<Vec<f64>> = shape.profiles.iter().map(|p| lanes.pulses(p)).collect();
    let longest = profiles.iter().map(Vec::len).max().unwrap_or(0);
    let mut signature = vec![0.0; longest * lanes.pulse + lanes.reach];
    let mut narrow = Vec::with_capacity(signature.len());
    let (mut onsets, mut known) = (Vec::new(), Vec::new());
    let mut before = None;
    for onset in &shape.onsets {
        let first = onset / lanes.pulse;
        if before == Some(first) || *onset >= residuals.len() {
            continue;
        }
        before = Some(first);
        let start = first * lanes.pulse;
        onsets.push(start);
        known.push(
            profiles
                .iter()
                .map(|heights| {
                    signature.fill(0.0);
                    let mut end = start;
                    for (k, height) in heights.iter().enumerate() {
                        if (first + k) * lanes.pulse >= residuals.len() {
                            break;
                        }
                        let answer = lanes.answer(first + k, answers);
                        let offset = k * lanes.pulse;
                        end = start + offset + answer.len();
                        for (sum, value) in signature[offset..].iter_mut().zip(answer) {
                            *sum += height * f64::from(*value);
                        }
                    }
                    let (mut information, mut score) = (0.0, 0.0);
                    for (value, step) in signature.iter_mut().zip(start..end) {
                        let weighted = weights[step] * *value;
                        information += weighted * *value;
                        score -= weighted * residuals[step];
                        *value = weighted;
                    }
                    if answers_back {
                        narrow.clear();
                        narrow.extend(signature[..end - start].iter().map(|value| *value as f32));
                        information -= beside.takes(start, &narrow);
                    }
                    EventScore { information: information.max(0.0), score }
                })
                .collect(),
        );
    }
    EventBank { effect, shape, onsets, known }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Answers to the pulses of a model that answers to a value with half of it a step later, and so on.
    fn answers(lanes: &PulseLanes) -> Vec<Vec<f32>> {
        lanes
            .directions()
            .map(|direction| {
                let Direction::Course(courses) = direction else { panic!("a course") };
                let mut state = 0.0_f64;
                courses[0]
                    .1
                    .iter()
                    .map(|value| {
                        state = 0.5 * state + value;
                        state as f32
                    })
                    .collect()
            })
            .collect()
    }

    #[test]
    fn an_event_is_scored_as_its_own_signature_would_be() {
        for field in [Field::SensorOffset, Field::ExtraCarbs, Field::Production] {
            let steps = 400;
            let lanes = PulseLanes::of(field, steps);
            let answers = answers(&lanes);
            let profile: Vec<f64> = (0..24).map(|k| f64::from(1 + k / 6)).collect();
            let shape = EventShape {
                field,
                profiles: vec![vec![1.0; 6], profile.clone()],
                onsets: (0..steps).collect(),
                per_day: 0.1,
                sizes: vec![(1.0, 1.0)],
            };
            let residuals: Vec<f64> = (0..steps).map(|k| (0.7 * k as f64).sin()).collect();
            let weights: Vec<f64> =
                (0..steps).map(|k| if k % 50 == 3 { 0.0 } else { 1.0 }).collect();
            let beside =
                Beside { left: residuals.clone(), signatures: Vec::new(), factor: Vec::new() };
            let bank = bank(0, shape, &lanes, &answers, &beside, &weights);
            assert!(bank.onsets.len() * lanes.pulse >= steps - lanes.pulse);
            for place in [3, bank.onsets.len() / 2, bank.onsets.len() - 2] {
                let onset = bank.onsets[place];
                let (mut state, mut information, mut score) = (0.0, 0.0, 0.0);
                for step in onset..steps {
                    state = 0.5 * state + profile.get(step - onset).copied().unwrap_or(0.0);
                    information += weights[step] * state * state;
                    score -= weights[step] * state * residuals[step];
                }
                let found = bank.known[place][1];
                // The answer is cut off after 2 h, when 2^-24 of it is left.
                assert!((found.information / information - 1.0).abs() < 1e-6, "{field:?} {onset}");
                assert!((found.score - score).abs() < 1e-5, "{field:?} {onset}");
            }
        }
    }
}
