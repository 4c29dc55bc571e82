//! The ambulatory glucose profile (AGP): percentiles of glucose by time of day.
//!
//! As in the international consensus on CGM reports (Battelino et al. 2019): the median with the
//! 25th to 75th and the 5th to 95th percentile, over all days together.

use contract::agp::Percentiles;

use crate::error::StatsError;
use crate::quantile::quantile;

/// The percentiles of a profile, per cent.
pub const PERCENTILES: [f64; 5] = [5.0, 25.0, 50.0, 75.0, 95.0];

/// The profile of `samples`, each a slot of the day (0 to `slots` - 1) and a glucose, mg/dL.
///
/// Percentiles interpolate linearly between order statistics (type 7 of Hyndman and Fan).
///
/// # Errors
/// [`StatsError::NonFinite`] for a glucose that is not a finite number and
/// [`StatsError::OutOfDomain`] for a slot beyond the day.
pub fn percentiles(
    samples: impl IntoIterator<Item = (usize, f64)>,
    slots: usize,
) -> Result<Percentiles, StatsError> {
    let mut by_slot: Vec<Vec<f64>> = vec![Vec::new(); slots];
    for (index, (slot, value)) in samples.into_iter().enumerate() {
        if !value.is_finite() {
            return Err(StatsError::NonFinite { what: "glucose sample", index, value });
        }
        let Some(there) = by_slot.get_mut(slot) else {
            let (name, value) = ("slot of the day", slot as f64);
            return Err(StatsError::OutOfDomain { name, value, expected: "below the slots" });
        };
        there.push(value);
    }
    by_slot.iter_mut().for_each(|values| values.sort_by(f64::total_cmp));
    let [p05, p25, p50, p75, p95] = PERCENTILES.map(|percent| {
        by_slot
            .iter()
            .map(|values| (!values.is_empty()).then(|| quantile(values, percent / 100.0)))
            .collect()
    });
    Ok(Percentiles { p05, p25, p50, p75, p95 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_of_each_slot_by_themselves() {
        // 0, 1, ..., 100 in slot 0: the percentiles are their own names; one value in slot 2.
        let samples = (0..=100).rev().map(|k| (0, f64::from(k))).chain([(2, 90.0)]);
        let profile = percentiles(samples, 3).expect("valid");
        let slot = |k: usize| {
            [&profile.p05, &profile.p25, &profile.p50, &profile.p75, &profile.p95].map(|p| p[k])
        };
        for (found, expected) in slot(0).iter().zip(PERCENTILES) {
            assert!((found.expect("samples") - expected).abs() < 1e-9); // rounding of p times n
        }
        assert_eq!(slot(1), [None; 5]);
        assert_eq!(slot(2), [Some(90.0); 5]);
    }

    #[test]
    fn what_is_no_glucose_or_no_slot_is_refused() {
        assert!(percentiles([(0, f64::NAN)], 1).is_err());
        assert!(percentiles([(1, 100.0)], 1).is_err());
    }
}
