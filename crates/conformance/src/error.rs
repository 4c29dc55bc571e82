//! What can go wrong with an input of this crate. An undecided row is a verdict, not an error.

use thiserror::Error;

/// Everything this crate refuses.
#[derive(Debug, Error)]
pub enum ConformanceError {
    /// An array of a network does not have the length that its other arrays imply.
    #[error(
        "network '{network}': {array} has {found} values, expected {expected}; w1 is (hidden x \
         inputs) row by row, b1 and w2 are (hidden)"
    )]
    Shape {
        /// Output name of the network.
        network: String,
        /// Which array.
        array: &'static str,
        /// Its length.
        found: usize,
        /// The length it must have.
        expected: usize,
    },
    /// A network without inputs or without hidden neurons.
    #[error("network '{network}': no {what}; at least one is needed")]
    Empty {
        /// Output name of the network.
        network: String,
        /// What is absent.
        what: &'static str,
    },
    /// A weight or bias that is not a finite number.
    #[error("network '{network}': {array}[{index}] is {value}; weights must be finite")]
    NonFiniteWeight {
        /// Output name of the network.
        network: String,
        /// Which array.
        array: &'static str,
        /// Position in the array.
        index: usize,
        /// The value found.
        value: f64,
    },
    /// Two inputs of a network share a name.
    #[error("network '{network}': input '{input}' is named twice; input names must differ")]
    DuplicateInput {
        /// Output name of the network.
        network: String,
        /// The repeated name.
        input: String,
    },
    /// A property speaks of an input that the network does not have.
    #[error("network '{network}': no input '{input}'; its inputs are {known:?}")]
    UnknownInput {
        /// Output name of the network.
        network: String,
        /// The name asked for.
        input: String,
        /// The inputs the network has.
        known: Vec<String>,
    },
    /// A property of one network was asked of another.
    #[error(
        "property of network '{property}' asked of network '{network}'; pass the network it names"
    )]
    WrongNetwork {
        /// Network named by the property.
        property: String,
        /// Output name of the network that was passed.
        network: String,
    },
    /// `region.json` is not JSON of the expected form.
    #[error(
        "region: not of the form {{\"unit\": \"scaled\" or \"physical\", \"bounds\": {{name: [lo, \
         hi]}}}}: {0}"
    )]
    RegionForm(contract::ContractError),
    /// The region could not be read.
    #[error("region: not readable")]
    RegionRead(#[source] std::io::Error),
    /// The region bounds the signal of this name twice.
    #[error("region: '{0}' is bounded twice; keep one")]
    RegionDuplicate(String),
    /// The region bounds a signal that the caller does not know.
    #[error("region: unknown signal '{signal}'; known are {known:?}")]
    RegionUnknown {
        /// The name found.
        signal: String,
        /// The names that would be accepted.
        known: Vec<String>,
    },
    /// The region lacks a signal that a network takes as input.
    #[error("region: no bounds for '{signal}', an input of network '{network}'; add them")]
    RegionMissing {
        /// The absent signal.
        signal: String,
        /// The network that needs it.
        network: String,
    },
    /// A half-space that is none.
    #[error("region: half-space {number}: {reason}")]
    HalfSpace {
        /// Its place, from 0.
        number: usize,
        /// What is wrong.
        reason: String,
    },
    /// Half-spaces with no point strictly inside all of them, or with so little room that none is
    /// found, for the network of this output name. Over a region without an inside every claim would
    /// count as proved.
    #[error(
        "region: no point of the box that network '{0}' sees is found strictly inside all \
         half-spaces; widen them"
    )]
    RegionEmpty(String),
    /// An engine that knows boxes alone.
    #[error("region: the enumeration of cells knows boxes alone, not half-spaces")]
    BoxesAlone,
    /// A bound that is not a finite number.
    #[error("region: bounds of '{signal}' are [{lower}, {upper}]; both must be finite")]
    RegionNonFinite {
        /// The signal.
        signal: String,
        /// Lower bound as given or as scaled.
        lower: f64,
        /// Upper bound as given or as scaled.
        upper: f64,
    },
    /// A lower bound above its upper bound.
    #[error(
        "region: lower bound of '{signal}' is above its upper bound, [{lower}, {upper}]; swap them"
    )]
    RegionOrder {
        /// The signal.
        signal: String,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// A physical region needs the scaling of each signal it bounds; that of the signal of this name
    /// is unknown.
    #[error(
        "region: bounds of '{0}' are physical but its scaling is unknown; give its centre and \
         scale, or scaled bounds"
    )]
    RegionNoScaling(String),
    /// A scaling that is not finite or whose scale is not positive.
    #[error("scaling of '{signal}': centre {centre}, scale {scale}; both finite, scale above zero")]
    Scaling {
        /// The signal.
        signal: String,
        /// Centre.
        centre: f64,
        /// Scale.
        scale: f64,
    },
    /// The tested input cannot vary, so there is no slope along it.
    #[error(
        "network '{network}': input '{input}' is fixed at {value} by the region; a tested input \
         needs a lower bound below its upper bound"
    )]
    FixedInput {
        /// Output name of the network.
        network: String,
        /// The tested input.
        input: String,
        /// The only value the region leaves it.
        value: f64,
    },
    /// A point with the wrong number of coordinates, or one that is not finite.
    #[error(
        "network '{network}': point {index} is not {expected} finite numbers; give one value per \
         input, in the network's order"
    )]
    Point {
        /// Output name of the network.
        network: String,
        /// Position among the points passed.
        index: usize,
        /// Number of inputs.
        expected: usize,
    },
    /// A limit outside its range.
    #[error("limit '{limit}' is {value}; {range}")]
    Limit {
        /// Which limit.
        limit: &'static str,
        /// The value passed.
        value: f64,
        /// What would be accepted.
        range: &'static str,
    },
    /// The exact enumeration takes two inputs only.
    #[error(
        "network '{network}': {inputs} inputs; the enumeration of cells is for two, use branch and \
         bound"
    )]
    NotPlanar {
        /// Output name of the network.
        network: String,
        /// Its number of inputs.
        inputs: usize,
    },
    /// HiGHS refused a model, an option or a solve.
    #[error("network '{network}', input '{input}': HiGHS failed while {stage}: {reason}")]
    Solver {
        /// Output name of the network.
        network: String,
        /// The tested input.
        input: String,
        /// What was being done.
        stage: &'static str,
        /// What HiGHS said.
        reason: String,
    },
    /// No step of a record lies far enough inside its box to be replayed.
    #[error(
        "network '{network}', input '{input}': no step of the record lies inside its box; give a longer record"
    )]
    NoStep {
        /// Name of the sum of networks.
        network: String,
        /// The tested input.
        input: String,
    },
    /// The checker refuses the certificates that were written for it.
    #[error("the checker rejects what the verifier wrote, a defect of one of the two: {reason}")]
    Rejected {
        /// What the checker said.
        reason: String,
    },
}

/// Refuses the `value` of a `limit` unless it `holds`; `range` says what would be accepted.
pub(crate) fn require(
    holds: bool,
    limit: &'static str,
    value: f64,
    range: &'static str,
) -> Result<(), ConformanceError> {
    if holds { Ok(()) } else { Err(ConformanceError::Limit { limit, value, range }) }
}
