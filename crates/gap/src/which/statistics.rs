//! Sufficient statistics of a person's linear model, by fold of days and by quarter of a day.
//!
//! Innovations e depend on amplitudes theta as e0 + S theta. With weights W all that inference needs is
//! A = S'WS and b = -S'W e0: the log likelihood of theta is b'theta - theta'A theta / 2 up to a
//! constant.

use faer::Mat;
use physiology::STEPS_PER_DAY;

use super::held_out::{FOLDS, fold};
use crate::design::{Column, Design};

/// Steps of a block: six hours.
pub(super) const BLOCK: usize = STEPS_PER_DAY / 4;

/// What may vary at random from day to day and from block to block: columns of the background by name.
pub(super) const RANDOM: [&str; 7] =
    ["action", "egp_0", "t_max_g", "t_max_i", "a_g", "sensor_gain", "flux"];

/// A and b of some days.
#[derive(Debug, Clone)]
pub(super) struct Sums {
    /// A: (columns, columns).
    pub(super) a: Mat<f64>,
    /// b: (columns).
    pub(super) b: Vec<f64>,
}

impl Sums {
    /// Sums of no day.
    fn none(columns: usize) -> Self {
        Self { a: Mat::zeros(columns, columns), b: vec![0.0; columns] }
    }
}

/// What the random factors of a day see of it.
#[derive(Debug, Clone)]
pub(super) struct Day {
    /// Rows of A that belong to [`RANDOM`], by block: (random, columns) each.
    pub(super) za: Vec<Mat<f64>>,
    /// Entries of b that belong to [`RANDOM`], by block.
    pub(super) zb: Vec<Vec<f64>>,
}

/// A person's statistics.
#[derive(Debug, Clone)]
pub(super) struct Person {
    /// What the columns stand for.
    pub(super) columns: Vec<Column>,
    /// Places of [`RANDOM`] among the columns.
    pub(super) random: [usize; RANDOM.len()],
    /// Days counted from the start of the record, 24 h each; the last may be shorter.
    pub(super) days: Vec<Day>,
    /// A and b of the days of each fold; nothing asks for single days.
    pub(super) folds: Vec<Sums>,
}

impl Person {
    /// Sums up a design.
    pub(super) fn of(design: &Design) -> Self {
        let columns = design.columns.clone();
        let random = RANDOM.map(|wanted| {
            columns
                .iter()
                .position(|c| matches!(c, Column::Background { name, .. } if name == wanted))
                .expect("the background has every random column")
        });
        let steps = design.residuals.len();
        let count = steps.div_ceil(STEPS_PER_DAY);
        let mut days = Vec::with_capacity(count);
        let folds = (0..FOLDS)
            .map(|place| {
                let mut sums = Sums::none(columns.len());
                for day in fold(count, place) {
                    let first = day * STEPS_PER_DAY;
                    let steps = first..(first + STEPS_PER_DAY).min(steps);
                    days.push(day_of(design, &random, steps, &mut sums));
                }
                sums
            })
            .collect();
        Self { columns, random, days, folds }
    }
}

/// A day, which is added to `sums`.
fn day_of(
    design: &Design,
    random: &[usize],
    steps: std::ops::Range<usize>,
    sums: &mut Sums,
) -> Day {
    let count = design.columns.len();
    let mut day = Day { za: Vec::new(), zb: Vec::new() };
    let mut first = steps.start;
    while first < steps.end {
        let last = (first + BLOCK).min(steps.end);
        let (a, b) = block_of(design, first..last);
        day.za.push(Mat::from_fn(random.len(), count, |row, column| a[(random[row], column)]));
        day.zb.push(random.iter().map(|place| b[*place]).collect());
        sums.a += &a;
        for (sum, value) in sums.b.iter_mut().zip(b) {
            *sum += value;
        }
        first = last;
    }
    day
}

/// A and b of a stretch of steps.
fn block_of(design: &Design, steps: std::ops::Range<usize>) -> (Mat<f64>, Vec<f64>) {
    let scored: Vec<usize> = steps.filter(|step| design.weights[*step] > 0.0).collect();
    let roots: Vec<f64> = scored.iter().map(|step| design.weights[*step].sqrt()).collect();
    let count = design.columns.len();
    let rows = Mat::from_fn(scored.len(), count, |row, column| {
        roots[row] * f64::from(design.signatures[column][scored[row]])
    });
    let residuals =
        Mat::from_fn(scored.len(), 1, |row, _| roots[row] * design.residuals[scored[row]]);
    let a = rows.transpose() * &rows;
    let b = rows.transpose() * &residuals;
    (a, (0..count).map(|k| -b[(k, 0)]).collect())
}
