//! `realism`: every statistic that the diagnosis reads, in made worlds and in real people.

use anyhow::{Context as _, Result, ensure};
use blind::realism;
use cohort::{Cohort, Person};
use contract::blind_check::{Group, PersonStatistics};
use effects::Effect;
use gap::{DiagnosisConfig, person_statistics};
use physiology::STEPS_PER_DAY;
use rayon::prelude::*;
use world::blind::{Plan, PlannedWorld};

use crate::cli::RealismArgs;
use crate::manifest::Manifest;
use crate::output::OutputFolder;
use crate::progress::{Progress, note};
use crate::stages::twin::read_cohort;

/// Most worlds of one table.
const MOST_WORLDS: usize = 10_000;
/// Fewest and most days of a person.
const DAYS: std::ops::RangeInclusive<usize> = 4..=366;

/// Runs the command.
pub(crate) fn run(args: &RealismArgs) -> Result<()> {
    for (name, value) in [("--worlds", args.worlds), ("--nulls", args.nulls)] {
        ensure!(
            (1..=MOST_WORLDS).contains(&value),
            "{name} {value} must be from 1 to {MOST_WORLDS}"
        );
    }
    ensure!(
        DAYS.contains(&args.days),
        "--days {} must be from {} to {}",
        args.days,
        DAYS.start(),
        DAYS.end()
    );
    ensure!(args.people >= 1, "--people must be at least 1");
    let settings = serde_json::json!({
        "worlds": args.worlds,
        "nulls": args.nulls,
        "people": args.people,
        "days": args.days,
    });
    let mut manifest = Manifest::new("realism", settings, Some(args.seed));
    let mut people = Vec::new();
    for folder in &args.cohort {
        manifest = manifest.with_input(folder)?;
        let study = folder.file_name().map_or_else(String::new, |n| n.to_string_lossy().into());
        people
            .extend(read_cohort(folder)?.people.into_iter().map(|person| (study.clone(), person)));
    }
    let output = OutputFolder::begin(&args.out, manifest)?;
    let (library, config) = (effects::library(), DiagnosisConfig::working());
    let read = Reader { effects: &library, config: &config, days: args.days };

    let mut found = Vec::new();
    for (study, person) in &people {
        let (statistics, excluded) = read.statistics(Group::Real, study, person)?;
        if let Some(reason) = excluded {
            note(format!("realism: {}: the record alone, {reason}", person.id));
        }
        found.push(statistics);
    }
    let planned = Plan::check(args.worlds, args.nulls).worlds(args.seed);
    let progress = Progress::begin("worlds", planned.len());
    let made = planned
        .into_par_iter()
        .enumerate()
        .map(|(index, planned)| {
            let planned = PlannedWorld { people: args.people, days: args.days, ..planned };
            let found = of_world(&read, &planned).with_context(|| format!("world {}", index + 1));
            progress.advance("");
            found
        })
        .collect::<Result<Vec<_>>>()?;
    progress.finish(&format!("{} worlds read", made.len()));
    found.extend(made.into_iter().flatten());

    let realism = realism::compare(&found)?;
    let table = realism::table(&realism);
    output.write_json("realism.json", &realism)?;
    output.write_json("people.json", &found)?;
    output.write("realism.txt", table.as_bytes())?;
    let place = output.finish()?;
    for line in table.lines() {
        note(line);
    }
    note(format!(
        "realism: in {} of {} statistics no more real people lie outside the central 95 % of both kinds of worlds \
         than by chance, in {} nobody does; {} of {} values lie inside; {}",
        realism.inside,
        realism.statistics.len(),
        realism.all_inside,
        realism.values_inside,
        realism.values,
        place.join("realism.json").display()
    ));
    Ok(())
}

/// Reads people as the diagnosis would.
struct Reader<'a> {
    effects: &'a [Box<dyn Effect>],
    config: &'a DiagnosisConfig,
    days: usize,
}

impl Reader<'_> {
    /// The statistics of a person, and why she is not diagnosed if that is so.
    fn statistics(
        &self,
        group: Group,
        hand: &str,
        person: &Person,
    ) -> Result<(PersonStatistics, Option<String>)> {
        let person = best_days(person, self.days);
        let found = person_statistics(&person, self.effects, self.config)?;
        let statistics = PersonStatistics {
            group,
            hand: hand.to_owned(),
            person_id: person.id,
            values: found.values,
        };
        Ok((statistics, found.excluded))
    }
}

fn of_world(read: &Reader<'_>, planned: &PlannedWorld) -> Result<Vec<PersonStatistics>> {
    let group = if planned.effects.is_empty() { Group::Null } else { Group::Effect };
    let Cohort { people } = planned.realise()?.cohort()?;
    let hand = planned.generator.name();
    people.iter().map(|person| Ok(read.statistics(group, hand, person)?.0)).collect()
}

/// The whole days in a row, at most so many, that hold the most readings; of equal ones the first.
///
/// Evidence grows with the days: people are compared over as many.
fn best_days(person: &Person, days: usize) -> Person {
    let cgm = person.record.cgm();
    let length = (days * STEPS_PER_DAY).min(cgm.len());
    let readings = |first: usize| cgm[first..first + length].iter().flatten().count();
    let starts = 0..(cgm.len() - length) / STEPS_PER_DAY + 1;
    let best = starts.rev().max_by_key(|day| readings(day * STEPS_PER_DAY)).unwrap_or(0);
    let first = best * STEPS_PER_DAY;
    let record = person.record.slice(first..first + length);
    Person { record: record.unwrap_or_else(|| person.record.clone()), ..person.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cohort::{Channel, Record, Therapy};

    #[test]
    fn the_days_with_the_most_readings_are_read() {
        let start = "2024-03-04T00:00:00".parse().expect("a literal time");
        let mut record = Record::new(start, 5 * STEPS_PER_DAY).expect("on the grid");
        for step in 2 * STEPS_PER_DAY..4 * STEPS_PER_DAY {
            record.channel_mut(Channel::Cgm)[step] = Some(120.0);
        }
        let person = Person {
            id: "p".to_owned(),
            weight: None,
            therapy: Therapy::Unknown,
            heart_rate_baseline: None,
            record,
        };
        let best = best_days(&person, 2);
        assert_eq!(best.record.len(), 2 * STEPS_PER_DAY);
        assert!(best.record.cgm().iter().all(Option::is_some));
        assert_eq!(best_days(&person, 9).record, person.record);
    }
}
