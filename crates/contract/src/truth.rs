//! `truth.json`: which effects act in a cohort, where its makers state it beside the cohort folder.
//!
//! It is read when a report is written, after the diagnosis is final. No diagnosis reads it.

/// `truth.json`: what the makers of a cohort state.
#[apply(strict!)]
pub struct StatedTruth {
    /// `truth/1`.
    pub schema: String,
    /// Name of the file beside the cohort folder that states it.
    pub source: String,
    /// Effects that act in somebody, those of the library first, by name.
    pub effects: Vec<ActingEffect>,
}

/// An effect that acts.
#[apply(strict!)]
pub struct ActingEffect {
    /// Its name.
    pub effect: String,
    /// Mean amplitude over the people in whom it acts; 1 is the published size.
    pub amplitude: f64,
    /// Smallest amplitude of a person; null where it is not stated by person.
    pub lowest: Option<f64>,
    /// Largest amplitude of a person; null where it is not stated by person.
    pub highest: Option<f64>,
    /// People in whom it acts.
    pub people: usize,
    /// What an amplitude of 1 does, or the form of the effect, in words.
    pub says: Option<String>,
    /// Mean absolute shift of glucose that it causes, mg/dL; null where it is not stated.
    pub shift_mg_dl: Option<f64>,
}
