//! At which port of the model something is missing.

use super::words::{list, port, sentence};
use crate::distinct::distinct;
use crate::figure::palette::{BLUE, GREY, Key, SHADE, solid};
use crate::figure::{Axis, Drawn, Panel, PortShade, WIDTH, draw, schematic};
use crate::html::{Column, Html};
use crate::number::{ABSENT, percent};
use contract::Diagnosis;
use contract::diagnosis::{CoursePart, PortEvidence, Standing, Verdict};

/// Most places that are listed as inseparable; of more the number is said.
const LISTED: usize = 3;
/// Ports whose course is drawn.
const DRAWN: usize = 3;

pub(super) fn body(html: &mut Html, diagnosis: &Diagnosis) {
    let framed = framed(diagnosis);
    let shades = shades(diagnosis, &framed);
    if shades.is_empty() {
        html.absent("No place in the model was assessed.");
        return;
    }
    let (frame, bold) = match diagnosis.verdict {
        Verdict::Effect => (
            Some("Frame: an effect that is named enters here"),
            "; bold: an effect that is named enters here",
        ),
        Verdict::Unknown => (
            Some("Frame: the most probable place, and any that cannot be separated from it"),
            "; bold: the most probable place and any that cannot be separated from it",
        ),
        Verdict::None => (None, ""),
    };
    html.figure(
        Some(schematic(&shades, frame)),
        "The model in a sketch. Insulin comes from the left, meals from the right; both meet in \
         blood glucose, which the sensor reads. The deeper the colour of a place, the more probable \
         it is that something is missing there. The table says the same in numbers.",
    );
    let mut ports: Vec<&PortEvidence> = diagnosis.ports.iter().collect();
    ports.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    let is_framed = |p: &PortEvidence| framed.contains(&p.port.as_str());
    let like = |p: &PortEvidence| match p.confusable_with.len() {
        0 => ABSENT.to_owned(),
        1..=LISTED => list(p.confusable_with.iter().map(|key| port(key))),
        more => format!("{more} other places"),
    };
    html.marked_rows(
        &format!("Evidence that something is missing, by place in the model{bold}"),
        &ports,
        |p| is_framed(p),
        &[
            ("Place", Column::Text, &|p| Html::from(sentence(&port(&p.port)))),
            ("Probability among the places", Column::Text, &|p| Html::bar(p.probability)),
            ("Cannot be separated from", Column::Text, &|p| Html::from(like(p))),
        ],
    );
    // What is missing through the day at the ports that the verdict names.
    let own = ports.into_iter().filter(|p| is_framed(p) && !p.course.is_empty());
    own.take(DRAWN).for_each(|evidence| course(html, evidence));
}

/// The course of what is missing at a port.
fn course(html: &mut Html, evidence: &PortEvidence) {
    let place = match evidence.port.as_str() {
        "insulin_absorption" => "the time that insulin takes to be absorbed".to_owned(),
        "gut_absorption" => "the time that meals take to be absorbed".to_owned(),
        key => port(key),
    };
    let axis = match evidence.unit.as_str() {
        "factor" => "Change of a factor of 1",
        unit => unit,
    };
    let certain = evidence.course.iter().filter(|part| part.is_certain());
    let certain: Vec<String> =
        certain.map(|part| format!("{} h", part.hours.replace('-', "\u{2013}"))).collect();
    let says = match certain.as_slice() {
        [] => "Every interval holds 0: no part of the day stands out.".to_owned(),
        parts => format!("The interval leaves 0 out at {}.", list(parts)),
    };
    html.figure(
        through_the_day(
            &evidence.course,
            &format!("What is lacking in {place} through the day"),
            axis,
        ),
        &format!(
            "What the data ask for in {place}, beyond the mean of the day, which calibration takes; \
             at other places nothing is assumed to change. {says}"
        ),
    );
}

/// Draws a course, or `None` where no part of it has a time of day.
fn through_the_day(parts: &[CoursePart], label: &str, axis: &str) -> Option<Drawn> {
    let placed = parts.iter().filter_map(|part| {
        let (from, to) = part.ends()?;
        Some((f64::from(from), f64::from(to), part))
    });
    let placed: Vec<(f64, f64, &CoursePart)> = placed.collect();
    if placed.is_empty() {
        return None;
    }
    let ends = parts.iter().flat_map(|part| [part.lower, part.upper, 0.0]);
    let (x, y) = (Axis::clock(0.0, 24.0), Axis::over(ends, 5));
    let panel = Panel::new((130, WIDTH - 50), (60, 360), x, y);
    let keys = vec![
        Key::line("Estimate", solid(BLUE, 6)),
        Key::area("95 % interval, all parts of the day together", SHADE, 1.0),
    ];
    Some(draw(label, 470, keys, |canvas| {
        for (from, to, part) in &placed {
            let corners = (panel.at(*from, part.upper), panel.at(*to, part.lower));
            canvas.rectangle(corners.0, corners.1, SHADE, 1.0);
        }
        panel.frame(canvas, "Time of day", axis);
        canvas.path([panel.at(0.0, 0.0), panel.at(24.0, 0.0)], solid(GREY, 3));
        for (from, to, part) in &placed {
            canvas.path([panel.at(*from, part.value), panel.at(*to, part.value)], solid(BLUE, 6));
        }
    }))
}

/// Ports that the verdict names.
fn framed(diagnosis: &Diagnosis) -> Vec<&str> {
    match diagnosis.verdict {
        Verdict::Effect => diagnosis.effects.iter().map(|e| e.port.as_str()).collect(),
        Verdict::Unknown => best(diagnosis)
            .into_iter()
            .flat_map(|best| best.confusable_with.iter().chain([&best.port]))
            .map(String::as_str)
            .collect(),
        Verdict::None => Vec::new(),
    }
}

/// One shade per port: its strongest evidence, or that an effect was found where none was assessed.
fn shades<'a>(diagnosis: &'a Diagnosis, framed: &[&'a str]) -> Vec<PortShade<'a>> {
    // `found` where one of the effects is, else `suspected`.
    let named = |port: &str| {
        let here = || diagnosis.effects.iter().filter(|effect| effect.port == port);
        let found = here().any(|effect| effect.standing() == Standing::Found);
        here().next().map(|_| if found { "found" } else { "suspected" })
    };
    let assessed = diagnosis.ports.iter().map(|p| p.port.as_str());
    distinct(assessed.chain(framed.iter().copied()))
        .into_iter()
        .map(|name| {
            let of_name = diagnosis.ports.iter().filter(|p| p.port == name);
            let strongest = of_name.max_by(|a, b| a.probability.total_cmp(&b.probability));
            let probability = strongest.map(|p| p.probability);
            let says = match (named(name), probability) {
                (Some(word), Some(probability)) => format!("{word}; {}", percent(probability)),
                (Some(word), None) => word.to_owned(),
                (None, probability) => percent(probability),
            };
            PortShade { port: name, probability, says, framed: framed.contains(&name) }
        })
        .collect()
}

/// The most probable place in words, with those that cannot be separated from it.
pub(super) fn most_probable(diagnosis: &Diagnosis) -> Option<String> {
    let best = best(diagnosis)?;
    let mut places = vec![port(&best.port)];
    places.extend(best.confusable_with.iter().filter(|p| **p != best.port).map(|p| port(p)));
    let apart = if places.len() > 1 { " (the data cannot separate them)" } else { "" };
    Some(format!("Most probably it concerns {}{apart}", places.join(" or ")))
}

/// The port with the strongest evidence.
fn best(diagnosis: &Diagnosis) -> Option<&PortEvidence> {
    diagnosis.ports.iter().max_by(|a, b| a.probability.total_cmp(&b.probability))
}
