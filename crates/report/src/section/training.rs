//! Training of the population network.

use crate::html::Html;
use crate::number::{count, fixed};
use crate::{ReportError, figure};
use contract::Training;

pub(super) fn body(training: &Training) -> Result<Html, ReportError> {
    let mut html = Html::default();
    html.paragraph(&format!(
        "Model {}, seed {}, {}, {} for training and {} for validation, {} s.",
        training.model,
        training.seed,
        count(training.epochs.len(), "epoch", "epochs"),
        count(training.data.windows_train, "window", "windows"),
        training.data.windows_validation,
        fixed(training.seconds, 1),
    ));
    let mut hash = Html::default();
    hash.literal("<p>").element("code", &training.data.hash).literal("</p>\n");
    html.folded("Hash of the data", &hash);
    let caption = format!(
        "Loss by epoch. The two have different units and axes of their own: compare their \
         courses, not their heights. Validation is: {}. Where it rises while training falls, \
         the network overfits; the upright line is the epoch whose weights are kept.",
        training.validation_loss_is
    );
    if !html.figure(figure::training(training)?, &caption) {
        html.absent("The training record holds no epoch.");
    }
    Ok(html)
}
