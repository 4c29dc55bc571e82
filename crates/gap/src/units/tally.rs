//! Sums over a person's units of one kind, from which a cohort's statistics are made.

use crate::filter::tangent::LANES;

/// Index of the innovations themselves among what is scored side by side; the others are drawn.
pub(super) const DATA: usize = 0;
/// Innovations that are drawn as the model says where nothing is missing: the mean of their squared scores is the
/// information (Hutchinson, Commun Stat Simul Comput 1989;18:1059).
pub(super) const DRAWS: usize = LANES - 1;

/// Least information of a score: below it the record says nothing of the factor.
const LEAST_INFORMATION: f64 = 1e-9;

/// Scores of some units, or products of theirs with a covariate.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Total {
    /// Sum of the scores.
    pub(super) score: f64,
    /// Sum of their squares: the variance of the sum as units scatter.
    pub(super) squares: f64,
    /// The variance of the sum where nothing is missing, as draws of the sum tell it.
    pub(super) information: f64,
    /// The same of units that are independent: the sum of their variances, which far more draws tell.
    pub(super) apart: f64,
}

impl Total {
    /// Of each unit's scores times a factor.
    pub(super) fn of<'a>(units: impl Iterator<Item = (&'a [f64; LANES], f64)>) -> Self {
        let mut sums = [0.0; LANES];
        let (mut squares, mut apart) = (0.0, 0.0);
        for (scores, factor) in units {
            for (sum, score) in sums.iter_mut().zip(scores) {
                *sum += factor * score;
            }
            squares += (factor * scores[DATA]).powi(2);
            apart += factor * factor * drawn_variance(scores);
        }
        Self { score: sums[DATA], squares, information: drawn_variance(&sums), apart }
    }
}

/// What the draws' squares tell of a variance.
fn drawn_variance(scores: &[f64; LANES]) -> f64 {
    scores[DATA + 1..].iter().map(|score| score * score).sum::<f64>() / DRAWS as f64
}

/// What one person's units of one kind show of one field.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Tally {
    pub(super) units: f64,
    pub(super) total: Total,
    /// Sums of powers of the units' scores over what their standard deviation is where nothing is missing.
    pub(super) powers: [f64; 4],
    /// Sum of products of neighbours.
    pub(super) products: f64,
    pub(super) most: f64,
    pub(super) least: f64,
}

impl Tally {
    /// Of units; those without a scored step are none.
    pub(super) fn of(scores: &[[f64; LANES]]) -> Self {
        let scored = || scores.iter().filter(|scores| drawn_variance(scores) > LEAST_INFORMATION);
        let total = Total::of(scored().map(|s| (s, 1.0)));
        let units = scored().count() as f64;
        let variance = total.apart / units.max(1.0);
        let mut tally = Self { units, total, ..Self::default() };
        let mut before = 0.0;
        for scores in scored() {
            let value = scores[DATA] / variance.sqrt();
            let mut power = 1.0;
            for sum in &mut tally.powers {
                power *= value;
                *sum += power;
            }
            tally.products += before * value;
            before = value;
            tally.most = tally.most.max(value);
            tally.least = tally.least.min(value);
        }
        tally
    }
}

/// Power of scores at a period of so many units, about their mean: 1 on average where they have no memory.
pub(crate) fn power(scores: &[f64], period: usize) -> f64 {
    let mean = scores.iter().sum::<f64>() / scores.len().max(1) as f64;
    let (mut along, mut across, mut squares) = (0.0, 0.0, 0.0);
    for (index, score) in scores.iter().enumerate() {
        let (sin, cos) = (std::f64::consts::TAU * index as f64 / period as f64).sin_cos();
        let value = score - mean;
        along += value * cos;
        across += value * sin;
        squares += value * value;
    }
    if squares > 0.0 { (along * along + across * across) / squares } else { 0.0 }
}

/// A cohort's statistics of totals: one a person.
pub(super) const OF_TOTALS: [&str; 5] = ["z", "z by unit", "z by person", "size", "people differ"];

/// The values of [`OF_TOTALS`].
pub(super) fn of_totals(people: &[Total]) -> [f64; 5] {
    let sum = |of: fn(&Total) -> f64| people.iter().map(of).sum::<f64>();
    let (score, squares) = (sum(|t| t.score), sum(|t| t.squares));
    let (information, apart) = (sum(|t| t.information), sum(|t| t.apart));
    if information < LEAST_INFORMATION {
        return [0.0; 5];
    }
    let by_person = sum(|t| t.score * t.score);
    let over =
        |value: f64, variance: f64| if variance > 0.0 { value / variance.sqrt() } else { 0.0 };
    // Few draws tell one person's information; how far units are correlated is the cohort's.
    let differ =
        people.iter().map(|t| over(t.score, information / apart * t.apart).powi(2)).sum::<f64>()
            / people.len() as f64;
    [
        over(score, information),
        over(score, squares),
        over(score, by_person),
        score / information,
        (differ + 0.01).ln(),
    ]
}

/// A cohort's statistics of tallies beside those of their totals.
pub(super) const OF_TALLIES: [&str; 6] =
    ["spread", "skewness", "kurtosis", "memory", "most", "least"];

/// The values of [`OF_TALLIES`].
pub(super) fn of_tallies(people: &[Tally]) -> [f64; 6] {
    let sum = |of: fn(&Tally) -> f64| people.iter().map(of).sum::<f64>();
    let units = sum(|t| t.units);
    if units < 1.0 {
        return [0.0; 6];
    }
    let [_, second, third, fourth] =
        std::array::from_fn(|power| people.iter().map(|t| t.powers[power]).sum::<f64>() / units);
    let spread = second.max(1e-6);
    [
        spread.ln(),
        third / spread.powf(1.5),
        fourth / (spread * spread) - 3.0,
        sum(|t| t.products) / units / spread,
        people.iter().map(|t| t.most).fold(0.0, f64::max),
        people.iter().map(|t| t.least).fold(0.0, f64::min),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit whose score is `data` and whose draws have the size `sd`.
    fn unit(data: f64, sd: f64) -> [f64; LANES] {
        std::array::from_fn(|lane| match lane {
            DATA => data,
            _ if lane % 2 == 0 => sd,
            _ => -sd,
        })
    }

    #[test]
    fn totals_pool_people_by_information() {
        let person = |scores: &[f64]| {
            let units: Vec<[f64; LANES]> = scores.iter().map(|s| unit(*s, 2.0)).collect();
            Total::of(units.iter().map(|u| (u, 1.0)))
        };
        // Draws of all units are alike, so that their sum has the size 2 n.
        let one = person(&[3.0, 1.0]);
        assert_eq!((one.score, one.squares, one.information, one.apart), (4.0, 10.0, 16.0, 8.0));
        let [z, by_unit, by_person, size, differ] = of_totals(&[one, person(&[-1.0, 1.0])]);
        assert!((z - 4.0 / 32f64.sqrt()).abs() < 1e-12);
        assert!((by_unit - 4.0 / 12f64.sqrt()).abs() < 1e-12);
        assert_eq!((by_person, size), (1.0, 0.125));
        assert!((differ - 0.51f64.ln()).abs() < 1e-12);
        assert_eq!(of_totals(&[Total::default()]), [0.0; 5]);
    }

    #[test]
    fn a_wave_has_power_at_its_period_alone() {
        let wave: Vec<f64> =
            (0..60).map(|k| (std::f64::consts::TAU * f64::from(k) / 12.0).sin()).collect();
        // n / 2 at its own period.
        assert!((power(&wave, 12) - 30.0).abs() < 1e-9);
        assert!(power(&wave, 10) < 1e-9);
        assert_eq!(power(&[], 12), 0.0);
        assert_eq!(power(&[2.0; 20], 10), 0.0);
    }

    #[test]
    fn tallies_tell_spread_tails_and_memory() {
        let of = |scores: &[f64]| {
            let units: Vec<[f64; LANES]> = scores.iter().map(|s| unit(*s, 2.0)).collect();
            of_tallies(&[Tally::of(&units)])
        };
        let [spread, skewness, kurtosis, memory, most, least] = of(&[2.0, -2.0, 2.0, -2.0]);
        assert_eq!((spread, skewness, kurtosis), (0.0, 0.0, -2.0));
        assert_eq!((memory, most, least), (-0.75, 1.0, -1.0));
        assert!(of(&[0.0, 0.0, 0.0, 8.0])[1] > 1.9);
        assert_eq!(of_tallies(&[Tally::default()]), [0.0; 6]);
    }

    #[test]
    fn units_without_a_scored_step_are_none() {
        let known = [unit(2.0, 2.0), unit(-2.0, 2.0)];
        let gap = [known[0], unit(0.0, 0.0), known[1]];
        assert_eq!(Tally::of(&gap), Tally::of(&known));
        assert_eq!(Tally::of(&gap[1..2]), Tally::default());
    }
}
