//! Every effect that is tried unless the user says otherwise.

mod dawn;

use crate::effect::Effect;

/// The effects of the library, in a fixed order.
#[must_use]
pub fn library() -> Vec<Box<dyn Effect>> {
    vec![Box::new(dawn::Dawn)]
}
