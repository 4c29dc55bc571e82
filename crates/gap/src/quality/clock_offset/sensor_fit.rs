//! What the sensor says about when doses were given.
//!
//! Rises of glucose over 15 min are regressed on the carbohydrate absorbed and the insulin action in
//! them, both from the logged doses by compartments in series, with level, day-night rhythm and
//! return to the mean taken out. With every dose moved by an offset the fit is better or worse; its
//! log-likelihood, the sizes of both effects integrated out under priors, says how well the offset
//! suits. Sums by day tell whether that is more than a few days' accident.
//!
//! The model is linear and coarse on purpose: it is fitted for tens of offsets and several speeds of
//! absorption in a few milliseconds. A whole extended Kalman filter, recalibrated for each offset,
//! told the offsets of real records no better.

use std::f64::consts::TAU;

use chrono::Timelike as _;
use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};

use super::{DoseSteps, z_over_days};
use crate::filter::whitening::robust_scale;

/// Length of the rises, steps.
const RISE: usize = 3;
/// Largest offset, steps: 3 h.
const LARGEST: i32 = 36;
/// Spacing of the offsets that are fitted, steps: 10 min, fine beside absorption.
const SPACING: i32 = 2;
/// Times to maximum of gut absorption, min: around the 40 min of Hovorka et al. 2004.
const GUT: [f64; 3] = [25.0, 40.0, 60.0];
/// Times to maximum of insulin absorption, min: around the 55 min of Hovorka et al. 2004.
const DEPOT: [f64; 3] = [40.0, 55.0, 75.0];
/// Indices in [`GUT`] and [`DEPOT`] of the people that are tried.
const SPEEDS: [(usize, usize); 5] = [(0, 0), (0, 2), (1, 1), (2, 0), (2, 2)];
/// Lag of the sensor behind plasma, min.
const SENSOR_LAG: f64 = 10.0;
/// Time constants of plasma insulin and of its remote effect, min: 1/k_e and 1/k_a of Hovorka et
/// al. 2004, rounded.
const PLASMA: f64 = 10.0;
const REMOTE: f64 = 60.0;
/// A unit lowers glucose by 1700 over the daily dose (mg/dL/U), a gram needs 1/500 of the daily dose
/// (U/g): the rules of thumb of Walsh & Roberts, "Pumping Insulin". A gram hence raises glucose by
/// their ratio, mg/dL/g.
const CORRECTION_RULE: f64 = 1700.0;
const RISE_PER_GRAM: f64 = 1700.0 / 500.0;
/// Coefficient of variation of both rules between people, as a prior.
const RULE_CV: f64 = 0.5;
/// Smallest residual standard deviation that is believed, mg/dL per rise.
const SMALLEST_SD: f64 = 3.0;
/// Huber's bend, in robust standard deviations.
const BEND: f64 = 2.0;
/// Order of the residual's autoregression.
const ORDER: usize = 2;
/// Columns taken out first: level, glucose, one day-night wave.
const BASE: usize = 4;
/// Where clean records lie, min, and how far they scatter: people log a meal a little late, and the
/// kernels above are no one's own.
const HABIT: (f64, f64) = (5.0, 15.0);
/// Half-width of the range over which habit is fitted, steps.
const HABIT_RANGE: i32 = 5;

/// Two offsets of meals and of insulin, compared by how well they explain the sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Comparison {
    /// Log-likelihood of the first minus that of the second, nats.
    pub(super) gain: f64,
    /// The same by days, in standard errors over days.
    pub(super) z: f64,
}

/// Offsets of the two channels, steps, recorded minus actual.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Offsets {
    pub(super) meals: i32,
    pub(super) insulin: i32,
}

/// Whitened columns without their base, one an offset from -[`LARGEST`] to [`LARGEST`].
type Predictors = Vec<Vec<f64>>;

/// The regression for every offset.
pub(super) struct SensorFit {
    /// Whitened rises.
    rises: Vec<f64>,
    /// Day of each.
    days: Vec<usize>,
    /// Carbohydrate taken up in each rise, by speed of the gut.
    gut: [Predictors; GUT.len()],
    /// Insulin action in each rise, by speed of the depot.
    depot: [Predictors; DEPOT.len()],
    /// Prior means of the rise per gram and of the fall per unit.
    priors: (f64, f64),
}

/// One fit.
struct OffsetFit {
    evidence: f64,
    /// Half the squared residual of each rise.
    losses: Vec<f64>,
}

impl SensorFit {
    /// Prepares the regression; `None` with fewer than two days of rises or no insulin.
    pub(super) fn new(doses: &DoseSteps<'_>) -> Option<Self> {
        let record = &doses.person.record;
        let cgm = record.cgm();
        let n = record.len();
        let reach = LARGEST as usize;
        let steps: Vec<usize> = (reach..n.saturating_sub(reach + RISE)).step_by(RISE).collect();
        let rises: Vec<Option<f64>> =
            steps.iter().map(|k| Some(cgm[k + RISE]? - cgm[*k]?)).collect();
        if rises.iter().flatten().count() < 2 * STEPS_PER_DAY / RISE {
            return None;
        }
        let mean = cgm.iter().flatten().sum::<f64>() / cgm.iter().flatten().count() as f64;
        let start = (record.time(0).time().num_seconds_from_midnight() / 60) as usize;
        let wave = |k: usize| TAU * ((start + 5 * k) % 1440) as f64 / 1440.0;
        let base: [Vec<f64>; BASE] = [
            vec![1.0; steps.len()],
            steps.iter().map(|k| cgm[*k].map_or(0.0, |glucose| glucose - mean)).collect(),
            steps.iter().map(|k| wave(*k).cos()).collect(),
            steps.iter().map(|k| wave(*k).sin()).collect(),
        ];
        let whitening = RiseWhitening::of(&rises, &base)?;
        let days = whitening.rows.iter().map(|row| steps[*row] / STEPS_PER_DAY).collect();
        let rises: Vec<f64> = rises.iter().map(|rise| rise.unwrap_or(0.0)).collect();

        let columns = |amounts: &[f64], times: &[f64]| -> Predictors {
            let curve = taken_up(amounts, times);
            let column = |offset: i32| -> Vec<f64> {
                let at = |k: usize| curve[(k as i32 + offset) as usize];
                let values: Vec<f64> = steps.iter().map(|k| at(k + RISE) - at(*k)).collect();
                whitening.column(&values)
            };
            (-LARGEST..=LARGEST).step_by(SPACING as usize).map(column).collect()
        };
        let gut = GUT.map(|time| columns(&doses.carbs, &[time, time, SENSOR_LAG]));
        let depot =
            DEPOT.map(|time| columns(&doses.bolus, &[time, time, PLASMA, REMOTE, SENSOR_LAG]));

        let basal: Vec<f64> = record.basal().iter().flatten().copied().collect();
        let basal = basal.iter().sum::<f64>() / basal.len().max(1) as f64 * 24.0;
        let daily = basal + doses.bolus.iter().sum::<f64>() * STEPS_PER_DAY as f64 / n as f64;
        let priors = (RISE_PER_GRAM, CORRECTION_RULE / daily);
        let rises = whitening.column(&rises);
        (daily > 0.0).then_some(Self { rises, days, gut, depot, priors })
    }

    /// How much better the first offsets explain the sensor than the second, over some days. Each is
    /// given the benefit of habit: a shift of both channels by a few minutes, fitted under a prior.
    pub(super) fn compare(&self, first: Offsets, second: Offsets) -> Comparison {
        let (Some(first), Some(second)) = (self.best(first), self.best(second)) else {
            return Comparison { gain: 0.0, z: 0.0 };
        };
        let days = self.days.last().map_or(0, |last| last + 1);
        let mut gains = vec![0.0; days];
        for ((day, first), second) in self.days.iter().zip(&first.losses).zip(&second.losses) {
            gains[*day] += second - first;
        }
        Comparison { gain: first.evidence - second.evidence, z: z_over_days(gains.into_iter()) }
    }

    /// The shift of both channels together that suits best, among those at least `beyond` steps from
    /// none, with the ends of the range that is at most two nats worse.
    pub(super) fn best_common(&self, beyond: i32, distance: i32) -> Option<(i32, i32, i32)> {
        let evidence = |shift: i32| {
            let offsets = Offsets { meals: shift, insulin: shift + distance };
            self.fit(offsets).map(|fit| fit.evidence)
        };
        let shifts =
            (-LARGEST..=LARGEST).step_by(SPACING as usize).filter(|shift| shift.abs() >= beyond);
        let curve: Vec<(i32, f64)> = shifts.filter_map(|s| evidence(s).map(|e| (s, e))).collect();
        let (best, most) = curve.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let near = |(s, e): &&(i32, f64)| *e > most - 2.0 && s.signum() == best.signum();
        let close: Vec<i32> = curve.iter().filter(near).map(|(s, _)| *s).collect();
        Some((best, *close.first()?, *close.last()?))
    }

    fn best(&self, offsets: Offsets) -> Option<OffsetFit> {
        let (centre, spread) = HABIT;
        (-HABIT_RANGE + 1..=HABIT_RANGE + 1)
            .step_by(SPACING as usize)
            .filter_map(|shift| {
                let moved =
                    Offsets { meals: offsets.meals + shift, insulin: offsets.insulin + shift };
                let mut fit = self.fit(moved)?;
                fit.evidence -= 0.5 * ((5.0 * f64::from(shift) - centre) / spread).powi(2);
                Some(fit)
            })
            .max_by(|a, b| a.evidence.total_cmp(&b.evidence))
    }

    /// The fit at some offsets with the speeds that suit best; `None` beyond [`LARGEST`].
    fn fit(&self, offsets: Offsets) -> Option<OffsetFit> {
        let index = |offset: i32| {
            let index = usize::try_from((offset + LARGEST + SPACING / 2).div_euclid(SPACING)).ok();
            index.filter(|index| *index < self.gut[0].len())
        };
        let (meals, insulin) = (index(offsets.meals)?, index(offsets.insulin)?);
        let (rise, fall) = self.priors;
        let (p_rise, p_fall) = ((RULE_CV * rise).powi(-2), (RULE_CV * fall).powi(-2));
        let best = SPEEDS
            .iter()
            .map(|(gut, depot)| {
                let (x, u) = (&self.gut[*gut][meals], &self.depot[*depot][insulin]);
                let (mut xx, mut xu, mut uu) = (p_rise, 0.0, p_fall);
                let (mut xy, mut uy) = (p_rise * rise, p_fall * fall);
                for ((x, u), y) in x.iter().zip(u).zip(&self.rises) {
                    xx += x * x;
                    xu -= x * u;
                    uu += u * u;
                    xy += x * y;
                    uy -= u * y;
                }
                let determinant = xx * uu - xu * xu;
                let a = (uu * xy - xu * uy) / determinant;
                let b = (xx * uy - xu * xy) / determinant;
                (0.5 * (a * xy + b * uy) - 0.5 * determinant.ln(), a, b, x, u)
            })
            .max_by(|a, b| a.0.total_cmp(&b.0))?;
        let (evidence, a, b, x, u) = best;
        let losses = x.iter().zip(u).zip(&self.rises);
        let losses = losses.map(|((x, u), y)| 0.5 * (y - a * x + b * u).powi(2)).collect();
        Some(OffsetFit { evidence, losses })
    }
}

/// Amount taken up by the start of each step: doses through compartments in series with the given
/// time constants, min, summed over time.
fn taken_up(doses: &[f64], times: &[f64]) -> Vec<f64> {
    let keep: Vec<f64> =
        times.iter().map(|time| (-60.0 / STEPS_PER_HOUR as f64 / time).exp()).collect();
    let mut state = vec![0.0; times.len()];
    let mut total = 0.0;
    let mut curve = Vec::with_capacity(doses.len() + 1);
    curve.push(0.0);
    for dose in doses {
        let mut flow = *dose;
        for (state, keep) in state.iter_mut().zip(&keep) {
            *state = *keep * *state + (1.0 - keep) * flow;
            flow = *state;
        }
        total += flow;
        curve.push(total);
    }
    curve
}

/// The transformation that makes residuals white, of equal size, and free of the base.
struct RiseWhitening {
    /// Coefficients of the autoregression.
    phi: [f64; ORDER],
    /// Rises whose predecessors are known.
    rows: Vec<usize>,
    /// Weight of each of them: Huber's, over the standard deviation.
    weights: Vec<f64>,
    /// The base, whitened and made orthonormal.
    base: Vec<Vec<f64>>,
}

impl RiseWhitening {
    fn of(rises: &[Option<f64>], base: &[Vec<f64>; BASE]) -> Option<Self> {
        let filled: Vec<f64> = rises.iter().map(|rise| rise.unwrap_or(0.0)).collect();
        // Without a weight, a rise that is not known adds nothing to a sum.
        let known = rises.iter().map(|rise| f64::from(rise.is_some())).collect();
        let plain = Self::with([0.0; ORDER], (0..rises.len()).collect(), known, base);
        let residual = plain.column(&filled);
        let lagged = |lag: usize| {
            let products = |of: &[f64]| of.iter().zip(&of[lag..]).map(|(a, b)| a * b).sum::<f64>();
            products(&residual) / products(&plain.weights).max(1.0)
        };
        let (c_0, c_1, c_2) = (lagged(0), lagged(1), lagged(2));
        let determinant = c_0 * c_0 - c_1 * c_1;
        if determinant.is_nan() || determinant <= 0.0 {
            return None;
        }
        let phi = [(c_0 * c_1 - c_1 * c_2) / determinant, (c_0 * c_2 - c_1 * c_1) / determinant];
        let known = |row: usize| (0..=ORDER).all(|back| rises[row - back].is_some());
        let rows: Vec<usize> = (ORDER..rises.len()).filter(|row| known(*row)).collect();
        let even = Self::with(phi, rows.clone(), vec![1.0; rows.len()], base);
        let residual: Vec<Option<f64>> = even.column(&filled).into_iter().map(Some).collect();
        let scale = robust_scale(&residual).max(SMALLEST_SD);
        let weight = |e: &f64| (BEND * scale / e.abs()).min(1.0).sqrt() / scale;
        Some(Self::with(phi, rows, residual.iter().flatten().map(weight).collect(), base))
    }

    /// With these coefficients, rows and weights, and the base whitened by them.
    fn with(
        phi: [f64; ORDER],
        rows: Vec<usize>,
        weights: Vec<f64>,
        base: &[Vec<f64>; BASE],
    ) -> Self {
        let mut found = Self { phi, rows, weights, base: Vec::with_capacity(BASE) };
        for column in base {
            let mut values = found.column(column);
            let norm = values.iter().map(|v| v * v).sum::<f64>().sqrt();
            if norm > 1e-9 {
                values.iter_mut().for_each(|value| *value /= norm);
                found.base.push(values);
            }
        }
        found
    }

    /// A column, whitened, weighted and without the base.
    fn column(&self, column: &[f64]) -> Vec<f64> {
        let [first, second] = self.phi;
        // A rise without two before it is kept only where `phi` is zero.
        let before = |row: usize, back: usize| row.checked_sub(back).map_or(0.0, |row| column[row]);
        let white = |row: usize| column[row] - first * before(row, 1) - second * before(row, 2);
        let rows = self.rows.iter().zip(&self.weights);
        let mut values: Vec<f64> = rows.map(|(row, weight)| weight * white(*row)).collect();
        for direction in &self.base {
            let product: f64 = values.iter().zip(direction).map(|(v, d)| v * d).sum();
            for (value, direction) in values.iter_mut().zip(direction) {
                *value -= product * direction;
            }
        }
        values
    }
}
