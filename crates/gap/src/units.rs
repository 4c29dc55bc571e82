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
pub(crate) use self::tally::power;

use self::kinds::{Covariate, KINDS, Life};
use self::port_course::CourseSums;
use self::scores::{FIELDS, Scores};
use self::tally::{DATA, OF_TALLIES, OF_TOTALS, Tally, Total, of_tallies, of_totals};
use crate::background::Allowed;
use crate::calibrated_person::CalibratedPerson;
use crate::context::Situations;
use crate::design::Design;
use crate::error::GapError;
use crate::filter::tangent::LANES;
use crate::person_statistics::mean_and_sd;

/// What one person's units show.
#[derive(Debug, Clone)]
pub(crate) struct PersonUnits {
    /// By kind and field.
    fields: BTreeMap<(usize, usize), OfField>,
    /// By driven effect, variant and whether the background is the plain one; days as units.
    effects: Vec<((EffectId, usize, bool), Total)>,
    /// At every port, by part of the day.
    courses: Vec<CourseSums>,
}

/// What one person's units of one kind show of one field.
#[derive(Debug, Clone)]
struct OfField {
    tally: Tally,
    /// Power at each of the kind's periods.
    rhythms: Vec<f64>,
    /// By covariate.
    trends: Vec<Total>,
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
        nuisances: &[Allowed],
        plain: &[Allowed],
    ) -> Result<Self, GapError> {
        let course = person.course();
        let situations = Situations::of(person.person, &course.glucose);
        let [usual, less] = Scores::profiled(person, design, information, [nuisances, plain])?;
        let mut found = Self {
            fields: BTreeMap::new(),
            effects: Vec::new(),
            courses: port_course::of_person(&less, &course.hour),
        };
        let doses = Doses::of_person(person);
        let life = Life::of(&course, &situations, &doses, &person.observations.doses_recorded);
        for (index, kind) in KINDS.iter().enumerate() {
            let units = (kind.units)(&life);
            if units.is_empty() {
                continue;
            }
            let scores = if kind.plain { &less } else { &usual };
            let over_units = |(_, of): &Covariate| {
                standardised(&units.iter().map(|unit| of(&life, unit)).collect::<Vec<_>>())
            };
            let covariates: Vec<Vec<f64>> = kind.covariates.iter().map(over_units).collect();
            for field in 0..FIELDS.len() {
                let of_units: Vec<[f64; LANES]> =
                    units.iter().map(|unit| scores.over(field, &unit.steps)).collect();
                let data: Vec<f64> = of_units.iter().map(|scores| scores[DATA]).collect();
                let trend =
                    |values: &Vec<f64>| Total::of(of_units.iter().zip(values.iter().copied()));
                let of_field = OfField {
                    tally: Tally::of(&of_units),
                    rhythms: kind.rhythms.iter().map(|(_, n)| power(&data, *n)).collect(),
                    trends: covariates.iter().map(trend).collect(),
                };
                found.fields.insert((index, field), of_field);
            }
        }
        for (scores, plain) in [(usual, false), (less, true)] {
            let of = scores.effects.into_iter();
            let of = of.map(|(effect, variant, total)| ((effect, variant, plain), total));
            found.effects.extend(of);
        }
        Ok(found)
    }
}

/// With mean 0 and standard deviation 1; 0 where values do not vary.
fn standardised(values: &[f64]) -> Vec<f64> {
    let (mean, sd) = mean_and_sd(values);
    values.iter().map(|x| if sd > 1e-9 { (x - mean) / sd } else { 0.0 }).collect()
}

/// What a cohort lacks at every port through the day.
pub(crate) fn courses(people: &[&PersonUnits]) -> Vec<PortCourse> {
    port_course::of_cohort(&people.iter().map(|p| p.courses.as_slice()).collect::<Vec<_>>())
}

/// The statistics of a cohort, by name; what no record shows is absent.
pub(crate) fn of_cohort(people: &[&PersonUnits]) -> BTreeMap<String, f64> {
    let mut found = BTreeMap::new();
    let mut add = |of: &str, names: &[&str], values: &[f64]| {
        let named = names.iter().zip(values);
        found.extend(named.map(|(name, value)| (format!("{of}/{name}"), *value)));
    };
    for (index, kind) in KINDS.iter().enumerate() {
        for (field, of) in FIELDS.iter().enumerate() {
            let shown: Vec<&OfField> =
                people.iter().filter_map(|p| p.fields.get(&(index, field))).collect();
            if shown.is_empty() {
                continue;
            }
            let tallies: Vec<Tally> = shown.iter().map(|of| of.tally).collect();
            let totals: Vec<Total> = tallies.iter().map(|tally| tally.total).collect();
            let units = format!("{}/{of:?}", kind.name);
            add(&units, &OF_TOTALS, &of_totals(&totals));
            add(&units, &OF_TALLIES, &of_tallies(&tallies));
            for (rhythm_index, (rhythm, _)) in kind.rhythms.iter().enumerate() {
                let powers = shown.iter().map(|of| of.rhythms[rhythm_index]);
                let mean = powers.sum::<f64>() / shown.len() as f64;
                add(&units, &[&format!("power at {rhythm}")], &[(mean + 0.01).ln()]);
            }
            for (covariate_index, (covariate, _)) in kind.covariates.iter().enumerate() {
                let totals: Vec<Total> =
                    shown.iter().map(|of| of.trends[covariate_index]).collect();
                add(&format!("{units}/by {covariate}"), &OF_TOTALS[..4], &of_totals(&totals));
            }
        }
    }
    let mut drivers: BTreeMap<(EffectId, usize, bool), Vec<Total>> = BTreeMap::new();
    for person in people {
        for (driver, total) in &person.effects {
            drivers.entry(*driver).or_default().push(*total);
        }
    }
    for ((effect, variant, plain), totals) in drivers {
        let background = if plain { "plain" } else { "usual" };
        add(&format!("{effect}/{variant}/{background}"), &OF_TOTALS, &of_totals(&totals));
    }
    found
}
