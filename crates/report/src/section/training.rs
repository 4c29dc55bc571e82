//! Training of the population network: training loss and validation error by epoch, each on an axis of
//! its own, since they have other units.

use contract::Training;
use contract::training::Epoch;

use crate::figure::palette::{GREY, Key, MEASURED, Stroke, TWIN, dashed};
use crate::figure::{Axis, Drawn, Panel, WIDTH, draw};
use crate::html::Html;
use crate::number::{count, fixed, significant};

/// Height of a panel, canvas units.
const HEIGHT: i32 = 280;
/// From the top of one panel to the top of the next, canvas units.
const NEXT: i32 = 360;
/// The epoch that is kept.
const KEPT: Stroke = dashed(GREY, 4, 10, 8);

/// The loss of an epoch, how its line looks, and the titles of its axes.
type Course = (fn(&Epoch) -> f64, Stroke, &'static str, &'static str);

pub(super) fn body(html: &mut Html, training: &Training) {
    html.paragraph(&format!(
        "Model {}, seed {}, {}, {} for training and {} for validation, {} s.",
        training.model,
        training.seed,
        count(training.epochs.len(), "epoch", "epochs"),
        count(training.data.windows_train, "window", "windows"),
        training.data.windows_validation,
        fixed(training.seconds, 1),
    ));
    html.folded("Hash of the data", |html| {
        html.literal("<p>").element("code", &training.data.hash).literal("</p>\n");
    });
    let caption = format!(
        "Loss by epoch. The two have different units and axes of their own: compare their \
         courses, not their heights. Validation is: {}. Where it rises while training falls, \
         the network overfits; the upright line is the epoch whose weights are kept.",
        training.validation_loss_is
    );
    if !html.figure(figure(&training.epochs, training.kept_epoch as f64), &caption) {
        html.absent("The training record holds no epoch.");
    }
}

/// Draws both on logarithmic axes, or `None` without an epoch.
fn figure(epochs: &[Epoch], kept: f64) -> Option<Drawn> {
    if epochs.is_empty() {
        return None;
    }
    let courses: [Course; 2] = [
        (|epoch| epoch.train_loss, MEASURED, "", "Training loss (scaled units)"),
        (|epoch| epoch.validation_loss, TWIN, "Epoch", "Validation error (mg/dL)"),
    ];
    let keys = vec![
        Key::line("Training", MEASURED),
        Key::line("Validation", TWIN),
        Key::line("Epoch that is kept", KEPT),
    ];
    Some(draw("Training and validation loss by epoch", 60 + 2 * NEXT + 40, keys, |canvas| {
        for (index, (loss, stroke, x_title, y_title)) in courses.into_iter().enumerate() {
            let top = 60 + NEXT * index as i32;
            let x = Axis::over(epochs.iter().map(|e| e.epoch as f64), 6);
            let y = Axis::decades(epochs.iter().map(loss));
            let panel = Panel::new((130, WIDTH - 30), (top, top + HEIGHT), x, y);
            panel.frame(canvas, x_title, y_title);
            if (panel.x.range.0..=panel.x.range.1).contains(&kept) {
                let (x, _) = panel.at(kept, panel.y.range.0);
                canvas.path([(x, panel.bottom), (x, panel.top)], KEPT);
            }
            let log = |loss: f64| (loss > 0.0).then(|| loss.log10());
            let points = epochs.iter().map(|epoch| (epoch.epoch as f64, log(loss(epoch))));
            panel.line(canvas, points, stroke);
            let half = (panel.right - panel.left) / (2 * epochs.len() as i32).max(2);
            for epoch in epochs {
                let (x, _) = panel.at(epoch.epoch as f64, panel.y.range.0);
                let words = format!("Epoch {}: {}", epoch.epoch, significant(loss(epoch)));
                canvas.hover((x - half, panel.top), (x + half, panel.bottom), &words);
            }
        }
    }))
}
