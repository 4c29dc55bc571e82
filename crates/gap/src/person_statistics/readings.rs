//! What a sensor's readings show by themselves: how smooth they are, how they dip and jump.

use cohort::Record;
use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};

use super::{DIFFERENCE, Values, excess_kurtosis, mean, moment, sd, skewness};
use crate::units::power;

/// Steps between readings whose differences are held against those of [`DIFFERENCE`].
const LONGER: [(&str, usize); 3] =
    [("30", STEPS_PER_HOUR / 2), ("60", STEPS_PER_HOUR), ("120", 2 * STEPS_PER_HOUR)];
/// Half widths of dips: the least of a compression low, and one an hour and a half wide.
const WIDTHS: [(&str, usize); 2] = [("30 min", STEPS_PER_HOUR / 2), ("45 min", 9)];
/// Times of day at which dips are separated.
const TIMES: [(&str, std::ops::Range<u8>); 2] = [("night", 0..6), ("day", 9..21)];

impl Values {
    /// `glucose` is what the sensor read within its range, mg/dL, by step.
    pub(super) fn readings(&mut self, record: &Record, glucose: &[Option<f64>]) {
        let n = record.len();
        let differences = |lag: usize| -> Vec<f64> {
            (lag..n).filter_map(|k| Some(glucose[k]? - glucose[k - lag]?)).collect()
        };
        let short = moment(&differences(DIFFERENCE), sd);
        for (name, lag) in LONGER {
            let ratio = moment(&differences(lag), sd).zip(short).map(|(long, short)| long / short);
            self.set(&format!("record/difference SD, {name} over 15 min"), ratio);
        }
        // Where glucose is above the line between its neighbours at both sides.
        let bend = |k: usize, width: usize| {
            let (before, after) = (glucose[k.checked_sub(width)?]?, *glucose.get(k + width)?);
            Some(glucose[k]? - f64::midpoint(before, after?))
        };
        for (width_name, width) in WIDTHS {
            for (time, hours) in &TIMES {
                let steps = (0..n).filter(|k| hours.contains(&record.hour(*k)));
                let bends: Vec<f64> = steps.filter_map(|k| bend(k, width)).collect();
                let name = |what: &str| format!("record/bend in {width_name} by {time} {what}");
                self.set(&name("skewness"), moment(&bends, skewness));
                self.set(&name("kurtosis"), moment(&bends, excess_kurtosis));
                self.set(&name("least over SD"), moment(&bends, |b| least(b) / sd(b)));
            }
        }
        // A sensor whose gain drifts is worn for ten days or a week.
        let mean_of = |readings: &[Option<f64>]| {
            let known: Vec<f64> = readings.iter().flatten().copied().collect();
            (!known.is_empty()).then(|| mean(&known))
        };
        let usual = mean_of(glucose).unwrap_or_default();
        let days: Vec<f64> =
            glucose.chunks(STEPS_PER_DAY).map(|day| mean_of(day).unwrap_or(usual)).collect();
        for period in [7, 10] {
            let name = format!("record/glucose of a day, power at {period} days");
            self.set(&name, Some((power(&days, period) + 0.01).ln()));
        }
        // A step to another level that readings around it do not lead to: a new sensor.
        let jump = |k: usize| {
            let before =
                glucose[k.checked_sub(DIFFERENCE)?]? - glucose[k.checked_sub(2 * DIFFERENCE)?]?;
            let (now, after) =
                (glucose[k]? - glucose[k - DIFFERENCE]?, *glucose.get(k + DIFFERENCE)?);
            Some(now - f64::midpoint(before, after? - glucose[k]?))
        };
        let jumps: Vec<f64> = (0..n).filter_map(jump).collect();
        self.set("record/jump kurtosis", moment(&jumps, excess_kurtosis));
        self.set("record/jump most over SD", moment(&jumps, |j| most(j) / sd(j)));
    }
}

fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

fn most(values: &[f64]) -> f64 {
    values.iter().map(|value| value.abs()).fold(0.0, f64::max)
}
