//! What differs most between people: six factors on the population's parameters, with their priors.

use serde::{Deserialize, Serialize};

use crate::parameters::OdeParameters;

/// A parameter that is calibrated to a person.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Factor {
    /// The three insulin sensitivities together.
    Action,
    /// Endogenous glucose production at zero insulin.
    Egp0,
    /// Time to the maximal appearance of meal glucose.
    TMaxG,
    /// Time to the maximal insulin absorption.
    TMaxI,
    /// Carbohydrate bioavailability.
    AG,
    /// Non-insulin-mediated uptake.
    F01,
}

/// Number of calibrated parameters.
pub const FACTORS: usize = 6;

/// Key in files, parameter and standard deviation of the prior of each factor, in the order of
/// [`Factor::ALL`].
const FACTS: [(&str, &str, f64); FACTORS] = [
    ("action", "s_f1 to s_f3", 0.3),
    ("egp0", "egp_0", 0.15),
    ("t_max_g", "t_max_g", 0.25),
    ("t_max_i", "t_max_i", 0.2),
    ("a_g", "a_g", 0.2),
    ("f01", "f_01", 0.15),
];

impl Factor {
    /// Every factor, in the order of [`PersonalFactors`].
    pub const ALL: [Self; FACTORS] =
        [Self::Action, Self::Egp0, Self::TMaxG, Self::TMaxI, Self::AG, Self::F01];

    /// Its key in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        FACTS[self as usize].0
    }

    /// The parameter that it multiplies, in the paper's symbols.
    #[must_use]
    pub const fn parameter(self) -> &'static str {
        FACTS[self as usize].1
    }

    /// Standard deviation of the prior of the factor's logarithm; its mean is 0.
    #[must_use]
    pub const fn prior_sd(self) -> f64 {
        FACTS[self as usize].2
    }
}

/// Logarithms of a person's factors on the population parameters, in the order of [`Factor::ALL`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PersonalFactors(pub [f64; FACTORS]);

impl PersonalFactors {
    /// The person's parameters.
    #[must_use]
    pub fn applied_to(&self, population: &OdeParameters) -> OdeParameters {
        let [action, egp_0, t_max_g, t_max_i, a_g, f_01] = self.0.map(f64::exp);
        let p = population.with_sensitivity_scaled(action);
        OdeParameters {
            egp_0: p.egp_0 * egp_0,
            t_max_g: p.t_max_g * t_max_g,
            t_max_i: p.t_max_i * t_max_i,
            a_g: p.a_g * a_g,
            f_01: p.f_01 * f_01,
            ..p
        }
    }

    /// The logarithm of one factor.
    #[must_use]
    pub fn get(&self, factor: Factor) -> f64 {
        self.0[factor as usize]
    }

    /// Half the squared distance from the prior's mean, in nats.
    #[must_use]
    pub fn prior_loss(&self) -> f64 {
        self.0.iter().zip(Factor::ALL).map(|(v, f)| 0.5 * (v / f.prior_sd()).powi(2)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_factor_moves_its_own_parameters() {
        let nominal = OdeParameters::nominal();
        assert_eq!(PersonalFactors::default().applied_to(&nominal), nominal);
        let moved: [&[&str]; FACTORS] = [
            &["s_f1", "s_f2", "s_f3"],
            &["egp_0"],
            &["t_max_g"],
            &["t_max_i"],
            &["a_g"],
            &["f_01"],
        ];
        for (factor, names) in Factor::ALL.into_iter().zip(moved) {
            let mut factors = PersonalFactors::default();
            factors.0[factor as usize] = 2.0_f64.ln();
            let found = factors.applied_to(&nominal);
            for ((name, value), (_, before)) in found.named().into_iter().zip(nominal.named()) {
                let expected = if names.contains(&name) { 2.0 * before } else { before };
                assert!((value - expected).abs() < 1e-12 * expected, "{factor:?} {name}");
            }
            // One prior SD is half a nat.
            factors.0[factor as usize] = factor.prior_sd();
            assert!((factors.prior_loss() - 0.5).abs() < 1e-12);
        }
    }
}
