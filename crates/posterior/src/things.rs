//! What can be missing, as a posterior counts it.

use std::collections::BTreeSet;

use crate::error::PosteriorError;
use crate::table::{Table, Truth};

/// What can be missing, in the order of log odds.
pub(crate) struct Things {
    pub(crate) effects: Vec<String>,
    /// Kinds outside the library. Each has odds of its own: what is unknown is many things, of which no two look alike
    /// (decision 0044).
    pub(crate) outside: Vec<String>,
}

impl Things {
    pub(crate) fn of(table: &Table, effects: &[String]) -> Self {
        let outside = table.truths.iter().filter_map(|truth| truth.outside.clone());
        let outside = outside.collect::<BTreeSet<_>>().into_iter().collect();
        Self { effects: effects.to_vec(), outside }
    }

    /// Which of them a world lacks.
    pub(crate) fn missing(&self, truth: &Truth) -> Result<Vec<bool>, PosteriorError> {
        if let Some(strange) = truth.effects.iter().find(|name| !self.effects.contains(name)) {
            return Err(PosteriorError::Table(format!("it has a world with `{strange}`")));
        }
        let known = self.effects.iter().map(|effect| truth.effects.contains(effect));
        let outside = self.outside.iter().map(|kind| truth.outside.as_ref() == Some(kind));
        let missing: Vec<bool> = known.chain(outside).collect();
        let count = missing.iter().filter(|is| **is).count();
        if count > 2 || truth.outside.is_some() && count > 1 {
            return Err(PosteriorError::Table(format!(
                "a world lacks {:?} and more",
                truth.effects
            )));
        }
        Ok(missing)
    }
}
