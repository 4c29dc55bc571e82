//! The sensor follows glucose later than its model has it.

use physiology::{MgPerDl, Minutes, STEP};

use super::forms::LagForm;

/// A lag before a sensor.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lagged {
    form: LagForm,
    lag: Minutes,
    /// Past glucose.
    passed: Vec<f64>,
    /// Its level behind a first-order lag.
    level: Option<f64>,
}

impl Lagged {
    /// A lag that has not yet read glucose.
    #[must_use]
    pub(crate) fn new(form: LagForm, lag: Minutes) -> Self {
        Self { form, lag, passed: Vec::new(), level: None }
    }

    /// Delayed glucose five minutes after the last call, if glucose has moved on a straight line
    /// from its last value to `glucose`. Without a lag it is glucose itself.
    pub(crate) fn pass(&mut self, glucose: MgPerDl) -> MgPerDl {
        if self.lag.0 <= 0.0 {
            return glucose;
        }
        let before = self.passed.last().copied().unwrap_or(glucose.0);
        self.passed.push(glucose.0);
        MgPerDl(match self.form {
            LagForm::FirstOrder => {
                let slope = (glucose.0 - before) / STEP.0;
                let distance = self.level.unwrap_or(glucose.0) - (before - slope * self.lag.0);
                let kept = distance * (-STEP.0 / self.lag.0).exp();
                *self.level.insert(glucose.0 - slope * self.lag.0 + kept)
            }
            LagForm::Delay => self.at(self.lag.0),
            LagForm::MovingMean => {
                // Over twice the lag, so that the mean age of its values is the lag.
                let points = (4.0 * self.lag.0 / STEP.0).ceil().max(1.0);
                let ages = (0..=points as usize).map(|k| 2.0 * self.lag.0 * k as f64 / points);
                ages.map(|age| self.at(age)).sum::<f64>() / (points + 1.0)
            }
        })
    }

    /// Glucose so many minutes ago, interpolated between values; the first value before it.
    fn at(&self, minutes: f64) -> f64 {
        let last = self.passed.len().saturating_sub(1) as f64;
        let place = (last - minutes / STEP.0).max(0.0);
        let (index, share) = (place as usize, place.fract());
        let of = |k: usize| self.passed.get(k).or(self.passed.last()).copied().unwrap_or(0.0);
        of(index) + share * (of(index + 1) - of(index))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_arrives_late_by_the_lag_and_no_lag_is_nothing() {
        for form in LagForm::ALL {
            let mut lagged = Lagged::new(form, Minutes(7.0));
            let mut last = MgPerDl(0.0);
            for step in 0..60 {
                last = lagged.pass(MgPerDl(100.0 + 5.0 * f64::from(step)));
            }
            // 1 mg/dL a minute; exp(-42) of the start is left.
            assert!((395.0 - last.0 - 7.0).abs() < 1e-9, "{form:?}: {}", last.0);
        }
        let mut none = Lagged::new(LagForm::Delay, Minutes(0.0));
        assert_eq!(none.pass(MgPerDl(123.4)).0, 123.4);
        assert_eq!(none.pass(MgPerDl(99.1)).0, 99.1);
    }
}
