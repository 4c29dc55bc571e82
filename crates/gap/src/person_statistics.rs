//! What a person's record, innovations and calibration show, as numbers by name.

mod doses;
mod readings;

use std::collections::BTreeMap;

use cohort::Person;
use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};

use crate::calibrated_person::CalibratedPerson;
use crate::context::{BANDS, band};
use crate::filter::calibration::{Calibration, Factor};
use crate::filter::observations::{Observations, Reading};

/// Quarters of the day: the levels of the statistics by hour.
const QUARTERS: [&str; 4] = ["00-06", "06-12", "12-18", "18-24"];
/// Steps between readings whose differences are taken: 15 min, which sensors of both usual spacings have.
const DIFFERENCE: usize = STEPS_PER_HOUR / 4;
/// Distances at which innovations are held against each other.
const LAGS: [(&str, usize); 3] =
    [("15 min", DIFFERENCE), ("1 h", STEPS_PER_HOUR), ("3 h", 3 * STEPS_PER_HOUR)];
/// Fewest values of which a moment is taken.
const FEWEST: usize = 100;
/// Least carbohydrate of an entry that counts as a meal, g.
const LEAST_MEAL: f64 = 10.0;

/// What the record alone shows.
pub(crate) fn of_record(person: &Person, observations: &Observations) -> BTreeMap<String, f64> {
    let mut found = Values::default();
    found.record(person, observations);
    found.0
}

/// What a person's record, innovations and calibration show, without any question put to them.
pub(crate) fn of_person(person: &CalibratedPerson<'_>) -> BTreeMap<String, f64> {
    let mut found = Values::default();
    found.record(person.person, person.observations);
    found.innovations(person.person, person.calibration);
    found.calibration(person.calibration);
    found.doses(person);
    found.0
}

#[derive(Default)]
struct Values(BTreeMap<String, f64>);

impl Values {
    fn set(&mut self, name: &str, value: Option<f64>) {
        if let Some(value) = value {
            self.0.insert(name.to_owned(), value);
        }
    }

    fn record(&mut self, person: &Person, observations: &Observations) {
        let record = &person.record;
        let glucose: Vec<f64> = observations.readings.iter().filter_map(|r| r.value()).collect();
        // Where the sensor gave a reading within its range.
        let within = observations.readings.iter().map(|reading| match reading {
            Reading::Within(glucose) => Some(glucose.0),
            _ => None,
        });
        let within: Vec<Option<f64>> = within.collect();
        let difference = |k: usize| Some(within[k]? - within[k - DIFFERENCE]?);
        let differences: Vec<Option<f64>> = (DIFFERENCE..record.len()).map(difference).collect();
        let known: Vec<f64> = differences.iter().flatten().copied().collect();
        self.set("record/glucose mean, mg/dL", moment(&glucose, mean));
        self.set("record/glucose SD, mg/dL", moment(&glucose, sd));
        self.set("record/difference SD, mg/dL in 15 min", moment(&known, sd));
        self.set("record/difference kurtosis", moment(&known, excess_kurtosis));
        self.set("record/difference autocorrelation", autocorrelation(&differences, DIFFERENCE));
        self.readings(record, &within);
        let carbs = |grams: f64| grams;
        let meal = |grams: f64| f64::from(u8::from(grams >= LEAST_MEAL));
        let given = |units: f64| f64::from(u8::from(units > 0.0));
        let some = |value: f64| (value > 0.0).then_some(value);
        self.set("record/carbohydrate, g/day", some(per_day(record.carbs(), carbs)));
        self.set("record/meals of 10 g, 1/day", some(per_day(record.carbs(), meal)));
        let basal = per_day(record.basal(), |rate| rate / STEPS_PER_HOUR as f64);
        let per_kg = (per_day(record.bolus(), |units| units) + basal) / observations.weight.0;
        self.set("record/insulin, U/kg/day", some(per_kg));
        self.set("record/boluses, 1/day", some(per_day(record.bolus(), given)));
    }

    fn innovations(&mut self, person: &Person, calibration: &Calibration) {
        let whitened = &calibration.whitened;
        let all: Vec<f64> = whitened.iter().flatten().copied().collect();
        self.set("innovations/scale", Some(calibration.scale));
        self.set("innovations/kurtosis", moment(&all, excess_kurtosis));
        let spacing = calibration.autoregression.spacing;
        for (name, lag) in LAGS {
            let name = format!("innovations/autocorrelation {name}");
            self.set(&name, autocorrelation(whitened, lag.div_ceil(spacing) * spacing));
        }
        self.set("innovations/a1", Some(calibration.autoregression.a1));
        self.set("innovations/a2", Some(calibration.autoregression.a2));
        let steps: Vec<(usize, f64)> =
            whitened.iter().enumerate().filter_map(|(step, w)| Some((step, (*w)?))).collect();
        for (quarter, level) in QUARTERS.into_iter().enumerate() {
            let own = |step: usize| person.record.hour(step) as usize / 6 == quarter;
            let own: Vec<f64> = steps.iter().filter(|(s, _)| own(*s)).map(|(_, w)| *w).collect();
            self.set(&format!("innovations/SD at {level} h"), moment(&own, sd));
            self.set(&format!("innovations/mean at {level} h"), moment(&own, mean));
        }
        let glucose = calibration.glucose();
        for (index, level) in BANDS.iter().enumerate() {
            // By what was known before the reading.
            let own = steps.iter().filter(|(s, _)| *s > 0 && band(glucose[s - 1]) == index);
            let own: Vec<f64> = own.map(|(_, w)| *w).collect();
            self.set(&format!("innovations/SD at {level} mg/dL"), moment(&own, sd));
        }
    }

    fn calibration(&mut self, calibration: &Calibration) {
        for (factor, sd) in Factor::ALL.into_iter().zip(calibration.sd) {
            let name = format!("{factor:?}").to_lowercase();
            let value = calibration.factors.get(factor);
            self.set(&format!("calibration/log {name}"), Some(value));
            self.set(&format!("calibration/SD of log {name}"), Some(sd));
        }
        self.set("calibration/iterations", Some(calibration.iterations as f64));
    }
}

/// Sum over the entries of a channel a day of entries; 0 for a channel without any.
fn per_day(channel: &[Option<f64>], of: impl Fn(f64) -> f64) -> f64 {
    let entries = || channel.iter().flatten();
    let days = entries().count().max(1) as f64 / STEPS_PER_DAY as f64;
    entries().map(|value| of(*value)).sum::<f64>() / days
}

/// A moment of enough values.
fn moment(values: &[f64], of: fn(&[f64]) -> f64) -> Option<f64> {
    moment_of_fewer(values, 1, of)
}

/// A moment of a sample that is smaller than [`FEWEST`] by a known factor.
fn moment_of_fewer(values: &[f64], factor: usize, of: fn(&[f64]) -> f64) -> Option<f64> {
    (values.len() * factor >= FEWEST).then(|| of(values)).filter(|value| value.is_finite())
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn sd(values: &[f64]) -> f64 {
    let mean = mean(values);
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (values.len() as f64 - 1.0)).sqrt()
}

/// Mean of a power of the distances from the mean.
fn central_moment(values: &[f64], power: i32) -> f64 {
    let mean = mean(values);
    values.iter().map(|v| (v - mean).powi(power)).sum::<f64>() / values.len() as f64
}

/// Mean and standard deviation of values that are no sample: there are no others.
pub(crate) fn mean_and_sd(values: &[f64]) -> (f64, f64) {
    (mean(values), central_moment(values, 2).sqrt())
}

/// Fourth moment over the squared second, less 3; 0 for a normal variable.
fn excess_kurtosis(values: &[f64]) -> f64 {
    central_moment(values, 4) / central_moment(values, 2).powi(2) - 3.0
}

/// Third moment over the standard deviation cubed; 0 for a normal variable.
fn skewness(values: &[f64]) -> f64 {
    central_moment(values, 3) / central_moment(values, 2).powf(1.5)
}

/// Correlation of entries `lag` apart, over the pairs that exist.
fn autocorrelation(values: &[Option<f64>], lag: usize) -> Option<f64> {
    let pairs: Vec<(f64, f64)> = values
        .iter()
        .zip(values.iter().skip(lag))
        .filter_map(|(a, b)| Some(((*a)?, (*b)?)))
        .collect();
    if pairs.len() < FEWEST {
        return None;
    }
    let all: Vec<f64> = values.iter().flatten().copied().collect();
    let (mean, sd) = (mean(&all), sd(&all));
    let product = pairs.iter().map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>();
    Some(product / pairs.len() as f64 / sd.powi(2)).filter(|value| value.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_count_the_time_that_is_on_record() {
        let mut channel = vec![Some(0.0); STEPS_PER_DAY];
        channel[10] = Some(30.0);
        channel.extend(vec![None; 3 * STEPS_PER_DAY]);
        assert_eq!(per_day(&channel, |grams| grams), 30.0);
        assert_eq!(per_day(&[None; 5], |grams| grams), 0.0);
    }

    #[test]
    fn moments_are_those_of_known_series() {
        // A square wave has kurtosis 1, 2 below the normal's, and repeats itself after two entries.
        let wave: Vec<f64> = (0..200).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
        assert_eq!(moment(&wave, mean), Some(0.0));
        assert_eq!(moment(&wave, excess_kurtosis), Some(-2.0));
        let series: Vec<Option<f64>> = wave.iter().copied().map(Some).collect();
        for (lag, expected) in [(1, -1.0), (2, 1.0)] {
            let found = autocorrelation(&series, lag).expect("enough pairs");
            // The sample variance has n - 1 below it.
            assert!((found - expected).abs() < 0.01, "{lag}: {found}");
        }
        assert_eq!(moment(&wave[..50], sd), None);
        assert_eq!(autocorrelation(&[Some(1.0); 300], 1), None);
    }
}
