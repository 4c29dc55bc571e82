//! At which port of the model something is missing.

use super::words::{list, port, sentence};
use crate::ReportError;
use crate::distinct::distinct;
use crate::figure::{PortShade, port_course, schematic};
use crate::html::{Column, Html};
use crate::number::{ABSENT, percent};
use contract::Diagnosis;
use contract::diagnosis::{PortEvidence, Standing, Verdict};

/// Most places that are listed as inseparable; of more the number is said.
const LISTED: usize = 3;

pub(super) fn body(diagnosis: &Diagnosis) -> Result<Html, ReportError> {
    let mut html = Html::default();
    let framed = framed(diagnosis);
    let shades = shades(diagnosis, &framed);
    if shades.is_empty() {
        html.absent("No place in the model was assessed.");
        return Ok(html);
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
        Some(schematic(&shades, frame)?),
        "The model in a sketch. Insulin comes from the left, meals from the right; both meet in \
         blood glucose, which the sensor reads. The deeper the colour of a place, the more probable \
         it is that something is missing there. The table says the same in numbers.",
    );
    let mut ports: Vec<&PortEvidence> = diagnosis.ports.iter().collect();
    ports.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    let rows: Vec<(bool, Vec<Html>)> = ports
        .into_iter()
        .map(|p| {
            let like: Vec<String> = p.confusable_with.iter().map(|key| port(key)).collect();
            let like = match like.len() {
                0 => ABSENT.to_owned(),
                1..=LISTED => list(&like),
                more => format!("{more} other places"),
            };
            let place = Html::of_text(&sentence(&port(&p.port)));
            let cells = vec![place, Html::bar(p.probability), Html::of_text(&like)];
            (framed.contains(&p.port.as_str()), cells)
        })
        .collect();
    let columns = [
        ("Place", Column::Text),
        ("Probability among the places", Column::Text),
        ("Cannot be separated from", Column::Text),
    ];
    if !rows.is_empty() {
        html.table_of(
            &format!("Evidence that something is missing, by place in the model{bold}"),
            &columns,
            &rows,
        );
    }
    courses(&mut html, diagnosis, &framed)?;
    Ok(html)
}

/// Ports whose course is drawn.
const DRAWN: usize = 3;

/// What is missing through the day at the ports that the verdict names.
fn courses(html: &mut Html, diagnosis: &Diagnosis, framed: &[&str]) -> Result<(), ReportError> {
    let mut own: Vec<&PortEvidence> =
        diagnosis.ports.iter().filter(|p| framed.contains(&p.port.as_str())).collect();
    own.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    for evidence in own.into_iter().filter(|p| !p.course.is_empty()).take(DRAWN) {
        let place = course_of(&evidence.port);
        let axis = match evidence.unit.as_str() {
            "factor" => "Change of a factor of 1".to_owned(),
            unit => unit.to_owned(),
        };
        let label = format!("What is lacking in {place} through the day");
        let certain: Vec<String> = evidence
            .course
            .iter()
            .filter(|part| part.is_certain())
            .map(|part| format!("{} h", part.hours.replace('-', "\u{2013}")))
            .collect();
        let says = if certain.is_empty() {
            "Every interval holds 0: no part of the day stands out.".to_owned()
        } else {
            format!("The interval leaves 0 out at {}.", list(&certain))
        };
        html.figure(
            port_course(&evidence.course, &label, &axis)?,
            &format!(
                "What the data ask for in {place}, beyond the mean of the day, which calibration takes; \
                 at other places nothing is assumed to change. {says}"
            ),
        );
    }
    Ok(())
}

/// The quantity of a course at a port.
fn course_of(key: &str) -> String {
    match key {
        "insulin_absorption" => "the time that insulin takes to be absorbed".to_owned(),
        "gut_absorption" => "the time that meals take to be absorbed".to_owned(),
        _ => port(key),
    }
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
                (None, Some(probability)) => percent(probability),
                (None, None) => ABSENT.to_owned(),
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
