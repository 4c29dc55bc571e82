//! An infusion set delivers less the longer it is worn.

use super::forms::SetAgeingForm;

/// Loss of bioavailability when a set is three days old, as a share: mild. Losses of the order of
/// 15 % a day after the first days have been described for some users; most see less (Heinemann and
/// Krinelke, J Diabetes Sci Technol 2012;6:954).
const LOSS_AT_THREE_DAYS: f64 = 0.14;

/// Share of the delivered insulin that reaches the tissue from a set worn for `age_days`.
///
/// Typically nothing is lost until `onset_days`; then the loss grows with the square of the time.
#[must_use]
pub(super) fn bioavailability(
    form: SetAgeingForm,
    age_days: f64,
    onset_days: f64,
    amplitude: f64,
) -> f64 {
    let worn = (age_days - onset_days).max(0.0) / (3.0 - onset_days).max(0.5);
    let lost = match form {
        SetAgeingForm::Quadratic => worn * worn,
        SetAgeingForm::Linear => age_days / 3.0,
        SetAgeingForm::Late => 1.5 * (age_days - 2.0).max(0.0),
        SetAgeingForm::Saturating => 1.0 - (-age_days / (0.7 * onset_days)).exp(),
    };
    (1.0 - amplitude * LOSS_AT_THREE_DAYS * lost).max(0.2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fresh_set_loses_nothing_and_an_old_one_does() {
        let bioavailability = |age, onset, amplitude| {
            bioavailability(SetAgeingForm::Quadratic, age, onset, amplitude)
        };
        for onset in [0.6, 1.0, 1.8] {
            assert_eq!(bioavailability(0.9 * onset, onset, 1.0), 1.0);
            assert!((bioavailability(3.0, onset, 1.0) - 0.86).abs() < 1e-12); // rounding
            assert_eq!(bioavailability(3.0, onset, 0.0), 1.0);
        }
    }
}
