//! Training loss and validation error by epoch, each on an axis of its own: they have other units.

use contract::Training;
use contract::training::Epoch;

use super::Drawn;
use super::canvas::{WIDTH, draw};
use super::palette::{GREY, Key, MEASURED, Stroke, TWIN, dashed};
use super::panel::{Axis, Panel};
use crate::ReportError;
use crate::number::significant;

/// Height of a panel, canvas units.
const HEIGHT: i32 = 280;
/// From the top of one panel to the top of the next, canvas units.
const NEXT: i32 = 360;
/// The epoch that is kept.
const KEPT: Stroke = dashed(GREY, 4, 10, 8);

/// The loss of an epoch, how its line looks, and the title of its axis.
type Course = (fn(&Epoch) -> f64, Stroke, String);

/// Draws both on logarithmic axes, or `None` without an epoch.
pub(crate) fn training(training: &Training) -> Result<Option<Drawn>, ReportError> {
    let epochs = &training.epochs;
    if epochs.is_empty() {
        return Ok(None);
    }
    let log = |loss: f64| (loss > 0.0).then(|| loss.log10());
    let of: [Course; 2] = [
        (|epoch| epoch.train_loss, MEASURED, "Training loss (scaled units)".to_owned()),
        (|epoch| epoch.validation_loss, TWIN, "Validation error (mg/dL)".to_owned()),
    ];
    let svg = draw("Training and validation loss by epoch", 60 + 2 * NEXT + 40, |canvas| {
        for (index, (loss, stroke, title)) in of.iter().enumerate() {
            let top = 60 + NEXT * index as i32;
            let x = Axis::over(epochs.iter().map(|e| e.epoch as f64), 6);
            let y = Axis::decades(epochs.iter().map(loss));
            let panel = Panel::new((130, WIDTH - 30), (top, top + HEIGHT), x, y);
            panel.frame(canvas, if index == 0 { "" } else { "Epoch" }, title)?;
            let kept = training.kept_epoch as f64;
            let ends = [(kept, Some(panel.y.range.0)), (kept, Some(panel.y.range.1))];
            if (panel.x.range.0..=panel.x.range.1).contains(&kept) {
                panel.line(canvas, ends, KEPT)?;
            }
            let points = epochs.iter().map(|epoch| (epoch.epoch as f64, log(loss(epoch))));
            panel.line(canvas, points, *stroke)?;
            let half = (panel.right - panel.left) / (2 * epochs.len() as i32).max(2);
            for epoch in epochs {
                let (x, _) = panel.at(epoch.epoch as f64, panel.y.range.0);
                let words = format!("Epoch {}: {}", epoch.epoch, significant(Some(loss(epoch))));
                canvas.hover((x - half, panel.top), (x + half, panel.bottom), &words);
            }
        }
        Ok(())
    })?;
    let keys = vec![
        Key::line("Training", MEASURED),
        Key::line("Validation", TWIN),
        Key::line("Epoch that is kept", KEPT),
    ];
    Ok(Some((svg, keys)))
}
