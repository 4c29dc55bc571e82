//! Contiguous folds of days.

/// Folds of days.
pub(super) const FOLDS: usize = 7;

/// Contiguous folds of `days`.
pub(super) fn fold(days: usize, fold: usize) -> std::ops::Range<usize> {
    let folds = FOLDS.min(days.max(1));
    if fold >= folds { 0..0 } else { fold * days / folds..(fold + 1) * days / folds }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folds_hold_every_day_once() {
        for days in [1, 3, 7, 14, 30] {
            let all: Vec<usize> = (0..FOLDS).flat_map(|index| fold(days, index)).collect();
            assert_eq!(all, (0..days).collect::<Vec<_>>());
        }
    }
}
