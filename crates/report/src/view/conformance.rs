//! `conformance.json`: which monotonicity properties of the networks are proved.

use serde::Deserialize;

/// All rows of a verification.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Conformance {
    /// One row a property.
    pub rows: Vec<ConformanceRow>,
}

/// One property of one network.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct ConformanceRow {
    /// Output of the network.
    pub network: String,
    /// Tested input.
    pub input: String,
    /// `increasing` or `decreasing`.
    pub property: String,
    /// `physical`, or `opposite_informational` for the sign that physiology does not ask for.
    #[serde(default)]
    pub kind: Option<String>,
    /// Slope against the property at the witness; scaled output per minute per scaled input.
    pub m_lower: Option<f64>,
    /// Certified bound on the largest slope against the property, the same unit.
    pub m_upper: Option<f64>,
    /// What follows.
    pub verdict: Verdict,
    /// Time taken, s.
    #[serde(default)]
    pub seconds: Option<f64>,
    /// Whether the independent checker accepts the certificate of a proof.
    #[serde(default)]
    pub certified: Option<bool>,
    /// Share of simulated steps at which the property fails.
    #[serde(default)]
    pub share_of_points: Option<FailingShare>,
    /// A counterexample.
    #[serde(default)]
    pub witness: Option<Counterexample>,
    /// The output through it.
    #[serde(default)]
    pub slice: Option<Slice>,
}

/// A share of points, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct FailingShare {
    /// Its value.
    pub value: f64,
}

/// A step of the tested input against the property, scaled.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Counterexample {
    /// The tested input before the step.
    pub from: f64,
    /// The tested input after it.
    pub to: f64,
}

/// A network's output along the tested input, the others as they are at the counterexample.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Slice {
    /// The tested input, scaled.
    pub input: Vec<f64>,
    /// The output, scaled per minute.
    pub output: Vec<f64>,
}

impl ConformanceRow {
    /// Whether the row states physiology, and not the opposite sign for comparison.
    #[must_use]
    pub fn is_physical(&self) -> bool {
        self.kind.as_deref().is_none_or(|kind| kind == "physical")
    }
}

/// What is known of a property.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// It holds on the whole region.
    Proved,
    /// A point of the region breaks it.
    Violated,
    /// Neither is known.
    Undecided,
}
