//! A person in one fold: trained on the other days, judged on the fold's.

use std::cmp::Ordering;
use std::ops::Range;

use super::drivers::{self, Driver};
use super::folds::Folds;
use super::hidden::Hidden;
use super::judge::{Candidate, Day, Floor, HeldOut};
use super::reconstruction::{Linear, Strength, Tally};
use super::refit::{Equations, Fit, Training};
use super::settings::Settings;
use super::subject::Subject;
use super::summary::Pair;
use crate::error::GapError;
use crate::filter::calibration::CalibrationRule;

/// Glucose that drivers see on days held out while the others train, mg/dL: nothing happens at it.
const UNKNOWN: f64 = 120.0;

/// A person in one fold.
pub(super) struct Unit<'a> {
    pub(super) subject: usize,
    pub(super) fold: usize,
    pub(super) folds: &'a Folds,
    pub(super) training: Training<'a>,
    pub(super) before: Fit,
    pub(super) after: Fit,
    /// The last equations of the fit with effects, and the fit at which they were taken.
    about: Option<(Fit, Equations)>,
    /// Length of the latest step of each fit, in posterior standard deviations.
    lengths: [Option<f64>; 2],
    /// Whether the fit with effects has not moved since they were taken.
    fresh: bool,
    /// Whether the fit with effects lies so near to where they were taken that they still hold.
    settled: bool,
    pub(super) failed: Option<GapError>,
}

impl<'a> Unit<'a> {
    pub(super) fn new(index: usize, fold: usize, subject: &'a Subject<'a>) -> Self {
        let calibration = subject.input.calibration;
        let mut glucose = subject.course.glucose.clone();
        if let Some(block) = subject.folds.held_out(fold) {
            glucose[block].fill(UNKNOWN);
        }
        let fit = Fit {
            factors: calibration.factors,
            amplitudes: Vec::new(),
            autoregression: calibration.autoregression,
            scale: calibration.scale.max(1.0),
        };
        Self {
            subject: index,
            fold,
            folds: &subject.folds,
            training: Training {
                observations: subject.input.observations,
                model: &calibration.model,
                stretches: subject.folds.training(fold),
                drivers: subject.drivers.clone(),
                whole: &subject.course,
                glucose,
            },
            after: Fit { amplitudes: subject.starts.clone(), ..fit.clone() },
            before: fit,
            about: None,
            lengths: [None; 2],
            fresh: false,
            settled: false,
            failed: None,
        }
    }
}

impl Unit<'_> {
    /// The fit with effects starts where the one without them came to.
    pub(super) fn start_after(&mut self) {
        let amplitudes = std::mem::take(&mut self.after.amplitudes);
        self.after = Fit { amplitudes, ..self.before.clone() };
    }

    /// One iteration of the fit without effects; whether another is expected to move it by less than the
    /// calibration's tolerance.
    pub(super) fn iterate_before(&mut self, rule: &CalibrationRule) -> bool {
        match self.training.equations(&mut self.before, rule) {
            Ok(equations) => {
                let length = equations.step(&mut self.before, Vec::new(), rule.bound);
                settles(&mut self.lengths[0], length, rule.tolerance)
            }
            Err(error) => {
                self.failed = Some(error);
                true
            }
        }
    }

    /// Takes the equations of the fit with effects anew, unless those at hand still hold.
    pub(super) fn take_equations(&mut self, rule: &CalibrationRule) {
        if self.failed.is_some() || self.settled || self.fresh {
            return;
        }
        match self.training.equations(&mut self.after, rule) {
            Ok(equations) => self.about = Some((self.after.clone(), equations)),
            Err(error) => {
                self.about = None;
                self.failed = Some(error);
            }
        }
    }

    /// The equations of the fit with effects; `None` for a unit that has failed.
    pub(super) fn equations(&self) -> Option<&Equations> {
        self.about.as_ref().map(|(_, equations)| equations)
    }

    /// Moves the fit with effects to where its equations lead at these amplitudes.
    pub(super) fn move_after(&mut self, amplitudes: Vec<f64>, rule: &CalibrationRule) {
        if self.training.drivers.iter().all(|driver| !driver.signalled) {
            // Nothing acts: it stays the fit without effects.
            self.after.amplitudes = amplitudes;
            self.settled = true;
        } else if let Some((at, equations)) = &self.about {
            self.after = at.clone();
            self.fresh = false;
            let length = equations.step(&mut self.after, amplitudes, rule.bound);
            self.settled |= settles(&mut self.lengths[1], length, rule.tolerance);
        }
    }

    /// The equations of an effect's variants side by side, each at amplitude zero, followed by the other
    /// effects; `None` for a unit that has failed or fails at it.
    pub(super) fn equations_of_variants(
        &mut self,
        index: usize,
        tried: usize,
        rule: &CalibrationRule,
    ) -> Option<(Fit, Equations)> {
        if self.failed.is_some() {
            return None;
        }
        // Some may read glucose where the variant in use does not.
        let own = Driver { reads_glucose: true, ..self.training.drivers[index] };
        let mut drivers: Vec<Driver<'_>> =
            (0..tried).map(|variant| Driver { variant, ..own }).collect();
        let mut fit = Fit { amplitudes: vec![0.0; tried], ..self.before.clone() };
        for (other, driver) in self.training.drivers.iter().enumerate() {
            if other != index {
                drivers.push(*driver);
                fit.amplitudes.push(self.after.amplitudes[other]);
            }
        }
        let mut training = Training {
            observations: self.training.observations,
            model: self.training.model,
            stretches: self.training.stretches.clone(),
            drivers,
            whole: self.training.whole,
            glucose: self.training.glucose.clone(),
        };
        let equations = training.equations(&mut fit, rule).ok()?;
        Some((fit, equations))
    }

    /// Gives an effect the variant that was found best among `tried`. The fit with effects starts where they were
    /// compared: `about` is what [`equations_of_variants`](Self::equations_of_variants) gave.
    pub(super) fn set_variant(
        &mut self,
        index: usize,
        variant: usize,
        tried: usize,
        about: Option<(Fit, Equations)>,
    ) {
        let driver = self.training.drivers[index];
        if driver.variant != variant {
            self.training.drivers[index] =
                Driver::new(driver.effect, variant, &self.training.course());
        }
        // Where its own stands among those that were compared, with the others after them.
        let own = |effect: usize| match effect.cmp(&index) {
            Ordering::Less => tried + effect,
            Ordering::Equal => variant,
            Ordering::Greater => tried + effect - 1,
        };
        if let Some((mut fit, equations)) = about.filter(|_| variant < tried) {
            let kept: Vec<usize> = (0..self.training.drivers.len()).map(own).collect();
            fit.amplitudes = kept.iter().map(|column| fit.amplitudes[*column]).collect();
            self.about = Some((fit, equations.restricted(&kept)));
            self.fresh = true;
        }
    }

    /// What training days say about each hidden effect.
    ///
    /// # Errors
    /// As [`filter`](crate::filter::kalman::filter()).
    pub(super) fn tallies(
        &self,
        subject: &Subject<'_>,
        hidden: &[(usize, Strength)],
        rule: &CalibrationRule,
    ) -> Result<Vec<Tally>, GapError> {
        let mut tallies = vec![Tally::default(); hidden.len()];
        let course = self.training.course();
        for range in &self.training.stretches {
            let mut linear = self.linear(range, rule)?;
            for (tally, (index, strength)) in tallies.iter_mut().zip(hidden) {
                if let Some(form) = &subject.forms[*index] {
                    let (_, counted) = linear.reconstruct(form, *strength, range, &course)?;
                    *tally = tally.plus(counted);
                }
            }
        }
        Ok(tallies)
    }

    /// The innovations of a stretch under the fit with effects.
    fn linear(&self, range: &Range<usize>, rule: &CalibrationRule) -> Result<Linear<'_>, GapError> {
        let training = &self.training;
        let modulations = drivers::modulations(
            &training.drivers,
            &self.after.amplitudes,
            &training.driving(),
            |_| true,
        );
        Linear::new(training.observations, training.model, range, &modulations, &self.after, rule)
    }

    /// The unit's days, judged with both fits, and with hidden changes reconstructed where there are.
    pub(super) fn judged(
        &self,
        subject: &Subject<'_>,
        hidden: &[usize],
        strengths: &[Vec<Strength>],
        settings: Settings<'_>,
    ) -> Result<Judged, GapError> {
        if let Some(error) = &self.failed {
            return Err(error.clone());
        }
        let mut judged =
            Judged { subject: self.subject, predicted: Vec::new(), reconstructed: Vec::new() };
        let Some(block) = self.folds.held_out(self.fold) else { return Ok(judged) };
        let held_out = HeldOut {
            observations: self.training.observations,
            model: self.training.model,
            whole_days: &self.folds.whole_days(&block),
            block: &block,
            settings,
        };
        let mut course = self.training.course();
        let before = Candidate { fit: &self.before, drivers: &[], hidden: None };
        let before = held_out.judge(&before, &mut course, Floor::Skip)?;
        let after = if self.training.drivers.is_empty() {
            before.clone()
        } else {
            let drivers = &self.training.drivers;
            let candidate = Candidate { fit: &self.after, drivers, hidden: None };
            held_out.judge(&candidate, &mut course, Floor::Take)?
        };
        if !hidden.is_empty() {
            let mut linear = self.linear(&held_out.seen(), settings.calibration)?;
            let mut changes = Hidden::default();
            for (place, strength) in hidden.iter().zip(&strengths[self.fold]) {
                if let Some(form) = &subject.forms[*place] {
                    changes.extend(linear.reconstruct(form, *strength, &block, &course)?.0);
                }
            }
            let drivers = &self.training.drivers;
            let candidate = Candidate { fit: &self.after, drivers, hidden: Some(&changes) };
            let known = held_out.judge(&candidate, &mut course, Floor::Skip)?;
            judged.reconstructed = pairs(after.clone(), known);
        }
        judged.predicted = pairs(before, after);
        Ok(judged)
    }
}

/// Whether the step after one of this length is expected to be shorter than `tolerance`: steps shrink by much the
/// same ratio. `latest` is the length of the step before, and becomes this one's.
fn settles(latest: &mut Option<f64>, length: f64, tolerance: f64) -> bool {
    let ratio = latest.replace(length).map_or(1.0, |before| length / before.max(length));
    length * ratio < tolerance
}

/// A person's days of one fold, by number.
pub(super) struct Judged {
    pub(super) subject: usize,
    pub(super) predicted: Vec<(usize, Pair)>,
    pub(super) reconstructed: Vec<(usize, Pair)>,
}

fn pairs(before: Vec<(usize, Day)>, after: Vec<(usize, Day)>) -> Vec<(usize, Pair)> {
    let pair =
        |((day, before), (_, after)): ((usize, Day), (usize, Day))| (day, Pair { before, after });
    before.into_iter().zip(after).map(pair).collect()
}
