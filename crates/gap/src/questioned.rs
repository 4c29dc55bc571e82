//! Whether "how far" agrees with "which": reasons to doubt a name.

use contract::WithInterval;
use contract::diagnosis::{FoundEffect, HowFar};

/// Of a name that is given to another plant than the ODE. Measured by `cargo xtask blind-check --model
/// crates/nn-statespace/model/population.safetensors --worlds 28 --nulls 40 --seed 20261205`.
const OTHER_PLANT: &str = "Its probability was learned on what the ODE lacks, and this is another plant: with the network \
                           of the repository, 5 of 40 made cohorts in which nothing was missing got a name.";

/// Reasons, in sentences, why a name is to be doubted; empty where its size and the errors on held-out days agree with it.
/// `is_ode` is whether the plant is the ODE.
pub(crate) fn doubts(found: &FoundEffect, how_far: &HowFar, is_ode: bool) -> Vec<String> {
    let mut doubts = Vec::new();
    if !is_ode {
        doubts.push(OTHER_PLANT.to_owned());
    }
    if found.amplitude.lower <= 0.0 {
        doubts.push("Its size may be 0.".to_owned());
    }
    let certain = |difference: &WithInterval| difference.upper < 0.0;
    if how_far.horizons.is_empty() {
        doubts.push("No held-out day could be compared with it and without it.".to_owned());
    } else if !how_far.horizons.iter().any(|horizon| certain(&horizon.difference)) {
        doubts.push("Adding it shrinks no error on held-out days beyond chance.".to_owned());
    }
    doubts
}

#[cfg(test)]
mod tests {
    use super::*;
    use contract::diagnosis::HorizonChange;

    fn found(lower: f64) -> FoundEffect {
        FoundEffect {
            effect: "dawn".to_owned(),
            port: "egp".to_owned(),
            gain_nats: 9.0,
            probability: 0.8,
            amplitude: WithInterval { value: 1.0, lower, upper: 2.0 },
            confusable_with: Vec::new(),
            people: Vec::new(),
            questioned: Vec::new(),
        }
    }

    fn change(minutes: u32, upper: f64) -> HorizonChange {
        HorizonChange {
            minutes,
            mae_before: 20.0,
            mae_after: 18.0,
            difference: WithInterval { value: -2.0, lower: -4.0, upper },
            reconstructed: minutes == 300,
            floor: None,
            share_above_floor: None,
            people: 5,
            runs: 100,
        }
    }

    #[test]
    fn a_name_is_doubted_without_size_and_where_no_error_shrinks() {
        let horizons = |uppers: [f64; 2]| HowFar {
            horizons: vec![change(60, uppers[0]), change(300, uppers[1])],
            ..HowFar::default()
        };
        assert!(doubts(&found(0.4), &horizons([0.3, -0.1]), true).is_empty());
        assert_eq!(doubts(&found(0.4), &horizons([0.3, 0.1]), true).len(), 1);
        assert_eq!(doubts(&found(-0.1), &horizons([-0.3, 0.1]), true), ["Its size may be 0."]);
        assert_eq!(doubts(&found(0.0), &HowFar::default(), true).len(), 2);
        assert_eq!(doubts(&found(0.4), &horizons([0.3, -0.1]), false), [OTHER_PLANT]);
    }
}
