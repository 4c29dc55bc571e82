//! Which innovations are scored: the same ones wherever readings are compared with a filter's predictions.

use std::ops::Range;

use crate::filter::calibration::rule::CalibrationRule;
use crate::filter::kalman::Innovation;
use crate::filter::observations::Observations;

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
