//! An effect of the library or one outside it.

use crate::effects::{Amplitudes, Effect, OutsideEffect, Port};
use crate::virtual_person::VirtualPerson;

/// An effect that can be planned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum PlannedEffect {
    /// One that a diagnosis can name.
    Named(Effect),
    /// One that it should call unknown.
    Outside(OutsideEffect),
}

impl PlannedEffect {
    /// Every effect, those of the library first.
    pub fn all() -> impl Iterator<Item = Self> {
        let named = Effect::ALL.into_iter().map(Self::Named);
        named.chain(OutsideEffect::ALL.into_iter().map(Self::Outside))
    }

    /// The effect of a name; `None` for an unknown name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::all().find(|effect| effect.name() == name)
    }

    /// The name that files use.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Named(effect) => effect.name(),
            Self::Outside(effect) => effect.name(),
        }
    }

    /// Where it acts.
    #[must_use]
    pub const fn port(self) -> Port {
        match self {
            Self::Named(effect) => effect.port(),
            Self::Outside(effect) => effect.port(),
        }
    }

    /// Whether a diagnosis can name it.
    #[must_use]
    pub const fn in_library(self) -> bool {
        matches!(self, Self::Named(_))
    }

    /// Largest mean amplitude that a world may use: six times the published size, and less where
    /// the effect is a share that reaches its limit before that.
    #[must_use]
    pub const fn largest_amplitude(self) -> f64 {
        match self {
            // Half of the rescue carbohydrate at 1: all of it at 2.
            Self::Named(Effect::UnloggedRescueCarbs) => 2.0,
            _ => 6.0,
        }
    }

    /// Its form in a world with these people, in words; `None` outside the library.
    #[must_use]
    pub fn form(self, people: &[VirtualPerson]) -> Option<&'static str> {
        match (self, people.first()) {
            (Self::Named(effect), Some(person)) => Some(person.shapes.forms.words(effect)),
            _ => None,
        }
    }

    /// These amplitudes with that of this effect set.
    #[must_use]
    pub fn set(self, amplitudes: Amplitudes, amplitude: f64) -> Amplitudes {
        match self {
            Self::Named(effect) => amplitudes.with(effect, amplitude),
            Self::Outside(effect) => amplitudes.with_outside(effect, amplitude),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_read_as_it_is_written() {
        for effect in PlannedEffect::all() {
            assert_eq!(PlannedEffect::from_name(effect.name()), Some(effect));
            assert!(effect.largest_amplitude() > 1.0);
        }
        assert_eq!(PlannedEffect::from_name("none"), None);
    }
}
