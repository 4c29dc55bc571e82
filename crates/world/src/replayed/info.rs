//! The truth behind a replayed person. Labels: kept apart from the cohort folder.

use std::collections::BTreeMap;

use serde::Serialize;

use super::ReplayedPerson;
use crate::effects::Amplitudes;
use crate::generator::Generator;

/// What a replayed person was made of.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReplayedInfo {
    /// Identifier in the cohort, that of the recorded person.
    pub person_id: String,
    /// Seed of the world.
    pub seed: u64,
    /// Kind of body.
    pub generator: Generator,
    /// Body weight, kg.
    pub weight_kg: f64,
    /// Parameters of the body by the name of their field, in its units.
    pub parameters: BTreeMap<&'static str, f64>,
    /// Logarithm of the restoring factor on insulin action, by day of the record.
    pub restoring: Vec<f64>,
    /// Effects that act, with their amplitudes: 1 is the published size.
    pub effects: Amplitudes,
}

impl ReplayedPerson {
    /// What this person was made of.
    #[must_use]
    pub fn info(&self) -> ReplayedInfo {
        ReplayedInfo {
            person_id: self.original.id.clone(),
            seed: self.seed,
            generator: self.body.generator(),
            weight_kg: self.body.weight().0,
            parameters: self.body.named(),
            restoring: self.restoring.clone(),
            effects: self.amplitudes,
        }
    }
}
