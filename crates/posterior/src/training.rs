//! Training on a table of worlds.

use std::collections::BTreeMap;

use candle_core::{Device, Tensor, Var};
use candle_nn::{AdamW, Optimizer, ParamsAdamW};
use contract::posterior::PosteriorCard;
use rand::seq::SliceRandom as _;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::error::PosteriorError;
use crate::joint::Joint;
use crate::network::{GAP_UNIT, Kept, Network, Shape};
use crate::posterior::{Described, Posterior};
use crate::reading::Reading;
use crate::regression::Regression;
use crate::table::{Table, Truth, distinct};

/// Largest gap that networks are shown, in units of [`GAP_UNIT`].
const LARGEST_GAP: f64 = 5.0;
/// Fewest worlds of one kind, and of all others, by which a hand is asked what a statistic tells.
const FEWEST: f64 = 5.0;
/// Statistics of which sums are taken together.
const COLUMNS_AT_ONCE: usize = 64;
/// Statistics that networks read: those that tell most of anything.
const STATISTICS: usize = 2000;
/// Statistics that the regression of one effect reads: those that tell most of it.
const OF_ONE_EFFECT: usize = 100;
/// Penalty on squared weights of the regressions, in units of worlds.
const RIDGE: f64 = 60.0;
/// First size of steps; it falls to 0 as a cosine.
const RATE: f64 = 1e-3;
/// Decay of weights.
const DECAY: f64 = 0.2;
/// Share of the statistics and of the hidden units that a step does not see.
const DROPPED: f64 = 0.5;
/// Weights of the losses of ports and of gaps; that of what is missing has weight 1.
const PORT_WEIGHT: f64 = 0.3;
const GAP_WEIGHT: f64 = 0.5;

/// How networks are trained.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Training {
    /// Networks of the ensemble; one member more is a regression.
    pub networks: usize,
    /// Hidden units in each of two layers.
    pub hidden: usize,
    /// Passes over the table.
    pub epochs: usize,
    /// Rows of a step.
    pub batch: usize,
    /// Seed of everything that is drawn.
    pub seed: u64,
}

impl Training {
    /// The settings in use.
    #[must_use]
    pub const fn working(seed: u64) -> Self {
        Self { networks: 2, hidden: 192, epochs: 20, batch: 64, seed }
    }
}

/// Trains a posterior over these effects and ports. `source` is the command, for its card.
///
/// # Errors
/// [`PosteriorError::Table`] for an empty table, one without statistics that vary, or a truth of more than two effects or of
/// an effect that is not among `effects`.
pub fn train(
    table: &Table,
    effects: &[String],
    ports: &[String],
    settings: &Training,
    source: &str,
) -> Result<Posterior, PosteriorError> {
    let refused = |why: &str| Err(PosteriorError::Table(why.to_owned()));
    table.checked()?;
    if table.is_empty() {
        return refused("it has no rows");
    }
    // Each kind outside the library has odds of its own: what is unknown is many things, of which no two look alike
    // (decision 0044).
    let outside = distinct(table.truths.iter().filter_map(|truth| truth.outside.clone()));
    let missing = table
        .truths
        .iter()
        .map(|truth| missing(truth, effects, &outside))
        .collect::<Result<Vec<Vec<bool>>, _>>()?;
    let all = Reading::of(table);
    if all.names.is_empty() {
        return refused("none of its statistics varies");
    }
    let read = all.of_table(table);
    let hands: Vec<&str> = table.truths.iter().map(|truth| truth.hand.as_str()).collect();
    let told = telling(&read, all.names.len(), &missing, &hands);
    if told.iter().flatten().all(|tells| *tells == 0.0) {
        return refused("none of its statistics tells anything");
    }
    let only = |columns: &[usize]| -> (Reading, Vec<f32>) {
        let rows = read.chunks(all.names.len());
        let read = rows.flat_map(|row| columns.iter().map(|column| row[*column])).collect();
        (all.only(columns), read)
    };
    // The regressions, each on the statistics that tell most of its effect.
    let of_things = &told[..effects.len() + outside.len()];
    let columns: Vec<Vec<usize>> =
        of_things.iter().map(|one| largest(one, OF_ONE_EFFECT)).collect();
    let kept = distinct(columns.iter().flatten().copied());
    let place = |column: &usize| kept.binary_search(column).expect("it is kept");
    let columns: Vec<Vec<usize>> =
        columns.iter().map(|columns| columns.iter().map(place).collect()).collect();
    let (regressed, of_regressions) = only(&kept);
    let regression = Regression::fitted(&of_regressions, &missing, &columns, effects.len(), RIDGE)?;
    // The networks, on those that tell most of anything.
    let of_any: Vec<f64> = (0..all.names.len())
        .map(|column| told.iter().map(|one| one[column]).fold(0.0, f64::max))
        .collect();
    let (reading, of_networks) = only(&largest(&of_any, STATISTICS));
    let nothing = missing.iter().filter(|row| !row.contains(&true)).count();
    let described = Described {
        effects: effects.to_vec(),
        outside,
        ports: ports.to_vec(),
        cells: distinct(table.truths.iter().flat_map(|truth| truth.gaps.keys().cloned())),
        hidden: settings.hidden,
        reading,
        regression: regressed,
        card: PosteriorCard {
            source: source.to_owned(),
            hands: by_hand(table),
            nothing: nothing as f64 / table.len() as f64,
            members: settings.networks,
            offset: 0.0,
            speaks_from: 1.0,
        },
    };
    let examples = Examples {
        read: of_networks,
        missing,
        effects: effects.len(),
        ports: table.truths.iter().flat_map(|truth| shares(truth, ports)).collect(),
        gaps: table.truths.iter().flat_map(|truth| gaps(truth, &described.cells)).collect(),
        shape: described.shape(),
    };
    let networks = (0..settings.networks)
        .into_par_iter()
        .map(|member| examples.fitted(settings, member as u64))
        .collect::<Result<Vec<Network>, _>>()?;
    Ok(Posterior { described, networks, regression })
}

/// Which of the effects, and then of the kinds outside the library, a world lacks.
fn missing(
    truth: &Truth,
    effects: &[String],
    outside: &[String],
) -> Result<Vec<bool>, PosteriorError> {
    if let Some(strange) = truth.effects.iter().find(|name| !effects.contains(name)) {
        return Err(PosteriorError::Table(format!("it has a world with `{strange}`")));
    }
    let known = effects.iter().map(|effect| truth.effects.contains(effect));
    let kinds = outside.iter().map(|kind| truth.outside.as_ref() == Some(kind));
    let missing: Vec<bool> = known.chain(kinds).collect();
    let count = missing.iter().filter(|is| **is).count();
    if count > 2 || truth.outside.is_some() && count > 1 {
        return Err(PosteriorError::Table(format!("a world lacks {:?} and more", truth.effects)));
    }
    Ok(missing)
}

/// Numbers of worlds by the hand that made them.
fn by_hand(table: &Table) -> Vec<(String, usize)> {
    let mut hands: BTreeMap<&str, usize> = BTreeMap::new();
    for truth in &table.truths {
        *hands.entry(&truth.hand).or_default() += 1;
    }
    hands.into_iter().map(|(hand, worlds)| (hand.to_owned(), worlds)).collect()
}

/// What each statistic tells of each thing, and last of nothing being missing: the standardised difference between the
/// worlds that lack the thing and all others.
///
/// What one hand's worlds tell alone would mislead in those of another: a difference counts as much as in the hand
/// that shows it least, and not at all where hands disagree about its sign. Hands that have no such worlds are not asked.
fn telling(read: &[f32], width: usize, missing: &[Vec<bool>], hands: &[&str]) -> Vec<Vec<f64>> {
    let things = missing.first().map_or(0, Vec::len);
    let classes_of: Vec<Vec<usize>> = missing
        .iter()
        .map(|row| match row.contains(&true) {
            true => (0..things).filter(|thing| row[*thing]).collect(),
            false => vec![things],
        })
        .collect();
    let rows_of: Vec<Vec<usize>> = distinct(hands.iter())
        .into_iter()
        .map(|hand| (0..hands.len()).filter(|row| hands[*row] == *hand).collect())
        .collect();
    // Columns that lie side by side are read together.
    let of_columns = |first: usize| -> Vec<Vec<f64>> {
        let columns = first..(first + COLUMNS_AT_ONCE).min(width);
        let of_hand = |rows: &Vec<usize>| {
            let mut all = vec![Moments::default(); columns.len()];
            let mut own = vec![(0.0, vec![0.0; columns.len()]); things + 1];
            for row in rows {
                let values = &read[row * width..][columns.clone()];
                all.iter_mut().zip(values).for_each(|(all, value)| all.add(f64::from(*value)));
                for class in &classes_of[*row] {
                    let (count, sums) = &mut own[*class];
                    *count += 1.0;
                    sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += f64::from(*value));
                }
            }
            (rows.len() as f64, all, own)
        };
        let by_hand: Vec<_> = rows_of.iter().map(of_hand).collect();
        let of_class = |class: usize, column: usize| -> f64 {
            let in_hands = || {
                by_hand.iter().filter_map(|(n, all, own)| {
                    let (inside, sums) = &own[class];
                    let asked = *inside >= FEWEST && n - inside >= FEWEST;
                    asked.then(|| all[column].difference(*n, *inside, sums[column]))
                })
            };
            let Some(least) = in_hands().reduce(f64::min) else { return 0.0 };
            let most = in_hands().fold(least, f64::max);
            least.max(-most).max(0.0)
        };
        let of_all = |class| (0..columns.len()).map(|column| of_class(class, column)).collect();
        (0..=things).map(of_all).collect()
    };
    let firsts: Vec<usize> = (0..width).step_by(COLUMNS_AT_ONCE).collect();
    let told: Vec<Vec<Vec<f64>>> = firsts.into_par_iter().map(of_columns).collect();
    (0..=things).map(|class| told.iter().flat_map(|told| &told[class]).copied().collect()).collect()
}

/// Sums of a statistic over worlds.
#[derive(Clone, Copy, Default)]
struct Moments {
    sum: f64,
    squares: f64,
}

impl Moments {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.squares += value.powi(2);
    }

    /// The standardised difference between `inside` of `n` worlds, whose values have the sum `own`, and the others.
    fn difference(&self, n: f64, inside: f64, own: f64) -> f64 {
        let variance = (self.squares / n - (self.sum / n).powi(2)).max(1e-9);
        let apart = own / inside - (self.sum - own) / (n - inside);
        apart / (variance * (1.0 / inside + 1.0 / (n - inside))).sqrt()
    }
}

/// The columns in which something is told, at most so many: those of the largest values, in their order.
fn largest(values: &[f64], most: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..values.len()).filter(|column| values[*column] > 0.0).collect();
    order.sort_by(|a, b| values[*b].total_cmp(&values[*a]));
    order.truncate(most);
    order.sort_unstable();
    order
}

/// Each port's share of a truth; all 0 where nothing is missing.
fn shares(truth: &Truth, ports: &[String]) -> Vec<f32> {
    let share = 1.0 / truth.ports.len().max(1) as f32;
    let count = |port: &String| truth.ports.iter().filter(|own| *own == port).count() as f32;
    ports.iter().map(|port| share * count(port)).collect()
}

/// The gap by cell in units of [`GAP_UNIT`], and then its sizes; not a number where the truth does not state it.
fn gaps(truth: &Truth, cells: &[String]) -> Vec<f32> {
    let nothing = truth.effects.is_empty() && truth.outside.is_none();
    let of_cell = |cell: &String| match truth.gaps.get(cell) {
        Some(gap) => (gap / GAP_UNIT).clamp(-LARGEST_GAP, LARGEST_GAP) as f32,
        None if nothing => 0.0,
        None => f32::NAN,
    };
    let gaps: Vec<f32> = cells.iter().map(of_cell).collect();
    gaps.iter().copied().chain(gaps.iter().map(|gap| gap.abs())).collect()
}

/// Rows ready for networks.
struct Examples {
    read: Vec<f32>,
    /// By row and thing.
    missing: Vec<Vec<bool>>,
    effects: usize,
    ports: Vec<f32>,
    /// Gaps, and their sizes beside them.
    gaps: Vec<f32>,
    shape: Shape,
}

impl Examples {
    fn fitted(&self, settings: &Training, member: u64) -> Result<Network, PosteriorError> {
        let mut rng = ChaCha8Rng::seed_from_u64(settings.seed);
        rng.set_stream(member + 1);
        let variables = self
            .shape
            .weights()
            .into_iter()
            .map(|(name, shape)| Ok(Var::from_tensor(&started(name, &shape, &mut rng)?)?))
            .collect::<Result<Vec<Var>, PosteriorError>>()?;
        let network =
            Network { weights: variables.iter().map(|v| v.as_tensor().clone()).collect() };
        let batch = settings.batch.clamp(1, self.missing.len());
        let steps = settings.epochs * (self.missing.len() / batch);
        let parameters = ParamsAdamW { lr: RATE, weight_decay: DECAY, ..ParamsAdamW::default() };
        let mut optimiser = AdamW::new(variables, parameters)?;
        let mut order: Vec<usize> = (0..self.missing.len()).collect();
        let mut step = 0;
        for _ in 0..settings.epochs {
            order.shuffle(&mut rng);
            for rows in order.chunks_exact(batch) {
                let share = step as f64 / steps.max(1) as f64;
                let turn = (std::f64::consts::PI * share).cos();
                optimiser.set_learning_rate(RATE * 0.5 * (1.0 + turn));
                let kept = self.kept(rows.len(), &mut rng)?;
                optimiser.backward_step(&self.loss(&network, rows, &kept)?)?;
                step += 1;
            }
        }
        let weights = network.weights.iter().map(Tensor::detach).collect();
        Ok(Network { weights })
    }

    /// Which numbers a step sees.
    fn kept(&self, rows: usize, rng: &mut ChaCha8Rng) -> Result<Kept, PosteriorError> {
        let mut of = |width: usize| -> Result<Tensor, PosteriorError> {
            let over = (1.0 - DROPPED).recip() as f32;
            let mut one = || if rng.random_bool(DROPPED) { 0.0 } else { over };
            let kept: Vec<f32> = (0..rows * width).map(|_| one()).collect();
            Ok(Tensor::from_vec(kept, (rows, width), &Device::Cpu)?)
        };
        let (statistics, hidden) = (self.shape.statistics, self.shape.hidden);
        Ok(Kept { statistics: of(statistics)?, first: of(hidden)?, second: of(hidden)? })
    }

    fn loss(
        &self,
        network: &Network,
        rows: &[usize],
        kept: &Kept,
    ) -> Result<Tensor, PosteriorError> {
        let Shape { statistics, ports, cells, .. } = self.shape;
        let pick = |values: &[f32], width: usize, of: fn(f32) -> f32| {
            let of_row = |row: &usize| values[row * width..(row + 1) * width].iter().copied();
            let picked: Vec<f32> = rows.iter().flat_map(of_row).map(of).collect();
            Tensor::from_vec(picked, (rows.len(), width), &Device::Cpu)
        };
        let gaps = |of: fn(f32) -> f32| pick(&self.gaps, 2 * cells, of);
        let known = |gap: f32| f32::from(u8::from(!gap.is_nan()));
        let or_zero = |gap: f32| if gap.is_nan() { 0.0 } else { gap };
        let read = pick(&self.read, statistics, |value| value)?;
        let found = network.answer(&read, Some(kept))?;
        let of_missing = self.loss_of_missing(&found.odds, network.pair(), rows)?;
        let count = rows.len() as f64;
        let ports = found.ports.mul(&pick(&self.ports, ports, |share| share)?)?;
        let of_ports = (ports.sum_all()? * (-PORT_WEIGHT / count))?;
        let apart = found.gaps.sub(&gaps(or_zero)?)?.mul(&gaps(known)?)?;
        let of_gaps =
            (apart.sqr()?.sum_all()? * (GAP_WEIGHT / (count * 2.0 * cells.max(1) as f64)))?;
        Ok(((of_missing + of_ports)? + of_gaps)?)
    }

    /// A tensor with the slopes of minus the mean log probability of what is missing: that of log odds is the probability
    /// less what is true.
    fn loss_of_missing(
        &self,
        odds: &Tensor,
        pair: &Tensor,
        rows: &[usize],
    ) -> Result<Tensor, PosteriorError> {
        let of_pairs = f64::from(pair.to_vec1::<f32>()?[0]);
        let share = 1.0 / rows.len() as f64;
        let (mut by_odds, mut by_pair) = (Vec::with_capacity(rows.len() * self.shape.odds), 0.0);
        for (row, own) in rows.iter().zip(odds.to_vec2::<f32>()?) {
            let own: Vec<f64> = own.into_iter().map(f64::from).collect();
            let slopes = Joint::of(&own, self.effects, of_pairs).slopes(&self.missing[*row]);
            by_odds.extend(slopes.0.iter().map(|slope| (share * slope) as f32));
            by_pair += share * slopes.1;
        }
        let by_odds = Tensor::from_vec(by_odds, odds.dims(), &Device::Cpu)?;
        Ok((odds.mul(&by_odds)?.sum_all()? + (pair.sum_all()? * by_pair)?)?)
    }
}

/// Weights at the start: what keeps the size of a layer's output, and biases that call effects rare.
fn started(name: &str, shape: &[usize], rng: &mut ChaCha8Rng) -> Result<Tensor, PosteriorError> {
    let count = shape.iter().product();
    let size = match (name, shape) {
        ("first.weight", [inputs, _]) => (3.0 / *inputs as f32).sqrt(),
        ("second.weight", [inputs, _]) => (6.0 / *inputs as f32).sqrt(),
        (_, [inputs, _]) => (0.3 / *inputs as f32).sqrt(),
        _ => 0.0,
    };
    let bias = if name == "odds.bias" { -3.0 } else { 0.0 };
    // Drawn for biases too, so that the stream does not depend on which there are.
    let values: Vec<f32> =
        (0..count).map(|_| bias + size * rng.random_range(-1.0f32..1.0)).collect();
    Ok(Tensor::from_vec(values, shape, &Device::Cpu)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Worlds of two effects, each of which raises a statistic of its own.
    fn table(rows: usize, seed: u64) -> Table {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut table = Table {
            names: ["one", "other", "noise"].map(str::to_owned).to_vec(),
            ..Table::default()
        };
        for row in 0..rows {
            let mut noise = || rng.random_range(-1.0f32..1.0);
            let acts = [row % 4 == 1 || row % 8 == 3, row % 4 == 2 || row % 8 == 3];
            let shift = |acts: bool| if acts { 3.0 } else { 0.0 };
            table.values.extend([shift(acts[0]) + noise(), shift(acts[1]) + noise(), noise()]);
            let named = ["dawn", "exercise"].iter().zip(acts).filter(|(_, acts)| *acts);
            let ports = ["egp", "insulin_action"].iter().zip(acts).filter(|(_, acts)| *acts);
            table.truths.push(Truth {
                hand: "made".to_owned(),
                effects: named.map(|(name, _)| (*name).to_owned()).collect(),
                outside: None,
                ports: ports.map(|(name, _)| (*name).to_owned()).collect(),
                gaps: BTreeMap::from([("60/hour/05".to_owned(), if acts[0] { 20.0 } else { 0.0 })]),
            });
        }
        table
    }

    fn trained(rows: usize) -> Posterior {
        trained_on(&table(rows, 1))
    }

    fn trained_on(table: &Table) -> Posterior {
        let settings =
            Training { networks: 2, hidden: 16, epochs: 80, batch: 32, ..Training::working(1) };
        let effects = ["dawn".to_owned(), "exercise".to_owned()];
        let ports = ["egp".to_owned(), "insulin_action".to_owned()];
        train(table, &effects, &ports, &settings, "a test").expect("trained")
    }

    #[test]
    fn what_acts_is_learned_from_worlds_and_so_is_where() {
        let posterior = trained(800);
        let test = table(200, 2);
        let mut right = 0;
        for (row, truth) in test.truths.iter().enumerate() {
            let answer = posterior.answer(&test.row(row)).expect("finite");
            let both = answer.effects.iter().filter(|(_, p)| *p > 0.5);
            let named: Vec<String> = both.map(|(name, _)| name.clone()).collect();
            right += usize::from(named == truth.effects);
            let sets: f64 = answer.sets.iter().map(|(_, p)| p).sum();
            assert!((answer.nothing + answer.unknown + sets - 1.0).abs() < 1e-9);
            if truth.effects == ["dawn"] {
                assert_eq!(answer.ports[0].0, "egp");
                let gap = &answer.gaps["60/hour/05"];
                // Shrunken, as few steps are taken, but far from the 0 of all other worlds.
                assert!((6.0..22.0).contains(&gap.mean) && gap.size >= gap.mean, "{gap:?}");
            }
        }
        // The statistics do not overlap; one in twenty is left to chance.
        assert!(right >= 190, "{right} of 200");
    }

    /// One class for both kinds would see the same mean of the statistic in it as outside it.
    #[test]
    fn kinds_that_differ_in_opposite_directions_are_both_unknown() {
        let with_kinds = |mut table: Table| {
            for (row, truth) in table.truths.iter_mut().enumerate().filter(|(r, _)| r % 8 == 7) {
                let (kind, shift) = if row % 16 == 7 { ("bath", 4.0) } else { ("tea", -4.0) };
                truth.outside = Some(kind.to_owned());
                table.values[3 * row + 2] += shift;
            }
            table
        };
        let posterior = trained_on(&with_kinds(table(800, 1)));
        let test = with_kinds(table(200, 2));
        let unknown = |row: usize| posterior.answer(&test.row(row)).expect("finite").unknown;
        let mean = |kind: Option<&str>| {
            let rows: Vec<usize> =
                (0..200).filter(|r| test.truths[*r].outside.as_deref() == kind).collect();
            rows.iter().map(|row| unknown(*row)).sum::<f64>() / rows.len() as f64
        };
        let (bath, tea, rest) = (mean(Some("bath")), mean(Some("tea")), mean(None));
        assert!(bath > 2.0 * rest && tea > 2.0 * rest, "{bath} {tea} {rest}");
    }

    #[test]
    fn a_world_with_something_outside_and_an_effect_is_refused() {
        let mut table = table(20, 1);
        let acts = table.truths.iter_mut().find(|truth| truth.effects == ["dawn"]).expect("one");
        acts.outside = Some("bath".to_owned());
        let effects = ["dawn".to_owned(), "exercise".to_owned()];
        let refused = train(&table, &effects, &[], &Training::working(1), "").map(|_| ());
        assert!(refused.expect_err("two").to_string().contains("and more"));
    }

    #[test]
    fn a_posterior_is_its_table_and_seed_whatever_the_threads() {
        let in_pool = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("a pool").install(|| trained(160).bytes().expect("written"))
        };
        assert_eq!(in_pool(1), in_pool(2));
    }

    #[test]
    fn a_file_that_would_answer_nonsense_is_refused() {
        let sound = trained(160);
        type Damage = fn(&mut Posterior);
        let damages: [(&str, Damage); 6] = [
            ("not finite", |p| p.described.card.offset = f64::INFINITY),
            ("centre or spread each", |p| p.described.reading.centre.truncate(1)),
            ("centre or spread each", |p| p.described.regression.spread.push(1.0)),
            ("spread is not positive", |p| p.described.reading.spread[0] = 0.0),
            ("not finite", |p| p.described.regression.centre[0] = f32::MAX * 2.0),
            ("weight that is not finite", |p| {
                let weights = &mut p.networks[0].weights[0];
                *weights = (&*weights * 1e9).expect("a product");
            }),
        ];
        for (why, damage) in damages {
            let mut damaged = sound.clone();
            damage(&mut damaged);
            let bytes = damaged.bytes().expect("written");
            let error = Posterior::from_bytes(&bytes).map(|_| ()).expect_err(why).to_string();
            assert!(error.contains(why) || error.contains("null"), "{error}");
        }
    }

    #[test]
    fn an_offset_says_how_often_something_is_missing_and_not_what() {
        let test = table(20, 2);
        let plain = trained(100);
        let moved = plain.clone().judged(1.5, 0.5);
        for row in 0..20 {
            let asked = |posterior: &Posterior| posterior.answer(&test.row(row)).expect("finite");
            let (before, after) = (asked(&plain), asked(&moved));
            let odds = |p: f64| (p / (1.0 - p)).ln();
            assert!((odds(after.nothing) - odds(before.nothing) - 1.5).abs() < 1e-6);
            let factor = (1.0 - after.nothing) / (1.0 - before.nothing);
            assert!((after.unknown - factor * before.unknown).abs() < 1e-9);
            for ((_, before), (_, after)) in before.effects.iter().zip(&after.effects) {
                assert!((after - factor * before).abs() < 1e-9);
            }
            assert_eq!(before.ports, after.ports);
        }
    }

    #[test]
    fn a_table_without_rows_or_with_a_strange_effect_is_refused() {
        let of = |table: &Table| {
            let settings = Training::working(1);
            train(table, &["dawn".to_owned()], &[], &settings, "")
                .map(|_| ())
                .map_err(|e| e.to_string())
        };
        assert!(of(&Table::default()).expect_err("empty").contains("no rows"));
        assert!(of(&table(20, 1)).expect_err("strange").contains("exercise"));
    }
}
