//! From statistics by name to what a network reads.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::table::Table;

/// Largest size of what a network reads: statistics of people unlike all that were seen must not run away.
const LARGEST: f32 = 4.0;
/// Least share of the rows that must have a statistic.
const LEAST_SHARE: f64 = 0.15;
/// Quantiles between which a statistic's spread is taken, and their distance for a Gaussian of standard deviation 1.
const QUANTILES: (f64, f64) = (0.2, 0.8);
const GAUSSIAN: f32 = 1.68;

/// Which statistics are read, and their centres and spreads in training.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Reading {
    pub(crate) names: Vec<String>,
    pub(crate) centre: Vec<f32>,
    pub(crate) spread: Vec<f32>,
}

impl Reading {
    /// Centres and spreads of the statistics that vary and that enough rows have.
    pub(crate) fn of(table: &Table) -> Self {
        let mut reading = Self { names: Vec::new(), centre: Vec::new(), spread: Vec::new() };
        let width = table.names.len();
        for (column, name) in table.names.iter().enumerate() {
            let column = table.values.iter().skip(column).step_by(width.max(1)).copied();
            let mut values: Vec<f32> = column.filter(|value| value.is_finite()).collect();
            if (values.len() as f64) < LEAST_SHARE * table.len() as f64 || values.is_empty() {
                continue;
            }
            values.sort_by(f32::total_cmp);
            let at = |share: f64| values[((values.len() - 1) as f64 * share) as usize];
            let mut spread = (at(QUANTILES.1) - at(QUANTILES.0)) / GAUSSIAN;
            if spread < f32::EPSILON * at(QUANTILES.1).abs().max(1e-3) {
                spread = standard_deviation(&values);
            }
            if spread > 1e-6 {
                reading.names.push(name.clone());
                reading.centre.push(at(0.5));
                reading.spread.push(spread);
            }
        }
        reading
    }

    /// Why this cannot be read with, if so.
    pub(crate) fn fault(&self) -> Option<&'static str> {
        let names = self.names.len();
        if [self.centre.len(), self.spread.len()] != [names, names] {
            return Some("its statistics have no centre or spread each");
        }
        let sound = self.centre.iter().all(|centre| centre.is_finite())
            && self.spread.iter().all(|spread| spread.is_finite() && *spread > 0.0);
        (!sound).then_some("a centre is not finite, or a spread is not positive")
    }

    /// Some of the statistics.
    pub(crate) fn only(&self, kept: &[usize]) -> Self {
        Self {
            names: kept.iter().map(|index| self.names[*index].clone()).collect(),
            centre: kept.iter().map(|index| self.centre[*index]).collect(),
            spread: kept.iter().map(|index| self.spread[*index]).collect(),
        }
    }

    /// What a network reads of one statistic; 0, the centre, where it is absent.
    fn read(&self, index: usize, value: f32) -> f32 {
        if !value.is_finite() {
            return 0.0;
        }
        ((value - self.centre[index]) / self.spread[index]).asinh().clamp(-LARGEST, LARGEST)
    }

    /// What a network reads of a cohort.
    pub(crate) fn of_cohort(&self, statistics: &BTreeMap<String, f64>) -> Vec<f32> {
        let value = |(index, name): (usize, &String)| {
            self.read(index, statistics.get(name).map_or(f32::NAN, |value| *value as f32))
        };
        self.names.iter().enumerate().map(value).collect()
    }

    /// What a network reads of a table: (rows, names).
    pub(crate) fn of_table(&self, table: &Table) -> Vec<f32> {
        let values = table.ordered(&self.names).into_iter().enumerate();
        values.map(|(place, value)| self.read(place % self.names.len(), value)).collect()
    }
}

fn standard_deviation(values: &[f32]) -> f32 {
    let n = values.len() as f32;
    let mean = values.iter().sum::<f32>() / n;
    (values.iter().map(|x| (x - mean) * (x - mean)).sum::<f32>() / n).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::Truth;

    #[test]
    fn statistics_are_centred_bounded_and_absent_ones_are_the_centre() {
        let rows = 11;
        let values: Vec<f32> = (0..rows).flat_map(|k| [k as f32, 7.0]).collect();
        let names = vec!["a".to_owned(), "same".to_owned()];
        let table = Table { names, values, truths: vec![Truth::default(); rows] };
        let reading = Reading::of(&table);
        assert_eq!((&reading.names[..], reading.centre[0]), (&["a".to_owned()][..], 5.0));
        let read = |value: f64| reading.of_cohort(&BTreeMap::from([("a".to_owned(), value)]))[0];
        assert_eq!((read(5.0), read(f64::NAN), read(1e9)), (0.0, 0.0, LARGEST));
        assert_eq!(reading.of_cohort(&BTreeMap::new()), [0.0]);
        let of_table = reading.of_table(&table);
        assert_eq!((of_table.len(), of_table[10]), (rows, read(10.0)));
    }
}
