//! A person in one fold: trained on the other days, judged on the fold's.

use std::ops::Range;

use super::Subject;
use super::drivers::{self, Driver};
use super::judge::{CandidateFit, HeldOutBlock, HeldOutDay};
use super::reconstruction::{Hidden, Linear, Strength, StrengthSums};
use super::refit::{Equations, Fit, Training};
use super::summary::Pair;
use crate::config::DiagnosisConfig;
use crate::error::GapError;
use crate::filter::calibration::CalibrationRule;
use crate::filter::scored::Whitening;

/// Most Gauss-Newton iterations of the fits before and after alike; a fit ends earlier where the next step is
/// expected to be within the tolerance of the calibration.
pub(super) const ITERATIONS: usize = 3;
/// Glucose that drivers see on days held out while the others train, mg/dL: nothing happens at it.
const UNKNOWN: f64 = 120.0;

/// A person in one fold.
pub(super) struct PersonFold<'a> {
    pub(super) subject: &'a Subject<'a>,
    pub(super) fold: usize,
    /// Steps held out.
    block: Range<usize>,
    training: Training<'a>,
    before: Fit,
    pub(super) after: Fit,
    /// Length of the latest step of the fit with effects, in posterior standard deviations.
    length: Option<f64>,
    state: State,
}

/// How far the fit with effects is.
enum State {
    /// Its equations have to be taken.
    Due,
    /// The fit at which its equations were taken, they, and whether it lies so near that they still hold.
    Taken(Fit, Box<Equations>, bool),
    /// A fit is impossible.
    Failed(GapError),
}

impl<'a> PersonFold<'a> {
    /// A person with the fit without effects, where the one with effects starts; `None` where nothing of her record is
    /// held out in the fold.
    pub(super) fn new(
        subject: &'a Subject<'a>,
        fold: usize,
        rule: &CalibrationRule,
    ) -> Option<Self> {
        let block = subject.folds.held_out(fold)?;
        let calibration = subject.input.calibration;
        let mut glucose = subject.course.glucose.clone();
        glucose[block.clone()].fill(UNKNOWN);
        let mut training = Training {
            observations: subject.input.observations,
            model: &calibration.model,
            stretches: subject.folds.training(fold),
            drivers: subject.drivers.clone(),
            whole: &subject.course,
            glucose,
        };
        let mut before = Fit {
            factors: calibration.factors,
            amplitudes: Vec::new(),
            whitening: Whitening {
                autoregression: calibration.autoregression,
                scale: calibration.scale.max(1.0),
            },
        };
        let mut fit_before = || -> Result<(), GapError> {
            let mut latest = None;
            for _ in 0..ITERATIONS {
                let equations = training.equations(&mut before, rule)?;
                let length = equations.step(&mut before, Vec::new(), rule.bound);
                if settles(&mut latest, length, rule.tolerance) {
                    break;
                }
            }
            Ok(())
        };
        let state = fit_before().map_or_else(State::Failed, |()| State::Due);
        let after = Fit { amplitudes: subject.starts.clone(), ..before.clone() };
        Some(Self { subject, fold, block, training, before, after, length: None, state })
    }

    /// Takes the equations of the fit with effects again, unless those at hand still hold.
    pub(super) fn take_equations(&mut self, rule: &CalibrationRule) {
        if matches!(self.state, State::Due) {
            self.state = match self.training.equations(&mut self.after, rule) {
                Ok(equations) => State::Taken(self.after.clone(), Box::new(equations), false),
                Err(error) => State::Failed(error),
            };
        }
    }

    /// The equations of the fit with effects; `None` where they are due, and for a unit that has failed.
    pub(super) fn equations(&self) -> Option<&Equations> {
        match &self.state {
            State::Taken(_, equations, _) => Some(equations),
            State::Due | State::Failed(_) => None,
        }
    }

    /// Moves the fit with effects to where its equations lead at these amplitudes.
    pub(super) fn move_after(&mut self, amplitudes: Vec<f64>, rule: &CalibrationRule) {
        let State::Taken(at, equations, near) = &mut self.state else { return };
        if self.training.drivers.iter().all(|driver| !driver.signalled) {
            // Nothing acts: it stays the fit without effects.
            self.after.amplitudes = amplitudes;
            *near = true;
        } else {
            self.after = at.clone();
            let length = equations.step(&mut self.after, amplitudes, rule.bound);
            *near |= settles(&mut self.length, length, rule.tolerance);
            if !*near {
                self.state = State::Due;
            }
        }
    }

    /// The equations of an effect's variants side by side, each at amplitude zero, followed by the other
    /// effects; `None` for a unit that has failed or fails at it.
    pub(super) fn equations_of_variants(
        &self,
        index: usize,
        tried: usize,
        rule: &CalibrationRule,
    ) -> Option<(Fit, Equations)> {
        if matches!(self.state, State::Failed(_)) {
            return None;
        }
        let (mut others, mut amplitudes) =
            (self.training.drivers.clone(), self.after.amplitudes.clone());
        // Some may read glucose where the variant in use does not.
        let own = Driver { reads_glucose: true, ..others.remove(index) };
        let variants = (0..tried).map(|variant| Driver { variant, ..own });
        let drivers = variants.chain(others).collect();
        amplitudes.remove(index);
        let amplitudes = [vec![0.0; tried], amplitudes].concat();
        let mut fit = Fit { amplitudes, ..self.before.clone() };
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
        if let Some((mut fit, equations)) = about.filter(|_| variant < tried) {
            // Its own among those that were compared, and the others after them.
            let mut kept: Vec<usize> = (tried..fit.amplitudes.len()).collect();
            kept.insert(index, variant);
            fit.amplitudes = kept.iter().map(|column| fit.amplitudes[*column]).collect();
            self.state = State::Taken(fit, Box::new(equations.restricted(&kept)), false);
        }
    }

    /// What hidden effects did in the steps of `within`, and how often, by the innovations of a filter that runs over
    /// `span` under the fit with effects: an entry an effect.
    fn reconstructed(
        &self,
        hidden: &[(usize, Strength)],
        span: &Range<usize>,
        within: &Range<usize>,
        rule: &CalibrationRule,
    ) -> Result<Vec<(Vec<Hidden>, StrengthSums)>, GapError> {
        let Self { subject, after, training, .. } = self;
        let Training { observations, model, drivers, .. } = training;
        let course = training.driving();
        let modulations = drivers::modulations(drivers, &after.amplitudes, &course, |_| true);
        let mut linear = Linear::new(observations, model, span, &modulations, after, rule)?;
        let of = |(index, strength): &(usize, Strength)| match &subject.forms[*index] {
            Some(form) => linear.reconstruct(form, *strength, within, &subject.course),
            None => Ok((Vec::new(), StrengthSums::default())),
        };
        hidden.iter().map(of).collect()
    }

    /// What training days say about each hidden effect.
    ///
    /// # Errors
    /// As [`filter`](crate::filter::kalman::filter()).
    pub(super) fn tallies(
        &self,
        hidden: &[(usize, Strength)],
        rule: &CalibrationRule,
    ) -> Result<Vec<StrengthSums>, GapError> {
        let mut tallies = vec![StrengthSums::default(); hidden.len()];
        for range in &self.training.stretches {
            let found = self.reconstructed(hidden, range, range, rule)?;
            for (tally, (_, counted)) in tallies.iter_mut().zip(found) {
                *tally = tally.plus(counted);
            }
        }
        Ok(tallies)
    }

    /// The unit's days judged with both fits, and those with hidden changes reconstructed as well where there are.
    pub(super) fn judged(
        &self,
        strengths: &[Vec<(usize, Strength)>],
        config: &DiagnosisConfig,
    ) -> Result<(Vec<Pair>, Vec<Pair>), GapError> {
        if let State::Failed(error) = &self.state {
            return Err(error.clone());
        }
        let Training { observations, model, drivers, .. } = &self.training;
        let block = &self.block;
        let whole_days = &self.subject.folds.whole_days(block);
        let held_out = HeldOutBlock { observations, model, block, whole_days, config };
        let mut course = self.training.course();
        let before = CandidateFit { fit: &self.before, drivers: &[], hidden: &[], floor: false };
        let before = held_out.judge(&before, &mut course)?;
        let with_effects = CandidateFit { fit: &self.after, drivers, hidden: &[], floor: true };
        let after = if drivers.is_empty() {
            before.clone()
        } else {
            held_out.judge(&with_effects, &mut course)?
        };
        let (strengths, mut reconstructed) = (&strengths[self.fold], Vec::new());
        if !strengths.is_empty() {
            let (span, rule) = (held_out.filtered_steps(), &config.calibration);
            let found = self.reconstructed(strengths, &span, block, rule)?;
            let hidden: Vec<Hidden> = found.into_iter().flat_map(|(hidden, _)| hidden).collect();
            let known = CandidateFit { hidden: &hidden, floor: false, ..with_effects };
            reconstructed = pairs(after.clone(), held_out.judge(&known, &mut course)?);
        }
        Ok((pairs(before, after), reconstructed))
    }
}

/// Whether the step after one of this length is expected to be shorter than `tolerance`: steps shrink by much the
/// same ratio. `latest` is the length of the step before, and becomes this one's.
fn settles(latest: &mut Option<f64>, length: f64, tolerance: f64) -> bool {
    let ratio = latest.replace(length).map_or(1.0, |before| length / before.max(length));
    length * ratio < tolerance
}

fn pairs(before: Vec<HeldOutDay>, after: Vec<HeldOutDay>) -> Vec<Pair> {
    before.into_iter().zip(after).map(|(before, after)| Pair { before, after }).collect()
}
