//! At which place in the model something is missing.

use super::words::{list, port, sentence};
use crate::figure::{PortShade, schematic};
use crate::html::{Column, Html};
use crate::number::{ABSENT, optional, percent};
use crate::view::{Diagnosis, PortEvidence};
use crate::{Inputs, ReportError};

pub(super) fn body(inputs: &Inputs) -> Result<Html, ReportError> {
    let mut html = Html::default();
    let Some(diagnosis) = &inputs.diagnosis else {
        html.absent("There is no diagnosis in this folder, so no place was assessed.");
        return Ok(html);
    };
    let Some(best) = best(diagnosis) else {
        html.absent("No place in the model was assessed.");
        return Ok(html);
    };
    let in_front = |p: &PortEvidence| p.port == best.port || best.confusable_with.contains(&p.port);
    let shades: Vec<PortShade<'_>> = diagnosis
        .ports
        .iter()
        .map(|p| PortShade {
            port: &p.port,
            probability: p.probability,
            says: p.probability.map_or_else(|| ABSENT.to_owned(), percent),
            framed: in_front(p),
        })
        .collect();
    let (svg, keys) = schematic(&shades)?;
    html.figure(
        &svg,
        &keys,
        "The model in a sketch. Insulin comes from the left, meals from the right; both meet in \
         blood glucose, which the sensor reads. The deeper the colour of a place, the more probable it is \
         that something is missing there. The table says the same in numbers.",
    );
    let mut ports: Vec<&PortEvidence> = diagnosis.ports.iter().collect();
    ports.sort_by(|a, b| order(b).total_cmp(&order(a)));
    let rows: Vec<(bool, Vec<Html>)> = ports
        .into_iter()
        .map(|p| {
            let like: Vec<String> = p.confusable_with.iter().map(|key| port(key)).collect();
            let like = if like.is_empty() { ABSENT.to_owned() } else { list(&like) };
            let cells = vec![
                Html::of_text(&sentence(&port(&p.port))),
                Html::of_text(&optional(p.gain_nats, 1)),
                Html::bar(p.probability),
                Html::of_text(&like),
            ];
            (in_front(p), cells)
        })
        .collect();
    html.table_of(
        "Evidence that something is missing, by place in the model; bold: the most probable place \
         and any that cannot be told from it",
        &[
            ("Place", Column::Text),
            ("Gain, nats", Column::Number),
            ("Probability", Column::Text),
            ("Cannot be told from", Column::Text),
        ],
        &rows,
    );
    Ok(html)
}

/// The place with the strongest evidence.
pub(super) fn best(diagnosis: &Diagnosis) -> Option<&PortEvidence> {
    diagnosis.ports.iter().max_by(|a, b| order(a).total_cmp(&order(b)))
}

/// Gain, or probability where there is no gain; what is absent comes last.
fn order(port: &PortEvidence) -> f64 {
    port.gain_nats.or(port.probability).unwrap_or(f64::NEG_INFINITY)
}
