//! Values that are on a straight line because someone drew it.
//!
//! Sources that fill gaps linearly do not say where. Three readings of a sensor are seldom on one
//! line to the last digit; values between two anchors always are.

use std::ops::Range;

/// Largest second difference, relative to the values, of a line that was computed in f64 and
/// printed with 16 digits.
const TOLERANCE: f64 = 1e-9;
/// Largest second difference of a line whose values were rounded, in units of their last decimal: a
/// half for either end, twice a half for the middle.
const ROUNDED: f64 = 2.0;
/// Most decimals to which a source is assumed to have rounded.
const MOST_DECIMALS: i32 = 6;
/// Fewest values strictly inside a line that count as drawn. One in the middle of three happens by
/// chance where a sensor reports whole mg/dL.
const FEWEST_INSIDE: usize = 2;

/// The straight lines in a column.
#[derive(Debug, Clone, PartialEq)]
pub struct StraightLines {
    /// The steps strictly inside each line (its two ends are readings), in order. Constant
    /// stretches are not counted.
    pub inside: Vec<Range<usize>>,
    /// Share of the recorded values that lie strictly inside a line, 0 to 1.
    pub share: f64,
}

impl StraightLines {
    /// Finds the lines of at least two inner values.
    #[must_use]
    pub fn find(values: &[Option<f64>]) -> Self {
        let unit = last_decimal(values);
        let on_line =
            |k: usize| Self::on_line_or_level(values, k, unit) && values[k - 1] != values[k + 1];
        let mut inside = Vec::new();
        let mut k = 0;
        while k < values.len() {
            let start = k;
            while k < values.len() && on_line(k) {
                k += 1;
            }
            if k - start >= FEWEST_INSIDE {
                inside.push(start..k);
            }
            k += 1;
        }
        let recorded = values.iter().flatten().count();
        let drawn: usize = inside.iter().map(ExactSizeIterator::len).sum();
        let share = if recorded == 0 { 0.0 } else { drawn as f64 / recorded as f64 };
        Self { inside, share }
    }

    /// The readings of a source that draws lines between: the steps whose values are neither on the
    /// line between their neighbours nor equal to them, and those next to a missing value;
    /// ascending.
    #[must_use]
    pub fn corners(values: &[Option<f64>]) -> Vec<usize> {
        let unit = last_decimal(values);
        let recorded = (0..values.len()).filter(|k| values[*k].is_some());
        recorded.filter(|k| !Self::on_line_or_level(values, *k, unit)).collect()
    }

    /// `false` where one of the three values is missing. `unit` is that of the last decimal, 0
    /// where values were not rounded.
    fn on_line_or_level(values: &[Option<f64>], k: usize, unit: f64) -> bool {
        match values.get(k.wrapping_sub(1)..k.saturating_add(2)) {
            Some(&[Some(before), Some(at), Some(after)]) => {
                let scale = before.abs().max(at.abs()).max(after.abs());
                (after - 2.0 * at + before).abs() <= ROUNDED * unit + TOLERANCE * scale
            }
            _ => false,
        }
    }

    /// Number of values inside lines of at least `steps` inner values.
    #[must_use]
    pub fn values_in_lines_of(&self, steps: usize) -> usize {
        self.inside.iter().map(ExactSizeIterator::len).filter(|len| *len >= steps).sum()
    }
}

/// The unit of the last decimal to which the values were rounded. It is 0 for values that were not
/// rounded, and for whole numbers, because sensors report these themselves.
fn last_decimal(values: &[Option<f64>]) -> f64 {
    let of = |decimals: i32| {
        let factor = 10f64.powi(decimals);
        values.iter().flatten().all(|value| {
            let scaled = value * factor;
            (scaled - scaled.round()).abs() <= TOLERANCE * scaled.abs().max(1.0)
        })
    };
    match (0..=MOST_DECIMALS).find(|decimals| of(*decimals)) {
        None | Some(0) => 0.0,
        Some(decimals) => 10f64.powi(-decimals),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_between_anchors_are_found_and_readings_are_not() {
        // Anchors 100, 130, 118, 118 every 15 min, then whole-number readings with a chance line.
        let values = [100.0, 110.0, 120.0, 130.0, 126.0, 122.0, 118.0, 118.0, 118.0, 118.0]
            .into_iter()
            .chain([120.0, 122.0, 125.0, 121.0])
            .map(Some)
            .collect::<Vec<_>>();
        let lines = StraightLines::find(&values);
        assert_eq!(lines.inside, [1..3, 4..6]);
        assert_eq!(lines.share, 4.0 / 14.0);
        assert_eq!((lines.values_in_lines_of(2), lines.values_in_lines_of(3)), (4, 0));
    }

    #[test]
    fn lines_are_found_however_many_decimals_a_source_writes() {
        let read = |k: usize| 120.0 + ((k * k * 7) % 41) as f64;
        let drawn = |k: usize| {
            let (anchor, part) = (k / 3, (k % 3) as f64 / 3.0);
            read(anchor) + part * (read(anchor + 1) - read(anchor))
        };
        let lines = |decimals: i32| {
            let factor = 10f64.powi(decimals);
            let rounded = |k: usize| Some((factor * drawn(k)).round() / factor);
            StraightLines::find(&(0..300).map(rounded).collect::<Vec<_>>())
        };
        let exact = StraightLines::find(&(0..300).map(|k| Some(drawn(k))).collect::<Vec<_>>());
        assert!(exact.share > 0.5);
        for decimals in [2, 3, 4, 5, 9] {
            assert_eq!(lines(decimals).inside, exact.inside, "{decimals} decimals");
        }
        // Sensors report whole numbers, so only exact lines count.
        assert!(lines(0).share < exact.share);
        assert_eq!(last_decimal(&[Some(284.400_000_000_000_03), None, Some(5.0)]), 0.1);
        assert_eq!(last_decimal(&[Some(1.0 / 3.0)]), 0.0);
        assert_eq!(last_decimal(&[]), 0.0);
    }

    #[test]
    fn missing_values_end_a_line_and_nothing_is_no_line() {
        let values = [Some(1.0), Some(2.0), None, Some(4.0), Some(5.0)];
        assert!(StraightLines::find(&values).inside.is_empty());
        assert_eq!(StraightLines::find(&[]).share, 0.0);
    }
}
