//! The kidneys lose glucose from another concentration on, and faster or slower, than in the model.

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

/// Factor on the glucose above which the kidneys clear glucose.
#[must_use]
pub(super) fn threshold_factor(kidneys: &Kidneys, amplitude: f64) -> f64 {
    // Never in the range in which everybody would lose glucose.
    (amplitude * CHANGE * kidneys.threshold).clamp(-0.6, 0.9).exp()
}

/// Factor on the rate at which glucose above it is cleared.
#[must_use]
pub(super) fn slope_factor(kidneys: &Kidneys, amplitude: f64) -> f64 {
    (amplitude * CHANGE * kidneys.slope).clamp(-2.0, 2.0).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_change_by_thirty_per_cent() {
        let wasteful = Kidneys { threshold: -1.0, slope: 1.0 };
        assert!((slope_factor(&wasteful, 1.0) - 1.30).abs() < 0.01);
        assert!((threshold_factor(&wasteful, 1.0) - 1.0 / 1.30).abs() < 0.01);
        assert_eq!((slope_factor(&wasteful, 0.0), threshold_factor(&wasteful, 0.0)), (1.0, 1.0));
    }
}
