//! Parameters of the glucoregulatory model.

use serde::{Deserialize, Serialize};

use crate::dual::Scalar;
use crate::error::OdeError;

/// Factor on the three sensitivities that turns a person without diabetes into one with T1D
/// (Resalat et al. 2019: the population then needs 42.3 U a day on average).
pub const T1D_SENSITIVITY_FACTOR: f64 = 0.4;

/// Parameters of Eqs. (1) and (U_G) of the paper, in the paper's symbols.
///
/// Values and units follow Resalat et al. 2019 (single-hormone population).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OdeParameters<T = f64> {
    /// Non-insulin-mediated glucose uptake F01 at 4.5 mmol/L and above, mmol/kg/min.
    pub f_01: T,
    /// Distribution volume of glucose V_G, L/kg.
    pub v_g: T,
    /// Transfer rate k12 from the non-accessible to the accessible glucose, 1/min.
    pub k_12: T,
    /// Carbohydrate bioavailability A_G, unitless.
    pub a_g: T,
    /// Time to the maximal appearance of meal glucose t_max,G, min.
    pub t_max_g: T,
    /// Endogenous glucose production at zero insulin EGP0, mmol/kg/min.
    pub egp_0: T,
    /// Time to the maximal insulin absorption t_max,I, min.
    pub t_max_i: T,
    /// Elimination rate of plasma insulin k_e, 1/min.
    pub k_e: T,
    /// Distribution volume of insulin V_I, L/kg.
    pub v_i: T,
    /// Deactivation rate k_a1 of the effect on distribution, 1/min.
    pub k_a1: T,
    /// Deactivation rate k_a2 of the effect on disposal, 1/min.
    pub k_a2: T,
    /// Deactivation rate k_a3 of the effect on endogenous production, 1/min.
    pub k_a3: T,
    /// Sensitivity S_f1 of distribution to insulin, L/mU/min.
    pub s_f1: T,
    /// Sensitivity S_f2 of disposal to insulin, L/mU/min.
    pub s_f2: T,
    /// Sensitivity S_f3 of endogenous production to insulin, L/mU.
    pub s_f3: T,
}

impl<T: Copy> OdeParameters<T> {
    /// The same parameters as other numbers.
    #[inline]
    #[must_use]
    pub fn map<U>(&self, to: impl Fn(T) -> U) -> OdeParameters<U> {
        OdeParameters {
            f_01: to(self.f_01),
            v_g: to(self.v_g),
            k_12: to(self.k_12),
            a_g: to(self.a_g),
            t_max_g: to(self.t_max_g),
            egp_0: to(self.egp_0),
            t_max_i: to(self.t_max_i),
            k_e: to(self.k_e),
            v_i: to(self.v_i),
            k_a1: to(self.k_a1),
            k_a2: to(self.k_a2),
            k_a3: to(self.k_a3),
            s_f1: to(self.s_f1),
            s_f2: to(self.s_f2),
            s_f3: to(self.s_f3),
        }
    }
}

impl<T: Scalar> OdeParameters<T> {
    /// The same person with the three insulin sensitivities multiplied by `factor`.
    #[must_use]
    pub fn with_sensitivity_scaled(self, factor: T) -> Self {
        Self {
            s_f1: self.s_f1 * factor,
            s_f2: self.s_f2 * factor,
            s_f3: self.s_f3 * factor,
            ..self
        }
    }
}

impl OdeParameters {
    /// The population-level T1D parameters: the published means with the three sensitivities scaled
    /// by [`T1D_SENSITIVITY_FACTOR`].
    #[must_use]
    pub fn nominal() -> Self {
        Self {
            f_01: 0.0097,
            v_g: 0.16,
            k_12: 0.066,
            a_g: 0.8,
            t_max_g: 40.0,
            egp_0: 0.0161,
            t_max_i: 55.0,
            k_e: 0.138,
            v_i: 0.12,
            k_a1: 0.006,
            k_a2: 0.06,
            k_a3: 0.03,
            s_f1: 51.2e-4,
            s_f2: 8.2e-4,
            s_f3: 520e-4,
        }
        .with_sensitivity_scaled(T1D_SENSITIVITY_FACTOR)
    }

    /// Each parameter with its name, in the order of the fields.
    #[must_use]
    pub fn named(&self) -> [(&'static str, f64); 15] {
        [
            ("f_01", self.f_01),
            ("v_g", self.v_g),
            ("k_12", self.k_12),
            ("a_g", self.a_g),
            ("t_max_g", self.t_max_g),
            ("egp_0", self.egp_0),
            ("t_max_i", self.t_max_i),
            ("k_e", self.k_e),
            ("v_i", self.v_i),
            ("k_a1", self.k_a1),
            ("k_a2", self.k_a2),
            ("k_a3", self.k_a3),
            ("s_f1", self.s_f1),
            ("s_f2", self.s_f2),
            ("s_f3", self.s_f3),
        ]
    }

    /// Checks that every parameter is a positive finite number.
    ///
    /// # Errors
    /// [`OdeError::Parameter`] naming the first that is not.
    pub fn validated(self) -> Result<Self, OdeError> {
        match self.named().into_iter().find(|(_, value)| !(value.is_finite() && *value > 0.0)) {
            Some((name, value)) => Err(OdeError::Parameter { name, value }),
            None => Ok(self),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nominal_parameters_carry_the_t1d_sensitivities() {
        let p = OdeParameters::nominal();
        // Products of two decimals: equal to rounding.
        assert!((p.s_f1 - 20.48e-4).abs() < 1e-18);
        assert!((p.s_f2 - 3.28e-4).abs() < 1e-18);
        assert!((p.s_f3 - 208e-4).abs() < 1e-17);
    }

    #[test]
    fn a_parameter_that_is_not_positive_is_named() {
        let mut p = OdeParameters::nominal();
        assert!(p.validated().is_ok());
        p.k_12 = 0.0;
        let error = p.validated().expect_err("zero is not positive");
        assert!(matches!(error, OdeError::Parameter { name: "k_12", .. }));
        p.k_12 = f64::NAN;
        assert!(p.validated().is_err());
    }
}
