//! How far effects move glucose: the measured size of a gap.
//!
//! Closed-loop insulin and the person's reactions respond to an effect and hide it. A diagnosis can
//! only see the effect under the insulin that was delivered and the carbohydrate that was logged.
//! So the days are replayed without the effect under both.

use physiology::{Grams, MgPerDl, OpenLoop, StepInput};

use crate::effects::{Amplitudes, Effect, OutsideEffect, Port};
use crate::error::WorldError;
use crate::reactions::reactions;
use crate::stream::Concept;
use crate::virtual_person::{LivedDays, VirtualPerson};

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
        let inputs = self.inputs_behind_the_log(lived, amplitudes);
        let source = &mut OpenLoop::new(&inputs);
        let (_, glucose) = self.run(&lived.life, &lived.happenings, amplitudes, source)?;
        let sensed = self.sensed(lived, &glucose, amplitudes)?;
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
        let differences = if self.sensors_differ(without) {
            self.readings_less(lived, &other.sensed)?
        } else {
            lived.glucose.iter().zip(&other.glucose).map(|(a, b)| Some(a.0 - b.0)).collect()
        };
        Ok(MgPerDl(mean(differences.iter().flatten().map(|d| d.abs())).unwrap_or(0.0)))
    }

    /// The difference that effects make to the sensor at the same glucose, mg/dL; `None` where a
    /// needed reading is lost.
    pub(crate) fn shown_by_sensors(
        &self,
        lived: &LivedDays,
        without: &Amplitudes,
    ) -> Result<Vec<Option<f64>>, WorldError> {
        if !self.sensors_differ(without) {
            return Ok(vec![Some(0.0); lived.glucose.len()]);
        }
        self.readings_less(lived, &self.sensed(lived, &lived.glucose, without)?)
    }

    /// The readings of the days as lived less others, mg/dL; `None` where one is lost.
    pub(crate) fn readings_less(
        &self,
        lived: &LivedDays,
        others: &[Option<MgPerDl>],
    ) -> Result<Vec<Option<f64>>, WorldError> {
        let sensed = self.sensed(lived, &lived.glucose, &self.amplitudes)?;
        Ok(sensed.iter().zip(others).map(|(a, b)| Some((*a)?.0 - (*b)?.0)).collect())
    }

    /// Whether an effect on the sensor differs from this person's.
    pub(crate) fn sensors_differ(&self, other: &Amplitudes) -> bool {
        let named = |e: &Effect| self.amplitudes.of(*e) != other.of(*e);
        let outside = |e: &OutsideEffect| self.amplitudes.of_outside(*e) != other.of_outside(*e);
        Effect::ALL.iter().any(|e| e.port() == Port::Sensor && named(e))
            || OutsideEffect::ALL.iter().any(|e| e.port() == Port::Sensor && outside(e))
    }

    /// What a record of the sensors of these days would hold of a course of glucose, not rounded.
    pub(crate) fn sensed(
        &self,
        lived: &LivedDays,
        glucose: &[MgPerDl],
        amplitudes: &Amplitudes,
    ) -> Result<Vec<Option<MgPerDl>>, WorldError> {
        let mut sensors = self.sensors(&lived.life, &lived.happenings, amplitudes);
        let shown = glucose.iter().enumerate().map(|(step, value)| sensors.sense(step, *value));
        let shown: Vec<_> =
            shown.collect::<Result<_, _>>().map_err(|source| self.failed(source))?;
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
        let reactions = reactions(&lived.life.calendar, &mut self.rng(Concept::Reactions));
        for (step, (input, reaction)) in inputs.iter_mut().zip(&reactions).enumerate() {
            if kept.omits_rescue(step, reaction) && !other.omits_rescue(step, reaction) {
                input.rescue.amount = Grams(0.0);
                for (_, slow) in lived.slow_rescues.iter().filter(|(at, _)| *at == step) {
                    input.carbs = Grams(input.carbs.0 - slow.0);
                }
            }
        }
        inputs
    }
}

/// The mean of these values, if there is any.
pub(crate) fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, n) = values.fold((0.0, 0_usize), |(sum, n), value| (sum + value, n + 1));
    (n > 0).then(|| sum / n as f64)
}
