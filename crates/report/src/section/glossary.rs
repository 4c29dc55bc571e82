//! What the short words of the page stand for.

use crate::html::Html;

/// Word, what it stands for, what it is.
const WORDS: [(&str, &str); 19] = [
    ("TIR", "Time in range: share of readings from 70 to 180 mg/dL, %."),
    ("TBR", "Time below range: share of readings below 70 mg/dL, %."),
    ("TAR", "Time above range: share of readings above 180 mg/dL, %."),
    ("LBGI", "Low blood glucose index: the risk of low glucose, weighted by how low; 0 is none."),
    (
        "HBGI",
        "High blood glucose index: the risk of high glucose, weighted by how high; 0 is none.",
    ),
    ("MG", "Mean glucose, mg/dL."),
    (
        "CV",
        "Coefficient of variation of glucose: SD over mean, %. Above 36 % glucose counts as unstable.",
    ),
    ("GMI", "Glucose management indicator: the HbA1c that goes with the mean glucose, %."),
    ("CGM", "Continuous glucose monitoring: the readings of the sensor."),
    (
        "AGP",
        "Ambulatory glucose profile: the median of glucose by time of day, with the middle half and the \
         middle nine tenths of all days.",
    ),
    (
        "TOST",
        "Two one-sided tests: they show that a difference is smaller than a margin that was set before. \
         Not equivalent means not shown, and not that they differ.",
    ),
    ("RMSE", "Root mean squared error: the size of an error, in which large errors weigh most."),
    (
        "F1",
        "One number for the names of a blind check: 2 / (1 / precision + 1 / recall). Precision is the \
         share of the names given that are right, recall the share of the effects that are named; 1 is \
         best.",
    ),
    (
        "ODE",
        "Ordinary differential equations: the physiological model, as opposed to the networks.",
    ),
    (
        "nats",
        "Unit of evidence: x nats say that readings that were held out are e to the power of x times as \
         probable with the effect as without it.",
    ),
    ("Held-out days", "Days that no fit has seen."),
    (
        "Free run",
        "A prediction from one moment on that sees no later reading, only doses, meals and activity.",
    ),
    (
        "Published size",
        "The size that the literature gives for an effect; sizes on this page are multiples of it.",
    ),
    ("Gap", "What a person's glucose does and the model does not: measured minus predicted."),
];

pub(super) fn body(html: &mut Html) {
    html.literal("<dl>\n");
    for (word, meaning) in WORDS {
        html.literal("<div>").element("dt", word).element("dd", meaning).literal("</div>\n");
    }
    html.literal("</dl>\n");
}
