//! `conformance.json`: which monotonicity properties of the networks are proved.

use std::collections::BTreeMap;

/// The rows of a verification.
#[apply(strict!)]
pub struct Conformance {
    /// One row a property.
    pub rows: Vec<Row>,
    /// `conformance/2`.
    pub schema: String,
}

/// One row of `conformance.json`.
#[apply(strict!)]
pub struct Row {
    /// The person whose twin it is; absent for a population network.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub person_id: Option<String>,
    /// Output name of the network; of a twin `residual`, or `twin`: the residual and the population's network together.
    pub network: String,
    /// The tested input.
    pub input: String,
    /// The direction asked for.
    pub property: Direction,
    /// Whether the row states physiology or is for comparison.
    pub kind: PropertyKind,
    /// Slope against the property at the witness, rounded down; scaled output per minute per
    /// scaled input.
    pub m_lower: f64,
    /// Certified upper bound on the largest slope against the property over the region, same unit.
    pub m_upper: f64,
    /// What follows.
    pub verdict: Verdict,
    /// On what the verdict rests; `None` for one that is undecided.
    pub grounds: Option<Grounds>,
    /// Where `m_lower` is attained; absent if its linear piece is too short for a step between
    /// two numbers.
    pub witness: Option<Witness>,
    /// Time taken by the certified search, by the caller's clock.
    pub seconds: f64,
    /// Which engine certified `m_upper`.
    pub engine: String,
    /// Boxes bounded.
    pub nodes: u64,
    /// Why the search ended.
    pub stop: Stop,
    /// Share of the steps of a twin's record at which the slope goes against the property.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share_of_steps: Option<f64>,
    /// The MILP's answer, if asked for. Its bound is the solver's claim and decides nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub milp: Option<MilpReport>,
    /// Whether the MILP claims a bound below a slope that is attained, by more than
    /// a millionth: the solver is then wrong about this row.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub milp_contradicted: Option<bool>,
    /// Share of the region on which the property fails, if the caller adds it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share_of_region: Option<Share>,
    /// Share of simulated points on which the property fails, if the caller adds it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share_of_points: Option<Share>,
    /// The paper's z for a step of the caller's, if the caller adds it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step: Option<StepBracket>,
    /// The same in physical units: delta of the input, z of the output per minute.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub physical_step: Option<StepBracket>,
    /// What the solver says of that step, if the caller asks it. Its bound is its claim and decides nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub milp_step: Option<StepReport>,
    /// The smallest change of the output in five minutes that its caller has seen, as a rate in physical units per minute
    /// (the paper's minimum-viable change).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smallest_change: Option<f64>,
    /// The output along the tested input through the witness, if the caller adds it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slice: Option<Slice>,
    /// Physical units, if the caller adds them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub physical: Option<Physical>,
}

/// The outcome of a property. Not an error, whichever it is.
#[apply(word!)]
#[derive(Hash)]
pub enum Verdict {
    /// The certified upper bound is not above 0: the property holds on the whole region.
    Proved,
    /// The witness, replayed in exact arithmetic, moves against the property.
    Violated,
    /// Neither, within the limits; the bracket says how far it got.
    Undecided,
}

/// On what a verdict rests.
#[apply(word!)]
#[derive(Hash)]
pub enum Grounds {
    /// Proved: the search's outward-rounded bound is not above 0. No certificate was written yet.
    Bound,
    /// Proved: the independent checker accepts the certificate.
    Certificate,
    /// Proved: every weight on the way has the sign that the property needs, whatever the region.
    Construction,
    /// Proved: of a sum of networks, each is proved by a row of its own.
    Summands,
    /// Violated: a step that exact arithmetic replays goes against the property.
    Witness,
}

/// The direction in which the output must move as the input grows, all else equal.
#[apply(word!)]
#[derive(Hash)]
pub enum Direction {
    /// The output must not fall.
    Increasing,
    /// The output must not rise.
    Decreasing,
}

/// Whether a row states physiology.
#[apply(word!)]
#[derive(Hash)]
pub enum PropertyKind {
    /// The sign of the ODE's partial derivative.
    Physical,
    /// The opposite sign, which the paper's appendix lists too; for comparison only.
    OppositeInformational,
}

/// Why the search ended.
#[apply(word!)]
pub enum Stop {
    /// The bracket closed to within the asked relative gap.
    Gap,
    /// The limit on boxes was reached.
    Nodes,
    /// The limit on time was reached.
    Time,
    /// Only boxes too small to halve in floating point were left.
    Resolution,
}

/// A point and a step along the tested input.
#[apply(strict!)]
pub struct Witness {
    /// The inputs at the first point, scaled, by name.
    pub point: BTreeMap<String, f64>,
    /// The tested input at the first point, scaled.
    pub from: f64,
    /// The tested input at the second point, scaled; the others stay as they are.
    pub to: f64,
    /// Movement of the output against the property from the first point to the second, replayed in
    /// exact arithmetic and rounded down; scaled output per minute.
    pub rise: f64,
}

/// The output of a network along one input, the others as they are at a witness.
#[apply(strict!)]
pub struct Slice {
    /// The tested input across the region, scaled.
    pub input: Vec<f64>,
    /// The output there, scaled per minute.
    pub output: Vec<f64>,
}

/// The same numbers in physical units.
#[apply(strict!)]
#[derive(Copy)]
pub struct Physical {
    /// `m_lower`, physical output per minute per physical input.
    pub m_lower: f64,
    /// `m_upper`, physical output per minute per physical input.
    pub m_upper: f64,
}

/// A share with its 95 % interval.
#[apply(strict!)]
#[derive(Copy)]
pub struct Share {
    /// Points at which the slope to the right goes against the property, over all points.
    pub value: f64,
    /// Lower end of the Wilson interval.
    pub lower: f64,
    /// Upper end of the Wilson interval.
    pub upper: f64,
    /// Number of points.
    pub points: usize,
}

/// Bracket of the largest movement against a property over steps of at most `delta`.
#[apply(strict!)]
#[derive(Copy)]
pub struct StepBracket {
    /// Longest step, scaled.
    pub delta: f64,
    /// Movement that exact arithmetic confirms, rounded down; scaled output per minute. Not below 0: a step may be of no
    /// length.
    pub z_lower: f64,
    /// Certified bound, `delta max(0, m_upper)`; scaled output per minute.
    pub z_upper: f64,
}

/// What the solver says, and what of it survives exact evaluation.
#[apply(strict!)]
pub struct MilpReport {
    /// How the solve ended.
    pub status: MilpStatus,
    /// Exact slope to the right at `point`, rounded down: attained, whatever the solver says.
    pub m_lower: Option<f64>,
    /// Where, scaled, in the order of the network's inputs.
    pub point: Option<Vec<f64>>,
    /// Objective claimed by the solver.
    pub claimed_objective: Option<f64>,
    /// Bound claimed by the solver, where it got as far as one. Not a proof.
    pub claimed_bound: Option<f64>,
    /// Number of binaries.
    pub binaries: usize,
    /// Time taken, by the caller's clock.
    pub seconds: f64,
}

/// How a solve ended, in the solver's words.
#[apply(word!)]
pub enum MilpStatus {
    /// The solver claims an optimum within its gap and tolerances.
    Optimal,
    /// The solver stopped at a limit: nothing is decided.
    Limit,
    /// No switch is undecided over the box; nothing was solved.
    Constant,
}

/// What the solver says of a step, and what of it survives exact evaluation.
#[apply(strict!)]
pub struct StepReport {
    /// The form that was solved.
    pub form: Form,
    /// How the solve ended.
    pub status: MilpStatus,
    /// Longest step, scaled.
    pub delta: f64,
    /// Movement against the property over the solver's step, exact and rounded down: attained, whatever the solver
    /// says. Scaled output per minute.
    pub z_lower: Option<f64>,
    /// The point before the step, scaled, in the order of the network's inputs.
    pub point: Option<Vec<f64>>,
    /// The step, scaled.
    pub step: Option<f64>,
    /// Objective claimed by the solver.
    pub claimed_objective: Option<f64>,
    /// Bound claimed by the solver, where it got as far as one. Not a proof.
    pub claimed_bound: Option<f64>,
    /// Number of binaries.
    pub binaries: usize,
    /// Time taken, by the caller's clock.
    pub seconds: f64,
}

/// How a step is written as a programme.
#[apply(word!)]
pub enum Form {
    /// One copy of the network; one binary a neuron says which of two bounds holds for its change.
    Difference,
    /// Two copies, each with a binary a neuron (paper).
    TwoCopies,
}

impl Direction {
    /// The factor s that turns a slope into a slope *against* the property: +1 for decreasing, -1
    /// for increasing.
    #[must_use]
    pub fn against(self) -> f64 {
        match self {
            Self::Increasing => -1.0,
            Self::Decreasing => 1.0,
        }
    }

    /// The other direction.
    #[must_use]
    pub fn opposite(self) -> Self {
        match self {
            Self::Increasing => Self::Decreasing,
            Self::Decreasing => Self::Increasing,
        }
    }
}

impl Row {
    /// Whether the row states physiology, and not the opposite sign for comparison.
    #[must_use]
    pub fn is_physical(&self) -> bool {
        self.kind == PropertyKind::Physical
    }
}
