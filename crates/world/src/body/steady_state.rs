//! What the steady states of all kinds share.

use ode_sim::OdeError;
use physiology::MgPerDl;

/// That a glucose and the parameters of a body are positive and finite.
///
/// # Errors
/// [`OdeError::Argument`] or [`OdeError::Parameter`] for the first that is not.
pub(crate) fn require_possible(
    glucose: MgPerDl,
    parameters: &[(&'static str, f64)],
) -> Result<(), OdeError> {
    let possible = |value: f64| value.is_finite() && value > 0.0;
    if !possible(glucose.0) {
        let requirement = "positive and finite";
        return Err(OdeError::Argument { name: "glucose", value: glucose.0, requirement });
    }
    match parameters.iter().find(|(_, value)| !possible(*value)) {
        Some((name, value)) => Err(OdeError::Parameter { name, value: *value }),
        None => Ok(()),
    }
}

/// Plasma insulin that balances what it lowers: `surplus`, production less disposal at an insulin.
///
/// # Errors
/// [`OdeError::NoBasal`] where glucose falls even without insulin, and [`OdeError::SteadyState`]
/// where `most` does not hold it.
pub(crate) fn balancing_insulin(
    glucose: MgPerDl,
    surplus: impl Fn(f64) -> f64,
    most: f64,
) -> Result<f64, OdeError> {
    if surplus(0.0) < 0.0 {
        return Err(OdeError::NoBasal { glucose: glucose.0 });
    }
    let residual = surplus(most);
    if residual > 0.0 {
        return Err(OdeError::SteadyState { glucose: glucose.0, residual, iterations: 0 });
    }
    Ok(falling(surplus, most))
}

/// The zero of a falling function between 0 and `most`, from above.
///
/// After some sixty halvings the interval reaches the spacing of the numbers.
pub(crate) fn falling(of: impl Fn(f64) -> f64, most: f64) -> f64 {
    let (mut low, mut high) = (0.0, most);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if of(middle) > 0.0 { low = middle } else { high = middle }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_zero_of_a_falling_function_is_found_to_rounding() {
        let zero = falling(|x| 2.0 - x * x, 10.0);
        assert!((zero - 2.0_f64.sqrt()).abs() < 1e-15, "{zero}");
        assert_eq!(falling(|_| 1.0, 3.0), 3.0); // it falls nowhere
    }

    #[test]
    fn what_is_impossible_is_named() {
        let nominal = [("v_g", 1.7), ("k_g", 0.0)];
        let named = require_possible(MgPerDl(100.0), &nominal);
        assert!(matches!(named, Err(OdeError::Parameter { name: "k_g", .. })));
        let glucose = require_possible(MgPerDl(f64::NAN), &nominal[..1]);
        assert!(matches!(glucose, Err(OdeError::Argument { name: "glucose", .. })));
    }
}
