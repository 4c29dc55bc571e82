//! Bounds of what an option can be, said before any work.

use std::fmt::Debug;

use anyhow::{Result, ensure};

/// Refuses a value of an option that is outside `least` to `most`, or no number.
///
/// # Errors
/// With the option, its value and both bounds.
pub fn within<T: PartialOrd + Debug>(option: &str, value: T, least: T, most: T) -> Result<()> {
    ensure!(
        value >= least && value <= most,
        "{option} {value:?} must be from {least:?} to {most:?}"
    );
    Ok(())
}

/// Refuses a number of worlds that is none or more than `most`.
pub(crate) fn worlds(
    (with, effects): (&str, usize),
    (without, nulls): (&str, usize),
    most: usize,
) -> Result<()> {
    let asked = effects.saturating_add(nulls);
    ensure!(
        (1..=most).contains(&asked),
        "{with} {effects} and {without} {nulls} are {asked} worlds; from 1 to {most} can be"
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_is_outside() {
        assert!(within("--x", 0.5, 0.0, 1.0).is_ok());
        for value in [-0.1, 1.1, f64::NAN, f64::INFINITY] {
            let error = within("--x", value, 0.0, 1.0).expect_err("outside").to_string();
            assert!(error.starts_with("--x ") && error.ends_with("from 0.0 to 1.0"), "{error}");
        }
        assert!(worlds(("--worlds", usize::MAX), ("--nulls", 1), 10).is_err());
    }
}
