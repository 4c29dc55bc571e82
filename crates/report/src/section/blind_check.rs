//! The blind check: what was promised, what was found, and every world.

mod confusion;
mod power;
mod reliability;
mod scores;
mod targets;
mod worlds;

pub(super) use confusion::body as confusion;
use contract::BlindCheck;
pub(super) use power::body as power;
pub(super) use reliability::body as reliability;
pub(super) use scores::body as scores;
pub(super) use targets::body as targets;
pub(super) use worlds::body as worlds;

use crate::Inputs;
use crate::html::Html;

/// The check, or a paragraph that says that there is none.
fn check(inputs: &Inputs) -> Result<&BlindCheck, Html> {
    inputs.blind_check.as_ref().ok_or_else(|| {
        let mut html = Html::default();
        html.absent("There is no blind check in this folder.");
        html
    })
}
