//! z, the paper's quantity: how far the output moves against a property when the tested input grows by at most delta.

use crate::error::ConformanceError;
use crate::network::OneHiddenLayer;
use crate::property::Property;
use crate::region::Region;
use crate::replay::replay;
use crate::verify::z_bound;
use contract::conformance::{Row, StepBracket};

/// How many halvings of the step are tried about a witness.
const HALVINGS: i32 = 20;

/// The bracket of a row's step. Tried are steps about the row's witness, of `delta` and shorter, to its right and across it.
///
/// # Errors
/// What [`verify()`](crate::verify()) refuses; [`ConformanceError::Limit`] for a `delta` that is not above 0.
pub fn step_bracket(
    network: &OneHiddenLayer,
    property: &Property,
    region: &Region,
    row: &Row,
    delta: f64,
) -> Result<StepBracket, ConformanceError> {
    if !(delta.is_finite() && delta > 0.0) {
        return Err(ConformanceError::Limit { limit: "delta", value: delta, range: "above 0" });
    }
    let tested = network.input_index(&property.input)?;
    let boxed = region.box_of(network)?;
    boxed.check_free(network, tested)?;
    let mut z_lower = 0.0_f64;
    if let Some(witness) = &row.witness {
        let mut point: Vec<f64> = network.inputs().iter().map(|name| witness.point[name]).collect();
        let (first, last) = (boxed.lower()[tested], boxed.upper()[tested]);
        for halvings in 0..HALVINGS {
            let length = delta * 0.5_f64.powi(halvings);
            for share in [0.0, 0.5, 1.0] {
                let from = (witness.from - share * length).max(first);
                let mut to = (from + length).min(last);
                while to - from > delta {
                    to = to.next_down();
                }
                if to > from {
                    point[tested] = to;
                    let ends_inside = boxed.contains(&point);
                    point[tested] = from;
                    if !ends_inside || !boxed.contains(&point) {
                        continue;
                    }
                    let rise = replay(network, &point, tested, to, property.direction).rise;
                    z_lower = z_lower.max(rise);
                }
            }
        }
    }
    let bound = z_bound(row, delta);
    let z_upper = if bound > 0.0 { bound.next_up() } else { 0.0 };
    Ok(StepBracket { delta, z_lower, z_upper })
}
