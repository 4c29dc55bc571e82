//! Statistics of worlds beside what is true of them.

use std::collections::{BTreeMap, BTreeSet};

use crate::error::PosteriorError;

/// What is true of a world.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Truth {
    /// Which hand made it.
    pub hand: String,
    /// Names of the effects that act; empty for none.
    pub effects: Vec<String>,
    /// What acts, by the name that its hand gives it, where it is none of the effects.
    pub outside: Option<String>,
    /// Names of the ports at which they act.
    pub ports: Vec<String>,
    /// The gap by cell, mg/dL; cells that it does not state are absent. All 0 where nothing acts.
    pub gaps: BTreeMap<String, f64>,
}

/// Rows of statistics with their truths.
#[derive(Debug, Clone, Default)]
pub struct Table {
    /// Names of the statistics.
    pub names: Vec<String>,
    /// Values, (rows, names); not a number where absent.
    pub values: Vec<f32>,
    /// One a row.
    pub truths: Vec<Truth>,
}

impl Table {
    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.truths.len()
    }

    /// Whether there is no row.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.truths.is_empty()
    }

    /// The rows of all tables, with their names in order; a name that a table lacks is absent from its rows.
    ///
    /// # Errors
    /// [`PosteriorError::Table`] where a table has another number of values than rows times names.
    pub fn joined(tables: &[Self]) -> Result<Self, PosteriorError> {
        tables.iter().try_for_each(Self::checked)?;
        let names = distinct(tables.iter().flat_map(|table| &table.names).cloned());
        let values = tables.iter().flat_map(|table| table.ordered(&names)).collect();
        let truths = tables.iter().flat_map(|table| &table.truths).cloned().collect();
        Ok(Self { names, values, truths })
    }

    /// The values in another order of names; not a number where there is none.
    pub(crate) fn ordered(&self, names: &[String]) -> Vec<f32> {
        let known: BTreeMap<&String, usize> =
            self.names.iter().enumerate().map(|(index, name)| (name, index)).collect();
        let columns: Vec<Option<usize>> =
            names.iter().map(|name| known.get(name).copied()).collect();
        let of_row = |row: &[f32]| {
            let value = |column: &Option<usize>| column.map_or(f32::NAN, |column| row[column]);
            columns.iter().map(value).collect::<Vec<f32>>()
        };
        self.values.chunks(self.names.len().max(1)).flat_map(of_row).collect()
    }

    /// The rows of which something holds.
    #[must_use]
    pub fn rows_where(&self, holds: impl Fn(&Truth) -> bool) -> Self {
        let kept: Vec<usize> = (0..self.len()).filter(|row| holds(&self.truths[*row])).collect();
        Self {
            names: self.names.clone(),
            values: kept.iter().flat_map(|row| self.values_of(*row)).copied().collect(),
            truths: kept.iter().map(|row| self.truths[*row].clone()).collect(),
        }
    }

    /// The statistics of a row by name.
    #[must_use]
    pub fn row(&self, row: usize) -> BTreeMap<String, f64> {
        let known = self.names.iter().zip(self.values_of(row)).filter(|(_, value)| !value.is_nan());
        known.map(|(name, value)| (name.clone(), f64::from(*value))).collect()
    }

    fn values_of(&self, row: usize) -> &[f32] {
        let width = self.names.len();
        &self.values[row * width..(row + 1) * width]
    }

    pub(crate) fn checked(&self) -> Result<(), PosteriorError> {
        let (values, rows, names) = (self.values.len(), self.len(), self.names.len());
        if values == rows * names {
            return Ok(());
        }
        Err(PosteriorError::Table(format!("{values} values of {rows} rows with {names} names")))
    }
}

/// Each of some values once, in order.
pub(crate) fn distinct<T: Ord>(values: impl Iterator<Item = T>) -> Vec<T> {
    values.collect::<BTreeSet<T>>().into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(names: &[&str], values: &[f32], hand: &str) -> Table {
        let rows = values.len() / names.len();
        let truth = Truth { hand: hand.to_owned(), ..Truth::default() };
        Table {
            names: names.iter().map(|n| (*n).to_owned()).collect(),
            values: values.to_vec(),
            truths: vec![truth; rows],
        }
    }

    #[test]
    fn tables_of_other_names_are_brought_together() {
        let one = table(&["b", "a"], &[1.0, 2.0, 3.0, 4.0], "x");
        let other = table(&["c", "a"], &[5.0, 6.0], "y");
        let all = Table::joined(&[one, other]).expect("whole");
        assert_eq!(all.names, ["a", "b", "c"]);
        assert_eq!(all.row(1), BTreeMap::from([("a".into(), 4.0), ("b".into(), 3.0)]));
        assert_eq!(all.row(2), BTreeMap::from([("a".into(), 6.0), ("c".into(), 5.0)]));
        let some = all.rows_where(|truth| truth.hand == "y");
        assert_eq!((some.len(), some.row(0)), (1, all.row(2)));
        let broken = Table { values: vec![1.0], ..table(&["a", "b"], &[1.0, 2.0], "z") };
        assert!(Table::joined(&[all, broken]).is_err());
    }
}
