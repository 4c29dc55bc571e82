//! Which monotonicity each sub-network must have.
//!
//! The signs are those of the partial derivatives of the ODE (paper, equations 1a-1h, and
//! Hovorka's two-compartment gut for C1 and C2) at non-negative physical states. Scaling a signal
//! by a positive factor cannot flip a sign, so each input has one physical property. Where the
//! paper's appendix tests the opposite sign as well, or instead (its arrows of C2 are
//! exchanged), that row is kept as informational: it is computed, and expected to be violated.

use contract::conformance::{Direction, PropertyKind};

use crate::error::ConformanceError;
use crate::network::OneHiddenLayer;
use crate::region::{BoxRegion, Region};

/// A monotonicity property of one network in one of its inputs.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Property {
    /// Output name of the network.
    pub network: String,
    /// The tested input.
    pub input: String,
    /// The direction asked for.
    pub direction: Direction,
    /// Whether this is physiology or a row for comparison.
    pub kind: PropertyKind,
}

impl Property {
    /// Position of the tested input in the network that the property speaks of.
    pub(crate) fn tested_in(&self, network: &OneHiddenLayer) -> Result<usize, ConformanceError> {
        if self.network != network.output() {
            return Err(ConformanceError::WrongNetwork {
                property: self.network.clone(),
                network: network.output().to_owned(),
            });
        }
        network.input_index(&self.input)
    }

    /// What the network sees of a region, and the position of the tested input. Refuses a box that leaves that input a
    /// single value.
    pub(crate) fn box_in(
        &self,
        network: &OneHiddenLayer,
        region: &Region,
    ) -> Result<(BoxRegion, usize), ConformanceError> {
        let tested = self.tested_in(network)?;
        let boxed = region.box_of(network)?;
        let value = boxed.lower()[tested];
        if value < boxed.upper()[tested] {
            return Ok((boxed, tested));
        }
        let (network, input) = (network.output().to_owned(), self.input.clone());
        Err(ConformanceError::FixedInput { network, input, value })
    }
}

/// The sign table: network, input, direction of the ODE, and whether the paper's appendix also (or
/// instead) tests the opposite direction.
const SIGNS: [(&str, &str, Direction, bool); 25] = {
    use Direction::{Decreasing, Increasing};
    [
        ("Q1", "X1", Decreasing, true),
        ("Q1", "X3", Decreasing, false),
        ("Q1", "Q1", Decreasing, true),
        ("Q1", "Q2", Increasing, false),
        ("Q1", "C2", Increasing, false),
        ("Q2", "X1", Increasing, true),
        ("Q2", "X2", Decreasing, true),
        ("Q2", "Q1", Increasing, true),
        ("Q2", "Q2", Decreasing, true),
        ("S1", "S1", Decreasing, false),
        ("S1", "u_insulin", Increasing, false),
        ("S2", "S1", Increasing, false),
        ("S2", "S2", Decreasing, false),
        ("I", "S2", Increasing, false),
        ("I", "I", Decreasing, false),
        ("X1", "I", Increasing, false),
        ("X1", "X1", Decreasing, false),
        ("X2", "I", Increasing, false),
        ("X2", "X2", Decreasing, false),
        ("X3", "I", Increasing, false),
        ("X3", "X3", Decreasing, false),
        ("C2", "C1", Increasing, true),
        ("C2", "C2", Decreasing, true),
        ("C1", "C1", Decreasing, false),
        ("C1", "u_carbs", Increasing, false),
    ]
};

/// The 33 rows of the conformance table: 25 physical properties and, each after its physical
/// one, the 8 opposite signs that the paper's appendix lists.
#[must_use]
pub fn paper_properties() -> Vec<Property> {
    let mut rows = Vec::new();
    for (network, input, direction, opposite) in SIGNS {
        let row = |direction, kind| Property {
            network: network.to_owned(),
            input: input.to_owned(),
            direction,
            kind,
        };
        rows.push(row(direction, PropertyKind::Physical));
        if opposite {
            rows.push(row(direction.opposite(), PropertyKind::OppositeInformational));
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn has_the_rows_of_the_papers_appendix() {
        let rows = paper_properties();
        let physical = rows.iter().filter(|row| row.kind == PropertyKind::Physical);
        assert_eq!(physical.count(), 25);
        assert_eq!(rows.len(), 33);
        // The paper's Table "Conformance verification results" has 31 rows, network by network;
        // its two C2 rows are our two informational ones, beside which stand the physical two.
        let count = |network: &str| rows.iter().filter(|row| row.network == network).count();
        let expected = [
            ("Q1", 7),
            ("Q2", 8),
            ("S1", 2),
            ("S2", 2),
            ("I", 2),
            ("X1", 2),
            ("X2", 2),
            ("X3", 2),
            ("C2", 4),
            ("C1", 2),
        ];
        for (network, rows) in expected {
            assert_eq!(count(network), rows, "{network}");
        }
    }

    #[test]
    fn signs_are_those_of_the_equations() {
        // Partial derivatives of equations (1a)-(1h) at a positive state, by central differences
        // of the equations written out here; the gut chain is dC1 = u - C1, dC2 = C1 - C2.
        type Rate = fn(&dyn Fn(&str) -> f64) -> f64;
        let rates: [(&str, Rate); 10] = [
            ("S1", |v| v("u_insulin") - v("S1")),
            ("S2", |v| v("S1") - v("S2")),
            ("I", |v| v("S2") - v("I")),
            ("X1", |v| v("I") - v("X1")),
            ("X2", |v| v("I") - v("X2")),
            ("X3", |v| v("I") - v("X3")),
            ("Q1", |v| -v("X1") * v("Q1") + v("Q2") + v("C2") + (1.0 - v("X3"))),
            ("Q2", |v| v("X1") * v("Q1") - v("Q2") - v("X2") * v("Q2")),
            ("C1", |v| v("u_carbs") - v("C1")),
            ("C2", |v| v("C1") - v("C2")),
        ];
        for property in paper_properties() {
            let (_, rate) =
                rates.iter().find(|(name, _)| *name == property.network).expect("ten networks");
            let at = |moved: f64| {
                let state = |name: &str| if name == property.input { 0.7 + moved } else { 0.7 };
                rate(&state)
            };
            let against = property.direction.against() * (at(0.1) - at(-0.1));
            match property.kind {
                PropertyKind::Physical => assert!(against < 0.0, "{property:?}"),
                PropertyKind::OppositeInformational => assert!(against > 0.0, "{property:?}"),
            }
        }
    }
}
