//! What physiology says about the slopes of each network, and which units may carry it.
//!
//! The signs are those of the ODE's partial derivatives (paper, equations 1a to 1h) at non-negative states. Eight
//! of the ten rates are linear there: units that each move in the right direction add up to them, whatever their number
//! and wherever their kinks lie. The rates of Q1 and Q2 hold besides a product of two states each (X1 Q1, and X2 Q2), which no
//! sum of such units comes near: units for it see these two states alone and move as they like, and what has to keep
//! its sign is the sum of them, a function of two states.

use physiology::Compartment;

use crate::signal::Signal;

/// The sign of a rate's slope by one of its network's inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SlopeSign {
    /// More of the input is a higher rate.
    Rising,
    /// More of the input is a lower rate.
    Falling,
}

impl SlopeSign {
    /// 1 for rising, -1 for falling.
    #[must_use]
    pub fn factor(self) -> f32 {
        match self {
            Self::Rising => 1.0,
            Self::Falling => -1.0,
        }
    }
}

/// What a hidden unit of a network with kept slopes may do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnitRole {
    /// Sees every input and moves with each as physiology asks; its output weight has this sign.
    Monotone(SlopeSign),
    /// One of those that together stand for a product of two states, and sees these alone.
    Product([Compartment; 2]),
}

/// The sign of the slope of a compartment's rate by an input that its network has in the paper's wiring.
#[must_use]
pub fn slope_sign(network: Compartment, input: Signal) -> SlopeSign {
    use Compartment::{C1, C2, I, Q1, Q2, S1, S2, X1, X2, X3};
    use SlopeSign::{Falling, Rising};
    match (network, input) {
        // Every compartment empties; X1 moves glucose out of Q1, and X3 suppresses its production.
        (own, Signal::State(state)) if own == state => Falling,
        (Q1, Signal::State(X1 | X3)) | (Q2, Signal::State(X2)) => Falling,
        (Q1, Signal::State(Q2 | C2)) | (Q2, Signal::State(X1 | Q1)) => Rising,
        (S2, Signal::State(S1)) | (I, Signal::State(S2)) | (C2, Signal::State(C1)) => Rising,
        (X1 | X2 | X3, Signal::State(I)) => Rising,
        (_, Signal::Insulin | Signal::Carbs) => Rising,
        // Not wired.
        (_, Signal::State(_)) => Rising,
    }
}

/// The pairs of states whose product is part of a compartment's rate.
#[must_use]
pub fn products(network: Compartment) -> &'static [[Compartment; 2]] {
    use Compartment::{Q1, Q2, X1, X2};
    match network {
        Q1 => &[[X1, Q1]],
        Q2 => &[[X1, Q1], [X2, Q2]],
        _ => &[],
    }
}

/// The role of a hidden unit by its place: without products every second unit rises; with them two of five are monotone
/// for one product, one of five for two.
#[must_use]
pub fn unit_role(network: Compartment, unit: usize) -> UnitRole {
    let by_turns = |place: usize| {
        let rising = place.is_multiple_of(2);
        UnitRole::Monotone(if rising { SlopeSign::Rising } else { SlopeSign::Falling })
    };
    match (products(network), unit % 5) {
        ([], _) => by_turns(unit),
        ([_], place @ (0 | 1)) => by_turns(place),
        ([pair], _) => UnitRole::Product(*pair),
        ([..], 0) => by_turns(unit / 5),
        ([first, ..], 1 | 2) => UnitRole::Product(*first),
        ([.., last], _) => UnitRole::Product(*last),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wiring::Wiring;

    #[test]
    fn every_network_has_units_of_each_role_that_see_what_it_is_wired_to() {
        let wiring = Wiring::paper();
        for network in Compartment::ALL {
            let roles: Vec<UnitRole> = (0..12).map(|unit| unit_role(network, unit)).collect();
            for sign in [SlopeSign::Rising, SlopeSign::Falling] {
                assert!(roles.contains(&UnitRole::Monotone(sign)), "{network}");
            }
            for pair in products(network) {
                assert!(roles.contains(&UnitRole::Product(*pair)), "{network}");
                for state in pair {
                    assert!(wiring.inputs(network).contains(&Signal::State(*state)));
                }
            }
            let own = Signal::State(network);
            assert_eq!(slope_sign(network, own), SlopeSign::Falling, "{network} empties");
        }
    }
}
