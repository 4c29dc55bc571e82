//! How far effects move glucose: the measured size of a gap.
//!
//! Closed-loop insulin and the person's reactions respond to an effect and hide it. A diagnosis can
//! only see the effect under the insulin that was delivered and the carbohydrate that was logged.
//! So the days are replayed without the effect under both.

use physiology::{Grams, MgPerDl, OpenLoop, StepInput};

use crate::behaviour::Life;
use crate::effects::{Amplitudes, Effect, OutsideEffect, Port, conditions};
use crate::error::WorldError;
use crate::reactions::reactions;
use crate::stream::{Concept, stream};
use crate::virtual_person::{FIRST_GLUCOSE, LivedDays, VirtualPerson};

/// Glucose as it would have been.
#[derive(Debug, Clone, PartialEq)]
pub struct Counterfactual {
    /// True glucose at the start of each step.
    pub glucose: Vec<MgPerDl>,
    /// What a record of the sensor would hold, not rounded; `None` where readings were lost.
    pub sensed: Vec<Option<MgPerDl>>,
}

impl VirtualPerson {
    /// The days that this person lived, replayed with other amplitudes but with the insulin
    /// delivered and the carbohydrate logged in `lived`.
    ///
    /// What is eaten follows the log. With a smaller amplitude of [`Effect::MissedMeals`] or
    /// [`Effect::UnloggedRescueCarbs`], carbohydrate that is missing from the log because of the
    /// difference is not eaten. With another amplitude of [`Effect::CarbMiscount`] a meal has the
    /// size that would have been counted the same.
    ///
    /// # Errors
    /// If the body's model fails.
    pub fn counterfactual(
        &self,
        lived: &LivedDays,
        amplitudes: &Amplitudes,
    ) -> Result<Counterfactual, WorldError> {
        let in_body = |source: ode_sim::OdeError| WorldError::Body { person: self.index, source };
        let happenings = self.happenings(&lived.life);
        let course = conditions(&lived.life, &happenings, &self.shapes, amplitudes);
        let inputs = self.inputs_behind_the_log(lived, amplitudes);
        let steps = inputs.len();
        let run = self
            .body
            .run(
                &course,
                self.shapes.forms.in_body(*amplitudes),
                self.everyday.warps,
                FIRST_GLUCOSE,
                &mut OpenLoop::new(&inputs),
                steps,
            )
            .map_err(in_body)?;
        let mut glucose = run.glucose;
        glucose.truncate(steps);
        let sensed = self.sensed(&lived.life, &glucose, amplitudes)?;
        Ok(Counterfactual { glucose, sensed })
    }

    /// How far the effects that `without` switches off (or weakens) move glucose: the mean absolute
    /// difference between the days as lived and their [counterfactual](Self::counterfactual).
    ///
    /// The glucose is the true one, or what the sensor shows if an effect on the sensor differs.
    ///
    /// # Errors
    /// If the body's model fails.
    pub fn shift(&self, lived: &LivedDays, without: &Amplitudes) -> Result<MgPerDl, WorldError> {
        let other = self.counterfactual(lived, without)?;
        if !self.sensors_differ(without) {
            let pairs = lived.glucose.iter().zip(&other.glucose);
            return Ok(mean_absolute(pairs.map(|(a, b)| a.0 - b.0)));
        }
        let sensed = self.sensed(&lived.life, &lived.glucose, &self.amplitudes)?;
        let pairs = sensed.iter().zip(&other.sensed);
        Ok(mean_absolute(pairs.filter_map(|(a, b)| Some((*a)?.0 - (*b)?.0))))
    }

    /// Whether an effect on the sensor differs from this person's.
    pub(crate) fn sensors_differ(&self, other: &Amplitudes) -> bool {
        let named = |e: &Effect| self.amplitudes.of(*e) != other.of(*e);
        let outside = |e: &OutsideEffect| self.amplitudes.of_outside(*e) != other.of_outside(*e);
        Effect::ALL.iter().any(|e| e.port() == Port::Sensor && named(e))
            || OutsideEffect::ALL.iter().any(|e| e.port() == Port::Sensor && outside(e))
    }

    /// What a record of the sensors of a life holds of a course of glucose, not rounded.
    pub(crate) fn sensed(
        &self,
        life: &Life,
        glucose: &[MgPerDl],
        amplitudes: &Amplitudes,
    ) -> Result<Vec<Option<MgPerDl>>, WorldError> {
        let mut sensors = self.sensors(life, &self.happenings(life), amplitudes);
        let shown = glucose.iter().enumerate().map(|(step, value)| sensors.sense(step, *value));
        let shown: Vec<_> = shown
            .collect::<Result<_, _>>()
            .map_err(|source| WorldError::Body { person: self.index, source })?;
        Ok(self.everyday.sensor.drawn_through(shown.into_iter()))
    }

    /// The inputs of the days, with what is eaten under `amplitudes` for the same log.
    pub(crate) fn inputs_behind_the_log(
        &self,
        lived: &LivedDays,
        amplitudes: &Amplitudes,
    ) -> Vec<StepInput> {
        let mut inputs = lived.inputs.clone();
        let (kept, other) = (self.logging(&self.amplitudes), self.logging(amplitudes));
        if kept == other {
            return inputs;
        }
        for meal in &lived.life.meals {
            let Some(input) = inputs.get_mut(meal.step) else { continue };
            let eaten = match (kept.of_meal(meal), other.of_meal(meal)) {
                // For a meal that both count, the size behind the count.
                (Some(_), Some(_)) => kept.behind_the_same_count(&other, meal),
                // Missing from the log although the other log would hold it: it was not eaten.
                (None, Some(_)) => Grams(0.0),
                (_, None) => meal.eaten,
            };
            input.carbs = Grams(input.carbs.0 - meal.eaten.0 + eaten.0);
        }
        let mut rng = stream(self.seed, self.index, Concept::Reactions);
        let reactions = reactions(&lived.life.calendar, &mut rng);
        for (step, (input, reaction)) in inputs.iter_mut().zip(&reactions).enumerate() {
            if kept.omits_rescue(step, reaction) && !other.omits_rescue(step, reaction) {
                input.rescue.amount = Grams(0.0);
            }
        }
        for (step, slow) in &lived.slow_rescues {
            let Some(reaction) = reactions.get(*step) else { continue };
            if let Some(input) = inputs.get_mut(*step)
                && kept.omits_rescue(*step, reaction)
                && !other.omits_rescue(*step, reaction)
            {
                input.carbs = Grams(input.carbs.0 - slow.0);
            }
        }
        inputs
    }
}

/// Mean absolute value; 0 for no values.
fn mean_absolute(differences: impl Iterator<Item = f64>) -> MgPerDl {
    let (sum, n) = differences.fold((0.0, 0_usize), |(sum, n), d| (sum + d.abs(), n + 1));
    MgPerDl(if n == 0 { 0.0 } else { sum / n as f64 })
}
