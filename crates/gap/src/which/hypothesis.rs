//! What may be missing, and the list of what is tried.

use effects::{Effect, EffectId, Port, ShownBy, Structure};

pub use super::unknown::courses::{Course, Kind as CourseKind};

/// What may be missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hypothesis {
    /// An effect of the library.
    Effect(EffectId),
    /// Events of no known effect: a rival of the library that is tried, named and conditioned on like an effect.
    Events {
        /// Their kind.
        kind: EffectId,
        /// Where they enter.
        port: Port,
    },
    /// A course of no known effect at a port. Nothing can be conditioned on it.
    Course(Course),
}

impl Hypothesis {
    /// The name that its evidence and its threshold have in files.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Effect(id) | Self::Events { kind: id, .. } => id.name().to_owned(),
            Self::Course(course) => course.name(),
        }
    }

    /// The effect of the library.
    #[must_use]
    pub fn known(self) -> Option<EffectId> {
        match self {
            Self::Effect(id) => Some(id),
            Self::Events { .. } | Self::Course(_) => None,
        }
    }

    /// Whether it is an effect of the library, or a kind of events, of this identity.
    #[must_use]
    pub fn is(self, id: EffectId) -> bool {
        match self {
            Self::Effect(own) | Self::Events { kind: own, .. } => own == id,
            Self::Course(_) => false,
        }
    }

    /// The port of what the library does not hold.
    #[must_use]
    pub fn unknown_port(self) -> Option<Port> {
        match self {
            Self::Effect(_) => None,
            Self::Events { port, .. } => Some(port),
            Self::Course(course) => Some(course.port),
        }
    }
}

/// The effects that are tried: those of the library, then events of no known effect.
#[derive(Debug, Clone)]
pub(super) struct Tried<'a> {
    effects: Vec<&'a dyn Effect>,
    /// How many of them are the library's.
    known: usize,
}

impl<'a> Tried<'a> {
    pub(super) fn of(library: &'a [Box<dyn Effect>], unknown: &'a [Box<dyn Effect>]) -> Self {
        let effects = library.iter().chain(unknown).map(AsRef::as_ref).collect();
        Self { effects, known: library.len() }
    }

    /// All of them.
    pub(super) fn effects(&self) -> &[&'a dyn Effect] {
        &self.effects
    }

    /// The effects of the library.
    pub(super) fn of_library(&self) -> &[&'a dyn Effect] {
        &self.effects[..self.known]
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

    /// What one of them stands for.
    pub(super) fn hypothesis(&self, id: EffectId) -> Hypothesis {
        let known = self.of_library().iter().any(|effect| effect.card().id == id);
        if known {
            Hypothesis::Effect(id)
        } else {
            Hypothesis::Events { kind: id, port: self.get(id).card().port }
        }
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
