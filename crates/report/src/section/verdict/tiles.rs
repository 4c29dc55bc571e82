//! The four tiles of a diagnosis (where, which, how far, how sure), and who is in it.

use std::collections::BTreeMap;

use super::how_far::change;
use super::place::{direction, expected, worst};
use super::sentence::why_suspected;
use crate::Inputs;
use crate::html::Html;
use crate::number::{count, fixed, interval, p_value, percent};
use crate::section::words::{ahead, effect, list, model, number, reason, sentence, situation};
use contract::Diagnosis;
use contract::diagnosis::{FoundEffect, Standing, Verdict};

/// Most people whose reason is told here; the others stand under the data checks.
const NAMED: usize = 6;

/// Most effects whose names are the short answer; of more it is their number.
const LISTED: usize = 2;

/// A question, its short answer, and what the answer is, in paragraphs.
type Tile = (&'static str, String, Vec<String>);

/// The tiles, and the people under them.
pub(super) fn tiles(html: &mut Html, diagnosis: &Diagnosis, inputs: &Inputs) {
    let (far, far_detail) = change(diagnosis).map_or_else(
        || {
            (
                "Nothing was added".to_owned(),
                "No effect is named, so that no error was compared".to_owned(),
            )
        },
        |change| (change.answer, change.detail),
    );
    let tiles: [Tile; 4] =
        [place(diagnosis), which(diagnosis), ("How far", far, vec![far_detail]), sure(diagnosis)];
    html.literal("<dl class=\"tiles\">\n");
    for (question, answer, details) in tiles {
        html.literal("<div class=\"tile\">").element("dt", question);
        html.literal("<dd class=\"answer\">").text(&answer).literal("</dd>");
        for detail in details {
            html.element("dd", &detail);
        }
        html.literal("</div>\n");
    }
    let (people, model) = (people(diagnosis, inputs), model(&diagnosis.plant));
    html.literal("</dl>\n");
    html.paragraph_of("people", &format!("{people} Compared with the sensor: {model}."));
}

fn place(diagnosis: &Diagnosis) -> Tile {
    let Some(cell) = worst(diagnosis) else {
        let detail = match expected(diagnosis) {
            Some(cell) if diagnosis.verdict != Verdict::None => format!(
                "No situation differs from zero. The largest part of what is missing is expected {} ({} of it)",
                situation(cell.factor.name(), &cell.level),
                percent(cell.share_of_gap)
            ),
            _ => "No hour, situation or glucose band differs from zero".to_owned(),
        };
        return ("Where", "Nowhere for certain".to_owned(), vec![detail]);
    };
    // The step-down p can be small while the single-step interval still includes zero, so the limits
    // keep their signs, in the direction of the error.
    let (lower, upper) = match direction(cell) {
        "under" => (cell.lower, cell.upper),
        _ => (-cell.upper, -cell.lower),
    };
    let detail = format!(
        "Glucose is {}-predicted by {} mg/dL, {} ahead (simultaneous interval {} to {}, adjusted p {})",
        direction(cell),
        fixed(cell.mean_error_mg_dl.abs(), 0),
        ahead(cell.horizon_minutes),
        fixed(lower, 0),
        fixed(upper, 0),
        p_value(cell.p_adjusted)
    );
    ("Where", sentence(&situation(cell.factor.name(), &cell.level)), vec![detail])
}

fn which(diagnosis: &Diagnosis) -> Tile {
    let named = &diagnosis.effects;
    let (answer, detail) = match diagnosis.verdict {
        Verdict::None => {
            ("No effect".to_owned(), vec!["None of those that were tried stands out".to_owned()])
        }
        Verdict::Unknown => {
            let place = crate::section::ports::most_probable(diagnosis);
            let place = place
                .unwrap_or_else(|| "No effect of the library explains it well enough".to_owned());
            ("Something without a name".to_owned(), vec![place])
        }
        Verdict::Effect if named.len() > LISTED => {
            (how_many(named), named.iter().map(size).collect())
        }
        Verdict::Effect => {
            let answers = named.iter().map(|found| match found.standing() {
                Standing::Found => effect(&found.effect),
                Standing::Suspected => format!("{} (suspected)", effect(&found.effect)),
            });
            (sentence(&list(answers)), named.iter().map(size).collect())
        }
    };
    ("Which", answer, detail)
}

/// The number of effects, and of those that are only suspected.
fn how_many(named: &[FoundEffect]) -> String {
    let suspected = named.iter().filter(|found| found.standing() == Standing::Suspected).count();
    let effects = format!("{} effects", number(named.len()));
    match suspected {
        0 => effects,
        n => format!("{effects} ({} suspected)", number(n).to_lowercase()),
    }
}

/// Size of an effect and who shows it.
fn size(found: &FoundEffect) -> String {
    let people = match found.people.len() {
        0 => String::new(),
        1 => " in this one person".to_owned(),
        of => format!("; the data of {} of {of} people favour it", found.in_favour()),
    };
    let why = why_suspected(found).map_or_else(String::new, |why| format!("; {why}"));
    let size = interval(found.amplitude, 2);
    format!("{}: {size} times the published size{people}{why}", sentence(&effect(&found.effect)))
}

fn sure(diagnosis: &Diagnosis) -> Tile {
    let something = diagnosis.posterior.something;
    let (answer, mut detail) = match diagnosis.verdict {
        Verdict::Effect => {
            let each = diagnosis.effects.iter().map(|found| found.probability);
            let least = each.reduce(f64::min);
            let of_several = if diagnosis.effects.len() > 1 { "; the least of them" } else { "" };
            (
                least.map_or_else(|| "Not stated".to_owned(), percent),
                format!("{}{of_several}", sentence(PROBABILITY)),
            )
        }
        Verdict::Unknown => {
            (percent(something), "Probability that something is missing".to_owned())
        }
        Verdict::None => {
            (percent(1.0 - something), "Probability that nothing is missing".to_owned())
        }
    };
    let doubts: usize = diagnosis.effects.iter().map(|found| found.questioned.len()).sum();
    match doubts {
        0 => {}
        1 => detail.push_str(". One doubt stands below"),
        n => detail.push_str(&format!(". {} doubts stand below", number(n))),
    }
    ("How sure", answer, vec![detail])
}

/// What the probability of an effect is; also the name of its column.
pub(crate) const PROBABILITY: &str = "probability that it acts, with others or alone";

/// People and days in use, and who was left out: by the checks of the data or by the diagnosis.
fn people(diagnosis: &Diagnosis, inputs: &Inputs) -> String {
    let checked = inputs.data_in_use.iter().flat_map(|data| &data.people);
    let by_checks = checked.map(|p| (&*p.person_id, p.left_out.as_deref()));
    let by_diagnosis = diagnosis.people.iter().map(|p| (&*p.person_id, p.excluded.as_deref()));
    let mut all: BTreeMap<&str, Option<&str>> = BTreeMap::new();
    for (person, reason) in by_checks.chain(by_diagnosis) {
        let known = all.entry(person).or_default();
        *known = known.or(reason);
    }
    let used = |person: &str| all.get(person).is_some_and(Option::is_none);
    let days = match &inputs.data_in_use {
        Some(data) => {
            let people = || data.people.iter().filter(|person| used(&person.person_id));
            let recorded = people().map(|person| person.days).sum();
            let left_out: usize = people().map(|person| person.days_left_out.len()).sum();
            let days = count(recorded, "day", "days");
            format!("{} of their {days}", recorded.saturating_sub(left_out))
        }
        None => {
            let people = diagnosis.people.iter().filter(|person| used(&person.person_id));
            count(people.map(|person| person.days).sum(), "day", "days")
        }
    };
    let left_out: Vec<(&str, &str)> =
        all.iter().filter_map(|(person, reason)| Some((*person, (*reason)?))).collect();
    let in_use = all.len() - left_out.len();
    let mut text = format!("{in_use} of {} in use, {days}. ", count(all.len(), "person", "people"));
    if left_out.is_empty() {
        text.push_str("Nobody was left out.");
        return text;
    }
    let named: Vec<String> = left_out
        .iter()
        .take(NAMED)
        .map(|(person, why)| format!("{person} ({})", reason(why)))
        .collect();
    text.push_str(&format!("Left out: {}", named.join("; ")));
    if left_out.len() > NAMED {
        text.push_str(&format!("; {} more, under the data checks", left_out.len() - NAMED));
    }
    text.push('.');
    text
}
