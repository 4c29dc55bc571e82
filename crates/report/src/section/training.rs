//! Training of the population network.

use crate::html::Html;
use crate::number::{count, fixed};
use crate::{Inputs, ReportError, figure};

pub(super) fn body(inputs: &Inputs) -> Result<Html, ReportError> {
    let mut html = Html::default();
    let Some(training) = &inputs.training else {
        html.absent("There is no training record in this folder.");
        return Ok(html);
    };
    html.paragraph(&format!(
        "Model {}, seed {}, {}, {} for training and {} for validation, {} s. Data hash:",
        training.model,
        training.seed,
        count(training.epochs.len(), "epoch", "epochs"),
        count(training.data.windows_train, "window", "windows"),
        training.data.windows_validation,
        fixed(training.seconds, 1),
    ));
    html.literal("<p>").element("code", &training.data.hash).literal("</p>\n");
    match figure::training(training)? {
        Some((svg, keys)) => {
            html.figure(
                &svg,
                &keys,
                "Loss by epoch. The two have different units and axes of their own: compare their courses, \
                 not their heights. Validation that rises while training falls is overfitting; the \
                 upright line is the epoch whose weights are kept.",
            );
        }
        None => {
            html.absent("The training record holds no epoch.");
        }
    }
    Ok(html)
}
