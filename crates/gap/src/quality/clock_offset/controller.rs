//! When a controller answered the sensor: the insulin clock of automated delivery.
//!
//! A closed loop changes its basal rate at once when a reading changes. If the insulin clock runs
//! `m` minutes late against the sensor's, changes of the rate follow changes of glucose by `m`. The
//! share of the variance of rate changes that the readings `m` minutes before explain peaks there,
//! within one or two steps.

use physiology::STEPS_PER_DAY;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::Minutes95;

/// Largest delay that is searched, steps: 3 h.
const SEARCHED: usize = 36;
/// Changes of the basal rate a day from which something answers the sensor. The import of T1D-UOM
/// draws the line at 48; a programme changes fewer than 24 times.
const CHANGES_A_DAY: f64 = 48.0;
/// Smallest share of the variance that a real answer explains. Chance explains a few thousandths;
/// the loops that were looked at 0.2 to 0.4.
const SMALLEST_SHARE: f64 = 0.05;
/// How many times the median over all delays the peak must be.
const PROMINENCE: f64 = 5.0;
/// Rises of glucose that explain a change of the rate: those of the last four steps.
const RISES: usize = 4;
/// Regressors: a constant and the rises.
const REGRESSORS: usize = RISES + 1;
/// Bootstrap replicates over days.
const REPLICATES: usize = 50;
/// A delay is known to a step, and a controller may take one to answer, min.
const GRID: f64 = 5.0;

/// Sums for a least-squares fit: upper triangle of the regressors' products with themselves, their
/// products with the answer, and the answer's sum of squares.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    xx: [[f64; REGRESSORS]; REGRESSORS],
    xy: [f64; REGRESSORS],
    yy: f64,
}

impl Sums {
    fn add(&mut self, x: &[f64; REGRESSORS], y: f64) {
        for (a, x_a) in x.iter().enumerate() {
            for (b, x_b) in x.iter().enumerate().skip(a) {
                self.xx[a][b] += x_a * x_b;
            }
            self.xy[a] += x_a * y;
        }
        self.yy += y * y;
    }

    fn merge(&mut self, other: &Self) {
        for a in 0..REGRESSORS {
            for b in a..REGRESSORS {
                self.xx[a][b] += other.xx[a][b];
            }
            self.xy[a] += other.xy[a];
        }
        self.yy += other.yy;
    }

    /// Share of the answer's sum of squares that the fit explains, by Cholesky factorisation.
    fn explained(&self) -> f64 {
        let mut l = [[0.0; REGRESSORS]; REGRESSORS];
        let mut z = [0.0; REGRESSORS];
        let mut explained = 0.0;
        for i in 0..REGRESSORS {
            for j in 0..=i {
                let inner: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
                let left = self.xx[j][i] - inner;
                l[i][j] = if i == j { left.max(1e-9).sqrt() } else { left / l[j][j] };
            }
            let inner: f64 = (0..i).map(|k| l[i][k] * z[k]).sum();
            z[i] = (self.xy[i] - inner) / l[i][i];
            explained += z[i] * z[i];
        }
        if self.yy > 0.0 { explained / self.yy } else { 0.0 }
    }
}

/// The delay of rate changes behind the sensor, recorded minus actual; `None` where no controller's
/// answer is seen.
pub(super) fn delay(basal: &[Option<f64>], cgm: &[Option<f64>]) -> Option<Minutes95> {
    let n = basal.len().min(cgm.len());
    let change = |k: usize| Some(basal[k]? - basal[k.checked_sub(1)?]?);
    let changes: Vec<Option<f64>> = (0..n).map(change).collect();
    let days = n as f64 / STEPS_PER_DAY as f64;
    let moved = changes.iter().flatten().filter(|change| change.abs() > 1e-9).count();
    if days < 2.0 || (moved as f64) < CHANGES_A_DAY * days {
        return None;
    }
    let rise = |k: usize| Some(cgm[k]? - cgm[k.checked_sub(1)?]?);
    let rises: Vec<Option<f64>> = (0..n).map(rise).collect();
    let mut days = vec![[Sums::default(); 2 * SEARCHED + 1]; n.div_ceil(STEPS_PER_DAY)];
    for (k, change) in changes.iter().enumerate() {
        let Some(change) = *change else { continue };
        let day = &mut days[k / STEPS_PER_DAY];
        for (place, sums) in day.iter_mut().enumerate() {
            // At place SEARCHED + m, the rate changed m steps after the reading.
            let Some(reading) = (k + SEARCHED).checked_sub(place) else { continue };
            if reading >= n || reading < RISES {
                continue;
            }
            let mut x = [1.0; REGRESSORS];
            let known = (0..RISES).all(|back| match rises[reading - back] {
                Some(rise) => {
                    x[back + 1] = rise;
                    true
                }
                None => false,
            });
            if known {
                sums.add(&x, change);
            }
        }
    }
    let (place, share, median) = peak(days.iter());
    if share < SMALLEST_SHARE || share < PROMINENCE * median {
        return None;
    }
    let minutes = |place: usize| 5.0 * (place as f64 - SEARCHED as f64);
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let (mut lower, mut upper) = (minutes(place), minutes(place));
    let mut drawn: Vec<f64> = (0..REPLICATES)
        .map(|_| {
            let sample = (0..days.len()).map(|_| &days[rng.random_range(0..days.len())]);
            minutes(peak(sample).0)
        })
        .collect();
    drawn.sort_by(f64::total_cmp);
    // 2.5 % of 50 on each side: the second from each end.
    lower = lower.min(drawn[1]) - GRID;
    upper = upper.max(drawn[REPLICATES - 2]) + GRID;
    Some(Minutes95 { value: minutes(place), lower, upper })
}

/// Place of the largest explained share, that share, and the median share over all places.
fn peak<'a>(days: impl Iterator<Item = &'a [Sums; 2 * SEARCHED + 1]>) -> (usize, f64, f64) {
    let mut total = [Sums::default(); 2 * SEARCHED + 1];
    for day in days {
        for (total, sums) in total.iter_mut().zip(day) {
            total.merge(sums);
        }
    }
    let shares = total.map(|sums| sums.explained());
    let (place, share) = shares.iter().enumerate().fold((0, 0.0), |best, (place, share)| {
        if *share > best.1 { (place, *share) } else { best }
    });
    let mut sorted = shares;
    sorted.sort_by(f64::total_cmp);
    (place, share, sorted[SEARCHED])
}
