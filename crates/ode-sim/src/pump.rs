//! Insulin pumps deliver in whole increments; this turns what was ordered into what is given.

use physiology::{STEP, StepInput, Units};

use crate::error::{OdeError, not_negative, positive};

/// Smallest amount that common pumps deliver (Omnipod, Tandem, Medtronic).
pub const INCREMENT: Units = Units(0.05);

/// An order is a whole number of increments if it misses one by no more than this share of an
/// increment: doses such as 0.15 U are not representable exactly.
const ROUNDING: f64 = 1e-9;

/// A pump with what it still owes of the basal rate.
///
/// Basal accrues and is given in whole increments as soon as one is due, so that what was given and
/// what is owed add up to what was ordered. A bolus is given rounded to the nearest increment, as
/// the pump's own display would have it ordered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pump {
    increment: Units,
    owed: f64,
}

impl Pump {
    /// A pump that delivers in steps of `increment` and owes nothing.
    ///
    /// # Errors
    /// [`OdeError::Argument`] for an increment that is not a positive number.
    pub fn new(increment: Units) -> Result<Self, OdeError> {
        positive("pump increment, U", increment.0)?;
        Ok(Self { increment, owed: 0.0 })
    }

    /// What the pump gives within a step of 5 min for which `ordered` was programmed.
    ///
    /// Everything but basal and bolus is passed on.
    ///
    /// # Errors
    /// [`OdeError::Argument`] for a basal rate or bolus that is negative or not finite.
    pub fn deliver(&mut self, ordered: &StepInput) -> Result<StepInput, OdeError> {
        not_negative("basal rate, U/h", ordered.basal.0)?;
        not_negative("bolus, U", ordered.bolus.0)?;
        let accrued = self.owed + ordered.basal.during(STEP).0;
        let basal = self.increment.0 * (accrued / self.increment.0 + ROUNDING).floor();
        self.owed = (accrued - basal).max(0.0);
        let bolus = self.rounded(ordered.bolus);
        Ok(StepInput { basal: Units(basal).over(STEP), bolus, ..*ordered })
    }

    /// A bolus in whole increments, the nearest.
    #[must_use]
    pub fn rounded(&self, bolus: Units) -> Units {
        Units(self.increment.0 * (bolus.0 / self.increment.0).round())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use physiology::UnitsPerHour;

    fn pump() -> Pump {
        Pump::new(INCREMENT).expect("the increment is positive")
    }

    #[test]
    fn a_rate_below_one_increment_a_step_is_given_now_and_then() {
        let mut pump = pump();
        let ordered = StepInput { basal: UnitsPerHour(0.2), ..StepInput::default() };
        let given: Vec<f64> =
            (0..12).map(|_| pump.deliver(&ordered).expect("a rate").basal.during(STEP).0).collect();
        // 0.2 U/h is an increment every 15 min.
        for (step, amount) in given.iter().enumerate() {
            let expected = if step % 3 == 2 { 0.05 } else { 0.0 };
            assert!((amount - expected).abs() < 1e-12, "step {step}"); // rounding
        }
    }

    #[test]
    fn boluses_are_rounded_to_the_nearest_increment() {
        // (ordered, given)
        for (ordered, given) in [(0.0, 0.0), (0.02, 0.0), (0.03, 0.05), (0.15, 0.15), (3.33, 3.35)]
        {
            let rounded = pump().rounded(Units(ordered)).0;
            assert!((rounded - given).abs() < 1e-12, "{ordered} U gave {rounded} U"); // rounding
        }
    }

    #[test]
    fn what_no_pump_can_give_is_refused() {
        let withdrawn = StepInput { bolus: Units(-1.0), ..StepInput::default() };
        assert!(pump().deliver(&withdrawn).is_err());
        assert!(Pump::new(Units(0.0)).is_err());
    }
}
