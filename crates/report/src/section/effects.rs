//! Which unmodelled effect explains the gap: a card for each effect that was found.

use super::verdict::PROBABILITY;
use super::words::{effect, list, plain, port, sentence};
use crate::ReportError;
use crate::figure::{ForestFrame, ForestRow, forest};
use crate::html::Html;
use crate::number::{fixed, interval, significant};
use contract::diagnosis::{FoundEffect, PersonAmplitude, Standing, Verdict};
use contract::{Diagnosis, WithInterval};

/// People in one figure.
const SHOWN: usize = 40;

pub(super) fn body(diagnosis: &Diagnosis) -> Result<Html, ReportError> {
    let mut html = Html::default();
    match diagnosis.verdict {
        Verdict::Effect if !diagnosis.effects.is_empty() => {
            html.paragraph(
                "Effects stand in the order in which they were named; the size of each is judged with \
                 those above it already in the model. An effect is found where its probability is \
                 above 50\u{a0}%, the interval of its size lies above 0, the held-out data of two \
                 people favour it (of one, where there is one), and nothing questions it. Otherwise it \
                 is suspected.",
            );
        }
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
        Verdict::None => {
            html.paragraph("No effect is named.");
        }
    }
    for (index, found) in diagnosis.effects.iter().enumerate() {
        html.push(&card(index, found, diagnosis)?);
    }
    Ok(html)
}

/// One effect.
fn card(index: usize, found: &FoundEffect, diagnosis: &Diagnosis) -> Result<Html, ReportError> {
    let mut html = Html::default();
    html.literal("<article class=\"card\">\n");
    html.element("h3", &format!("{}. {}", index + 1, sentence(&effect(&found.effect))));
    html.literal("<dl>\n");
    entry(&mut html, "Name in files", Html::of_text(&found.effect));
    entry(&mut html, "Enters at", Html::of_text(&port(&found.port)));
    let standing = match found.standing() {
        Standing::Found => "found".to_owned(),
        Standing::Suspected => {
            let why = super::verdict::why_suspected(found).unwrap_or_default();
            format!("suspected, not found: {why}")
        }
    };
    entry(&mut html, "Answer", Html::of_text(&standing));
    let probability = sentence(PROBABILITY);
    entry(&mut html, &probability, Html::bar(found.probability));
    entry(&mut html, "Evidence", Html::of_text(&gain_in_words(found.gain_nats)));
    let size = format!("{} times the published size", interval(found.amplitude, 2));
    entry(&mut html, "Size", Html::of_text(&size));
    let like: Vec<String> = found.confusable_with.iter().map(|key| effect(key)).collect();
    let like = if like.is_empty() {
        "nothing else in the library".to_owned()
    } else {
        format!("{}; the answer is this set, not the one name", list(&like))
    };
    entry(&mut html, "Cannot be separated from", Html::of_text(&like));
    if !found.people.is_empty() {
        entry(&mut html, "In single people", Html::of_text(&agreement(&found.people)));
    }
    if !found.questioned.is_empty() {
        entry(&mut html, "Doubts", Html::of_text(&found.questioned.join(" ")));
    }
    html.literal("</dl>\n");
    amplitudes(&mut html, found)?;
    if index + 1 == diagnosis.effects.len() {
        html.paragraph_of(
            "note",
            "A gain of x nats says that readings which were held out are e to the power of x times \
             as probable with the effect as without it. The words are those of Kass and Raftery \
             (1995): above 1 positive, above 3 strong, above 5 very strong.",
        );
    }
    html.literal("</article>\n");
    Ok(html)
}

fn entry(html: &mut Html, name: &str, value: Html) {
    html.literal("<div>").element("dt", name);
    html.literal("<dd>").push(&value).literal("</dd></div>\n");
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
    let shows = |p: &&PersonAmplitude| p.lower > 0.0;
    let favours = |p: &&PersonAmplitude| p.gain_nats > 0.0;
    let (shown, favoured) =
        (people.iter().filter(shows).count(), people.iter().filter(favours).count());
    format!(
        "the interval lies above zero in {shown} of {of}; the data of {favoured} of {of} favour it"
    )
}

/// Amplitude over all and by person, against the published size.
fn amplitudes(html: &mut Html, found: &FoundEffect) -> Result<(), ReportError> {
    let row = |label: &str, value: WithInterval| ForestRow {
        label: label.to_owned(),
        value,
        stands_out: value.lower > 0.0,
    };
    let everyone = row("everyone", found.amplitude);
    let mut people: Vec<(f64, ForestRow)> = found
        .people
        .iter()
        .map(|p| {
            let value = WithInterval { value: p.amplitude, lower: p.lower, upper: p.upper };
            (p.gain_nats, row(&p.person_id, value))
        })
        .collect();
    let all = people.len();
    if all > SHOWN {
        people.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
        people.truncate(SHOWN);
    }
    people.sort_by(|a, b| b.1.value.value.total_cmp(&a.1.value.value));
    let rows: Vec<ForestRow> =
        std::iter::once(everyone).chain(people.into_iter().map(|(_, row)| row)).collect();
    let name = format!("Size of the effect: {}", plain(&found.effect));
    let frame = ForestFrame {
        label: &name,
        axis: "Size (1 = published)",
        unit: "times the published size",
        references: &[(0.0, "No effect"), (1.0, "Published size")],
        keys: ["Interval above zero", "Interval reaches zero"],
    };
    let shown = if all > SHOWN {
        format!(" Shown are the {SHOWN} of {all} people whose data say most.")
    } else {
        String::new()
    };
    let caption = if all == 0 {
        "Size of the effect with its interval, against no effect (0) and the published size (1)."
    } else {
        "Size of the effect with intervals, for everyone together and in single people, against \
         no effect (0) and the published size (1). Marks on one side of zero say that people \
         agree."
    };
    html.figure(forest(&frame, &rows)?, &format!("{caption}{shown}"));
    Ok(())
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
