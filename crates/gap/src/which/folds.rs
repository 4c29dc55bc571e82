//! Contiguous folds of days.

/// Folds of days.
pub(super) const FOLDS: usize = 7;

/// Contiguous folds of `days`.
pub(super) fn fold(days: usize, fold: usize) -> std::ops::Range<usize> {
    let folds = FOLDS.min(days.max(1));
    if fold >= folds { 0..0 } else { fold * days / folds..(fold + 1) * days / folds }
}

/// Sum over the days of a fold.
pub(super) fn inside(by_day: &[f64], index: usize) -> f64 {
    by_day[fold(by_day.len(), index)].iter().sum()
}

/// Sum over the days of all other folds.
pub(super) fn outside(by_day: &[f64], index: usize) -> f64 {
    by_day.iter().sum::<f64>() - inside(by_day, index)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_are_either_inside_a_fold_or_outside() {
        let days: Vec<f64> = (0..15).map(f64::from).collect();
        // The last of seven folds of fifteen days has three.
        assert_eq!((inside(&days, 6), outside(&days, 6)), (39.0, 66.0));
        assert_eq!((inside(&[2.0], 0), outside(&[2.0], 0), inside(&[2.0], 1)), (2.0, 0.0, 0.0));
    }

    #[test]
    fn folds_hold_every_day_once() {
        for days in [1, 3, 7, 14, 30] {
            let all: Vec<usize> = (0..FOLDS).flat_map(|index| fold(days, index)).collect();
            assert_eq!(all, (0..days).collect::<Vec<_>>());
        }
    }
}
