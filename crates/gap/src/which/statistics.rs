//! Sufficient statistics of a person's linear model, by fold of days and by quarter of a day.
//!
//! Innovations e depend on amplitudes theta as e0 + S theta. With weights W all that inference needs is
//! A = S'WS and b = -S'W e0: the log likelihood of theta is b'theta - theta'A theta / 2 up to a
//! constant.

use effects::{Field, Port};
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, Mat, MatRef, Par};
use physiology::STEPS_PER_DAY;

use super::folds::{FOLDS, fold};
use crate::design::{Background, Column, Design};
use crate::filter::tangent::Parameter;

/// Steps of a block: six hours.
pub(super) const BLOCK: usize = STEPS_PER_DAY / 4;

/// What may vary at random from day to day and from block to block.
#[derive(Debug, Clone, Copy)]
pub(super) struct RandomFactor {
    /// The column of the background that it is a factor on.
    pub(super) background: Background,
    /// The field that it is a factor on.
    pub(super) field: Field,
    /// Where it enters.
    pub(super) port: Port,
}

/// The random factors. Insulin input cannot be separated from insulin action, nor action on one target from that on
/// the other, by how they vary: they stand as one.
pub(super) const RANDOM: [RandomFactor; 7] = {
    const fn of(background: Background, field: Field, port: Port) -> RandomFactor {
        RandomFactor { background, field, port }
    }
    [
        of(Background::Parameter(Parameter::Action), Field::Action, Port::InsulinAction),
        of(Background::Parameter(Parameter::Egp0), Field::Production, Port::Egp),
        of(Background::Parameter(Parameter::TMaxG), Field::GutTime, Port::GutAbsorption),
        of(Background::Parameter(Parameter::TMaxI), Field::InsulinTime, Port::InsulinAbsorption),
        of(Background::Parameter(Parameter::AG), Field::CarbAmount, Port::CarbAmount),
        of(Background::Field(Field::SensorGain), Field::SensorGain, Port::Sensor),
        of(Background::Field(Field::Flux), Field::Flux, Port::GlucoseFlux),
    ]
};

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
    pub(super) fn none(columns: usize) -> Self {
        Self { a: Mat::zeros(columns, columns), b: vec![0.0; columns] }
    }

    /// Sums of all folds, or of all but one.
    pub(super) fn over(folds: &[Self], without: Option<usize>) -> Self {
        let mut all = Self::none(folds.first().map_or(0, |fold| fold.b.len()));
        for (_, fold) in folds.iter().enumerate().filter(|(index, _)| Some(*index) != without) {
            all.add(fold, 1.0);
        }
        all
    }

    /// Adds other sums times a sign.
    pub(super) fn add(&mut self, other: &Self, sign: f64) {
        self.a += faer::Scale(sign) * &other.a;
        for (sum, value) in self.b.iter_mut().zip(&other.b) {
            *sum += sign * value;
        }
    }
}

/// Adds `factor` R'R to the lower triangle of a symmetric matrix.
pub(super) fn add_gram(a: &mut Mat<f64>, rows: MatRef<'_, f64>, factor: f64) {
    use BlockStructure::{Rectangular, TriangularLower};
    triangular::matmul(
        a.as_mut(),
        TriangularLower,
        Accum::Add,
        rows.transpose(),
        Rectangular,
        rows,
        Rectangular,
        factor,
        Par::Seq,
    );
}

/// Makes the lower triangle stand for both.
pub(super) fn mirror(a: &mut Mat<f64>) {
    for column in 0..a.ncols() {
        for row in column + 1..a.nrows() {
            a[(column, row)] = a[(row, column)];
        }
    }
}

/// What the random factors of a day see of it.
#[derive(Debug, Clone)]
pub(super) struct DayStatistics {
    /// Rows of A that belong to [`RANDOM`], by block: (random, columns) each.
    pub(super) za: Vec<Mat<f64>>,
    /// Entries of b that belong to [`RANDOM`], by block.
    pub(super) zb: Vec<Vec<f64>>,
}

/// A person's statistics.
#[derive(Debug, Clone)]
pub(super) struct TestStatistics {
    /// What the columns stand for.
    pub(super) columns: Vec<Column>,
    /// Indices of [`RANDOM`] among the columns.
    pub(super) random: [usize; RANDOM.len()],
    /// Days counted from the start of the record, 24 h each; the last may be shorter.
    pub(super) days: Vec<DayStatistics>,
    /// A and b of the days of each fold; nothing asks for single days.
    pub(super) folds: Vec<Sums>,
}

impl TestStatistics {
    /// Sums up a design.
    pub(super) fn of(design: &Design) -> Self {
        let columns = design.columns.clone();
        let random = RANDOM.map(|wanted| {
            columns
                .iter()
                .position(|column| column.is(wanted.background))
                .expect("the background has every random column")
        });
        let steps = design.residuals.len();
        let count = steps.div_ceil(STEPS_PER_DAY);
        let mut days = Vec::with_capacity(count);
        let folds = (0..FOLDS)
            .map(|index| {
                let of_days = fold(count, index);
                let end = (of_days.end * STEPS_PER_DAY).min(steps);
                let rows = DayRows::of(design, of_days.start * STEPS_PER_DAY..end);
                let mut sums = Sums::none(columns.len());
                add_gram(&mut sums.a, rows.signatures.as_ref(), 1.0);
                mirror(&mut sums.a);
                let b = rows.signatures.transpose() * &rows.residuals;
                sums.b = b.col(0).iter().map(|value| -value).collect();
                days.extend(of_days.map(|day| rows.day(&random, day * STEPS_PER_DAY, steps)));
                sums
            })
            .collect();
        Self { columns, random, days, folds }
    }
}

/// The steps of a fold that are scored, each times the root of its weight.
struct DayRows {
    steps: Vec<usize>,
    /// (scored steps, columns)
    signatures: Mat<f64>,
    /// (scored steps, 1)
    residuals: Mat<f64>,
}

impl DayRows {
    fn of(design: &Design, steps: std::ops::Range<usize>) -> Self {
        let steps: Vec<usize> = steps.filter(|step| design.weights[*step] > 0.0).collect();
        let roots: Vec<f64> = steps.iter().map(|step| design.weights[*step].sqrt()).collect();
        let mut signatures = Mat::zeros(steps.len(), design.columns.len());
        for (to, from) in signatures.col_iter_mut().zip(&design.signatures) {
            for ((to, root), step) in to.iter_mut().zip(&roots).zip(&steps) {
                *to = root * f64::from(from[*step]);
            }
        }
        let residuals =
            Mat::from_fn(steps.len(), 1, |row, _| roots[row] * design.residuals[steps[row]]);
        Self { steps, signatures, residuals }
    }

    /// What random factors see of the day that starts at step `first` of a record of `steps`.
    fn day(&self, random: &[usize], first: usize, steps: usize) -> DayStatistics {
        let at = |step: usize| self.steps.partition_point(|scored| *scored < step);
        let blocks = (first..(first + STEPS_PER_DAY).min(steps)).step_by(BLOCK).map(|block| {
            let rows = at(block)..at(block + BLOCK);
            let signatures = self.signatures.as_ref().subrows(rows.start, rows.len());
            let z = Mat::from_fn(rows.len(), random.len(), |row, k| signatures[(row, random[k])]);
            let b = z.transpose() * self.residuals.as_ref().subrows(rows.start, rows.len());
            let b: Vec<f64> = b.col(0).iter().map(|value| -value).collect();
            (z.transpose() * signatures, b)
        });
        let (za, zb) = blocks.unzip();
        DayStatistics { za, zb }
    }
}
