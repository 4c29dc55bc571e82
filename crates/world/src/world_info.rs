//! What a world was made of. Labels: kept apart from the cohort folder.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::behaviour::Habits;
use crate::effects::{Amplitudes, Effect};
use crate::therapy::{Regime, TherapySettings};
use crate::virtual_person::VirtualPerson;

/// The truth behind a cohort.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WorldInfo {
    /// Version of this crate.
    pub version: &'static str,
    /// Seed of the world.
    pub seed: u64,
    /// Days of each person.
    pub days: usize,
    /// What an amplitude of 1 does, by effect.
    pub effects: BTreeMap<&'static str, &'static str>,
    /// The people, in the order of the cohort.
    pub people: Vec<PersonInfo>,
}

/// The truth about one person.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PersonInfo {
    /// Identifier in the cohort.
    pub person_id: String,
    /// Body weight, kg.
    pub weight_kg: f64,
    /// Parameters of the ODE model by the name of their field, in its units.
    pub parameters: BTreeMap<&'static str, f64>,
    /// Habits.
    pub habits: Habits,
    /// How basal insulin is decided.
    pub regime: Regime,
    /// Settings in use.
    pub settings: TherapySettings,
    /// Effects that act, with their amplitudes: 1 is the published size, 0 is off.
    pub effects: Amplitudes,
}

impl WorldInfo {
    /// The truth about these people.
    #[must_use]
    pub fn new(seed: u64, days: usize, people: &[VirtualPerson]) -> Self {
        let people = people
            .iter()
            .map(|person| PersonInfo {
                person_id: person.id.clone(),
                weight_kg: person.body.weight.0,
                parameters: person.body.model.named().into_iter().collect(),
                habits: person.habits,
                regime: person.regime,
                settings: person.settings,
                effects: person.amplitudes,
            })
            .collect();
        let effects = Effect::ALL.into_iter().map(|e| (e.name(), e.size_at_one())).collect();
        Self { version: env!("CARGO_PKG_VERSION"), seed, days, effects, people }
    }
}
