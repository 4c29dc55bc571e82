//! Which unmodelled effect explains the gap.

use super::words::plain;
use crate::html::{Column, Html};
use crate::number::{fixed, interval};
use crate::view::{Diagnosis, DiagnosisVerdict};
use crate::{Inputs, ReportError};

pub(super) fn body(inputs: &Inputs) -> Result<Html, ReportError> {
    let mut html = Html::default();
    let Some(diagnosis) = &inputs.diagnosis else {
        html.absent("There is no diagnosis in this folder, so no effect was sought.");
        return Ok(html);
    };
    if diagnosis.sought_effects() {
        html.paragraph(match diagnosis.verdict {
            DiagnosisVerdict::Effect => "Verdict: a named effect was found.",
            DiagnosisVerdict::Unknown => {
                "Verdict: unknown. There is a gap, and none of the effects tried explains it."
            }
            DiagnosisVerdict::None => "Verdict: none. No effect is called for.",
        });
        found(&mut html, diagnosis);
        tried(&mut html, diagnosis);
    } else {
        html.absent(
            "Naming the effect is not part of this run: the diagnosis measured and located the gap, \
             and tried no effect.",
        );
    }
    ports(&mut html, diagnosis);
    Ok(html)
}

fn found(html: &mut Html, diagnosis: &Diagnosis) {
    if diagnosis.effects.is_empty() {
        return;
    }
    let rows: Vec<(bool, Vec<String>)> = diagnosis
        .effects
        .iter()
        .map(|effect| {
            let like: Vec<String> = effect.confusable_with.iter().map(|e| plain(e)).collect();
            let cells = vec![
                plain(&effect.effect),
                plain(&effect.port),
                fixed(effect.probability, 2),
                fixed(effect.gain_nats, 1),
                interval(effect.amplitude, 2),
                if like.is_empty() { "nothing".to_owned() } else { like.join(", ") },
            ];
            (true, cells)
        })
        .collect();
    html.table(
        "Effects found, in the order in which the data were conditioned on them",
        &[
            ("Effect", Column::Text),
            ("Enters at", Column::Text),
            ("Probability", Column::Number),
            ("Held-out gain, nats", Column::Number),
            ("Amplitude (1 = published size)", Column::Number),
            ("Cannot be told from", Column::Text),
        ],
        &rows,
    );
}

fn tried(html: &mut Html, diagnosis: &Diagnosis) {
    let mut candidates: Vec<_> = diagnosis.candidates.iter().collect();
    if candidates.is_empty() {
        return;
    }
    candidates.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    let rows: Vec<(bool, Vec<String>)> = candidates
        .into_iter()
        .map(|c| (false, vec![plain(&c.effect), fixed(c.probability, 2), fixed(c.gain_nats, 1)]))
        .collect();
    html.table(
        "Every effect that was tried",
        &[
            ("Effect", Column::Text),
            ("Probability", Column::Number),
            ("Held-out gain, nats", Column::Number),
        ],
        &rows,
    );
}

fn ports(html: &mut Html, diagnosis: &Diagnosis) {
    if diagnosis.ports.is_empty() {
        return;
    }
    let rows: Vec<(bool, Vec<String>)> = diagnosis
        .ports
        .iter()
        .map(|p| (false, vec![plain(&p.port), fixed(p.probability, 2), fixed(p.gain_nats, 1)]))
        .collect();
    html.table(
        "Evidence that something is missing, by place in the equations",
        &[
            ("Port", Column::Text),
            ("Probability", Column::Number),
            ("Held-out gain, nats", Column::Number),
        ],
        &rows,
    );
}
