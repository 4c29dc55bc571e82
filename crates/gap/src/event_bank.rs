//! Hidden events wherever they could start: what each would do to the whitened innovations.
//!
//! The linear model answers to a course of a field as it does to the pulses that the course is made of. The
//! answers to single pulses are worked out once for each field; many pulses share a direction as long as their
//! answers do not meet. An event of any shape is then a sum of answers.

use std::cell::OnceCell;
use std::ops::Range;

use effects::{EffectId, EventShape, Field};
use physiology::STEPS_PER_HOUR;

use crate::f32_kernels::{WIDTH, add_products, add_scaled, combined, product};
use crate::filter::tangent::Direction;

/// Hidden events of one effect at every place where one could start.
#[derive(Debug, Clone)]
pub struct EventBank {
    /// The effect.
    pub effect: EffectId,
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
    /// The effects and their shapes.
    effects: Vec<(EffectId, EventShape)>,
    fields: Vec<PulseLanes>,
    /// By field and direction; whitened.
    answers: Vec<Vec<Vec<f32>>>,
}

impl HiddenEvents {
    /// Those of a record of so many steps; the answers are yet to come.
    pub(crate) fn of(effects: Vec<(EffectId, EventShape)>, steps: usize) -> Self {
        let mut fields: Vec<PulseLanes> = Vec::new();
        for (_, shape) in &effects {
            if fields.iter().all(|known| known.field != shape.field) {
                fields.push(PulseLanes::of(shape.field, steps));
            }
        }
        Self { effects, fields, answers: Vec::new() }
    }

    /// The effects that act by hidden events.
    pub(crate) fn effects(&self) -> impl Iterator<Item = EffectId> + '_ {
        self.effects.iter().map(|(effect, _)| *effect)
    }

    /// The directions of all pulses.
    pub(crate) fn directions(&self) -> impl Iterator<Item = Direction> + '_ {
        self.fields.iter().flat_map(PulseLanes::directions)
    }

    /// Takes the whitened answers to [`Self::directions`].
    pub(crate) fn answered(&mut self, answers: Vec<Vec<f32>>) {
        let mut answers = answers.into_iter();
        let of_field = |field: &PulseLanes| answers.by_ref().take(field.count()).collect();
        self.answers = self.fields.iter().map(of_field).collect();
    }

    /// Scores every event against what the background that `background_of` gives for its effect leaves of the residuals.
    ///
    /// Effects that are given one background share the sums over pulses. `before` are the same person's banks of an
    /// earlier round, empty where hidden events were named since: those change what readings weigh, driven effects hardly
    /// do, and information is kept after them.
    pub(crate) fn banks<'a>(
        self,
        background_of: impl Fn(EffectId) -> &'a FittedBackground<'a>,
        weights: &[f64],
        before: &[EventBank],
    ) -> Vec<EventBank> {
        let Self { effects, fields, answers } = self;
        let mut banks = Vec::with_capacity(effects.len());
        for (lanes, answers) in fields.iter().zip(&answers) {
            let theirs: Vec<Events<'_>> = effects
                .iter()
                .filter(|(_, shape)| shape.field == lanes.field)
                .map(|(effect, shape)| Events::of(*effect, shape, lanes, before))
                .collect();
            let unknown = || theirs.iter().filter(|events| events.known.is_none());
            let touched = lanes.touched(unknown().map(|events| events.shape));
            let products = PulseProducts::of(lanes, answers, weights, unknown().next().is_some());
            let mut against: Vec<(&FittedBackground<'_>, PulseSums)> = Vec::new();
            for events in &theirs {
                let background = background_of(events.effect);
                let known = against.iter().position(|(known, _)| std::ptr::eq(*known, background));
                let index = known.unwrap_or_else(|| {
                    let sums = PulseSums::of(lanes, answers, &products, &touched, background);
                    against.push((background, sums));
                    against.len() - 1
                });
                banks.push(events.bank(lanes, &products, &against[index].1));
            }
        }
        banks
    }
}

/// The background of an event's test: constant directions, fitted to the whole record.
pub(crate) struct FittedBackground<'a> {
    /// What they leave of the residuals, weighted, one entry a step.
    residuals: Vec<f32>,
    signatures: Vec<&'a [f32]>,
    /// The inverse of the factor of their information, column by column.
    inverse: Vec<f32>,
    /// The signatures solved by the factor, a row of [`width`](Self::width) a step: the squares of an event's products
    /// with them are what the directions take of its information. Computed at the first use.
    rows: OnceCell<Vec<f32>>,
    /// Number of directions, filled up to a multiple of [`WIDTH`].
    width: usize,
}

impl<'a> FittedBackground<'a> {
    /// `residuals` is what the directions leave, to be weighted; `factor` is the factor L of their information, prior
    /// included, row by row: the lower triangle of (directions, directions).
    pub(crate) fn of(
        residuals: &[f64],
        weights: &[f64],
        signatures: Vec<&'a [f32]>,
        factor: &[Vec<f64>],
    ) -> Self {
        let width = signatures.len().next_multiple_of(WIDTH);
        // Columns of the inverse of the factor, one after the other.
        let mut inverse = vec![0.0_f32; signatures.len() * width];
        for (column, out) in inverse.chunks_exact_mut(width.max(1)).enumerate() {
            let mut solved = vec![0.0; signatures.len()];
            for (row, entries) in factor.iter().enumerate().skip(column) {
                let before: f64 = entries.iter().zip(&solved[..row]).map(|(a, b)| a * b).sum();
                let right = if row == column { 1.0 } else { 0.0 };
                solved[row] = (right - before) / entries[row];
                out[row] = solved[row] as f32;
            }
        }
        let residuals =
            residuals.iter().zip(weights).map(|(value, w)| (value * w) as f32).collect();
        Self { residuals, signatures, inverse, rows: OnceCell::new(), width }
    }

    /// The rows from a step on.
    fn rows(&self, from: usize) -> &[f32] {
        let rows = self.rows.get_or_init(|| {
            let mut rows = vec![0.0; self.residuals.len() * self.width];
            let mut values = vec![0.0; self.signatures.len()];
            for (step, row) in rows.chunks_exact_mut(self.width.max(1)).enumerate() {
                for (value, signature) in values.iter_mut().zip(&self.signatures) {
                    *value = signature[step];
                }
                combined(&values, &self.inverse, row);
            }
            rows
        });
        &rows[from * self.width..]
    }
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
            let length = self.pulse;
            let (first, every) = (lane * length, self.count() * length);
            Direction::Pulses { field: self.field, first, every, length }
        })
    }

    /// Number of pulses that begin within the record.
    fn pulse_count(&self) -> usize {
        self.steps.div_ceil(self.pulse)
    }

    /// The steps in which pulse `k` is answered.
    fn answered(&self, k: usize) -> Range<usize> {
        let start = k * self.pulse;
        start..(start + self.reach).min(self.steps)
    }

    /// The answer to pulse `k`, from its start, of those by direction.
    fn answer<'a>(&self, answers: &'a [Vec<f32>], k: usize) -> &'a [f32] {
        &answers[k % self.count()][self.answered(k)]
    }

    /// The answers by step from the start of their pulses, an entry a pulse; 0 beyond the end of the record.
    fn side_by_side(&self, answers: &[Vec<f32>]) -> Vec<Vec<f32>> {
        let mut rows = vec![vec![0.0; self.pulse_count()]; self.reach];
        for k in 0..self.pulse_count() {
            for (row, value) in rows.iter_mut().zip(self.answer(answers, k)) {
                row[k] = *value;
            }
        }
        rows
    }

    /// The pulses that events of these shapes are made of.
    fn touched<'a>(&self, shapes: impl Iterator<Item = &'a EventShape>) -> Vec<bool> {
        let mut touched = vec![false; self.pulse_count()];
        for shape in shapes {
            let longest = shape.profiles.iter().map(Vec::len).max().unwrap_or(0);
            let length = longest.div_ceil(self.pulse);
            let mut reached = 0;
            for onset in &shape.onsets {
                let first = onset / self.pulse;
                let end = (first + length).min(touched.len());
                if let Some(new) = touched.get_mut(first.max(reached)..end) {
                    new.fill(true);
                }
                reached = reached.max(end);
            }
        }
        touched
    }

    /// A profile as heights of pulses.
    fn pulses(&self, profile: &[f64]) -> Vec<f32> {
        profile
            .chunks(self.pulse)
            .map(|part| (part.iter().sum::<f64>() / self.pulse as f64) as f32)
            .collect()
    }
}

/// Weighted answers to the pulses of one field and their products with the answers.
struct PulseProducts {
    /// Weighted answers, a list a direction; none where the products are not wanted.
    weighted: Vec<Vec<f32>>,
    /// By distance d below the number of directions: the products of the answers to pulses k and k + d, by k.
    grams: Vec<Vec<f32>>,
}

impl PulseProducts {
    /// With the products where they are `wanted`.
    fn of(lanes: &PulseLanes, answers: &[Vec<f32>], weights: &[f64], wanted: bool) -> Self {
        if !wanted {
            return Self { weighted: Vec::new(), grams: Vec::new() };
        }
        let weight = |column: &Vec<f32>| {
            column.iter().zip(weights).map(|(value, w)| *value * *w as f32).collect()
        };
        let weighted: Vec<Vec<f32>> = answers.iter().map(weight).collect();
        let pulses = lanes.pulse_count();
        // By step from the start of a pulse, pulses side by side.
        let (plain, heavy) = (lanes.side_by_side(answers), lanes.side_by_side(&weighted));
        let grams = (0..lanes.count())
            .map(|distance| {
                let mut grams = vec![0.0; pulses.saturating_sub(distance)];
                let later = heavy.iter().skip(distance * lanes.pulse);
                for (first, second) in later.zip(&plain) {
                    let second = second.get(distance..).unwrap_or_default();
                    add_products(&mut grams, first, second);
                }
                grams
            })
            .collect();
        Self { weighted, grams }
    }

    /// The weighted squares of the answers to pulses of these heights from each pulse on. Pulses beyond the end
    /// of the record count for nothing.
    fn squares(&self, heights: &[f32]) -> Vec<f32> {
        let mut squares = vec![0.0; self.grams.first().map_or(0, Vec::len)];
        for (index, height) in heights.iter().enumerate() {
            for (distance, (other, grams)) in heights[index..].iter().zip(&self.grams).enumerate() {
                let twice = if distance == 0 { 1.0 } else { 2.0 };
                let factor = twice * height * other;
                if factor != 0.0 {
                    add_scaled(&mut squares, factor, grams.get(index..).unwrap_or_default());
                }
            }
        }
        squares
    }
}

/// What single pulses of one field say beside a background.
struct PulseSums {
    /// Minus the product of each answer with what is left of the residuals.
    scores: Vec<f32>,
    /// By pulse: the products of its answer with each row of the background; `width` numbers each, 0 for a pulse
    /// that no event has.
    shared: Vec<f32>,
    /// 0 where the background does not answer.
    width: usize,
}

impl PulseSums {
    fn of(
        lanes: &PulseLanes,
        answers: &[Vec<f32>],
        products: &PulseProducts,
        touched: &[bool],
        background: &FittedBackground<'_>,
    ) -> Self {
        let pulses = lanes.pulse_count();
        // The background does not answer to short errors of the sensor.
        let shared = lanes.pulse > 1 && touched.contains(&true);
        let width = if shared { background.width } else { 0 };
        let mut sums =
            Self { scores: Vec::with_capacity(pulses), shared: vec![0.0; width * pulses], width };
        for (k, touched) in touched.iter().enumerate() {
            let answer = lanes.answer(answers, k);
            let start = lanes.answered(k).start;
            sums.scores.push(-product(answer, &background.residuals[start..]));
            if width > 0 && *touched {
                let shared = &mut sums.shared[k * width..][..width];
                let weighted = lanes.answer(&products.weighted, k);
                combined(weighted, background.rows(start), shared);
            }
        }
        sums
    }

    /// The scores of pulses of these heights from each pulse on.
    fn scores(&self, heights: &[f32]) -> Vec<f32> {
        let mut scores = vec![0.0; self.scores.len()];
        for (index, height) in heights.iter().enumerate() {
            add_scaled(&mut scores, *height, self.scores.get(index..).unwrap_or_default());
        }
        scores
    }

    /// Information that the background takes from pulses of these heights from pulse `first` on. `sum` is scratch
    /// space for one number a direction.
    fn taken(&self, first: usize, heights: &[f32], sum: &mut [f32]) -> f32 {
        if self.width == 0 {
            return 0.0;
        }
        combined(heights, &self.shared[first * self.width..], sum);
        product(sum, sum)
    }
}

/// The events of one effect.
struct Events<'a> {
    effect: EffectId,
    shape: &'a EventShape,
    /// The pulses with which an event may start.
    firsts: Vec<usize>,
    /// What is known of the same events from an earlier round.
    known: Option<&'a EventBank>,
}

impl<'a> Events<'a> {
    fn of(
        effect: EffectId,
        shape: &'a EventShape,
        lanes: &PulseLanes,
        before: &'a [EventBank],
    ) -> Self {
        let mut firsts: Vec<usize> = shape.onsets.iter().map(|onset| onset / lanes.pulse).collect();
        firsts.dedup();
        firsts.retain(|first| *first < lanes.pulse_count());
        let same = |bank: &&EventBank| {
            bank.effect == effect
                && bank.shape.profiles == shape.profiles
                && bank.onsets.iter().copied().eq(firsts.iter().map(|first| first * lanes.pulse))
        };
        let known = before.iter().find(same);
        Self { effect, shape, firsts, known }
    }

    /// Information and score of every event.
    fn bank(&self, lanes: &PulseLanes, products: &PulseProducts, sums: &PulseSums) -> EventBank {
        let profiles = &self.shape.profiles;
        let empty = |_: &usize| Vec::with_capacity(profiles.len());
        let mut known: Vec<Vec<EventScore>> = self.firsts.iter().map(empty).collect();
        let mut scratch = vec![0.0; sums.width];
        for (number, profile) in profiles.iter().enumerate() {
            let heights = lanes.pulses(profile);
            let scores = sums.scores(&heights);
            let squares =
                if self.known.is_some() { Vec::new() } else { products.squares(&heights) };
            for (index, (first, known)) in self.firsts.iter().zip(&mut known).enumerate() {
                let information = match self.known {
                    Some(bank) => bank.known[index][number].information,
                    None => {
                        let remaining =
                            squares[*first] - sums.taken(*first, &heights, &mut scratch);
                        f64::from(remaining.max(0.0))
                    }
                };
                known.push(EventScore { information, score: f64::from(scores[*first]) });
            }
        }
        let onsets = self.firsts.iter().map(|first| first * lanes.pulse).collect();
        EventBank { effect: self.effect, shape: self.shape.clone(), onsets, known }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Answers to the pulses of a model that answers to a value with half of it a step later, and so on.
    fn answers(lanes: &PulseLanes) -> Vec<Vec<f32>> {
        lanes
            .directions()
            .map(|direction| {
                let Direction::Pulses { first, every, length, .. } = direction else {
                    panic!("pulses")
                };
                let mut state = 0.0_f64;
                (0..lanes.steps)
                    .map(|step| {
                        let acts = step >= first && (step - first) % every < length;
                        state = 0.5 * state + f64::from(u8::from(acts));
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
            let background = FittedBackground::of(&residuals, &weights, Vec::new(), &[]);
            let products = PulseProducts::of(&lanes, &answers, &weights, true);
            let touched = vec![true; lanes.pulse_count()];
            let sums = PulseSums::of(&lanes, &answers, &products, &touched, &background);
            let bank =
                Events::of(EffectId::DAWN, &shape, &lanes, &[]).bank(&lanes, &products, &sums);
            // A later round keeps the information of the same events, and of no others.
            let before = [EventBank {
                known: vec![vec![EventScore { information: 7.0, score: 0.0 }; 2]; bank.known.len()],
                ..bank.clone()
            }];
            let later =
                Events::of(EffectId::DAWN, &shape, &lanes, &before).bank(&lanes, &products, &sums);
            for (known, first) in later.known.iter().flatten().zip(bank.known.iter().flatten()) {
                assert_eq!((known.information, known.score), (7.0, first.score));
            }
            let fewer = EventShape { onsets: vec![0, 60], ..shape.clone() };
            assert!(Events::of(EffectId::DAWN, &fewer, &lanes, &before).known.is_none());
            assert!(bank.onsets.len() * lanes.pulse >= steps - lanes.pulse);
            for index in [3, bank.onsets.len() / 2, bank.onsets.len() - 2] {
                let onset = bank.onsets[index];
                let (mut state, mut information, mut score) = (0.0, 0.0, 0.0);
                for step in onset..steps {
                    state = 0.5 * state + profile.get(step - onset).copied().unwrap_or(0.0);
                    information += weights[step] * state * state;
                    score -= weights[step] * state * residuals[step];
                }
                let found = bank.known[index][1];
                // The answer is cut off after 2 h, when 2^-24 of it is left.
                assert!((found.information / information - 1.0).abs() < 1e-6, "{field:?} {onset}");
                assert!((found.score - score).abs() < 1e-5, "{field:?} {onset}");
            }
        }
    }
}
