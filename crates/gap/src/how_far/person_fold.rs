//! A person in one fold: trained on the other days, judged on the fold's.

use std::cmp::Ordering;
use std::ops::Range;

use super::drivers::{self, Driver};
use super::hidden::Hidden;
use super::judge::{CandidateFit, EVERY, Floor, HeldOutBlock, HeldOutDay};
use super::reconstruction::{Linear, Strength, StrengthSums};
use super::refit::{Equations, Fit, Training};
use super::settings::Settings;
use super::subject::Subject;
use super::summary::Pair;
use crate::error::GapError;
use crate::filter::calibration::CalibrationRule;
use crate::filter::scored::Whitening;

/// Glucose that drivers see on days held out while the others train, mg/dL: nothing happens at it.
const UNKNOWN: f64 = 120.0;

/// A person in one fold.
pub(super) struct PersonFold<'a> {
    pub(super) subject: usize,
    pub(super) fold: usize,
    pub(super) training: Training<'a>,
    pub(super) before: Fit,
    pub(super) after: Fit,
    /// Length of the latest step of the fit with effects, in posterior standard deviations.
    length: Option<f64>,
    state: State,
}

/// How far the fits of a unit are.
enum State {
    /// The fit with effects has no equations yet.
    Started,
    /// Its equations, the fit at which they were taken, and where it lies from there.
    Taken(Fit, Box<Equations>, Lies),
    /// A fit is impossible.
    Failed(GapError),
}

/// Where the fit with effects lies from the one at which its equations were taken.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Lies {
    /// It has not moved.
    There,
    /// So near that the equations still hold.
    Near,
    /// So far that they have to be taken again.
    Away,
}

impl<'a> PersonFold<'a> {
    pub(super) fn new(index: usize, fold: usize, subject: &'a Subject<'a>) -> Self {
        let calibration = subject.input.calibration;
        let mut glucose = subject.course.glucose.clone();
        if let Some(block) = subject.folds.held_out(fold) {
            glucose[block].fill(UNKNOWN);
        }
        let fit = Fit {
            factors: calibration.factors,
            amplitudes: Vec::new(),
            whitening: Whitening {
                autoregression: calibration.autoregression,
                scale: calibration.scale.max(1.0),
            },
        };
        Self {
            subject: index,
            fold,
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
            length: None,
            state: State::Started,
        }
    }
}

impl PersonFold<'_> {
    /// Fits without effects, in at most so many iterations. It ends where another iteration is expected to move the fit
    /// by less than the calibration's tolerance; the fit with effects starts there.
    pub(super) fn fit_before(&mut self, iterations: usize, rule: &CalibrationRule) {
        let mut latest = None;
        for _ in 0..iterations {
            match self.training.equations(&mut self.before, rule) {
                Ok(equations) => {
                    let length = equations.step(&mut self.before, Vec::new(), rule.bound);
                    if settles(&mut latest, length, rule.tolerance) {
                        break;
                    }
                }
                Err(error) => {
                    self.state = State::Failed(error);
                    break;
                }
            }
        }
        let amplitudes = std::mem::take(&mut self.after.amplitudes);
        self.after = Fit { amplitudes, ..self.before.clone() };
    }

    /// Takes the equations of the fit with effects again, unless those at hand still hold.
    pub(super) fn take_equations(&mut self, rule: &CalibrationRule) {
        if matches!(self.state, State::Started | State::Taken(_, _, Lies::Away)) {
            self.state = match self.training.equations(&mut self.after, rule) {
                Ok(equations) => State::Taken(self.after.clone(), Box::new(equations), Lies::There),
                Err(error) => State::Failed(error),
            };
        }
    }

    /// The equations of the fit with effects; `None` for a unit that has failed.
    pub(super) fn equations(&self) -> Option<&Equations> {
        match &self.state {
            State::Taken(_, equations, _) => Some(equations),
            State::Started | State::Failed(_) => None,
        }
    }

    /// Moves the fit with effects to where its equations lead at these amplitudes.
    pub(super) fn move_after(&mut self, amplitudes: Vec<f64>, rule: &CalibrationRule) {
        let State::Taken(at, equations, lies) = &mut self.state else { return };
        if self.training.drivers.iter().all(|driver| !driver.signalled) {
            // Nothing acts: it stays the fit without effects.
            self.after.amplitudes = amplitudes;
            *lies = Lies::Near;
        } else {
            self.after = at.clone();
            let length = equations.step(&mut self.after, amplitudes, rule.bound);
            let near = settles(&mut self.length, length, rule.tolerance) || *lies == Lies::Near;
            *lies = if near { Lies::Near } else { Lies::Away };
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
        if matches!(self.state, State::Failed(_)) {
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
        let mut training = Training { drivers, ..self.training.clone() };
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
            self.state = State::Taken(fit, Box::new(equations.restricted(&kept)), Lies::There);
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
    ) -> Result<Vec<StrengthSums>, GapError> {
        let mut tallies = vec![StrengthSums::default(); hidden.len()];
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
        if let State::Failed(error) = &self.state {
            return Err(error.clone());
        }
        let mut judged =
            Judged { subject: self.subject, predicted: Vec::new(), reconstructed: Vec::new() };
        let Some(block) = subject.folds.held_out(self.fold) else { return Ok(judged) };
        let held_out = HeldOutBlock {
            observations: self.training.observations,
            model: self.training.model,
            whole_days: &subject.folds.whole_days(&block),
            block: &block,
            every: EVERY,
            settings,
        };
        let mut course = self.training.course();
        let before = CandidateFit { fit: &self.before, drivers: &[], hidden: &[] };
        let before = held_out.judge(&before, &mut course, Floor::Skip)?;
        let after = if self.training.drivers.is_empty() {
            before.clone()
        } else {
            let drivers = &self.training.drivers;
            let candidate = CandidateFit { fit: &self.after, drivers, hidden: &[] };
            held_out.judge(&candidate, &mut course, Floor::Take)?
        };
        if !hidden.is_empty() {
            let mut linear = self.linear(&held_out.filtered_steps(), settings.calibration)?;
            let mut changes: Vec<Hidden> = Vec::new();
            for (index, strength) in hidden.iter().zip(&strengths[self.fold]) {
                if let Some(form) = &subject.forms[*index] {
                    changes.extend(linear.reconstruct(form, *strength, &block, &course)?.0);
                }
            }
            let drivers = &self.training.drivers;
            let candidate = CandidateFit { fit: &self.after, drivers, hidden: &changes };
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

fn pairs(before: Vec<(usize, HeldOutDay)>, after: Vec<(usize, HeldOutDay)>) -> Vec<(usize, Pair)> {
    let pair = |((day, before), (_, after)): ((usize, HeldOutDay), (usize, HeldOutDay))| {
        (day, Pair { before, after })
    };
    before.into_iter().zip(after).map(pair).collect()
}
