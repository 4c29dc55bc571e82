//! The list of effects that are tried.

use effects::{Effect, EffectId, ShownBy, Structure};

/// The effects that are tried.
#[derive(Debug, Clone)]
pub(super) struct Tried<'a> {
    pub(super) effects: Vec<&'a dyn Effect>,
}

impl<'a> Tried<'a> {
    pub(super) fn of(library: &'a [Box<dyn Effect>]) -> Self {
        Self { effects: library.iter().map(AsRef::as_ref).collect() }
    }

    /// The identities of all of them.
    pub(super) fn ids(&self) -> Vec<EffectId> {
        self.effects.iter().map(|effect| effect.card().id).collect()
    }

    /// One of them.
    pub(super) fn get(&self, id: EffectId) -> &'a dyn Effect {
        let found = self.effects.iter().find(|effect| effect.card().id == id);
        *found.expect("identities come from the list")
    }

    /// The effect that the likelihoods of sensor lags show.
    pub(super) fn lag(&self) -> Option<&'a dyn Effect> {
        let shown = |effect: &&&dyn Effect| effect.card().relations.shown_by == ShownBy::SensorLag;
        self.effects.iter().find(shown).copied()
    }

    /// Whether an effect belongs to the background of all others: every body sheds glucose when it is high and defends
    /// itself when it is low, and plants differ in how.
    pub(super) fn is_guard(&self, id: EffectId) -> bool {
        self.get(id).card().relations.structure == Structure::Guard
    }
}
