//! Whether "how far" agrees with "which": reasons to doubt a name.

use contract::WithInterval;
use contract::diagnosis::{FoundEffect, HorizonChange, HowFar};

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
    // What has a driver is predicted. Rows that reconstruct what another effect did say nothing of it.
    let is_predicted = how_far.amplitudes.iter().any(|change| change.effect == found.effect);
    let own: Vec<&HorizonChange> =
        how_far.horizons.iter().filter(|change| change.reconstructed != is_predicted).collect();
    if own.is_empty() {
        doubts.push("No held-out day could be compared with it and without it.".to_owned());
    } else if !own.iter().any(|horizon| certain(&horizon.difference)) {
        doubts.push("Adding it shrinks no error on held-out days beyond chance.".to_owned());
    }
    doubts
}

#[cfg(test)]
mod tests {
    use super::*;
    use contract::diagnosis::AmplitudeChange;

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

    /// A row of what is predicted, or reconstructed.
    fn change(reconstructed: bool, upper: f64) -> HorizonChange {
        HorizonChange {
            minutes: 60,
            mae_before: 20.0,
            mae_after: 18.0,
            difference: WithInterval { value: -2.0, lower: -4.0, upper },
            reconstructed,
            floor: None,
            share_above_floor: None,
            people: 5,
            runs: 100,
        }
    }

    #[test]
    fn a_name_is_doubted_without_size_and_where_no_error_shrinks() {
        let predicted = |uppers: [f64; 2]| HowFar {
            horizons: uppers.map(|upper| change(false, upper)).to_vec(),
            amplitudes: vec![amplitude("dawn")],
            ..HowFar::default()
        };
        assert!(doubts(&found(0.4), &predicted([0.3, -0.1]), true).is_empty());
        assert_eq!(doubts(&found(0.4), &predicted([0.3, 0.1]), true).len(), 1);
        assert_eq!(doubts(&found(-0.1), &predicted([-0.3, 0.1]), true), ["Its size may be 0."]);
        assert_eq!(doubts(&found(0.0), &HowFar::default(), true).len(), 2);
        assert_eq!(doubts(&found(0.4), &predicted([0.3, -0.1]), false), [OTHER_PLANT]);
    }

    #[test]
    fn what_is_predicted_is_not_borne_out_by_what_another_effect_s_reconstruction_takes_away() {
        let how_far = |effect: &str| HowFar {
            horizons: vec![change(false, 0.1), change(true, -0.1)],
            amplitudes: vec![amplitude(effect)],
            ..HowFar::default()
        };
        assert_eq!(doubts(&found(0.4), &how_far("dawn"), true).len(), 1);
        // An effect without a driver is reconstructed.
        assert!(doubts(&found(0.4), &how_far("exercise"), true).is_empty());
    }

    fn amplitude(effect: &str) -> AmplitudeChange {
        AmplitudeChange {
            effect: effect.to_owned(),
            variants: Vec::new(),
            mean: WithInterval { value: 1.0, lower: 0.5, upper: 1.5 },
            sd: 0.3,
            people: Vec::new(),
        }
    }
}
