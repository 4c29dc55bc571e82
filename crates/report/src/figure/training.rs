//! Loss by epoch.

use super::Drawn;
use super::canvas::{WIDTH, draw};
use super::palette::{Key, MEASURED, TWIN};
use super::panel::{Axis, Panel};
use crate::ReportError;
use crate::view::Training;

/// Draws training and validation loss on a logarithmic axis, or `None` without an epoch.
pub(crate) fn training(training: &Training) -> Result<Option<Drawn>, ReportError> {
    let epochs = &training.epochs;
    if epochs.is_empty() {
        return Ok(None);
    }
    let log = |loss: f64| (loss > 0.0).then(|| loss.log10());
    let losses = epochs.iter().flat_map(|e| [Some(e.train_loss), e.validation_loss]).flatten();
    let panel = Panel {
        left: 130,
        right: WIDTH - 30,
        top: 60,
        bottom: 440,
        x: Axis::over(epochs.iter().map(|e| f64::from(e.epoch)), 6),
        y: Axis::decades(losses),
    };
    let svg = draw("Training and validation loss by epoch", 550, |canvas| {
        panel.frame(canvas, "Epoch", "Loss (scaled units, logarithmic)")?;
        let points = |loss: &dyn Fn(usize) -> Option<f64>| -> Vec<(f64, Option<f64>)> {
            (0..epochs.len()).map(|k| (f64::from(epochs[k].epoch), loss(k).and_then(log))).collect()
        };
        panel.line(canvas, points(&|k| Some(epochs[k].train_loss)), MEASURED)?;
        panel.line(canvas, points(&|k| epochs[k].validation_loss), TWIN)
    })?;
    let mut keys = vec![Key::line("Training", MEASURED)];
    if epochs.iter().any(|e| e.validation_loss.is_some()) {
        keys.push(Key::line("Validation", TWIN));
    }
    Ok(Some((svg, keys)))
}
