//! The gap through the day, crossed with situations and people: what the report's maps show.
//!
//! Situations and people are families of their own beside those of `where`, so that a finer look takes no power from
//! the verdict.

use crate::context::{PARTS, Situation, hours_of_part, part_of_day};
use crate::free_run::minutes;
use crate::localisation::{CellEstimate, DayCells, LocalisationRule, of_each_person, over_people};
use contract::diagnosis::{CellFactor, CellGap, HourlyCell, HourlyGap, HourlyRow};

/// Rows: every run, then the situations.
const ROWS: usize = 1 + Situation::ALL.len();

/// A day without errors.
pub(crate) fn empty_day() -> DayCells {
    DayCells::empty(ROWS * PARTS)
}

/// Counts an error at an hour of the day (0 to 23): among all, or in a situation.
pub(crate) fn count(day: &mut DayCells, hour: usize, situation: Option<Situation>, error: f64) {
    let row = situation.map_or(0, |situation| 1 + situation as usize);
    day.add(row * PARTS + part_of_day(hour), error);
}

/// The gap by part of the day; `names` are those of the people whose days these are.
///
/// All runs are those of `gaps`, the cells of `where`, so that a part of the day has one interval. Two families beside them:
/// situations over people, and the people themselves.
pub(crate) fn hourly_gap(
    gaps: &[CellGap],
    names: &[&str],
    days: &[Vec<DayCells>],
    rule: &LocalisationRule,
    seed: u64,
) -> HourlyGap {
    let crossed = over_people(days, rule, rule.error_rate, seed);
    let situations = Situation::ALL
        .iter()
        .zip(crossed.chunks(PARTS).skip(1))
        .map(|(situation, cells)| row(situation.name(), cells.iter().copied()));
    let situations = std::iter::once(all_runs(gaps))
        .chain(situations)
        .filter(|row| row.cells.iter().any(Option::is_some))
        .collect();
    // The parts of the day share the error rate of the people equally.
    let of_part = |part: usize| {
        let seed = seed.wrapping_add(1 + part as u64);
        of_each_person(days, part, rule, rule.error_rate / PARTS as f64, seed)
    };
    let by_part: Vec<_> = (0..PARTS).map(of_part).collect();
    let person = |(index, name): (usize, &&str)| row(name, by_part.iter().map(|all| all[index]));
    HourlyGap {
        horizon_minutes: minutes(rule.horizon),
        parts: (0..PARTS).map(hours_of_part).collect(),
        situations,
        people: names.iter().enumerate().map(person).collect(),
    }
}

/// The row of all runs, from the cells of `where`.
fn all_runs(gaps: &[CellGap]) -> HourlyRow {
    let of_part = |part: usize| {
        let level = hours_of_part(part);
        let gap = gaps.iter().find(|gap| gap.factor == CellFactor::Hour && gap.level == level)?;
        Some(HourlyCell {
            mean_error_mg_dl: gap.mean_error_mg_dl,
            lower: gap.lower,
            upper: gap.upper,
            people: gap.people,
            runs: gap.runs,
        })
    };
    HourlyRow { name: "all".to_owned(), cells: (0..PARTS).map(of_part).collect() }
}

fn row(name: &str, cells: impl Iterator<Item = Option<CellEstimate>>) -> HourlyRow {
    let cell = |estimate: CellEstimate| HourlyCell {
        mean_error_mg_dl: estimate.mean,
        lower: estimate.lower,
        upper: estimate.upper,
        people: estimate.people,
        runs: estimate.errors,
    };
    HourlyRow { name: name.to_owned(), cells: cells.map(|c| c.map(cell)).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twelve days with two runs an hour, which miss by `error(hour)` and up to 1 mg/dL more or less.
    fn days(error: impl Fn(usize) -> f64) -> Vec<DayCells> {
        (0..12_usize)
            .map(|date| {
                let mut day = empty_day();
                for hour in 0..24 {
                    for half in 0..2 {
                        let wobble = ((7 * date + 5 * hour + 3 * half) % 11) as f64 / 5.0 - 1.0;
                        count(&mut day, hour, None, error(hour) + wobble);
                        if (12..15).contains(&hour) {
                            let situation = Some(Situation::AfterMeal);
                            count(&mut day, hour, situation, error(hour) + wobble);
                        }
                    }
                }
                day
            })
            .collect()
    }

    #[test]
    fn a_miss_in_the_morning_stands_in_its_part_with_its_sign() {
        let early = |hour: usize| if (3..6).contains(&hour) { 20.0 } else { 0.0 };
        let (own, other) = (days(early), days(|hour| 0.5 * early(hour)));
        let morning = CellGap {
            factor: CellFactor::Hour,
            level: "03-06".to_owned(),
            mean_error_mg_dl: 15.0,
            lower: 9.0,
            upper: 21.0,
            p_adjusted: 0.01,
            share_of_gap: 0.5,
            expected_mg_dl: None,
            horizon_minutes: 60,
            people: 2,
            runs: 144,
            innovation: None,
        };
        let rule = LocalisationRule::working();
        let found = hourly_gap(&[morning], &["a", "b"], &[own, other], &rule, 1);
        assert_eq!(found.parts.first().map(String::as_str), Some("00-03"));
        assert_eq!(found.parts.last().map(String::as_str), Some("21-24"));
        assert_eq!(found.horizon_minutes, 60);
        let names = |rows: &[HourlyRow]| -> Vec<String> {
            rows.iter().map(|row| row.name.clone()).collect()
        };
        // Situations that nobody was in have no row.
        assert_eq!(names(&found.situations), ["all", "after_meal"]);
        assert_eq!(names(&found.people), ["a", "b"]);
        for (row, size) in [(&found.people[0], 20.0), (&found.people[1], 10.0)] {
            for (part, cell) in row.cells.iter().enumerate() {
                let cell = cell.expect("72 runs on 12 days");
                let expected = if part == 1 { size } else { 0.0 };
                // The wobble of 72 runs averages out to less than 0.1.
                assert!((cell.mean_error_mg_dl - expected).abs() < 0.1, "{part} {cell:?}");
                assert_eq!((cell.people, cell.runs), (1, 72));
                assert_eq!(cell.is_certain(), part == 1, "{part} {cell:?}");
            }
        }
        // All runs are the cells of `where`, interval and all.
        let all = found.situations[0].cells[1].expect("a cell of `where`");
        assert_eq!((all.lower, all.upper, all.people, all.runs), (9.0, 21.0, 2, 144));
        assert!(found.situations[0].cells[2].is_none());
        let meal: Vec<bool> = found.situations[1].cells.iter().map(Option::is_some).collect();
        assert_eq!(meal, [false, false, false, false, true, false, false, false]);
    }
}
