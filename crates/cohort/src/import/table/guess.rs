//! A proposal of what the columns of a table hold, for the user to judge.

use std::path::PathBuf;

use super::layout::Opened;
use super::options::{Role, pairs};
use super::stamp::{DateOrder, Stamp};
use super::unit::{glucose_unit_in, glucose_unit_of};
use crate::error::{CohortError, shorten};
use crate::near_name::plain;
use crate::range::median;
use crate::text_table::TextTable;

/// Rows that are looked at.
const LOOKED_AT: usize = 2000;
/// Share of cells that must be of a kind.
const MOST: f64 = 0.8;

/// Words in the names of columns, without marks and in lower case, by role; the first role that
/// fits a column gets it. Languages: English, Spanish, German, French, Italian.
const WORDS: [(Role, &str); 11] = [
    (
        Role::Person,
        "person patient subject participant ptid deidentid userid paciente código codigo proband",
    ),
    (Role::LongActing, "longacting lantus lenta langwirk"),
    (Role::SetChange, "setchange sitechange cambiodecat katheterwechsel"),
    (Role::Glucose, "glucose glucosa glukose glycemie glycémie glicemia cgm sgv egv zucker"),
    (Role::Basal, "basal"),
    (Role::Bolus, "bolus bolo rapidacting insulinvalue insulin insulina"),
    (Role::Carbs, "carb cho kohlenhydrat hidrato glucid glucide"),
    (Role::HeartRate, "heartrate hr bpm pulse frecuenciacard herzfrequenz puls"),
    (Role::Steps, "steps stepcount pasos schritte"),
    (Role::Sleep, "sleepefficiency"),
    (Role::Time, "time date fecha hora zeit datum heure stamp _ts"),
];
/// Words in the names of columns that look like glucose and are none.
const NOT_GLUCOSE: [&str; 9] =
    ["rate", "scan", "strip", "target", "calib", "meter", "ketone", "capil", "trend"];

/// A proposal.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TableGuess {
    /// What each file is and what its columns seem to hold, for a person to read.
    pub lines: Vec<String>,
    /// The map, as `--map` takes it.
    pub map: String,
    /// Units that differ from the record's, as `--unit` takes them; empty if there are none.
    pub units: String,
    /// Roles that every record needs and no column seems to have.
    pub missing: Vec<Role>,
}

/// Proposes a map of tables by the names and the first cells of their columns; `sheet` is that of
/// workbooks.
///
/// # Errors
/// If a file cannot be read as a table.
pub fn guess_table(sources: &[PathBuf], sheet: Option<&str>) -> Result<TableGuess, CohortError> {
    let files = super::tables(sources, "table")?;
    let (mut guess, mut map) = (TableGuess::default(), Vec::new());
    let mut found: Vec<(Role, String, String)> = Vec::new();
    for (path, name) in &files {
        let opened = Opened::read(path, name, &[], sheet)?;
        let table = &opened.table;
        guess.lines.push(format!("{name}: {}, {} rows", opened.form, table.height()));
        let columns = columns(table);
        for (role, at) in &columns {
            let column = &table.header()[*at];
            let sample = samples(table, *at).next().unwrap_or("");
            let mut says = format!("  {:12} '{}'", role.name(), shorten(column, 60));
            if !sample.is_empty() {
                says.push_str(&format!(", like '{}'", shorten(sample, 40)));
            }
            if *role == Role::Glucose && unit(table, *at) == "mmol/L" {
                says.push_str(", mmol/L");
                guess.units = "glucose=mmol/L".into();
            }
            guess.lines.push(says);
            found.push((*role, name.clone(), column.clone()));
        }
        let rest: Vec<&str> = (0..table.header().len())
            .filter(|at| !columns.iter().any(|(_, taken)| taken == at))
            .map(|at| table.header()[at].as_str())
            .filter(|name| !name.is_empty())
            .collect();
        if !rest.is_empty() {
            guess.lines.push(format!("  not mapped   {}", shorten(&rest.join(", "), 200)));
        }
    }
    for role in Role::ALL {
        let mut names: Vec<(&str, &str)> = Vec::new();
        for (_, file, column) in found.iter().filter(|(of, ..)| *of == role) {
            if !names.iter().any(|(_, known)| known == column) {
                names.push((file, column));
            }
        }
        let mut mapped = false;
        for (file, column) in &names {
            // A name that stands for something else in another file needs its file.
            let elsewhere = |(of, other, name): &(Role, String, String)| {
                *of != role && name == column && other != file
            };
            let prefix = found.iter().any(elsewhere).then(|| format!("{file}:"));
            let meant = format!("{}{column}", prefix.unwrap_or_default());
            let pair = format!("{}={meant}", role.name());
            // The name of a column may look like another role and its column.
            if !pairs(&pair, "--map").is_ok_and(|read| read == [(role, meant)]) {
                let name = shorten(column, 60);
                let says = format!("  '{name}' cannot stand behind --map: rename the column");
                guess.lines.push(says);
                continue;
            }
            map.push(pair);
            mapped = true;
        }
        if !mapped && matches!(role, Role::Time | Role::Glucose) {
            guess.missing.push(role);
        }
    }
    guess.map = map.join(",");
    Ok(guess)
}

fn samples(table: &TextTable, at: usize) -> impl Iterator<Item = &str> {
    (0..table.height().min(LOOKED_AT)).filter_map(move |i| table.cell(i, at))
}

/// Whether most cells of a column pass; `false` without any.
fn most(table: &TextTable, at: usize, passes: impl Fn(&str) -> bool) -> bool {
    let (mut all, mut good) = (0, 0);
    for text in samples(table, at) {
        all += 1;
        good += usize::from(passes(text));
    }
    all > 0 && good as f64 >= MOST * f64::from(all)
}

/// Whether a column repeats few texts, as one that names people does.
fn few(table: &TextTable, at: usize) -> bool {
    let texts: std::collections::HashSet<&str> = samples(table, at).collect();
    !texts.is_empty() && 20 * texts.len() <= table.height().clamp(20, LOOKED_AT)
}

fn is_number(text: &str) -> bool {
    text.replace(',', ".").parse::<f64>().is_ok_and(f64::is_finite)
        || ["low", "high", "lo", "hi"].contains(&text.to_lowercase().as_str())
}

fn is_time(text: &str) -> bool {
    let stamp = |order| Stamp::parse(text, order).is_some_and(|stamp| stamp.timed);
    stamp(DateOrder::DayFirst) || stamp(DateOrder::MonthFirst)
}

/// The column of each role, as far as names and cells tell.
fn columns(table: &TextTable) -> Vec<(Role, usize)> {
    let names: Vec<String> = table.header().iter().map(|name| plain(name)).collect();
    let mut columns: Vec<(Role, usize)> = Vec::new();
    for (role, words) in WORDS {
        let free = |at: &usize| !columns.iter().any(|(_, taken)| taken == at);
        let fits = |at: &usize| match role {
            Role::Person => few(table, *at),
            Role::Time => most(table, *at, is_time),
            _ => {
                most(table, *at, is_number)
                    && !most(table, *at, |text| text.len() >= 9 && is_time(text))
            }
        };
        let named = |at: &usize| {
            let name = &names[*at];
            let not = role == Role::Glucose && NOT_GLUCOSE.iter().any(|word| name.contains(word));
            !not && words.split(' ').any(|word| match word.len() {
                0..=3 => name == word || name.starts_with(word) && word != "hr",
                _ => name.contains(word),
            })
        };
        // A column without a name cannot be mapped by one.
        let candidates =
            || (0..names.len()).filter(free).filter(|at| !table.header()[*at].is_empty());
        let mut found = candidates().find(|at| named(at) && fits(at));
        if role == Role::Time {
            found = found.or_else(|| candidates().find(fits));
        }
        if let Some(at) = found {
            columns.push((role, at));
        }
    }
    columns.sort_by_key(|(role, _)| *role);
    columns
}

fn unit(table: &TextTable, at: usize) -> &'static str {
    if let Some(unit) = glucose_unit_in(&table.header()[at]) {
        return unit;
    }
    let values = samples(table, at).filter_map(|text| text.replace(',', ".").parse::<f64>().ok());
    median(values.collect()).map_or("mg/dL", glucose_unit_of)
}
