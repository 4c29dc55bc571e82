//! How well meals that were found, or logged, agree with those that were eaten.
//!
//! Every figure is a sum or a list over people, so that tallies of several people merge into one
//! ([`Tally::merge`]) and people with many meals count for more.

pub use contract::meals::{ClassScore, Score, SizeError, TimeError};
use ode_sim::GutPair;
use physiology::{Grams, Minutes, STEP, STEPS_PER_DAY};

/// Carbohydrate at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Eaten {
    /// Step of the record.
    pub step: usize,
    /// How much; `None` where only the time is claimed.
    pub carbs: Option<Grams>,
}

/// How far a meal that is found may lie from one that was eaten, steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tolerance {
    /// How much too early.
    pub early: usize,
    /// How much too late.
    pub late: usize,
}

impl Tolerance {
    /// An hour early, an hour and a half late: the published rate-of-rise detectors give their
    /// alarm 30 to 60 min after the first bite and the slowest within 90 min, which is also as far
    /// as the paper lets a bolus lie from its meal; nothing shows before it is eaten, so that an
    /// hour is room for an onset that is estimated backwards.
    #[must_use]
    pub const fn usual() -> Self {
        Self { early: 12, late: 18 }
    }

    /// Signed distance in steps, if it is tolerated.
    fn distance(self, truth: usize, found: usize) -> Option<i64> {
        let late = found as i64 - truth as i64;
        (-(self.early as i64)..=self.late as i64).contains(&late).then_some(late)
    }
}

/// What was eaten within 30 min of the first bite is one meal at that time.
pub const SITTING: usize = 6;

/// Carbohydrate by step, g, as meals: steps within [`SITTING`] of a meal's first belong to it.
#[must_use]
pub fn sittings(carbs: impl IntoIterator<Item = f64>) -> Vec<Eaten> {
    let mut meals: Vec<Eaten> = Vec::new();
    for (step, grams) in carbs.into_iter().enumerate() {
        match meals.last_mut() {
            Some(Eaten { step: first, carbs: Some(sum) }) if step - *first < SITTING => {
                *sum = *sum + Grams(grams.max(0.0));
            }
            _ if grams > 0.0 => meals.push(Eaten { step, carbs: Some(Grams(grams)) }),
            _ => {}
        }
    }
    meals
}

/// Pairs of (place in `truth`, place in `found`), each used once: the nearest pair first, of equal
/// ones the earlier. In order of `truth`.
#[must_use]
pub fn pairs(truth: &[Eaten], found: &[Eaten], tolerance: Tolerance) -> Vec<(usize, usize)> {
    let mut near: Vec<(u64, usize, usize)> = Vec::new();
    for (t, eaten) in truth.iter().enumerate() {
        for (f, claimed) in found.iter().enumerate() {
            if let Some(late) = tolerance.distance(eaten.step, claimed.step) {
                near.push((late.unsigned_abs(), t, f));
            }
        }
    }
    near.sort_unstable();
    let near = near.into_iter().map(|(_, t, f)| (t, f));
    let mut pairs = each_once(near, truth.len(), found.len());
    pairs.sort_unstable();
    pairs
}

/// The pairs of places in two lists in which no place was used by a pair before.
pub(crate) fn each_once(
    pairs: impl Iterator<Item = (usize, usize)>,
    left: usize,
    right: usize,
) -> Vec<(usize, usize)> {
    let (mut of_left, mut of_right) = (vec![false; left], vec![false; right]);
    let take = |(l, r): &(usize, usize)| {
        let free = !of_left[*l] && !of_right[*r];
        if free {
            (of_left[*l], of_right[*r]) = (true, true);
        }
        free
    };
    pairs.filter(take).collect()
}

/// Upper ends of the classes of size, g; the last class has none.
pub const CLASSES: [f64; 3] = [20.0, 40.0, 70.0];

/// Counts and errors that are still to be summed up.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Tally {
    days: f64,
    eaten: [usize; CLASSES.len() + 1],
    matched: [usize; CLASSES.len() + 1],
    claimed: usize,
    eaten_grams: f64,
    explained_grams: f64,
    invented_grams: f64,
    late: Vec<f64>,
    sizes: Vec<(f64, f64)>,
    on_board: f64,
    steps: usize,
}

impl Tally {
    /// Tallies one person: `steps` of a record in which `truth` was eaten and `found` is claimed.
    #[must_use]
    pub fn of(truth: &[Eaten], found: &[Eaten], steps: usize, tolerance: Tolerance) -> Self {
        let mut tally = Self {
            days: steps as f64 / STEPS_PER_DAY as f64,
            claimed: found.len(),
            steps,
            on_board: on_board_error(truth, found, steps),
            ..Self::default()
        };
        let grams = |eaten: &Eaten| eaten.carbs.map_or(0.0, |g| g.0);
        for eaten in truth {
            tally.eaten[class(grams(eaten))] += 1;
            tally.eaten_grams += grams(eaten);
        }
        let pairs = pairs(truth, found, tolerance);
        let mut used = vec![false; found.len()];
        for (t, f) in pairs {
            let (eaten, claimed) = (&truth[t], &found[f]);
            used[f] = true;
            tally.matched[class(grams(eaten))] += 1;
            tally.late.push((claimed.step as f64 - eaten.step as f64) * STEP.0);
            if let Some(estimate) = claimed.carbs {
                tally.sizes.push((grams(eaten), estimate.0));
                tally.explained_grams += grams(eaten).min(estimate.0);
                tally.invented_grams += (estimate.0 - grams(eaten)).max(0.0);
            }
        }
        let unmatched = found.iter().zip(used).filter(|(_, used)| !used);
        tally.invented_grams += unmatched.map(|(claimed, _)| grams(claimed)).sum::<f64>();
        tally
    }

    /// Both people together.
    #[must_use]
    pub fn merge(mut self, other: Self) -> Self {
        let counts = self.eaten.iter_mut().chain(&mut self.matched);
        for (count, more) in counts.zip(other.eaten.iter().chain(&other.matched)) {
            *count += more;
        }
        self.days += other.days;
        self.claimed += other.claimed;
        self.eaten_grams += other.eaten_grams;
        self.explained_grams += other.explained_grams;
        self.invented_grams += other.invented_grams;
        self.late.extend(other.late);
        self.sizes.extend(other.sizes);
        self.on_board += other.on_board;
        self.steps += other.steps;
        self
    }

    /// The figures.
    #[must_use]
    pub fn score(&self) -> Score {
        let eaten: usize = self.eaten.iter().sum();
        let matched: usize = self.matched.iter().sum();
        let lower = std::iter::once(0.0).chain(CLASSES);
        let classes = lower
            .zip(self.eaten.iter().zip(&self.matched))
            .map(|(from, (eaten, matched))| ClassScore {
                from_g: from,
                eaten: *eaten,
                sensitivity: share(*matched as f64, *eaten as f64),
            })
            .collect();
        Score {
            days: self.days,
            eaten,
            claimed: self.claimed,
            matched,
            sensitivity: share(matched as f64, eaten as f64),
            precision: share(matched as f64, self.claimed as f64),
            false_per_day: share((self.claimed - matched) as f64, self.days),
            time: time_error(&self.late),
            size: size_error(&self.sizes),
            explained: share(self.explained_grams, self.eaten_grams),
            invented: share(self.invented_grams, self.eaten_grams),
            on_board_error_g: share(self.on_board, self.steps as f64),
            classes,
        }
    }
}

/// Errors of time of meals that are late by so many minutes; `None` of none.
fn time_error(late: &[f64]) -> Option<TimeError> {
    let mut sorted = late.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let mut absolute: Vec<f64> = late.iter().map(|minutes| minutes.abs()).collect();
    absolute.sort_unstable_by(f64::total_cmp);
    Some(TimeError {
        median: quantile(&sorted, 0.5)?,
        lower_quartile: quantile(&sorted, 0.25)?,
        upper_quartile: quantile(&sorted, 0.75)?,
        median_absolute: quantile(&absolute, 0.5)?,
        late: share(late.iter().filter(|m| **m > 0.0).count() as f64, late.len() as f64)?,
    })
}

/// Errors of size, from sizes eaten and claimed, g; `None` of none.
fn size_error(sizes: &[(f64, f64)]) -> Option<SizeError> {
    let n = sizes.len() as f64;
    let mean = |value: &dyn Fn(f64, f64) -> f64| {
        share(sizes.iter().map(|(truth, claimed)| value(*truth, *claimed)).sum(), n)
    };
    let mean_absolute_g = mean(&|truth, claimed| (claimed - truth).abs())?;
    Some(SizeError {
        meals: sizes.len(),
        bias_g: mean(&|truth, claimed| claimed - truth)?,
        mean_absolute_g,
        mean_absolute_percent: 100.0 * mean_absolute_g / mean(&|truth, _| truth)?,
    })
}

/// Time constant by which carbohydrate is taken to leave the gut: the plant's t_max,G.
const ON_BOARD: Minutes = Minutes(40.0);

/// Sum over the steps of the absolute difference between the carbohydrate that two lists leave in a
/// gut of two compartments, g.
fn on_board_error(truth: &[Eaten], found: &[Eaten], steps: usize) -> f64 {
    let mut signed = vec![0.0; steps];
    for (list, sign) in [(truth, 1.0), (found, -1.0)] {
        for eaten in list {
            if let Some(slot) = signed.get_mut(eaten.step) {
                *slot += sign * eaten.carbs.map_or(0.0, |grams| grams.0);
            }
        }
    }
    let mut gut = GutPair::default();
    let mut sum = 0.0;
    for grams in signed {
        gut = gut.fed(grams);
        sum += (gut.c1 + gut.c2).abs();
        gut = gut.after(STEP.0, ON_BOARD.0);
    }
    sum
}

fn class(grams: f64) -> usize {
    CLASSES.iter().filter(|end| grams >= **end).count()
}

fn share(part: f64, whole: f64) -> Option<f64> {
    (whole > 0.0).then(|| part / whole)
}

/// Quantile of sorted values, linear between them; `None` of none.
fn quantile(sorted: &[f64], p: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let position = p * last as f64;
    let below = position.floor() as usize;
    let above = (below + 1).min(last);
    Some(sorted[below] + (position - below as f64) * (sorted[above] - sorted[below]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meals(list: &[(usize, f64)]) -> Vec<Eaten> {
        list.iter().map(|(step, g)| Eaten { step: *step, carbs: Some(Grams(*g)) }).collect()
    }

    #[test]
    fn bites_of_half_an_hour_are_one_meal() {
        let mut carbs = vec![0.0; 40];
        for (step, grams) in [(3, 20.0), (5, 10.0), (8, 5.0), (9, 7.0), (30, 50.0)] {
            carbs[step] = grams;
        }
        assert_eq!(sittings(carbs), meals(&[(3, 35.0), (9, 7.0), (30, 50.0)]));
        assert!(sittings([0.0, f64::NAN]).is_empty());
    }

    #[test]
    fn pairs_are_one_to_one_and_nearest_first() {
        let tolerance = Tolerance { early: 12, late: 18 };
        let check = |eaten: &[usize], claimed: &[usize], expected: &[(usize, usize)]| {
            let list =
                |steps: &[usize]| meals(&steps.iter().map(|s| (*s, 1.0)).collect::<Vec<_>>());
            assert_eq!(pairs(&list(eaten), &list(claimed), tolerance), expected, "{eaten:?}");
        };
        check(&[100], &[88], &[(0, 0)]);
        check(&[100], &[87], &[]);
        check(&[100], &[118], &[(0, 0)]);
        check(&[100], &[119], &[]);
        check(&[100], &[96, 103], &[(0, 1)]);
        // The nearest pair is (110, 109); 100 is left with 95.
        check(&[100, 110], &[95, 109], &[(0, 0), (1, 1)]);
    }

    #[test]
    fn figures_by_hand() {
        let truth = meals(&[(100, 50.0), (150, 30.0), (200, 15.0)]);
        let found = meals(&[(102, 40.0), (149, 45.0), (250, 20.0)]);
        let score = Tally::of(&truth, &found, 576, Tolerance::usual()).score();
        assert_eq!((score.eaten, score.claimed, score.matched), (3, 3, 2));
        assert_eq!(score.sensitivity, Some(2.0 / 3.0));
        assert_eq!(score.precision, Some(2.0 / 3.0));
        assert_eq!(score.false_per_day, Some(0.5));
        let time = score.time.expect("two pairs");
        // Errors of +10 and -5 min.
        assert_eq!((time.median, time.lower_quartile, time.upper_quartile), (2.5, -1.25, 6.25));
        assert_eq!((time.median_absolute, time.late), (7.5, 0.5));
        let size = score.size.expect("two sizes");
        // Errors of -10 and +15 g of 50 and 30 g.
        assert_eq!((size.bias_g, size.mean_absolute_g), (2.5, 12.5));
        assert_eq!(size.mean_absolute_percent, 31.25);
        assert_eq!(score.explained, Some(70.0 / 95.0));
        assert_eq!(score.invented, Some(35.0 / 95.0));
        let by_class: Vec<_> = score.classes.iter().map(|c| (c.eaten, c.sensitivity)).collect();
        assert_eq!(by_class, [(1, Some(0.0)), (1, Some(1.0)), (1, Some(1.0)), (0, None)]);
    }

    #[test]
    fn carbohydrate_on_board_is_wrong_by_what_is_missing() {
        let truth = meals(&[(10, 60.0)]);
        assert_eq!(on_board_error(&truth, &truth, 288), 0.0);
        // Sum of D (1 + t/tau) exp(-t/tau) over steps of 5 min, about 2 tau D / 5 + D / 2.
        let missing = on_board_error(&truth, &[], 288);
        assert!((missing / (60.0 * (2.0 * 40.0 / 5.0 + 0.5)) - 1.0).abs() < 0.01, "{missing}");
        let late = on_board_error(&truth, &meals(&[(12, 60.0)]), 288);
        assert!(late > 0.0 && late < missing, "{late}");
    }

    #[test]
    fn tallies_of_people_are_those_of_one_long_record() {
        let one = Tally::of(&meals(&[(9, 30.0)]), &meals(&[(10, 20.0)]), 288, Tolerance::usual());
        let two = Tally::of(&meals(&[(40, 80.0)]), &meals(&[]), 288, Tolerance::usual());
        let both = one.clone().merge(two.clone()).score();
        assert_eq!((both.days, both.eaten, both.claimed, both.matched), (2.0, 2, 1, 1));
        assert_eq!(both.explained, Some(20.0 / 110.0));
        assert_eq!(both, two.merge(one).score());
    }

    #[test]
    fn nothing_has_no_share() {
        let score = Tally::of(&[], &[], 288, Tolerance::usual()).score();
        assert_eq!((score.sensitivity, score.precision, score.time), (None, None, None));
        assert_eq!((score.size, score.explained, score.false_per_day), (None, None, Some(0.0)));
    }
}
