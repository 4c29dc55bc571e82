//! The kidneys lose glucose from another concentration on, and faster or slower, than in the model.

use super::forms::RenalForm;

/// Change of slope and threshold at amplitude 1, as a logarithm: 30 %. In 23 people with type 1
/// diabetes the threshold lay between 6.0 and 14.3 mmol/L, and the rise of glucose that a given
/// excretion takes differed by a factor of seven (Johansen et al., Diabetologia 1984;26:180).
const CHANGE: f64 = 0.262;

/// How one person's kidneys differ from the model's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kidneys {
    /// Direction and size of the difference in threshold, in multiples of the published change.
    pub threshold: f64,
    /// The same for the slope.
    pub slope: f64,
}

/// Factors on the rate at which the kidneys clear glucose, and on the glucose above which they do.
#[must_use]
pub(super) fn factors(form: RenalForm, own: &Kidneys, amplitude: f64) -> (f64, f64) {
    let (slope, threshold) = match form {
        RenalForm::Opposite => (own.slope, own.threshold),
        RenalForm::ThresholdOnly => (0.0, 1.4 * own.threshold),
        RenalForm::RateOnly => (2.0 * own.slope, 0.0),
    };
    // Never a threshold in the range in which everybody would lose glucose.
    let threshold = (amplitude * CHANGE * threshold).clamp(-0.6, 0.9);
    ((amplitude * CHANGE * slope).clamp(-2.0, 2.0).exp(), threshold.exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_change_by_thirty_per_cent() {
        let wasteful = Kidneys { threshold: -1.0, slope: 1.0 };
        let (slope, threshold) = factors(RenalForm::Opposite, &wasteful, 1.0);
        assert!((slope - 1.30).abs() < 0.01 && (threshold - 1.0 / 1.30).abs() < 0.01);
        assert_eq!(factors(RenalForm::Opposite, &wasteful, 0.0), (1.0, 1.0));
    }
}
