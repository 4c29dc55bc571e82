//! Anybody's tables: one CSV or Excel sheet, one per person, or one per channel, as the user maps
//! them.
//!
//! Encoding, separator, decimal mark, order of dates and units are found out where the file shows
//! them, refused where it leaves them open, and told in the report. [`dexcom`](super::dexcom) and
//! [`libre`](super::libre) are plans for this reader.

use std::collections::{BTreeMap, HashSet};
use std::path::PathBuf;

use super::files::files;
use super::report::{DAYS_OF_READINGS, assemble};
use crate::error::{CohortError, shorten};

pub(super) mod clock;
mod grid;
mod guess;
mod layout;
mod log;
mod numbers;
mod options;
pub(super) mod plan;
mod rows;
mod stamp;
mod unit;

pub use guess::{TableGuess, guess_table};
pub use options::{Only, Role, TableOptions};
pub use stamp::DateOrder;

use clock::Clock;
use layout::Opened;
use log::Log;
use plan::Plan;
use rows::File;
use unit::Unit;

/// Endings of tables in a folder.
const ENDINGS: [&str; 6] = [".csv", ".tsv", ".txt", ".dat", ".xlsx", ".xlsm"];

/// Reads tables as the options map them.
pub(super) fn import(
    sources: &[PathBuf],
    options: &TableOptions,
) -> Result<super::Import, CohortError> {
    if options.columns.is_empty() {
        let reason = "say which column is what, like --map time=Date,glucose=Value; --guess \
                      proposes a map";
        return Err(CohortError::option("--map", reason));
    }
    read(sources, &Plan { format: "table", options: options.clone(), ..Plan::default() })
}

/// The files of the sources, folders opened, with their names for messages.
fn tables(
    sources: &[PathBuf],
    format: &'static str,
) -> Result<Vec<(PathBuf, String)>, CohortError> {
    let mut found = Vec::new();
    for source in sources {
        found.extend(files(source, format, "*.csv, *.tsv, *.txt or *.xlsx", |name| {
            let name = name.to_lowercase();
            ENDINGS.iter().any(|ending| name.ends_with(ending))
        })?);
    }
    for i in 0..found.len() {
        if found[..i].iter().any(|(_, name)| *name == found[i].1) {
            // Two folders may hold the same name; then the whole path tells them apart.
            found[i].1 = found[i].0.display().to_string();
        }
    }
    Ok(found)
}

/// The logs of one file, its stem, whether it holds glucose, and which columns of the plan.
struct Read {
    name: String,
    has_glucose: bool,
    present: Vec<bool>,
    columns: String,
    logs: BTreeMap<String, Log>,
}

/// Reads tables by a plan.
pub(super) fn read(sources: &[PathBuf], plan: &Plan) -> Result<super::Import, CohortError> {
    let clock = Clock::new(plan.options.zone.as_deref(), plan.options.utc)?;
    plan.options.check_decimal("--decimal")?;
    let basal_unit = Unit::of(Role::Basal, &plan.options)?;
    let files = tables(sources, plan.format)?;
    let names: Vec<String> = files.iter().map(|(_, name)| name.clone()).collect();
    let mut read: Vec<Option<Read>> = Vec::with_capacity(files.len());
    let mut orders = Vec::new();
    // Rows that stand in several files are those of one export after the other.
    let mut seen = HashSet::new();
    for file in &files {
        let (result, order) = one(file, plan, clock, &names, None, &mut seen)?;
        orders.extend(order);
        read.push(result);
    }
    // What one file leaves open the others of the same make decide, if they agree.
    let agreed = orders.first().filter(|first| orders.iter().all(|order| order == *first)).copied();
    for (file, read) in files.iter().zip(&mut read) {
        if read.is_none() {
            *read = one(file, plan, clock, &names, agreed, &mut seen)?.0;
        }
    }
    let read: Vec<Read> = read.into_iter().flatten().collect();
    every_role_is_there(plan, &read, &names)?;
    let logs = people(plan, read)?;
    let imported = logs.into_values().map(|log| grid::person(log, basal_unit));
    assemble(plan.format, names.join(", "), DAYS_OF_READINGS, imported)
}

/// Reads one file, with its order of dates where it shows one; nothing where the order stays open
/// and `agreed` is not known either.
fn one(
    (path, name): &(PathBuf, String),
    plan: &Plan,
    clock: Clock,
    names: &[String],
    agreed: Option<DateOrder>,
    seen: &mut HashSet<u64>,
) -> Result<(Option<Read>, Option<DateOrder>), CohortError> {
    let opened = Opened::read(path, name, &plan.wanted(names), plan.options.sheet.as_deref())?;
    let file = File::new(&opened, plan, names)?;
    let (order, shown) = match (plan.options.dates, file.order()?) {
        (Some(told), Some((order, shown))) if order != told && !shown.is_empty() => {
            let option = format!("--dates {}", told.name());
            let reason = format!("{name} shows the other order: {shown}");
            return Err(CohortError::option(option, reason));
        }
        (Some(told), _) => (told, String::new()),
        (None, Some(found)) => found,
        (None, None) => match agreed {
            Some(order) => (order, "the other files".to_owned()),
            None if names.len() == 1 => return Err(file.open_order()),
            None => return Ok((None, None)),
        },
    };
    let found = (!shown.is_empty()).then_some(order);
    let mut logs = BTreeMap::new();
    file.read(plan, clock, (order, &shown), seen, &mut logs)?;
    let has_glucose = file.roles().any(|role| role == Role::Glucose);
    let present = file.found.iter().map(Option::is_some).collect();
    let columns = shorten(&opened.table.header().join(", "), 160);
    Ok((Some(Read { name: name.clone(), has_glucose, present, columns, logs }), found))
}

/// Refuses a map of which a column is in none of the files.
fn every_role_is_there(plan: &Plan, read: &[Read], files: &[String]) -> Result<(), CohortError> {
    if read.len() < files.len() {
        let reason = "no file shows whether dates have the day or the month first: say day-first \
                      or month-first";
        return Err(CohortError::option("--dates", reason));
    }
    let absent = |column: &str, found: &str| CohortError::MissingColumn {
        file: files.join(", "),
        column: column.into(),
        found: found.into(),
    };
    if !read.iter().any(|file| file.has_glucose) {
        let column = plan.names(Role::Glucose).unwrap_or_else(|| Role::Glucose.name().into());
        return Err(absent(&column, "no column for glucose, which every record needs"));
    }
    let in_none = |at: &usize| !read.iter().any(|file| file.present[*at]);
    if plan.is_users()
        && let Some(at) = (0..plan.options.columns.len()).find(in_none)
    {
        let found = read.iter().map(|file| file.columns.as_str()).collect::<Vec<_>>().join("; ");
        return Err(absent(&plan.options.columns[at].1, &found));
    }
    Ok(())
}

/// The logs of people: by a column, or one file a person, or all files of one person.
fn people(plan: &Plan, read: Vec<Read>) -> Result<BTreeMap<String, Log>, CohortError> {
    let with_glucose = read.iter().filter(|file| file.has_glucose).count();
    let of_one = !plan.has(Role::Person) && with_glucose == 1;
    if !plan.has(Role::Person) && with_glucose > 1 && with_glucose < read.len() {
        let without = read.iter().find(|file| !file.has_glucose);
        let reason = format!(
            "{with_glucose} files have glucose and '{}' has none, so whose it is stays open; \
             map a column as person, or import each person alone",
            without.map_or("", |file| file.name.as_str())
        );
        return Err(CohortError::option("--map", reason));
    }
    let owner = read.iter().find(|file| file.has_glucose).and_then(|file| file.logs.keys().next());
    let owner = owner.cloned();
    let mut people: BTreeMap<String, Log> = BTreeMap::new();
    // The owner's file comes first, so that it is the one that messages name.
    let (first, rest): (Vec<Read>, Vec<Read>) = read.into_iter().partition(|file| file.has_glucose);
    for file in first.into_iter().chain(rest) {
        for (id, log) in file.logs {
            let id = if of_one { owner.clone().unwrap_or(id) } else { id };
            let known = people.entry(id.clone()).or_insert_with(|| {
                let written = log.written.clone();
                Log { written, ..Log::new(&id, &log.account.file) }
            });
            if !of_one && known.written != log.written {
                return Err(one_name_for_two(plan, known, &log));
            }
            known.take(log);
        }
    }
    Ok(people)
}

/// The error of two people whose names differ in nothing that an identifier may have.
fn one_name_for_two(plan: &Plan, known: &Log, other: &Log) -> CohortError {
    let reason = format!(
        "'{}' and '{}' of {} would both be called {}; use letters and digits that differ",
        shorten(&other.written, 40),
        shorten(&known.written, 40),
        known.account.file,
        known.account.id
    );
    CohortError::layout(&other.account.file, plan.format, reason)
}
