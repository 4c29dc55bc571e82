//! Where effects truly act: the part of a label against which "where" is scored.

use contract::blind_check::{TrueCell, TrueWhere};

/// Lengths of the runs over which the truth is stated, min; the third stands for whole days from
/// midnight.
pub const HORIZONS: [u32; 3] = [60, 300, 1440];

/// The absolute mean of a hot cell is at least this many times the mean absolute difference.
pub const ABOVE_MEAN: f64 = 1.25;
/// A hot cell reaches at least this share of the largest cell of its factor. Situations overlap, so
/// they have a lower limit.
pub const OF_BEST: f64 = 0.85;
/// The same for situations.
pub const OF_BEST_CONTEXT: f64 = 0.7;
/// Share of the runs below which a cell is too rare to be hot.
pub const RARE: f64 = 0.01;
/// Length in hours of the windows that decide whether a world has a hot part of the day.
const WINDOW: usize = 3;

/// Factor whose levels are hours of the clock.
const HOUR: &str = "hour";
/// Factor whose levels overlap.
const CONTEXT: &str = "context";

/// The mean difference at a cell of an answer, mg/dL, after the horizon at an index of
/// [`HORIZONS`]; `None` for a cell that the truth does not state.
///
/// A level of hours is `HH-HH`, from the first to before the second, also over midnight.
#[must_use]
pub fn mean_at(truth: &TrueWhere, factor: &str, level: &str, horizon: usize) -> Option<f64> {
    if factor == HOUR {
        let (first, width) = hours_of(level)?;
        return window(truth, first, width, horizon);
    }
    let cell = truth.cells.iter().find(|c| c.factor == factor && c.level == level)?;
    *cell.mean_mg_dl.get(horizon)?
}

/// Whether a cell is hot: large relative to the mean absolute difference and to the largest cell of
/// its factor ([`ABOVE_MEAN`], [`OF_BEST`], [`OF_BEST_CONTEXT`]); windows of hours are compared
/// with the largest of their width. `None` for a cell that the truth does not state, or that is too
/// [rare](RARE).
#[must_use]
pub fn is_hot(truth: &TrueWhere, factor: &str, level: &str, horizon: usize) -> Option<bool> {
    let size = mean_at(truth, factor, level, horizon)?.abs();
    let best = if factor == HOUR {
        let (_, width) = hours_of(level)?;
        largest((0..24).filter_map(|first| window(truth, first, width, horizon)))
    } else {
        let own = of_factor(truth, factor).find(|cell| cell.level == level)?;
        if own.share < RARE {
            return None;
        }
        largest(of_factor(truth, factor).filter_map(|cell| *cell.mean_mg_dl.get(horizon)?))
    };
    let of_best = if factor == CONTEXT { OF_BEST_CONTEXT } else { OF_BEST };
    let mean = truth.mean_absolute_mg_dl.get(horizon)?;
    Some(size > 0.0 && size >= ABOVE_MEAN * mean && size >= of_best * best)
}

/// Whether any window of three hours, situation, band or person is hot.
#[must_use]
pub fn has_hot_place(truth: &TrueWhere, horizon: usize) -> bool {
    let windows = (0..24).map(|first| format!("{first:02}-{:02}", (first + WINDOW) % 24));
    let hours = windows.into_iter().map(|level| (HOUR.to_owned(), level));
    let others = truth.cells.iter().filter(|cell| cell.factor != HOUR);
    let others = others.map(|cell| (cell.factor.clone(), cell.level.clone()));
    hours.chain(others).any(|(f, level)| is_hot(truth, &f, &level, horizon) == Some(true))
}

/// Cells of a factor that are not too rare.
fn of_factor<'a>(truth: &'a TrueWhere, factor: &'a str) -> impl Iterator<Item = &'a TrueCell> {
    truth.cells.iter().filter(move |cell| cell.factor == factor && cell.share >= RARE)
}

/// Mean over `width` hours from `first` on, each hour by its share of the runs.
fn window(truth: &TrueWhere, first: usize, width: usize, horizon: usize) -> Option<f64> {
    let (mut sum, mut weight) = (0.0, 0.0);
    for cell in truth.cells.iter().filter(|cell| cell.factor == HOUR) {
        let Ok(hour) = cell.level.parse::<usize>() else { continue };
        if (hour + 24 - first % 24) % 24 < width
            && let Some(Some(mean)) = cell.mean_mg_dl.get(horizon)
        {
            sum += cell.share * mean;
            weight += cell.share;
        }
    }
    (weight > 0.0).then(|| sum / weight)
}

/// First hour and number of hours of `HH-HH`.
pub(crate) fn hours_of(level: &str) -> Option<(usize, usize)> {
    let (first, end) = level.split_once('-')?;
    let (first, end): (usize, usize) = (first.trim().parse().ok()?, end.trim().parse().ok()?);
    (first < 24 && end <= 24)
        .then(|| (first, if end > first { end - first } else { end + 24 - first }))
}

fn largest(means: impl Iterator<Item = f64>) -> f64 {
    means.fold(0.0, |largest: f64, mean| largest.max(mean.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planted::morning;

    #[test]
    fn windows_of_hours_are_read_and_wrap() {
        assert_eq!(hours_of("03-08"), Some((3, 5)));
        assert_eq!(hours_of("21-24"), Some((21, 3)));
        assert_eq!(hours_of("22-02"), Some((22, 4)));
        assert_eq!(hours_of("night"), None);
        assert_eq!(hours_of("25-26"), None);
    }

    #[test]
    fn a_cell_is_hot_against_the_mean_and_against_the_best() {
        // 4 mg/dL from 03 to 08 h and nothing else: the mean absolute difference is 5/24 of 4.
        let truth = morning(4.0);
        assert_eq!(mean_at(&truth, "hour", "03-08", 0), Some(4.0));
        assert_eq!(is_hot(&truth, "hour", "03-08", 0), Some(true));
        // Three of four hours: 3 mg/dL, of a best window of 4.
        assert_eq!(mean_at(&truth, "hour", "02-06", 0), Some(3.0));
        assert_eq!(is_hot(&truth, "hour", "02-06", 0), Some(false));
        assert_eq!(is_hot(&truth, "hour", "12-17", 0), Some(false));
        assert_eq!(is_hot(&truth, "context", "sleep", 0), Some(true));
        assert_eq!(is_hot(&truth, "context", "sensor_late", 0), None);
        assert!(has_hot_place(&truth, 0));
        // A gap that is the same everywhere is hot nowhere.
        let mut even = truth;
        for cell in &mut even.cells {
            cell.mean_mg_dl = [Some(4.0); 3];
        }
        even.mean_absolute_mg_dl = [4.0; 3];
        assert!(!has_hot_place(&even, 0));
    }
}
