//! When a controller answered the sensor: the insulin clock of automated delivery.
//!
//! A closed loop changes its basal rate at once when a reading changes. If the insulin clock runs
//! `m` minutes late against the sensor's, changes of the rate follow changes of glucose by `m`. The
//! share of the variance of rate changes that rises `m` minutes before explain peaks there,
//! within one or two steps.

use physiology::STEPS_PER_DAY;

use super::{Minutes95, highest, total};

/// Largest delay that is searched, steps: 3 h.
const SEARCHED: usize = 36;
/// Changes of the basal rate a day from which something answers the sensor. The import of T1D-UOM
/// draws the line at 48; a programme changes fewer than 24 times.
pub(super) const CHANGES_A_DAY: f64 = 48.0;
/// Smallest share of the variance that a real answer explains. Chance explains a few thousandths;
/// the loops that were looked at 0.2 to 0.4.
const SMALLEST_SHARE: f64 = 0.05;
/// How many times the median over all delays the peak must be.
const PROMINENCE: f64 = 5.0;
/// Bootstrap replicates over days.
const REPLICATES: usize = 50;
/// A delay is known to a step, and a controller may take one to answer, min.
const GRID: f64 = 5.0;

/// Sums for a correlation of rises of glucose with changes of the rate: their number, both, the squares of both, and
/// their product.
const SUMS: usize = 6;

/// The sums of one day, one after the other by the steps from a reading to a change: from -[`SEARCHED`] to
/// [`SEARCHED`].
type DaySums = [f64; ALL_SUMS];
const ALL_SUMS: usize = SUMS * (2 * SEARCHED + 1);

/// Share of the variance that the two have in common; 0 where the rate goes down as glucose
/// goes up, which is no controller's answer.
fn explained([n, rise, change, rise_rise, change_change, rise_change]: &[f64; SUMS]) -> f64 {
    let product = rise_change - rise * change / n;
    let rises = rise_rise - rise * rise / n;
    let changes = change_change - change * change / n;
    let spread = rises * changes;
    if product > 0.0 && spread > 0.0 { product * product / spread } else { 0.0 }
}

/// The delay of rate changes behind the sensor, recorded minus actual; `None` where no controller's
/// answer is seen.
pub(super) fn delay(basal: &[Option<f64>], cgm: &[Option<f64>]) -> Option<Minutes95> {
    let differences = |values: &[Option<f64>]| -> Vec<Option<f64>> {
        (0..values.len()).map(|k| Some(values[k]? - values[k.checked_sub(1)?]?)).collect()
    };
    let (changes, rises) = (differences(basal), differences(cgm));
    let days = changes.len() as f64 / STEPS_PER_DAY as f64;
    let moved = changes.iter().flatten().filter(|change| change.abs() > 1e-9).count();
    if days < 2.0 || (moved as f64) < CHANGES_A_DAY * days {
        return None;
    }
    let mut days: Vec<DaySums> = vec![[0.0; ALL_SUMS]; changes.len().div_ceil(STEPS_PER_DAY)];
    for (k, change) in changes.iter().enumerate() {
        let Some(change) = *change else { continue };
        let (day, _) = days[k / STEPS_PER_DAY].as_chunks_mut::<SUMS>();
        for (index, sums) in day.iter_mut().enumerate() {
            // At index SEARCHED + m, the rate changed m steps after the reading.
            let reading = (k + SEARCHED).checked_sub(index);
            if let Some(rise) = reading.and_then(|reading| *rises.get(reading)?) {
                let own = [1.0, rise, change, rise * rise, change * change, rise * change];
                for (sum, value) in sums.iter_mut().zip(own) {
                    *sum += value;
                }
            }
        }
    }
    let (_, share, median) = peak(&days);
    if share < SMALLEST_SHARE || share < PROMINENCE * median {
        return None;
    }
    let minutes = |index: usize| 5.0 * (index as f64 - SEARCHED as f64);
    let found = Minutes95::bootstrapped(&days, REPLICATES, |drawn| Some(minutes(peak(drawn).0)))?;
    Some(found.widened(GRID))
}

/// Index of the largest explained share, that share, and the median share over all indices.
fn peak<'a>(days: impl IntoIterator<Item = &'a DaySums>) -> (usize, f64, f64) {
    let total = total(days);
    let mut shares: Vec<f64> = total.as_chunks::<SUMS>().0.iter().map(explained).collect();
    let (index, share) = highest(0..shares.len(), |index| shares[index]);
    shares.sort_by(f64::total_cmp);
    (index, share, shares[SEARCHED])
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// Four days of glucose that wanders, and a rate that answers it `steps` later.
    fn answered(steps: usize) -> (Vec<Option<f64>>, Vec<Option<f64>>) {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut glucose = 140.0;
        let cgm: Vec<f64> = (0..4 * STEPS_PER_DAY)
            .map(|_| {
                glucose += rng.random_range(-5.0..5.0);
                glucose
            })
            .collect();
        let rate = |k: usize| 1.0 + 0.01 * (cgm[k.saturating_sub(steps)] - 140.0);
        ((0..cgm.len()).map(|k| Some(rate(k))).collect(), cgm.iter().copied().map(Some).collect())
    }

    #[test]
    fn the_delay_of_a_controller_is_found_to_a_step() {
        for steps in [0, 6, 18] {
            let (basal, cgm) = answered(steps);
            let found = delay(&basal, &cgm).expect("it answers");
            assert_eq!(found.value, 5.0 * steps as f64);
            assert!(found.upper - found.lower <= 4.0 * GRID, "{found:?}");
        }
    }

    #[test]
    fn a_programme_is_no_controller() {
        let (_, cgm) = answered(0);
        let programme = |k: usize| if k % STEPS_PER_DAY < 96 { 0.8 } else { 1.1 };
        let basal: Vec<_> = (0..cgm.len()).map(|k| Some(programme(k))).collect();
        assert_eq!(delay(&basal, &cgm), None);
        // Nor is a rate that changes at every step for its own reasons.
        let restless: Vec<_> = (0..cgm.len()).map(|k| Some((k * 7919 % 13) as f64)).collect();
        assert_eq!(delay(&restless, &cgm), None);
    }
}
