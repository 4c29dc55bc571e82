//! Natural units: what a cohort's meals, boluses, nights, days, bouts, sets and lows show of every field of the plant.
//!
//! The filter is run once. With its gains held, the score of a factor on any field over any steps is a sum of the
//! adjoint's entries ([`course_scores`](crate::filter::tangent::course_scores)), the background taken out. Units of one kind are
//! then held against each other: whether their scores have a mean, a spread, tails or memory, whether they follow a
//! covariate, and whether people share it. Nothing is decided here: the statistics are what
//! a posterior reads.

mod doses;
mod kinds;
mod port_course;
mod scores;
mod tally;

use std::collections::BTreeMap;

use effects::EffectId;
use faer::Mat;

pub(crate) use self::doses::Doses;
pub(crate) use self::port_course::PortCourse;
pub(crate) use self::scores::Nuisance;
pub(crate) use self::tally::power;

use self::kinds::{KINDS, Unit, units};
use self::port_course::CourseSums;
use self::scores::{DATA, FIELDS, Scores};
use self::tally::{OF_TALLIES, OF_TOTALS, Tally, Total, of_tallies, of_totals};
use crate::calibrated_person::CalibratedPerson;
use crate::context::Situations;
use crate::design::Design;
use crate::error::GapError;
use crate::filter::tangent::LANES;

/// What one person's units show.
#[derive(Debug, Clone)]
pub(crate) struct PersonUnits {
    /// By kind and field.
    tallies: BTreeMap<(usize, usize), Tally>,
    /// Power at each of the kind's periods, by kind and field.
    rhythms: BTreeMap<(usize, usize), Vec<f64>>,
    /// By kind, covariate and field.
    trends: BTreeMap<(usize, usize, usize), Total>,
    /// By driven effect and variant, days as units.
    effects: Vec<(EffectId, usize, Total)>,
    /// At every port, by part of the day.
    courses: Vec<CourseSums>,
}

impl PersonUnits {
    /// Of one person. `nuisances` is the background that every body may differ in, and `plain` the part of it that
    /// says nothing of the clock and of glucose; `information` is A of the design over all days.
    ///
    /// # Errors
    /// As [`signatures`](crate::filter::tangent::signatures).
    pub(crate) fn of(
        person: &CalibratedPerson<'_>,
        design: &Design,
        information: &Mat<f64>,
        nuisances: &[Nuisance],
        plain: &[Nuisance],
    ) -> Result<Self, GapError> {
        let course = person.course();
        let situations = Situations::of(person.person, &course.glucose);
        let [usual, less] = Scores::profiled(person, design, information, [nuisances, plain])?;
        let mut found = Self {
            tallies: BTreeMap::new(),
            rhythms: BTreeMap::new(),
            trends: BTreeMap::new(),
            effects: Vec::new(),
            courses: port_course::of_person(&less, &course.hour),
        };
        let doses = Doses::of_person(person);
        for units in units(&course, &situations, &doses) {
            let kind = KINDS[units.kind];
            let scores = if kind.plain { &less } else { &usual };
            let covariates = standardised(&units.units, kind.covariates.len());
            for field in 0..FIELDS.len() {
                let of_units: Vec<[f64; LANES]> =
                    units.units.iter().map(|unit| scores.over(field, &unit.steps)).collect();
                found.tallies.insert((units.kind, field), Tally::of(&of_units));
                if !kind.rhythms.is_empty() {
                    let scores: Vec<f64> = of_units.iter().map(|scores| scores[DATA]).collect();
                    let powers = kind.rhythms.iter().map(|(_, period)| power(&scores, *period));
                    found.rhythms.insert((units.kind, field), powers.collect());
                }
                for (index, values) in covariates.iter().enumerate() {
                    let pairs = of_units.iter().zip(values.iter().copied());
                    found.trends.insert((units.kind, index, field), Total::of(pairs));
                }
            }
        }
        for scores in [&usual, &less] {
            found.effects.extend(scores.effects.iter().map(|of| {
                (of.effect, of.variant, Total::of(of.days.iter().map(|day| (day, 1.0))))
            }));
        }
        Ok(found)
    }
}

/// Each covariate with mean 0 and standard deviation 1 over the units; 0 where it does not vary.
fn standardised(units: &[Unit], covariates: usize) -> Vec<Vec<f64>> {
    let n = units.len() as f64;
    (0..covariates)
        .map(|index| {
            let values = || units.iter().map(|unit| unit.covariates[index]);
            let mean = values().sum::<f64>() / n;
            let sd = (values().map(|x| (x - mean) * (x - mean)).sum::<f64>() / n).sqrt();
            values().map(|x| if sd > 1e-9 { (x - mean) / sd } else { 0.0 }).collect()
        })
        .collect()
}

/// What a cohort lacks at every port through the day.
pub(crate) fn courses(people: &[&PersonUnits]) -> Vec<PortCourse> {
    port_course::of_cohort(&people.iter().map(|p| p.courses.as_slice()).collect::<Vec<_>>())
}

/// The statistics of a cohort, by name; what no record shows is absent.
pub(crate) fn of_cohort(people: &[&PersonUnits]) -> BTreeMap<String, f64> {
    let mut found = BTreeMap::new();
    for (index, kind) in KINDS.iter().enumerate() {
        for (field, of) in FIELDS.iter().enumerate() {
            let tallies: Vec<Tally> =
                people.iter().filter_map(|p| p.tallies.get(&(index, field)).copied()).collect();
            if tallies.is_empty() {
                continue;
            }
            let totals: Vec<Total> = tallies.iter().map(|tally| tally.total).collect();
            let name = |statistic: &str| format!("{}/{of:?}/{statistic}", kind.name);
            for (statistic, value) in OF_TOTALS.iter().zip(of_totals(&totals)) {
                found.insert(name(statistic), value);
            }
            for (statistic, value) in OF_TALLIES.iter().zip(of_tallies(&tallies)) {
                found.insert(name(statistic), value);
            }
            let powers: Vec<&Vec<f64>> =
                people.iter().filter_map(|p| p.rhythms.get(&(index, field))).collect();
            for (rhythm_index, (rhythm, _)) in kind.rhythms.iter().enumerate() {
                let mean =
                    powers.iter().map(|of| of[rhythm_index]).sum::<f64>() / powers.len() as f64;
                found.insert(name(&format!("power at {rhythm}")), (mean + 0.01).ln());
            }
            for (covariate_index, covariate) in kind.covariates.iter().enumerate() {
                let of_person =
                    |p: &&PersonUnits| p.trends.get(&(index, covariate_index, field)).copied();
                let totals: Vec<Total> = people.iter().filter_map(of_person).collect();
                for (statistic, value) in OF_TOTALS.iter().zip(of_totals(&totals)).take(4) {
                    found.insert(name(&format!("by {covariate}/{statistic}")), value);
                }
            }
        }
    }
    // Scores against the whole background come first, then those against the plain one.
    let mut drivers: BTreeMap<(EffectId, usize, bool), Vec<Total>> = BTreeMap::new();
    for person in people {
        let half = person.effects.len() / 2;
        for (position, (effect, variant, total)) in person.effects.iter().enumerate() {
            drivers.entry((*effect, *variant, position >= half)).or_default().push(*total);
        }
    }
    for ((effect, variant, plain), totals) in drivers {
        let background = if plain { "plain" } else { "usual" };
        for (statistic, value) in OF_TOTALS.iter().zip(of_totals(&totals)) {
            found.insert(format!("{effect}/{variant}/{background}/{statistic}"), value);
        }
    }
    found
}
