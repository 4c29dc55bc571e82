//! Worlds with an effect outside the library.

use contract::blind_check::{Kind, UnknownScore, Verdict};

use crate::error::BlindError;
use crate::scored_world::ScoredWorld;
use crate::share::among;

pub(crate) fn unknown_score(worlds: &[ScoredWorld]) -> Result<UnknownScore, BlindError> {
    let outside = || worlds.iter().filter(|w| w.label.kind == Kind::Outside);
    let recalled = || outside().filter(|w| w.answer.verdict == Verdict::Unknown);
    Ok(UnknownScore {
        recalled: among(outside(), |w| w.answer.verdict == Verdict::Unknown)?,
        right_port: among(recalled(), |w| right_port(w) == Some(true))?,
        right_port_or_in_set: among(recalled(), |w| {
            let truth = port(w);
            right_port(w) == Some(true)
                || w.answer.best_port().is_some_and(|best| {
                    best.confusable_with.iter().any(|other| Some(other.as_str()) == truth)
                })
        })?,
    })
}

fn port(world: &ScoredWorld) -> Option<&str> {
    world.label.effects.first().and_then(|effect| effect.port.as_deref())
}

/// Whether the strongest port is where the effect enters; `None` unless the effect is outside the
/// library and was called unknown.
pub(crate) fn right_port(world: &ScoredWorld) -> Option<bool> {
    let asked = world.label.kind == Kind::Outside && world.answer.verdict == Verdict::Unknown;
    asked.then(|| {
        let best = world.answer.best_port().map(|best| best.port.as_str());
        best.is_some() && best == port(world)
    })
}
