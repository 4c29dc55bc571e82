//! Which unmodelled effect explains the gap: a card for each effect that was found.

use super::verdict::{PROBABILITY, why_suspected};
use super::words::{effect, list, plain, port, sentence};
use crate::figure::{ForestFrame, ForestRow, forest};
use crate::html::Html;
use crate::number::{fixed, interval, significant};
use contract::diagnosis::{FoundEffect, PersonAmplitude, Verdict};
use contract::{Diagnosis, WithInterval};

/// People in one figure.
const SHOWN: usize = 40;

pub(super) fn body(html: &mut Html, diagnosis: &Diagnosis) {
    match diagnosis.verdict {
        Verdict::Effect if !diagnosis.effects.is_empty() => html.paragraph(
            "Effects stand in the order in which they were named; the size of each is judged with \
             those above it already in the model. An effect is found where its probability is \
             above 50\u{a0}%, the interval of its size lies above 0, the held-out data of two \
             people favour it (of one, where there is one), and nothing questions it. Otherwise it \
             is suspected.",
        ),
        Verdict::Effect => {
            html.absent("The verdict says that an effect is named, but the file names none.");
        }
        Verdict::Unknown => {
            let probable = diagnosis.candidates.iter().filter(|c| c.not_named.is_some());
            let probable: Vec<String> = probable.map(|c| effect(&c.effect)).collect();
            html.paragraph(&match probable.as_slice() {
                [] => "No effect is named: something is missing, and no effect that was tried accounts for it well enough.".to_owned(),
                probable => format!(
                    "No effect is named: something is missing. Probable enough, and not named for the reason that \
                     stands under what was weighed: {}.",
                    probable.join(", ")
                ),
            });
        }
        Verdict::None => html.paragraph("No effect is named."),
    }
    for (index, found) in diagnosis.effects.iter().enumerate() {
        card(html, index, found, index + 1 == diagnosis.effects.len());
    }
}

/// One effect; the last card also says how to read all of them.
fn card(html: &mut Html, index: usize, found: &FoundEffect, is_last: bool) {
    html.literal("<article class=\"card\">\n");
    html.element("h3", &format!("{}. {}", index + 1, sentence(&effect(&found.effect))));
    html.literal("<dl>\n");
    entry(html, "Name in files", found.effect.clone());
    entry(html, "Enters at", port(&found.port));
    let why = why_suspected(found).map(|why| format!("suspected, not found: {why}"));
    entry(html, "Answer", why.unwrap_or_else(|| "found".to_owned()));
    entry(html, &sentence(PROBABILITY), Html::bar(found.probability));
    entry(html, "Evidence", gain_in_words(found.gain_nats));
    let size = interval(found.amplitude, 2);
    entry(html, "Size", format!("{size} times the published size"));
    let like = list(found.confusable_with.iter().map(|key| effect(key)));
    let like = match found.confusable_with.is_empty() {
        true => "nothing else in the library".to_owned(),
        false => format!("{like}; the answer is this set, not the one name"),
    };
    entry(html, "Cannot be separated from", like);
    if !found.people.is_empty() {
        entry(html, "In single people", agreement(&found.people));
    }
    if !found.questioned.is_empty() {
        entry(html, "Doubts", found.questioned.join(" "));
    }
    html.literal("</dl>\n");
    amplitudes(html, found);
    if is_last {
        html.paragraph_of(
            "note",
            "A gain of x nats says that readings which were held out are e to the power of x times \
             as probable with the effect as without it. The words are those of Kass and Raftery \
             (1995): above 1 positive, above 3 strong, above 5 very strong.",
        );
    }
    html.literal("</article>\n");
}

fn entry(html: &mut Html, name: &str, value: impl Into<Html>) {
    html.literal("<div>").element("dt", name);
    html.literal("<dd>").push(&value.into()).literal("</dd></div>\n");
}

/// A gain in nats with what it means.
fn gain_in_words(nats: f64) -> String {
    let words = match nats {
        ..0.0 => "evidence against it",
        ..1.0 => "not worth more than a mention",
        ..3.0 => "positive",
        ..5.0 => "strong",
        _ => "very strong",
    };
    let size = fixed(nats, 1);
    if nats < 0.0 {
        return format!("{size} nats: {words}");
    }
    let times = match nats {
        ..9.0 => format!("{} times", significant(Some(nats.exp()))),
        _ => format!("about 10 to the power of {} times", fixed(nats / std::f64::consts::LN_10, 0)),
    };
    format!("{size} nats, {words}: held-out readings are {times} as probable with it as without")
}

/// How many people show the effect by themselves.
fn agreement(people: &[PersonAmplitude]) -> String {
    let of = people.len();
    let shown = people.iter().filter(|p| p.lower > 0.0).count();
    let favoured = people.iter().filter(|p| p.gain_nats > 0.0).count();
    format!(
        "the interval lies above zero in {shown} of {of}; the data of {favoured} of {of} favour it"
    )
}

/// Amplitude over all and by person, against the published size.
fn amplitudes(html: &mut Html, found: &FoundEffect) {
    let mut people: Vec<&PersonAmplitude> = found.people.iter().collect();
    let mut caption = match people.as_slice() {
        [] => "Size of the effect with its interval, against no effect (0) and the published size (1).",
        _ => {
            "Size of the effect with intervals, for everyone together and in single people, against \
             no effect (0) and the published size (1). Marks on one side of zero say that people \
             agree."
        }
    }
    .to_owned();
    if people.len() > SHOWN {
        let all = people.len();
        caption += &format!(" Shown are the {SHOWN} of {all} people whose data say most.");
        people.sort_by(|a, b| b.gain_nats.abs().total_cmp(&a.gain_nats.abs()));
        people.truncate(SHOWN);
    }
    people.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
    let row = |label: &str, value: WithInterval| ForestRow {
        label: label.to_owned(),
        value,
        stands_out: value.lower > 0.0,
    };
    let mut rows = vec![row("everyone", found.amplitude)];
    rows.extend(people.into_iter().map(|p| {
        let (value, lower, upper) = (p.amplitude, p.lower, p.upper);
        row(&p.person_id, WithInterval { value, lower, upper })
    }));
    let frame = ForestFrame {
        label: &format!("Size of the effect: {}", plain(&found.effect)),
        axis: "Size (1 = published)",
        unit: "times the published size",
        references: &[(0.0, "No effect"), (1.0, "Published size")],
        keys: ["Interval above zero", "Interval reaches zero"],
    };
    html.figure(forest(&frame, &rows), &caption);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gains_have_words() {
        for (nats, words) in [
            (-2.0, "\u{2212}2.0 nats: evidence against it"),
            (0.5, "0.5 nats, not worth more than a mention"),
            (2.0, "2.0 nats, positive: held-out readings are 7.39 times"),
            (4.0, "4.0 nats, strong: held-out readings are 54.6 times"),
            (31.2, "31.2 nats, very strong: held-out readings are about 10 to the power of 14"),
        ] {
            assert!(gain_in_words(nats).starts_with(words), "{}", gain_in_words(nats));
        }
    }

    #[test]
    fn people_are_counted_by_their_intervals() {
        let person = |lower: f64, gain_nats: f64| PersonAmplitude {
            person_id: "p".to_owned(),
            amplitude: 1.0,
            lower,
            upper: 2.0,
            gain_nats,
        };
        let people = [person(0.2, 3.0), person(-0.1, -1.0), person(-0.5, 0.5)];
        assert_eq!(
            agreement(&people),
            "the interval lies above zero in 1 of 3; the data of 2 of 3 favour it"
        );
    }
}
