//! A linear forecast from readings, insulin and carbohydrate: the least that a plant must beat.
//!
//! One least-squares regression a horizon and person, fitted on the training days alone: the change
//! of glucose from the origin to the horizon, on the last readings and on insulin and carbohydrate
//! in half hours before and, as the plants are told them too, after the origin.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use physiology::{STEP, STEPS_PER_HOUR, StepInput};

/// Readings up to the origin: half an hour.
pub(crate) const READINGS: usize = 7;
/// Steps of a sum of doses: half an hour.
const SUM: usize = STEPS_PER_HOUR / 2;
/// Steps before the origin whose doses count: three hours.
pub(crate) const BACK: usize = 3 * STEPS_PER_HOUR;
/// Training rows for each coefficient, at least.
const ROWS_EACH: usize = 10;
/// Ridge on coefficients of standardised columns, in rows: keeps columns without variation at 0.
const RIDGE: f64 = 1.0;

/// A fitted regression for one horizon.
#[derive(Debug, Clone)]
pub(crate) struct Arx {
    ahead: usize,
    /// Mean and scale of each column.
    columns: Vec<(f64, f64)>,
    coefficients: Vec<f64>,
    mean_change: f64,
}

impl Arx {
    /// Fits over origins of a record's training part; `None` if there are too few of them.
    ///
    /// `origins` have [`READINGS`] readings up to them and one `ahead` of them, and doses from
    /// [`BACK`] steps before to `ahead` after them.
    pub(crate) fn fit(
        glucose: &[Option<f64>],
        inputs: &[StepInput],
        origins: &[usize],
        ahead: usize,
    ) -> Option<Self> {
        let rows: Vec<(Vec<f64>, f64)> = origins
            .iter()
            .filter_map(|origin| {
                let change = (*glucose.get(origin + ahead)?)? - glucose[*origin]?;
                Some((features(glucose, inputs, *origin, ahead)?, change))
            })
            .collect();
        let width = rows.first()?.0.len();
        if rows.len() < ROWS_EACH * width {
            return None;
        }
        let count = rows.len() as f64;
        let columns: Vec<(f64, f64)> = (0..width)
            .map(|k| {
                let mean = rows.iter().map(|(row, _)| row[k]).sum::<f64>() / count;
                let squares: f64 = rows.iter().map(|(row, _)| (row[k] - mean).powi(2)).sum();
                let sd = (squares / count).sqrt();
                (mean, if sd > 0.0 { sd } else { 1.0 })
            })
            .collect();
        let mean_change = rows.iter().map(|(_, change)| change).sum::<f64>() / count;
        let standard = |row: &[f64], k: usize| (row[k] - columns[k].0) / columns[k].1;
        let mut matrix = Mat::<f64>::from_fn(width, width, |i, j| if i == j { RIDGE } else { 0.0 });
        let mut right = Mat::<f64>::zeros(width, 1);
        for (row, change) in &rows {
            for i in 0..width {
                let x = standard(row, i);
                right[(i, 0)] += x * (change - mean_change);
                for j in 0..width {
                    matrix[(i, j)] += x * standard(row, j);
                }
            }
        }
        let solved = matrix.llt(Side::Lower).ok()?.solve(&right);
        let coefficients = (0..width).map(|k| solved[(k, 0)]).collect();
        Some(Self { ahead, columns, coefficients, mean_change })
    }

    /// The forecast from an origin, mg/dL; `None` where a reading before it is missing.
    pub(crate) fn forecast(
        &self,
        glucose: &[Option<f64>],
        inputs: &[StepInput],
        origin: usize,
    ) -> Option<f64> {
        let row = features(glucose, inputs, origin, self.ahead)?;
        let change: f64 = row
            .iter()
            .zip(&self.columns)
            .zip(&self.coefficients)
            .map(|((value, (mean, scale)), coefficient)| coefficient * (value - mean) / scale)
            .sum();
        Some(glucose[origin]? + self.mean_change + change)
    }
}

/// Readings, then sums of insulin and of carbohydrate over half hours.
fn features(
    glucose: &[Option<f64>],
    inputs: &[StepInput],
    origin: usize,
    ahead: usize,
) -> Option<Vec<f64>> {
    let first = origin.checked_sub(BACK)?;
    let mut row = Vec::with_capacity(READINGS + 2 * (BACK + ahead) / SUM);
    for reading in &glucose[origin + 1 - READINGS..=origin] {
        row.push((*reading)?);
    }
    for half_hour in inputs.get(first..origin + ahead)?.chunks(SUM) {
        row.push(half_hour.iter().map(|input| input.insulin().0 * STEP.0 / 60.0).sum());
        row.push(half_hour.iter().map(|input| input.carbs.0).sum());
    }
    Some(row)
}

#[cfg(test)]
mod tests {
    use super::*;
    use physiology::Grams;

    #[test]
    fn a_linear_record_is_forecast_exactly() {
        // Each gram raises glucose by 2 mg/dL in the step after it, glucose falls by a tenth of what
        // it rose before.
        let inputs: Vec<StepInput> = (0..3000)
            .map(|k| StepInput {
                carbs: Grams(if (k * k) % 23 == 4 { (k % 31) as f64 } else { 0.0 }),
                ..StepInput::default()
            })
            .collect();
        let mut glucose = vec![Some(120.0), Some(120.0)];
        for k in 1..2999 {
            let (now, before): (f64, f64) =
                (glucose[k].expect("set"), glucose[k - 1].expect("set"));
            glucose.push(Some(
                now + 2.0 * inputs[k].carbs.0 - 0.1 * (now - before) - 0.02 * (now - 120.0),
            ));
        }
        let origins: Vec<usize> = (BACK..2000).collect();
        let arx = Arx::fit(&glucose, &inputs, &origins, 1).expect("enough rows");
        // A single step ahead shows a single step's dose: everything is in the columns.
        for origin in 2000..2900 {
            let found = arx.forecast(&glucose, &inputs, origin).expect("readings");
            let error = found - glucose[origin + 1].expect("set");
            // The ridge costs about one row in two thousand.
            assert!(error.abs() < 0.1, "{origin}: {error}");
        }
        assert!(Arx::fit(&glucose, &inputs, &origins[..20], 1).is_none());
        let mut gap = glucose.clone();
        gap[2100] = None;
        assert!(arx.forecast(&gap, &inputs, 2103).is_none());
    }
}
