//! `realism`: every statistic that the diagnosis reads, in made worlds and in real people.

use std::path::PathBuf;

use anyhow::{Context as _, Result};
use blind::realism;
use cohort::{Cohort, Person};
use contract::Document as _;
use contract::blind_check::{Group, People, PersonStatistics, Realism};
use gap::{DiagnosisConfig, person_statistics};
use world::blind::{Plan, PlannedWorld};

use crate::bounds::within;
use crate::people::read_cohort;
use crate::stages::evaluate::cohort_name;
use crate::{Manifest, OutputFolder, Progress, note};

/// Settings of `realism`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Cohorts of real people.
    pub cohort: Vec<PathBuf>,
    /// Worlds in which something is missing.
    pub worlds: usize,
    /// Worlds in which nothing is missing.
    pub nulls: usize,
    /// People in each world.
    pub people: usize,
    /// Days of each person; of longer records those with the most readings.
    pub days: usize,
    /// Output folder.
    pub out: PathBuf,
    /// Seed of the worlds.
    pub seed: u64,
}

/// Most worlds of one table.
const MOST_WORLDS: usize = 10_000;
/// Most people of a world.
const MOST_PEOPLE: usize = 1000;
/// Fewest and most days of a person.
const FEWEST_DAYS: usize = 4;
const MOST_DAYS: usize = 366;

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    within("--worlds", args.worlds, 1, MOST_WORLDS)?;
    within("--nulls", args.nulls, 1, MOST_WORLDS)?;
    within("--days", args.days, FEWEST_DAYS, MOST_DAYS)?;
    within("--people", args.people, 1, MOST_PEOPLE)?;
    let settings = serde_json::json!({
        "worlds": args.worlds,
        "nulls": args.nulls,
        "people": args.people,
        "days": args.days,
    });
    let manifest = Manifest::new("realism", settings, Some(args.seed)).with_inputs(&args.cohort)?;
    let mut people = Vec::new();
    let names: Vec<String> = args.cohort.iter().map(|folder| cohort_name(folder)).collect();
    for (place, (folder, name)) in args.cohort.iter().zip(&names).enumerate() {
        let is_twice = names.iter().filter(|other| *other == name).count() > 1;
        let study = if is_twice { format!("{name} {}", place + 1) } else { name.clone() };
        let read = read_cohort(folder)?.people.into_iter();
        people.extend(read.map(|person| (study.clone(), person)));
    }
    let output = OutputFolder::begin(&args.out, manifest)?;
    let (library, config) = (effects::library(), DiagnosisConfig::working());
    // The statistics of a person, as the diagnosis would read them, and why she is not diagnosed if that is so.
    let statistics = |group: Group, hand: &str, person: &Person| {
        let person = person.best_days(args.days);
        let found = person_statistics(&person, &library, &config)?;
        let (hand, person_id) = (hand.to_owned(), person.id);
        let statistics = PersonStatistics { group, hand, person_id, values: found.values };
        anyhow::Ok((statistics, found.excluded))
    };

    let mut found = Vec::new();
    for (study, person) in &people {
        let (statistics, excluded) = statistics(Group::Real, study, person)?;
        if let Some(reason) = excluded {
            note(format!("realism: {}: the record alone, {reason}", person.id));
        }
        found.push(statistics);
    }
    let mut planned = Plan::check(args.worlds, args.nulls).worlds(args.seed);
    for planned in &mut planned {
        (planned.people, planned.days) = (args.people, args.days);
    }
    let of_world = |planned: &PlannedWorld| -> Result<Vec<PersonStatistics>> {
        let group = if planned.effects.is_empty() { Group::Null } else { Group::Effect };
        let Cohort { people } = planned.realise()?.cohort();
        let hand = planned.generator.name();
        people.iter().map(|person| Ok(statistics(group, hand, person)?.0)).collect()
    };
    let progress = Progress::begin("worlds", planned.len());
    let made = progress.each(planned.len(), |index| {
        of_world(&planned[index]).with_context(|| format!("world {}", index + 1))
    })?;
    progress.finish(&format!("{} worlds read", made.len()));
    found.extend(made.into_iter().flatten());

    let realism = realism::compare(&found)?;
    let table = realism::table(&realism);
    output.write_document(&realism)?;
    output.write_document(&People(found))?;
    let place = output.finish_with_table("realism.txt", &table)?;
    note(format!(
        "realism: in {} of {} statistics no more real people lie outside the central 95 % of both kinds of worlds \
         than by chance, in {} nobody does; {} of {} values lie inside; {}",
        realism.inside,
        realism.statistics.len(),
        realism.all_inside,
        realism.values_inside,
        realism.values,
        place.join(Realism::FILE).display()
    ));
    Ok(())
}
