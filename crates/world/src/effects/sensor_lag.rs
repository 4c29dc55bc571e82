//! The sensor follows glucose later than its model has it.

use physiology::{MgPerDl, Minutes, STEP};

/// Additional lag at an amplitude for a person with the lag `own` at amplitude 1: lags of 6 to 12
/// min are published for the interstitium alone (Basu et al., Diabetes 2013;62:4083; Facchinetti et
/// al., IEEE Trans Biomed Eng 2014;61:620), and the filters of a device add theirs.
#[must_use]
pub(super) fn lag(own: Minutes, amplitude: f64) -> Minutes {
    Minutes(amplitude * own.0)
}

/// A first-order lag in front of a sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lagged {
    lag: Minutes,
    behind: Option<(f64, f64)>,
}

impl Lagged {
    /// A lag that has not yet seen glucose.
    #[must_use]
    pub(crate) fn new(lag: Minutes) -> Self {
        Self { lag, behind: None }
    }

    /// Glucose as it arrives five minutes after the last call, if glucose has gone straight from
    /// its last value to `glucose`; without a lag that is glucose itself.
    pub(crate) fn pass(&mut self, glucose: MgPerDl) -> MgPerDl {
        if self.lag.0 <= 0.0 {
            return glucose;
        }
        let (before, level) = self.behind.unwrap_or((glucose.0, glucose.0));
        let slope = (glucose.0 - before) / STEP.0;
        let distance = level - (before - slope * self.lag.0);
        let level = glucose.0 - slope * self.lag.0 + distance * (-STEP.0 / self.lag.0).exp();
        self.behind = Some((glucose.0, level));
        MgPerDl(level)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_arrives_late_by_the_lag_and_no_lag_is_nothing() {
        let mut lagged = Lagged::new(lag(Minutes(7.0), 1.0));
        let mut last = MgPerDl(0.0);
        for step in 0..60 {
            last = lagged.pass(MgPerDl(100.0 + 5.0 * f64::from(step)));
        }
        // 1 mg/dL a minute; exp(-42) of the start is left.
        assert!((395.0 - last.0 - 7.0).abs() < 1e-9, "{}", last.0);
        let mut none = Lagged::new(lag(Minutes(7.0), 0.0));
        assert_eq!(none.pass(MgPerDl(123.4)).0, 123.4);
        assert_eq!(none.pass(MgPerDl(99.1)).0, 99.1);
    }
}
