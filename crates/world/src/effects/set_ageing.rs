//! An infusion set delivers less the longer it is worn.

/// Loss of bioavailability when a set is three days old, as a share: mild. Losses of the order of
/// 15 % a day after the first days have been described for some users; most see less (Heinemann and
/// Krinelke, J Diabetes Sci Technol 2012;6:954).
const LOSS_AT_THREE_DAYS: f64 = 0.14;

/// Share of the delivered insulin that reaches the tissue from a set worn for `age_days`.
///
/// Nothing is lost on the first day; then the loss grows with the square of the age.
#[must_use]
pub(super) fn bioavailability(age_days: f64, amplitude: f64) -> f64 {
    let worn = (age_days - 1.0).max(0.0) / 2.0;
    (1.0 - amplitude * LOSS_AT_THREE_DAYS * worn * worn).max(0.2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fresh_set_loses_nothing_and_an_old_one_does() {
        assert_eq!(bioavailability(0.9, 1.0), 1.0);
        assert!((bioavailability(3.0, 1.0) - 0.86).abs() < 1e-12); // rounding
        assert_eq!(bioavailability(3.0, 0.0), 1.0);
    }
}
