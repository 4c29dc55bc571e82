//! Alcohol in the evening: less endogenous glucose until the next noon.

use super::between;
use super::forms::AlcoholForm;

/// Fall of the production at its depth after 0.75 g/kg, as a share. That dose at 21:00 lowers
/// glucose through the night and until noon (Turner et al., Diabetes Care 2001;24:1888); it
/// inhibits gluconeogenesis by about half, which is half of the production overnight (Siler et al.,
/// Am J Physiol 1998;275:E897).
const DEPTH: f64 = 0.30;

/// Factor on endogenous glucose production `hours` after the drinking of `dose` (1 is 0.75 g/kg).
#[must_use]
pub(super) fn production_factor(form: AlcoholForm, hours: f64, dose: f64, amplitude: f64) -> f64 {
    let course = match form {
        AlcoholForm::Night => between(hours, (2.0, 0.6), (11.5, 1.2)),
        AlcoholForm::NextMorning => between(hours, (7.0, 0.8), (15.0, 1.0)),
        AlcoholForm::Early => 1.4 * between(hours, (0.8, 0.25), (6.0, 0.6)),
        AlcoholForm::Fading => {
            let since = hours.max(0.0);
            1.4 * (1.0 - (-since / 1.0).exp()) * (-since / 7.0).exp()
        }
    };
    1.0 - (amplitude * DEPTH * dose).min(0.8) * course
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fall_spans_the_night_and_ends() {
        let production_factor =
            |hours, dose, amplitude| production_factor(AlcoholForm::Night, hours, dose, amplitude);
        assert!(production_factor(6.0, 1.0, 1.0) < 0.72);
        // Tails of the smooth steps: within a hundredth.
        assert!(production_factor(-1.0, 1.0, 1.0) > 0.99);
        assert!(production_factor(17.0, 1.0, 1.0) > 0.99);
        assert!(production_factor(6.0, 1.3, 5.0) >= 0.2);
    }
}
