//! Which innovations are scored and how they are whitened: the same wherever readings are compared with a filter's
//! predictions.

use std::ops::Range;

use crate::filter::calibration::rule::CalibrationRule;
use crate::filter::kalman::Innovation;
use crate::filter::observations::Observations;
use crate::filter::whitening::{Autoregression, HUBER_THRESHOLD, robust_scale};

impl CalibrationRule {
    /// Whether the innovation of each step of a stretch is scored, by a filter that starts with the stretch: not while it
    /// settles, and not while an unrecorded dose may still act.
    pub(crate) fn scored(&self, record: &Observations, stretch: &Range<usize>) -> Vec<bool> {
        let trusted = record.trusted(self.dose_memory);
        let settled = |offset: usize| offset >= self.burn_in;
        stretch.clone().enumerate().map(|(offset, step)| settled(offset) && trusted[step]).collect()
    }
}

/// Innovations in units of their standard deviations; `None` where there is none or it is not scored.
pub(crate) fn normalised(innovations: &[Option<Innovation>], scored: &[bool]) -> Vec<Option<f64>> {
    let both = innovations.iter().zip(scored);
    both.map(|(innovation, scored)| Some(innovation.filter(|_| *scored)?.normalised())).collect()
}

/// How normalised innovations are whitened.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Whitening {
    pub(crate) autoregression: Autoregression,
    /// Standard deviation of what it leaves.
    pub(crate) scale: f64,
}

impl Whitening {
    /// Fits a whitening; also returns what its autoregression leaves, of which `scale` gives the scale.
    pub(crate) fn fitted(
        normalised: &[Option<f64>],
        scale: impl Fn(&[Option<f64>]) -> f64,
    ) -> (Self, Vec<Option<f64>>) {
        let autoregression = Autoregression::fitted(normalised);
        let left = autoregression.whitened(normalised);
        (Self { autoregression, scale: scale(&left) }, left)
    }

    /// Whitened innovations in units of the scale.
    pub(crate) fn standardised(&self, normalised: &[Option<f64>]) -> Vec<Option<f64>> {
        let whitened = self.autoregression.whitened(normalised);
        whitened.into_iter().map(|w| w.map(|w| w / self.scale)).collect()
    }
}

/// Standard deviation with values clipped at Huber's threshold, so that wild readings do not
/// inflate it; 1 where nothing is scored.
pub(crate) fn clipped_scale(whitened: &[Option<f64>]) -> f64 {
    let limit = HUBER_THRESHOLD * robust_scale(whitened);
    let squares = whitened.iter().flatten().map(|w| w.clamp(-limit, limit).powi(2));
    let (n, sum) = (squares.clone().count() as f64, squares.sum::<f64>());
    if sum > 0.0 { f64::sqrt(sum / n) } else { 1.0 }
}

/// The clipped scale, at least 1: readings smoother than the noise model (interpolated ones) are not trusted more for
/// that.
pub(crate) fn cautious_scale(whitened: &[Option<f64>]) -> f64 {
    clipped_scale(whitened).max(1.0)
}
