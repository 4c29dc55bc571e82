//! Whether made people look like real ones: every statistic that a diagnosis reads, for both.
//!
//! A posterior predictive check (Gelman, Meng and Stern, Stat Sin 1996;6:733) with the worlds of a
//! blind check in place of the posterior. Figures from worlds in which real people are improbable
//! say nothing about real people.

use contract::Document as _;
use contract::blind_check::{Group, PersonStatistics, Quantiles, Realism, StatisticRow};

use std::collections::{BTreeMap, BTreeSet};

use statrs::distribution::{Binomial, DiscreteCDF as _};
use stats::quantiles;

use crate::error::BlindError;
use crate::text_table::aligned;

/// Share of a group that lies within its central range.
const CENTRAL: f64 = 0.95;
/// Probability that more real people than [`StatisticRow::allowed_outside`] lie outside if they are
/// drawn like the made ones.
const CHANCE: f64 = 0.05;

/// Compares real people with those of worlds. Statistics that no real person has are left out.
///
/// # Errors
/// If a value is not finite, or there is no real person.
pub fn compare(people: &[PersonStatistics]) -> Result<Realism, BlindError> {
    let real: Vec<&PersonStatistics> = people.iter().filter(|p| p.group == Group::Real).collect();
    let names: BTreeSet<&String> = real.iter().flat_map(|p| p.values.keys()).collect();
    if names.is_empty() {
        return Err(BlindError::NobodyReal);
    }
    let statistics: Vec<StatisticRow> =
        names.into_iter().map(|name| row(name, people)).collect::<Result<_, _>>()?;
    let values: usize = statistics.iter().map(|row| row.real.people).sum();
    let outside: usize = statistics.iter().map(|row| row.outside.len()).sum();
    Ok(Realism {
        schema: Realism::SCHEMA.to_owned(),
        inside: statistics.iter().filter(|row| row.inside).count(),
        all_inside: statistics.iter().filter(|row| row.outside.is_empty()).count(),
        values_inside: values - outside,
        values,
        statistics,
    })
}

/// The table as text: one line per statistic; those in which real people lie outside are marked.
#[must_use]
pub fn table(realism: &Realism) -> String {
    let header = ["statistic", "nulls: 2.5 %", "median", "97.5 %", "effects: 2.5 %", "median"];
    let header = header.into_iter().chain(["97.5 %", "real: least", "median", "most", ""]);
    let mut lines = vec![header.map(str::to_owned).collect::<Vec<_>>()];
    for row in &realism.statistics {
        let of = |quantiles: Option<Quantiles>| match quantiles {
            Some(q) => [q.lower, q.median, q.upper].map(figure),
            None => ["-"; 3].map(str::to_owned),
        };
        let mut line = vec![row.statistic.clone()];
        line.extend(of(row.nulls));
        line.extend(of(row.effects));
        line.extend(of(Some(row.real)));
        let people: Vec<&str> = row.outside.keys().map(String::as_str).collect();
        line.push(match (people.as_slice(), row.inside) {
            ([], _) => String::new(),
            (people, true) => format!("(outside: {})", people.join(", ")),
            (people, false) => format!("OUTSIDE: {}", people.join(", ")),
        });
        lines.push(line);
    }
    aligned(&lines)
}

fn row(name: &str, people: &[PersonStatistics]) -> Result<StatisticRow, BlindError> {
    let of = |group: Group| -> Vec<(&PersonStatistics, f64)> {
        let own = people.iter().filter(|p| p.group == group);
        own.filter_map(|p| Some((p, *p.values.get(name)?))).collect()
    };
    let real = of(Group::Real);
    let tail = 0.5 * (1.0 - CENTRAL);
    let quantiles_of = |group: Group, tail: f64| -> Result<Option<Quantiles>, BlindError> {
        let values: Vec<f64> = of(group).iter().map(|(_, value)| *value).collect();
        if values.is_empty() {
            return Ok(None);
        }
        let [lower, median, upper] = quantiles(&values, [tail, 0.5, 1.0 - tail])
            .map_err(|source| BlindError::Statistic { statistic: name.to_owned(), source })?;
        Ok(Some(Quantiles { people: values.len(), lower, median, upper }))
    };
    let nulls = quantiles_of(Group::Null, tail)?;
    let effects = quantiles_of(Group::Effect, tail)?;
    let outside: BTreeMap<String, f64> = real
        .iter()
        .filter(|(_, value)| {
            let within = |q: Quantiles| (q.lower..=q.upper).contains(value);
            ![nulls, effects].into_iter().flatten().any(within)
        })
        .map(|(person, value)| (called(person, people), *value))
        .collect();
    let allowed_outside = by_chance(real.len());
    Ok(StatisticRow {
        statistic: name.to_owned(),
        nulls,
        effects,
        // For few people the minimum and the maximum, not a quantile between them.
        real: quantiles_of(Group::Real, 0.0)?.ok_or(BlindError::NobodyReal)?,
        inside: outside.len() <= allowed_outside,
        allowed_outside,
        outside,
    })
}

/// What a real person is called: the identifier, after the hand where another hand has it too.
fn called(person: &PersonStatistics, people: &[PersonStatistics]) -> String {
    let PersonStatistics { hand, person_id, .. } = person;
    let mut others = people.iter().filter(|other| other.group == Group::Real);
    let shared = others.any(|other| other.person_id == *person_id && other.hand != *hand);
    if shared { format!("{hand}/{person_id}") } else { person_id.clone() }
}

/// How many of so many people lie outside the central range at most by chance.
fn by_chance(people: usize) -> usize {
    let outside = Binomial::new(1.0 - CENTRAL, people as u64).expect("a share between 0 and 1");
    outside.inverse_cdf(1.0 - CHANCE) as usize
}

/// Three significant digits.
fn figure(value: f64) -> String {
    let size = value.abs();
    match size {
        _ if size >= 100.0 => format!("{value:.0}"),
        _ if size >= 10.0 => format!("{value:.1}"),
        _ if size >= 1.0 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn person(group: Group, id: &str, value: f64) -> PersonStatistics {
        let values = [("spread".to_owned(), value)].into();
        PersonStatistics { group, hand: "a".to_owned(), person_id: id.to_owned(), values }
    }

    /// Nulls from 0 to 1, effects from 10 to 11.
    fn worlds() -> Vec<PersonStatistics> {
        let values = (0..=200).map(|k| f64::from(k) / 200.0);
        values
            .flat_map(|v| [(Group::Null, v), (Group::Effect, 10.0 + v)])
            .map(|(group, value)| person(group, "made", value))
            .collect()
    }

    #[test]
    fn real_people_are_inside_where_either_kind_of_world_has_them() {
        let mut people = worlds();
        for (id, value) in [("low", 0.5), ("high", 10.5), ("between", 5.0)] {
            people.push(person(Group::Real, id, value));
        }
        let realism = compare(&people).expect("countable");
        let [row] = &realism.statistics[..] else { panic!("one row: {realism:?}") };
        let nulls = row.nulls.expect("nulls");
        // 2.5 % of 201 evenly spaced values.
        assert!((nulls.lower - 0.025).abs() < 1e-12 && (nulls.upper - 0.975).abs() < 1e-12);
        assert_eq!(row.outside.keys().collect::<Vec<_>>(), ["between"]);
        assert_eq!((realism.values_inside, realism.values, realism.all_inside), (2, 3, 0));
        // One of three lies outside by chance in 14 % of draws, two in 0.7 %.
        assert_eq!((row.allowed_outside, row.inside), (1, true));
        assert!(table(&realism).contains("(outside: between)"), "{}", table(&realism));
    }

    #[test]
    fn too_many_outside_are_said_and_nobody_real_is_an_error() {
        let mut people = worlds();
        assert!(matches!(compare(&people), Err(BlindError::NobodyReal)));
        people.extend(["a", "b", "c"].map(|id| person(Group::Real, id, 5.0)));
        let realism = compare(&people).expect("countable");
        assert_eq!(realism.inside, 0);
        assert!(table(&realism).contains("OUTSIDE: a, b, c"));
        people.push(person(Group::Null, "odd", f64::NAN));
        assert!(matches!(compare(&people), Err(BlindError::Statistic { .. })));
    }

    #[test]
    fn people_of_two_cohorts_who_share_an_identifier_are_two() {
        let mut people = worlds();
        people.extend([5.0, 6.0, 0.5].map(|value| person(Group::Real, "P01", value)));
        for (person, hand) in people.iter_mut().rev().zip(["c", "b", "a"]) {
            person.hand = hand.to_owned();
        }
        people.push(person(Group::Real, "P02", 7.0));
        let realism = compare(&people).expect("countable");
        let outside: Vec<&str> = realism.statistics[0].outside.keys().map(String::as_str).collect();
        assert_eq!(outside, ["P02", "a/P01", "b/P01"]);
        assert_eq!((realism.values_inside, realism.values), (1, 4));
    }

    #[test]
    fn eleven_people_may_have_two_outside() {
        // P(X > 1) = 0.10 and P(X > 2) = 0.015 for 11 draws at 5 %.
        assert_eq!(by_chance(11), 2);
    }
}
