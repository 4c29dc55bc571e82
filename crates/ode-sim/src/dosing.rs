//! Rules by which doses are set: total daily insulin, insulin-to-carbohydrate ratio, bolus
//! calculator.

use physiology::{Grams, GramsPerUnit, MgPerDl, Units, UnitsPerHour};

use crate::error::{OdeError, positive};

/// Total daily insulin over the basal part of it (Resalat et al. 2019: basal is 56 % of the total).
pub const TOTAL_TO_BASAL: f64 = 1.78;
/// Correction factor times total daily insulin, mg/dL: the "1700 rule" (Davidson et al. 2008).
pub const CORRECTION_RULE: f64 = 1700.0;
/// Rise of glucose by one gram of carbohydrate that turns the correction factor into the
/// insulin-to-carbohydrate ratio, mg/dL/g (Resalat et al. 2019, test program).
pub const RISE_PER_GRAM: f64 = 3.0;

/// Total daily insulin of a person whom `basal` holds at target: 24 h of it times
/// [`TOTAL_TO_BASAL`].
#[must_use]
pub fn total_daily_insulin(basal: UnitsPerHour) -> Units {
    Units(basal.0 * 24.0 * TOTAL_TO_BASAL)
}

/// The basal rate that belongs to a total daily insulin; inverse of [`total_daily_insulin`].
#[must_use]
pub fn basal_of(total: Units) -> UnitsPerHour {
    UnitsPerHour(total.0 / TOTAL_TO_BASAL / 24.0)
}

/// Insulin-to-carbohydrate ratio 1700 / (3 TDIR), g/U.
#[must_use]
pub fn insulin_to_carb_ratio(total: Units) -> GramsPerUnit {
    GramsPerUnit(CORRECTION_RULE / (RISE_PER_GRAM * total.0))
}

/// What a bolus calculator does about glucose away from target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Correction {
    /// Fall of glucose by one unit, mg/dL/U.
    pub factor: f64,
    /// Glucose aimed at.
    pub target: MgPerDl,
}

/// A bolus calculator as pumps carry it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BolusCalculator {
    ratio: GramsPerUnit,
    correction: Option<Correction>,
}

impl BolusCalculator {
    /// A calculator with these settings; without `correction` it doses meals only.
    ///
    /// # Errors
    /// [`OdeError::Argument`] for a ratio, factor or target that is not a positive number.
    pub fn new(ratio: GramsPerUnit, correction: Option<Correction>) -> Result<Self, OdeError> {
        positive("insulin-to-carbohydrate ratio", ratio.0)?;
        if let Some(Correction { factor, target }) = correction {
            positive("correction factor", factor)?;
            positive("target glucose", target.0)?;
        }
        Ok(Self { ratio, correction })
    }

    /// The meal part alone: carbohydrate over the ratio.
    #[must_use]
    pub fn meal_bolus(&self, carbs: Grams) -> Units {
        Units(carbs.0 / self.ratio.0)
    }

    /// Meal part and correction together, never negative.
    ///
    /// Insulin still acting, `on_board`, is taken off the correction where that is positive, and
    /// never off the meal part. Glucose below target takes insulin off the meal part.
    #[must_use]
    pub fn bolus(&self, carbs: Grams, glucose: MgPerDl, on_board: Units) -> Units {
        let correction = self.correction.map_or(0.0, |c| (glucose.0 - c.target.0) / c.factor);
        let correction = match correction - on_board.0 {
            _ if correction <= 0.0 => correction,
            left if left < 0.0 => 0.0,
            left => left,
        };
        let bolus = self.meal_bolus(carbs).0 + correction;
        Units(if bolus < 0.0 { 0.0 } else { bolus })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn basal_and_total_are_inverse() {
        let total = total_daily_insulin(UnitsPerHour(0.9));
        assert!((total.0 - 38.448).abs() < 1e-12); // by hand, rounding
        assert!((basal_of(total).0 - 0.9).abs() < 1e-15); // rounding
    }

    #[test]
    fn the_1700_rule_by_hand() {
        assert!((insulin_to_carb_ratio(Units(42.5)).0 - 40.0 / 3.0).abs() < 1e-13); // rounding
    }

    /// That of a person on 42.5 U a day, correcting to 120 mg/dL.
    fn calculator() -> BolusCalculator {
        let correction = Correction { factor: CORRECTION_RULE / 42.5, target: MgPerDl(120.0) };
        BolusCalculator::new(insulin_to_carb_ratio(Units(42.5)), Some(correction))
            .expect("settings are positive")
    }

    #[test]
    fn boluses_by_hand() {
        let calculator = calculator();
        // (carbs g, glucose mg/dL, on board U, bolus U)
        let cases = [
            (40.0, 120.0, 0.0, 3.0),
            (40.0, 200.0, 0.0, 5.0),
            (40.0, 200.0, 1.5, 3.5),
            (40.0, 200.0, 9.0, 3.0),
            (40.0, 80.0, 5.0, 2.0),
            (0.0, 80.0, 0.0, 0.0),
        ];
        for (carbs, glucose, on_board, expected) in cases {
            let bolus = calculator.bolus(Grams(carbs), MgPerDl(glucose), Units(on_board));
            assert!((bolus.0 - expected).abs() < 1e-12, "{carbs} g at {glucose}"); // rounding
        }
    }

    #[test]
    fn a_reading_that_is_not_a_number_gives_no_number() {
        let calculator = calculator();
        assert!(calculator.bolus(Grams(40.0), MgPerDl(f64::NAN), Units(0.0)).0.is_nan());
        assert!(calculator.bolus(Grams(f64::NAN), MgPerDl(120.0), Units(0.0)).0.is_nan());
        assert!(calculator.bolus(Grams(40.0), MgPerDl(200.0), Units(f64::NAN)).0.is_nan());
    }

    #[test]
    fn settings_that_cannot_be_are_refused() {
        assert!(BolusCalculator::new(GramsPerUnit(0.0), None).is_err());
        let correction = Correction { factor: f64::NAN, target: MgPerDl(110.0) };
        assert!(BolusCalculator::new(GramsPerUnit(10.0), Some(correction)).is_err());
    }
}
