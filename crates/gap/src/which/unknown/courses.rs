//! Courses of no known effect at each port: something happens for some hours, for some days, or varies within
//! days, and neither what is constant nor what differs from day to day in everybody explains it.
//!
//! Events and states are a spike and slab over onsets, lengths and sizes, scored against their mirror image as
//! hidden events are. Few large changes are told in this way from many small ones: the usual differences are
//! normal. Swings are a random process that loses its memory within a day. Unlike the kinds of events that stand
//! beside the library, nothing here can be conditioned on; it says at which port something is missing.

use effects::Port;
use faer::{Mat, Side};
use rayon::prelude::*;

use super::bins::{BINS_PER_DAY, Bins, Left};
use crate::log_sum::{log_mean, log_with_probability};
use crate::which::held_out::Allowed;
use crate::which::statistics::{RANDOM, Sums};

/// A course of no known effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Course {
    /// Where it enters.
    pub port: Port,
    /// What it looks like.
    pub kind: Kind,
}

/// What a course looks like.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Hours at a time.
    Events,
    /// Days at a time.
    States,
    /// Up and down within days.
    Swings,
}

/// The courses that are tried.
const COURSES: [Course; 12] = [
    Course { port: Port::GlucoseFlux, kind: Kind::Events },
    Course { port: Port::Egp, kind: Kind::Events },
    Course { port: Port::InsulinAction, kind: Kind::Events },
    Course { port: Port::InsulinActionLiver, kind: Kind::Events },
    Course { port: Port::GutAbsorption, kind: Kind::Events },
    Course { port: Port::InsulinAbsorption, kind: Kind::Events },
    Course { port: Port::GlucoseFlux, kind: Kind::States },
    Course { port: Port::InsulinAction, kind: Kind::States },
    Course { port: Port::GutAbsorption, kind: Kind::States },
    Course { port: Port::InsulinAction, kind: Kind::Swings },
    Course { port: Port::GutAbsorption, kind: Kind::Swings },
    Course { port: Port::InsulinAbsorption, kind: Kind::Swings },
];
/// The ports of the courses, each once.
const PORTS: [Port; 6] = [
    Port::GlucoseFlux,
    Port::Egp,
    Port::InsulinAction,
    Port::InsulinActionLiver,
    Port::GutAbsorption,
    Port::InsulinAbsorption,
];

/// Probabilities of an event or a state in a stretch; they are averaged over.
const FREQUENCIES: [f64; 5] = [0.003, 0.01, 0.03, 0.1, 0.3];
/// Lengths of an event, bins, and bins of a stretch in which at most one starts.
const EVENT_LENGTHS: [usize; 2] = [2, 4];
const EVENT_STRETCH: usize = 4;
/// Sizes of an event, log or relative; a flux in units of nominal production.
const EVENT_SIZES: [f64; 4] = [0.3, 0.6, 1.0, 1.6];
/// The same of a state of days.
const STATE_LENGTHS: [usize; 3] = [3 * BINS_PER_DAY, 5 * BINS_PER_DAY, 8 * BINS_PER_DAY];
const STATE_STRETCH: usize = 7 * BINS_PER_DAY;
const STATE_SIZES: [f64; 3] = [0.15, 0.3, 0.5];
/// Most nats that one event may bring: an outlier shall not decide.
const MOST: f64 = 50.0;
/// Memory of swings, bins, and their spreads, which are averaged over.
const MEMORY: f64 = 4.0;
const SPREADS: [f64; 4] = [0.07, 0.15, 0.3, 0.6];

impl Course {
    /// The name that its evidence and its threshold have in files: port and kind.
    #[must_use]
    pub fn name(self) -> String {
        let kind = match self.kind {
            Kind::Events => "events",
            Kind::States => "states",
            Kind::Swings => "swings",
        };
        format!("{}/{kind}", self.port.name())
    }

    /// The course of this name; `None` for a name that none has.
    pub(in crate::which) fn from_name(name: &str) -> Option<Self> {
        COURSES.into_iter().find(|course| course.name() == name)
    }
}

/// Log likelihoods of one person's record over those of no course at all: a value a frequency for
/// either sign, or a value a spread.
enum Likelihood {
    Spikes([[f64; FREQUENCIES.len()]; 2]),
    Process([f64; SPREADS.len()]),
    /// No such direction in this person's model.
    Nothing,
}

/// What a person brings.
pub(in crate::which) struct Subject<'a> {
    pub(in crate::which) bins: &'a Bins,
    /// A and b as they are.
    pub(in crate::which) sums: &'a [Sums],
    /// What is allowed for.
    pub(in crate::which) allowed: Vec<Allowed>,
}

/// The evidence for every course, nats. `spreads` are those from day to day.
pub(in crate::which) fn gains(
    people: &[Subject<'_>],
    spreads: &[f64; RANDOM.len()],
) -> Vec<(Course, f64)> {
    let of_person = |person: &Subject<'_>| -> Vec<Likelihood> {
        let left = Left::of(person.bins, person.sums, &person.allowed, spreads, &PORTS);
        COURSES
            .iter()
            .map(|course| {
                let index = PORTS.iter().position(|port| *port == course.port);
                match index.and_then(|index| left[index].as_ref()) {
                    Some(left) => likelihood(left, course.kind),
                    None => Likelihood::Nothing,
                }
            })
            .collect()
    };
    let people: Vec<Vec<Likelihood>> = people.par_iter().map(of_person).collect();
    let of = |(index, course)| (course, together(people.iter().map(|p| &p[index])));
    COURSES.into_iter().enumerate().map(of).collect()
}

fn likelihood(left: &Left, kind: Kind) -> Likelihood {
    match kind {
        Kind::Events => spikes(left, &EVENT_LENGTHS, &EVENT_SIZES, EVENT_STRETCH),
        Kind::States => spikes(left, &STATE_LENGTHS, &STATE_SIZES, STATE_STRETCH),
        Kind::Swings => swings(left),
    }
}

/// Evidence over all people: averaged over frequencies, the mirror image subtracted where it has any; averaged
/// over spreads.
fn together<'a>(people: impl Iterator<Item = &'a Likelihood>) -> f64 {
    let mut spikes = [[0.0; FREQUENCIES.len()]; 2];
    let mut process = [0.0; SPREADS.len()];
    for person in people {
        match person {
            Likelihood::Spikes(logs) => add(spikes.as_flattened_mut(), logs.as_flattened()),
            Likelihood::Process(logs) => add(&mut process, logs),
            Likelihood::Nothing => {}
        }
    }
    // A course is of one kind: the other's average is 0.
    let [up, down] = spikes.map(|logs| log_mean(&logs));
    up.max(down) - up.min(down).max(0.0) + log_mean(&process)
}

fn add(sums: &mut [f64], values: &[f64]) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += value;
    }
}

/// In each stretch at most one event of either sign starts, with every frequency in turn.
fn spikes(left: &Left, lengths: &[usize], sizes: &[f64], stretch: usize) -> Likelihood {
    let mut score = vec![0.0];
    for s in &left.score {
        score.push(score[score.len() - 1] + s);
    }
    let mut logs = [[0.0; FREQUENCIES.len()]; 2];
    for start in (0..left.len()).step_by(stretch) {
        let mut ratios: [Vec<f64>; 2] = [Vec::new(), Vec::new()];
        for length in lengths {
            for onset in start..(start + stretch).min((left.len() + 1).saturating_sub(*length)) {
                let information = left.information(onset..onset + length);
                let score = score[onset + length] - score[onset];
                for size in sizes {
                    let square = 0.5 * size * size * information;
                    ratios[0].push((size * score - square).min(MOST));
                    ratios[1].push((-size * score - square).min(MOST));
                }
            }
        }
        for (logs, ratios) in logs.iter_mut().zip(&ratios).filter(|(_, r)| !r.is_empty()) {
            let ratio = log_mean(ratios);
            for (log, q) in logs.iter_mut().zip(FREQUENCIES) {
                *log += log_with_probability(ratio, q);
            }
        }
    }
    Likelihood::Spikes(logs)
}

/// An Ornstein-Uhlenbeck process in each day: with LL' its covariance, M = I + L'GL and z = L'score,
/// z'M^-1 z/2 - log|M|/2.
fn swings(left: &Left) -> Likelihood {
    let mut logs = [0.0; SPREADS.len()];
    let correlation =
        Mat::from_fn(BINS_PER_DAY, BINS_PER_DAY, |i, j| (-(i.abs_diff(j) as f64) / MEMORY).exp());
    let root = correlation.llt(Side::Lower).expect("the correlation of a process in time");
    for day in 0..left.days() {
        let (bins, gram) = left.day(day);
        let root = root.L().submatrix(0, 0, bins.len(), bins.len()).to_owned();
        let score = Mat::from_fn(bins.len(), 1, |k, _| left.score[bins.start + k]);
        let (gram, score) = (root.transpose() * &gram * &root, root.transpose() * &score);
        for (log, spread) in logs.iter_mut().zip(SPREADS) {
            let one = |i: usize, j: usize| f64::from(u8::from(i == j));
            let m = Mat::from_fn(bins.len(), bins.len(), |i, j| {
                one(i, j) + spread * spread * gram[(i, j)]
            });
            let factor = m.llt(Side::Lower).expect("the identity plus an information matrix");
            let mut solved = &score * faer::Scale(spread);
            faer::linalg::triangular_solve::solve_lower_triangular_in_place(
                factor.L(),
                solved.as_mut(),
                faer::Par::Seq,
            );
            *log += 0.5 * solved.squared_norm_l2();
            *log -= (0..bins.len()).map(|k| factor.L()[(k, k)].ln()).sum::<f64>();
        }
    }
    Likelihood::Process(logs)
}

#[cfg(test)]
mod tests {
    use super::super::bins::tests::alone;
    use super::*;

    /// Information of a bin about a factor.
    const INFORMATION: f64 = 8.0;

    /// Evidence for a course that is `size(bin)` for two weeks, behind noise of the size that is expected.
    fn gain(kind: Kind, size: impl Fn(usize) -> f64) -> f64 {
        let noise = |k: usize| (2.0 * INFORMATION).sqrt() * (1.7 * (k * k) as f64 + 0.3).sin();
        let score = (0..14 * BINS_PER_DAY).map(|k| INFORMATION * size(k) + noise(k)).collect();
        together([likelihood(&alone(INFORMATION, score), kind)].iter())
    }

    #[test]
    fn events_and_states_are_found_and_noise_is_not() {
        let events = |k: usize| if k % 40 < 3 { 1.2 } else { 0.0 };
        let state = |k: usize| if (50..110).contains(&k) { -0.5 } else { 0.0 };
        assert!(gain(Kind::Events, events) > 5.0);
        assert!(gain(Kind::States, state) > 5.0);
        for kind in [Kind::Events, Kind::States, Kind::Swings] {
            assert!(gain(kind, |_| 0.0) < 1.0, "{kind:?}");
        }
    }

    #[test]
    fn events_both_ways_are_no_evidence_for_either_but_for_swings() {
        let both = |k: usize| -> f64 {
            match k % 20 {
                0..4 => 0.9,
                10..14 => -0.9,
                _ => 0.0,
            }
        };
        let one_way = |k: usize| both(k).max(0.0);
        assert!(gain(Kind::Events, both) < 0.5 * gain(Kind::Events, one_way));
        assert!(gain(Kind::Swings, both) > 5.0);
    }

    #[test]
    fn a_record_without_the_direction_says_nothing_and_names_are_distinct() {
        assert_eq!(together([Likelihood::Nothing].iter()), 0.0);
        for course in COURSES {
            assert_eq!(Course::from_name(&course.name()), Some(course));
            assert!(PORTS.contains(&course.port));
        }
        assert_eq!(Course::from_name("egp/day"), None);
    }
}
