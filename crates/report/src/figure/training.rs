//! Loss by epoch.

use super::Drawn;
use super::canvas::{WIDTH, draw};
use super::palette::{Key, MEASURED, TWIN};
use super::panel::{Axis, Panel};
use crate::ReportError;
use contract::Training;
use contract::training::Epoch;

/// Draws training and validation loss on a logarithmic axis, or `None` without an epoch.
pub(crate) fn training(training: &Training) -> Result<Option<Drawn>, ReportError> {
    let epochs = &training.epochs;
    if epochs.is_empty() {
        return Ok(None);
    }
    let log = |loss: f64| (loss > 0.0).then(|| loss.log10());
    let losses = epochs.iter().flat_map(|e| [e.train_loss, e.validation_loss]);
    let panel = Panel {
        left: 130,
        right: WIDTH - 30,
        top: 60,
        bottom: 440,
        x: Axis::over(epochs.iter().map(|e| e.epoch as f64), 6),
        y: Axis::decades(losses),
    };
    let svg = draw("Training and validation loss by epoch", 550, |canvas| {
        panel.frame(canvas, "Epoch", "Loss (scaled units, logarithmic)")?;
        let points = |loss: fn(&Epoch) -> f64| -> Vec<(f64, Option<f64>)> {
            epochs.iter().map(|epoch| (epoch.epoch as f64, log(loss(epoch)))).collect()
        };
        panel.line(canvas, points(|epoch| epoch.train_loss), MEASURED)?;
        panel.line(canvas, points(|epoch| epoch.validation_loss), TWIN)
    })?;
    Ok(Some((svg, vec![Key::line("Training", MEASURED), Key::line("Validation", TWIN)])))
}
