//! A pair of axes: from data to canvas, ticks, grid, and the lines and bands between them.

use plotters::style::RGBColor;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{At, Canvas};
use super::palette::{GREY, GRID, Stroke, solid};
use crate::number::fixed;

/// One axis: its range and where it is labelled.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Axis {
    /// Lower and upper end.
    pub(crate) range: (f64, f64),
    /// Ticks with their labels.
    pub(crate) ticks: Vec<(f64, String)>,
}

impl Axis {
    /// An axis over `values` with about `wanted` ticks at round numbers. The ends are ticks, so
    /// nothing is drawn outside; without a finite value it runs from 0 to 1.
    pub(crate) fn over(values: impl IntoIterator<Item = f64>, wanted: usize) -> Self {
        let (mut low, mut high) = ends(values);
        if high - low < 1e-9 * low.abs().max(1e-6) {
            let half = (0.1 * low.abs()).max(0.5);
            (low, high) = (low - half, high + half);
        }
        let step = round_step((high - low) / wanted.max(1) as f64);
        let (first, last) = ((low / step).floor() as i64, (high / step).ceil() as i64);
        let digits = (-step.log10().floor()).clamp(0.0, 9.0) as usize;
        let ticks = (first..=last).map(|k| (k as f64 * step, fixed(k as f64 * step, digits)));
        Self { range: (first as f64 * step, last as f64 * step), ticks: ticks.collect() }
    }

    /// Time of day from `from` to `to` hours, labelled `HH:MM`; hours from 24 on are further days.
    pub(crate) fn clock(from: f64, to: f64) -> Self {
        let step = match to - from {
            36.0.. => 12.0,
            12.0.. => 4.0,
            _ => 2.0,
        };
        let first = (from / step).ceil() as i64;
        let last = (to / step).floor() as i64;
        let ticks = (first..=last).map(|k| k as f64 * step).map(|hour| {
            // The end of the axis is 24:00; only if the axis continues is it the next day's 00:00.
            let shown = if hour == 24.0 && to < 36.0 { 24 } else { (hour as i64).rem_euclid(24) };
            (hour, format!("{shown:02}:00"))
        });
        let ticks = ticks.collect();
        Self { range: (from, if to > from { to } else { from + 1.0 }), ticks }
    }

    /// Powers of ten over positive `values`; positions are logarithms.
    pub(crate) fn decades(values: impl IntoIterator<Item = f64>) -> Self {
        let (low, high) = ends(values.into_iter().filter(|v| *v > 0.0).map(f64::log10));
        let (first, last) = (low.floor() as i32, (high.ceil() as i32).max(low.floor() as i32 + 1));
        let mut ticks = Vec::new();
        for decade in first..=last {
            for factor in [1.0, 2.0, 5.0] {
                let value: f64 = factor * 10_f64.powi(decade);
                let place = value.log10();
                // With many decades only the powers themselves fit.
                if place <= f64::from(last) + 1e-9 && (factor == 1.0 || last - first <= 2) {
                    let digits = usize::try_from(-decade).unwrap_or(0);
                    ticks.push((place, fixed(value, digits)));
                }
            }
        }
        Self { range: (f64::from(first), f64::from(last)), ticks }
    }

    /// Minutes from 0 to `last`, labelled at whole hours.
    pub(crate) fn minutes(last: f64) -> Self {
        let last = if last > 0.0 { last } else { 60.0 };
        let step = [60.0, 120.0, 240.0, 720.0].into_iter().find(|step| last / step < 4.0);
        let step = step.unwrap_or(1440.0);
        let ticks = (0..=(last / step).floor() as i64).map(|k| k as f64 * step);
        Self { range: (0.0, last), ticks: ticks.map(|at| (at, fixed(at, 0))).collect() }
    }

    /// The same axis with its grid and without labels, for a panel beside one that has them.
    pub(crate) fn unlabelled(&self) -> Self {
        let ticks = self.ticks.iter().map(|(index, _)| (*index, String::new())).collect();
        Self { range: self.range, ticks }
    }

    /// An axis without labels.
    pub(crate) fn bare(low: f64, high: f64) -> Self {
        Self { range: (low, high), ticks: Vec::new() }
    }

    /// Position of a value as a share of the axis.
    fn share(&self, value: f64) -> f64 {
        (value - self.range.0) / (self.range.1 - self.range.0)
    }
}

/// The smallest and the largest finite value; 0 and 1 without one.
fn ends(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let finite = values.into_iter().filter(|v| v.is_finite());
    finite
        .map(|value| (value, value))
        .reduce(|(low, high), (value, _)| (low.min(value), high.max(value)))
        .unwrap_or((0.0, 1.0))
}

/// 1, 2 or 5 times a power of ten, at least `step`.
fn round_step(step: f64) -> f64 {
    let power = 10_f64.powf(step.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|f| f * power >= step * (1.0 - 1e-9));
    factor.unwrap_or(10.0) * power
}

/// A rectangle of the canvas with axes.
pub(crate) struct Panel {
    /// Canvas edges.
    pub(crate) left: i32,
    /// Canvas edges.
    pub(crate) right: i32,
    /// Canvas edges.
    pub(crate) top: i32,
    /// Canvas edges.
    pub(crate) bottom: i32,
    /// Horizontal axis.
    pub(crate) x: Axis,
    /// Vertical axis.
    pub(crate) y: Axis,
}

impl Panel {
    /// A panel from its left to its right and from its top to its bottom edge.
    pub(crate) fn new(
        (left, right): (i32, i32),
        (top, bottom): (i32, i32),
        x: Axis,
        y: Axis,
    ) -> Self {
        Self { left, right, top, bottom, x, y }
    }

    /// A panel of so many rows, each one unit of the vertical axis and `high` canvas units.
    pub(crate) fn rows(across: (i32, i32), x: Axis, rows: usize, high: i32) -> Self {
        let height = high * i32::try_from(rows).unwrap_or(i32::MAX / high);
        Self::new(across, (20, 20 + height), x, Axis::bare(0.0, rows as f64))
    }

    /// The name of a row, left of it.
    pub(crate) fn label(&self, canvas: &Canvas<'_>, label: &str, middle: i32) {
        canvas.text(label, (self.left - 14, middle), (HPos::Right, VPos::Center));
    }

    /// From data to canvas.
    pub(crate) fn at(&self, x: f64, y: f64) -> At {
        let across = f64::from(self.right - self.left) * self.x.share(x);
        let down = f64::from(self.bottom - self.top) * (1.0 - self.y.share(y));
        (self.left + across.round() as i32, self.top + down.round() as i32)
    }

    /// Grid, labels and titles. The vertical axis has its title above, horizontal, where a phone
    /// can show it. An empty title of the horizontal axis also removes its labels.
    pub(crate) fn frame(&self, canvas: &Canvas<'_>, x_title: &str, y_title: &str) {
        let Self { left, right, top, bottom, .. } = *self;
        let grid = solid(GRID, 2);
        for (value, label) in &self.y.ticks {
            let (_, y) = self.at(self.x.range.0, *value);
            canvas.path([(left, y), (right, y)], grid);
            if !label.is_empty() {
                canvas.text(label, (left - 12, y), (HPos::Right, VPos::Center));
            }
        }
        for (value, label) in &self.x.ticks {
            let (x, _) = self.at(*value, self.y.range.0);
            canvas.path([(x, top), (x, bottom)], grid);
            if !x_title.is_empty() {
                canvas.text(label, (x, bottom + 12), (HPos::Center, VPos::Top));
            }
        }
        let corners = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
        canvas.path(corners, solid(GREY, 2));
        if !y_title.is_empty() {
            canvas.text(y_title, (10, top - 16), (HPos::Left, VPos::Bottom));
        }
        if !x_title.is_empty() {
            let centre = (left + right) / 2;
            canvas.text(x_title, (centre, bottom + 58), (HPos::Center, VPos::Top));
        }
    }

    /// A line, broken where a value is missing; a single value becomes a short stroke.
    pub(crate) fn line(
        &self,
        canvas: &Canvas<'_>,
        points: impl IntoIterator<Item = (f64, Option<f64>)>,
        stroke: Stroke,
    ) {
        let place = |(x, y): (f64, Option<f64>)| Some(self.at(x, y.filter(|y| y.is_finite())?));
        let places: Vec<Option<At>> = points.into_iter().map(place).collect();
        for run in places.split(Option::is_none) {
            let run: Vec<At> = run.iter().copied().flatten().collect();
            match run[..] {
                [] => {}
                [(x, y)] => canvas.path([(x - 3, y), (x + 3, y)], stroke),
                _ => canvas.path(run, stroke),
            }
        }
    }

    /// The area between two lines, broken where either is missing.
    pub(crate) fn band(
        &self,
        canvas: &Canvas<'_>,
        points: impl IntoIterator<Item = (f64, Option<f64>, Option<f64>)>,
        colour: RGBColor,
        opacity: f64,
    ) {
        let place = |(x, low, high): (f64, Option<f64>, Option<f64>)| {
            Some((self.at(x, low?), self.at(x, high?)))
        };
        let places: Vec<Option<(At, At)>> = points.into_iter().map(place).collect();
        for run in places.split(Option::is_none) {
            let ends = run.iter().copied().flatten();
            let (mut outline, upper): (Vec<At>, Vec<At>) = ends.unzip();
            outline.extend(upper.into_iter().rev());
            if outline.len() > 2 {
                canvas.fill(outline, colour, opacity);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_enclose_the_data() {
        let axis = Axis::over([43.0, 287.0, f64::NAN], 5);
        let labels: Vec<&str> = axis.ticks.iter().map(|(_, l)| l.as_str()).collect();
        assert_eq!(labels, ["0", "50", "100", "150", "200", "250", "300"]);
        assert_eq!(axis.range, (0.0, 300.0));
        let small = Axis::over([-0.31, 0.27], 4);
        assert_eq!(small.ticks[0].1, "\u{2212}0.4");
        assert!(small.range.0 <= -0.31 && small.range.1 >= 0.27);
    }

    #[test]
    fn degenerate_data_still_has_an_axis() {
        for values in [vec![], vec![5.0], vec![0.0, 0.0], vec![f64::NAN]] {
            let axis = Axis::over(values.clone(), 4);
            assert!(axis.range.1 > axis.range.0, "{values:?}: {axis:?}");
            assert!(axis.ticks.len() >= 2);
        }
        assert!(Axis::decades([]).range.1 > Axis::decades([]).range.0);
    }

    #[test]
    fn decades_label_ones_twos_and_fives() {
        let axis = Axis::decades([0.13, 0.9]);
        let labels: Vec<&str> = axis.ticks.iter().map(|(_, l)| l.as_str()).collect();
        assert_eq!(labels, ["0.1", "0.2", "0.5", "1"]);
    }

    #[test]
    fn hours_and_minutes_have_few_labels() {
        for (axis, expected) in [
            (Axis::clock(0.0, 24.0), "00:00 04:00 08:00 12:00 16:00 20:00 24:00"),
            (Axis::clock(0.0, 71.9), "00:00 12:00 00:00 12:00 00:00 12:00"),
            (Axis::minutes(300.0), "0 120 240"),
            (Axis::minutes(180.0), "0 60 120 180"),
            (Axis::minutes(0.0), "0 60"),
        ] {
            let labels: Vec<&str> = axis.ticks.iter().map(|(_, l)| l.as_str()).collect();
            assert_eq!(labels.join(" "), expected);
        }
        let plain = Axis::minutes(300.0).unlabelled();
        assert!(plain.ticks.len() == 3 && plain.ticks.iter().all(|(_, l)| l.is_empty()));
    }

    #[test]
    fn corners_map_to_corners() {
        let (x, y) = (Axis::bare(0.0, 24.0), Axis::bare(0.0, 10.0));
        let panel = Panel::new((100, 900), (50, 450), x, y);
        assert_eq!(panel.at(0.0, 0.0), (100, 450));
        assert_eq!(panel.at(24.0, 10.0), (900, 50));
        assert_eq!(panel.at(12.0, 5.0), (500, 250));
    }
}
