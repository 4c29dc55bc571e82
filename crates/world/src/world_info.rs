//! What a world was made of. Labels: kept apart from the cohort folder.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::background::{self, Background};
use crate::behaviour::Habits;
use crate::effects::{Amplitudes, Effect, Forms, OutsideEffect};
use crate::generator::Generator;
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
    /// What an amplitude of 1 does, by effect, of those that act in somebody.
    pub effects: BTreeMap<&'static str, &'static str>,
    /// The form of each of them, where a world has forms of its own.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub forms: BTreeMap<&'static str, &'static str>,
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
    /// Kind of body.
    pub generator: Generator,
    /// Parameters of its model by the name of their field, in its units.
    pub parameters: BTreeMap<&'static str, f64>,
    /// Habits.
    pub habits: Habits,
    /// How basal insulin is decided.
    pub regime: Regime,
    /// Settings in use.
    pub settings: TherapySettings,
    /// Effects that act, with their amplitudes: 1 is the published size.
    pub effects: Amplitudes,
}

impl WorldInfo {
    /// The truth about these people.
    #[must_use]
    pub fn new(seed: u64, days: usize, people: &[VirtualPerson]) -> Self {
        let acts = |name: &str| {
            people.iter().any(|person| person.amplitudes.acting().any(|(acting, _)| acting == name))
        };
        let in_effect = people.iter().any(|p| p.background == Background::ERRORS_IN_EFFECT);
        let size = |effect: Effect| match effect {
            Effect::CarbMiscount if in_effect => background::SIZE_OF_ERRORS_IN_EFFECT,
            _ => effect.size_at_one(),
        };
        let named = Effect::ALL.into_iter().map(|e| (e.name(), size(e)));
        let outside = OutsideEffect::ALL.map(|e| (e.name(), e.size_at_one()));
        let effects = named.chain(outside).filter(|(name, _)| acts(name)).collect();
        let forms = people
            .first()
            .map(|person| person.shapes.forms)
            .filter(|forms| *forms != Forms::TYPICAL)
            .map_or_else(BTreeMap::new, |forms| {
                let acting = Effect::ALL.into_iter().filter(|effect| acts(effect.name()));
                acting.map(|effect| (effect.name(), forms.words(effect))).collect()
            });
        let people = people
            .iter()
            .map(|person| PersonInfo {
                person_id: person.id.clone(),
                weight_kg: person.body.weight().0,
                generator: person.body.generator(),
                parameters: person.body.named(),
                habits: person.habits,
                regime: person.regime,
                settings: person.settings,
                effects: person.amplitudes,
            })
            .collect();
        Self { version: env!("CARGO_PKG_VERSION"), seed, days, effects, forms, people }
    }
}
