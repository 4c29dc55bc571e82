//! What a port lacks through the day: a course by three hours of the clock, with simultaneous intervals.
//!
//! With gains held, scores of a factor on each part of the day are a vector with a known information matrix, so that the
//! course is a generalised least-squares estimate. Its prior is Gaussian about none with a size that is averaged over;
//! where scores scatter more over days or people than the model says, information counts for less (a sandwich). What
//! lasts all day is the calibration's: a course is what goes beyond its own mean.

use effects::{Field, Port};
use faer::{Mat, Side};
use physiology::STEPS_PER_HOUR;

use super::scores::{FIELDS, Scores};
use super::tally::{DATA, DRAWS};
use crate::context::{HOURS_OF_PART, PARTS, part_of_day};
use crate::log_sum::raised;

/// Parts of which neighbours may share steps: a day (weights fall to 0 there; Newey and West, Econometrica 1987;55:703).
const REACH: usize = PARTS;
/// Standard errors of intervals that hold all parts in 95 of 100 (Bonferroni).
const ERRORS: f64 = 2.734;
/// Sizes that a course may have, times what one part of average information could show.
const SIZES: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];

/// One field for each port, its unit, and what its scores' unit is of that unit. Not the sensor's: readings that move
/// slowly cannot be separated from glucose that does.
const OF_PORTS: [(Port, Field, &str, f64); 8] = [
    (Port::InsulinInput, Field::InsulinInput, "factor", 1.0),
    (Port::InsulinAbsorption, Field::InsulinTime, "factor", 1.0),
    (Port::InsulinAction, Field::Action, "factor", 1.0),
    (Port::InsulinActionLiver, Field::LiverAction, "factor", 1.0),
    (Port::Egp, Field::Production, "factor", 1.0),
    (Port::GutAbsorption, Field::GutTime, "factor", 1.0),
    (Port::CarbAmount, Field::ExtraCarbs, "g/h", STEPS_PER_HOUR as f64),
    (Port::GlucoseFlux, Field::Flux, "mmol/kg/min", 1.0),
];

/// What a cohort lacks at a port through the day.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PortCourse {
    pub(crate) port: Port,
    pub(crate) unit: &'static str,
    /// Estimate and half width of its simultaneous interval, by part of the day from midnight on.
    pub(crate) parts: [(f64, f64); PARTS],
}

/// Scores of one person at one port, by part of the day.
#[derive(Debug, Clone)]
pub(super) struct CourseSums {
    score: [f64; PARTS],
    /// (parts, parts): variance of the scores where nothing is missing.
    information: Mat<f64>,
    /// (parts, parts): their variance as days scatter.
    scatter: Mat<f64>,
}

/// Scores of a person at every port. `hours` is the hour of each step.
pub(super) fn of_person(scores: &Scores, hours: &[f64]) -> Vec<CourseSums> {
    let length = HOURS_OF_PART * STEPS_PER_HOUR;
    let first =
        (0..hours.len()).find(|k| hours[*k].rem_euclid(HOURS_OF_PART as f64) < 1e-6).unwrap_or(0);
    let of_port = |(_, field, ..): &(Port, Field, &str, f64)| {
        let field = FIELDS.iter().position(|of| of == field).expect("a field that is scored");
        let whole = (first..hours.len()).step_by(length).filter(|k| k + length <= hours.len());
        let of_block =
            |k: usize| (part_of_day(hours[k] as usize), scores.over(field, &(k..k + length)));
        CourseSums::of(&whole.map(of_block).collect::<Vec<_>>())
    };
    OF_PORTS.iter().map(of_port).collect()
}

impl CourseSums {
    fn of<const LANES: usize>(blocks: &[(usize, [f64; LANES])]) -> Self {
        let mut sums = Self {
            score: [0.0; PARTS],
            information: Mat::zeros(PARTS, PARTS),
            scatter: Mat::zeros(PARTS, PARTS),
        };
        for (index, (part, own)) in blocks.iter().enumerate() {
            sums.score[*part] += own[DATA];
            for (lag, (other, theirs)) in blocks[index..].iter().take(REACH).enumerate() {
                let weight = 1.0 - lag as f64 / REACH as f64;
                let drawn = own.iter().zip(theirs).skip(DATA + 1).map(|(a, b)| a * b).sum::<f64>();
                let pairs = [
                    (&mut sums.information, drawn / DRAWS as f64),
                    (&mut sums.scatter, own[DATA] * theirs[DATA]),
                ];
                for (matrix, product) in pairs {
                    matrix[(*part, *other)] += weight * product;
                    if lag > 0 {
                        matrix[(*other, *part)] += weight * product;
                    }
                }
            }
        }
        sums
    }
}

/// The courses of a cohort, a port each; those of ports that no record tells of are absent.
pub(super) fn of_cohort(people: &[&[CourseSums]]) -> Vec<PortCourse> {
    OF_PORTS
        .iter()
        .enumerate()
        .filter_map(|(index, (port, _, unit, scale))| {
            let own: Vec<&CourseSums> = people.iter().filter_map(|p| p.get(index)).collect();
            let parts = course(&own)?.map(|(value, half)| (scale * value, scale * half));
            Some(PortCourse { port: *port, unit, parts })
        })
        .collect()
}

/// Estimate and half width by part.
fn course(people: &[&CourseSums]) -> Option<[(f64, f64); PARTS]> {
    let mut information = Mat::<f64>::zeros(PARTS, PARTS);
    people.iter().for_each(|person| information += &person.information);
    let score: [f64; PARTS] =
        std::array::from_fn(|part| people.iter().map(|person| person.score[part]).sum());
    let eigen = information.self_adjoint_eigen(Side::Lower).ok()?;
    let (values, vectors) = (eigen.S().column_vector(), eigen.U());
    let largest = values[PARTS - 1];
    if !largest.is_finite() || largest <= 0.0 {
        return None;
    }
    // Directions of which the data tell next to nothing stay at their prior.
    let bounded: Vec<f64> = (0..PARTS).map(|k| values[k].max(1e-9 * largest)).collect();
    let along: Vec<f64> =
        (0..PARTS).map(|k| (0..PARTS).map(|i| vectors[(i, k)] * score[i]).sum()).collect();
    let excess = scatter_over_model(people);
    let unit = (excess * PARTS as f64 / bounded.iter().sum::<f64>()).sqrt();
    // Log likelihood of every size, and the estimate and covariance that it gives, in the eigenvectors.
    let (likelihoods, of_sizes): (Vec<f64>, Vec<Vec<(f64, f64)>>) = SIZES
        .iter()
        .map(|size| {
            let prior = (size * unit).powi(2);
            let mut likelihood = 0.0;
            let each = bounded.iter().zip(&along).map(|(bounded, along)| {
                let precision = bounded / excess;
                let variance = precision + precision * precision * prior;
                let scaled = along / excess;
                likelihood -= 0.5 * (scaled * scaled / variance + variance.ln());
                let posterior = prior / (1.0 + precision * prior);
                (posterior * scaled, posterior)
            });
            let each: Vec<(f64, f64)> = each.collect();
            (likelihood, each)
        })
        .unzip();
    let weights = raised(&likelihoods);
    let total: f64 = weights.iter().sum();
    let averaged = |k: usize, of: &dyn Fn((f64, f64)) -> f64| {
        of_sizes.iter().zip(&weights).map(|(each, w)| w * of(each[k])).sum::<f64>() / total
    };
    let mean: Vec<f64> = (0..PARTS).map(|k| averaged(k, &|(mean, _)| mean)).collect();
    // Within sizes and between them.
    let spread = |k: usize| averaged(k, &|(own, within)| within + (own - mean[k]).powi(2));
    let variance: Vec<f64> = (0..PARTS).map(spread).collect();
    // Beyond the mean of the day.
    let centred = Mat::from_fn(PARTS, PARTS, |i, k| {
        let mean = (0..PARTS).map(|j| vectors[(j, k)]).sum::<f64>() / PARTS as f64;
        vectors[(i, k)] - mean
    });
    Some(std::array::from_fn(|i| {
        let value = (0..PARTS).map(|k| centred[(i, k)] * mean[k]).sum();
        let variance: f64 = (0..PARTS).map(|k| centred[(i, k)].powi(2) * variance[k]).sum();
        (value, ERRORS * variance.sqrt())
    }))
}

/// By how much scores scatter over days, or over people, more than where nothing is missing; 1 at least.
fn scatter_over_model(people: &[&CourseSums]) -> f64 {
    let sum = |of: fn(&CourseSums) -> &Mat<f64>| -> f64 {
        people.iter().map(|p| (0..PARTS).map(|i| of(p)[(i, i)]).sum::<f64>()).sum()
    };
    let model = sum(|p| &p.information).max(f64::MIN_POSITIVE);
    let days = sum(|p| &p.scatter) / model;
    // About what each person's own information would share of the cohort's score.
    let mut apart = 0.0;
    for part in 0..PARTS {
        let score: f64 = people.iter().map(|p| p.score[part]).sum();
        let of_person = |p: &&CourseSums| p.information[(part, part)];
        let information: f64 = people.iter().map(of_person).sum();
        if information > 0.0 {
            let own =
                |p: &&CourseSums| (p.score[part] - score * of_person(p) / information).powi(2);
            apart += people.iter().map(own).sum::<f64>();
        }
    }
    let count = people.len() as f64;
    let persons = if count > 1.0 { apart * count / (count - 1.0) / model } else { 0.0 };
    days.max(persons).max(1.0)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::filter::tangent::LANES;

    /// A person of a fortnight whose every part of a day has information 4, and lacks so much of it.
    fn person(lacks: [f64; PARTS], seed: u64) -> CourseSums {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let blocks: Vec<(usize, [f64; LANES])> = (0..14 * PARTS)
            .map(|block| {
                let part = block % PARTS;
                let mut noise = || 2.0 * 3f64.sqrt() * rng.random_range(-1.0..1.0);
                let mut lanes = [0.0; LANES].map(|_: f64| noise());
                lanes[DATA] += 4.0 * lacks[part];
                (part, lanes)
            })
            .collect();
        CourseSums::of(&blocks)
    }

    fn found(lacks: [f64; PARTS]) -> [(f64, f64); PARTS] {
        let people: Vec<CourseSums> = (0..6).map(|seed| person(lacks, seed)).collect();
        course(&people.iter().collect::<Vec<_>>()).expect("informative")
    }

    #[test]
    fn a_course_is_found_within_its_interval_and_none_where_nothing_is_lacking() {
        let mut lacks = [0.0; PARTS];
        lacks[1] = 0.8;
        for (part, (value, half)) in found(lacks).into_iter().enumerate() {
            let truth = lacks[part] - 0.1;
            assert!((value - truth).abs() < half, "{part}: {value} of {truth} by {half}");
            assert_eq!(value - half > 0.0, part == 1, "{part}: {value} by {half}");
        }
        assert!(found([0.0; PARTS]).iter().all(|(value, half)| value.abs() < *half));
        // What lasts all day is the calibration's.
        assert!(found([0.8; PARTS]).iter().all(|(value, half)| value.abs() < *half));
    }

    #[test]
    fn people_who_differ_widen_the_interval() {
        let mut lacks = [0.0; PARTS];
        lacks[1] = 0.8;
        let mut people: Vec<CourseSums> = (0..6).map(|seed| person(lacks, seed)).collect();
        let half = |people: &[CourseSums]| {
            course(&people.iter().collect::<Vec<_>>()).expect("informative")[1].1
        };
        let alike = half(&people);
        lacks[1] = -3.0;
        people[5] = person(lacks, 5);
        assert!(half(&people) > 1.3 * alike);
        assert!(course(&[]).is_none());
    }
}
