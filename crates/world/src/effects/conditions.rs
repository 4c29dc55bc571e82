//! What acts on the body beyond its inputs: one [`Condition`] a step.

use physiology::{Exercise, MgPerDl, Minutes, STEPS_PER_DAY, STEPS_PER_HOUR};

use super::counter_regulation::LowTrace;
use super::forms::LowForm;
use super::happenings::Happenings;
use super::outside;
use super::shapes::Shapes;
use super::{
    Amplitudes, Effect, alcohol, circadian_sensitivity, counter_regulation, dawn, exercise_forms,
    renal_threshold, set_ageing, set_failure, sleep_loss, slow_meals,
};
use crate::behaviour::{Life, Meal};

/// What acts on the body through one step.
///
/// Every body applies all of it. Most fields are multipliers, 1 for the body as drawn. A body calls
/// [`at_glucose`](Self::at_glucose) first, which sets the fields that depend on its own glucose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Condition {
    /// On endogenous glucose production.
    pub production: f64,
    /// On insulin action in the periphery (S_f1, S_f2).
    pub action: f64,
    /// On insulin action in the liver (S_f3).
    pub liver_action: f64,
    /// On the time to the maximal insulin absorption.
    pub insulin_time: f64,
    /// On the time to the maximal meal absorption.
    pub gut_time: f64,
    /// On the insulin delivered.
    pub bioavailability: f64,
    /// On the rate at which the kidneys clear glucose above their threshold.
    pub renal_slope: f64,
    /// On the glucose above which the kidneys clear glucose.
    pub renal_threshold: f64,
    /// On the uptake of glucose that needs no insulin.
    pub uptake: f64,
    /// Glucose that enters the accessible compartment besides meals and production, mmol/kg/min.
    pub glucose_flux: f64,
    /// Rise of the production, as a share, while counter-regulation is fully active.
    pub low_response: f64,
    /// Time constant of counter-regulation.
    pub low_response_time: Minutes,
    /// Form of counter-regulation.
    pub low_form: LowForm,
    /// Exercise as working muscle feels it, where it differs from the exercise itself.
    pub felt: Option<Exercise>,
    /// Change of the logarithm of the gut time for each 100 mg/dL of glucose above 140 mg/dL.
    pub gut_time_per_glucose: f64,
}

impl Condition {
    /// The body as drawn.
    pub const AS_DRAWN: Self = Self {
        production: 1.0,
        action: 1.0,
        liver_action: 1.0,
        insulin_time: 1.0,
        gut_time: 1.0,
        bioavailability: 1.0,
        renal_slope: 1.0,
        renal_threshold: 1.0,
        uptake: 1.0,
        glucose_flux: 0.0,
        low_response: 0.0,
        low_response_time: Minutes(15.0),
        low_form: LowForm::Proportional,
        felt: None,
        gut_time_per_glucose: 0.0,
    };

    /// Exercise as working muscle feels it, for that of an input.
    #[must_use]
    pub fn felt(&self, exercise: Option<Exercise>) -> Option<Exercise> {
        self.felt.or(exercise)
    }

    /// The condition of a body whose glucose is `glucose` and whose counter-regulation is `low`.
    /// Only production and gut time depend on these.
    #[must_use]
    pub fn at_glucose(&self, glucose: MgPerDl, low: &LowTrace) -> Self {
        let excess = ((glucose.0 - 140.0) / 100.0).clamp(0.0, 2.0);
        Self {
            production: self.production * low.production_factor(self.low_response),
            gut_time: self.gut_time * (self.gut_time_per_glucose * excess).exp(),
            low_response: 0.0,
            gut_time_per_glucose: 0.0,
            ..*self
        }
    }
}

/// The conditions of each step of a life.
#[must_use]
pub fn conditions(
    life: &Life,
    happenings: &Happenings,
    shapes: &Shapes,
    amplitudes: &Amplitudes,
) -> Vec<Condition> {
    let days = &happenings.variability;
    let awake_action = after_nights(life, shapes, amplitudes.of(Effect::SleepLoss));
    let trained = exercise_forms::after(
        shapes.forms.after_exercise,
        life,
        amplitudes.of(Effect::PostExerciseSensitivity),
    );
    let exercises = amplitudes.of(Effect::Exercise) != 0.0
        || amplitudes.of(Effect::PostExerciseSensitivity) != 0.0;
    let clock = circadian_sensitivity::day(
        shapes.forms.circadian,
        &shapes.circadian,
        amplitudes.of(Effect::CircadianSensitivity),
    );
    let (kidneys, own) = (amplitudes.of(Effect::RenalThreshold), shapes.kidneys());
    let slow_ones: Vec<&Meal> = life
        .meals
        .iter()
        .filter(|m| slow_meals::slowness(shapes.forms.slow_meals, m) > 0.0)
        .collect();
    let mut course: Vec<Condition> = (0..life.calendar.steps())
        .map(|step| {
            let hour = life.calendar.hour(step);
            let dawn = dawn::production_factor(
                shapes.forms.dawn,
                hour,
                life.usual_wake_hour + shapes.dawn_shift,
                amplitudes.of(Effect::Dawn),
            );
            let alcohol: f64 = life
                .evenings
                .iter()
                .map(|e| {
                    let hours = hours_between(e.step, step);
                    let amplitude = amplitudes.of(Effect::Alcohol);
                    alcohol::production_factor(shapes.forms.alcohol, hours, e.dose, amplitude)
                })
                .product();
            let slow = slow_ones
                .iter()
                .map(|m| {
                    let hours = hours_between(m.step, step);
                    let amplitude = amplitudes.of(Effect::SlowMeals);
                    slow_meals::gut_time_factor(shapes.forms.slow_meals, m, hours, amplitude)
                })
                .fold(1.0, f64::max);
            let (by_clock, liver_by_clock) = clock[step % STEPS_PER_DAY];
            let everyday = happenings.everyday.at(step);
            let action = days.action[step].exp() * everyday.action;
            let always = days.insulin_time_always.get(step).map_or(1.0, |log| log.exp());
            let aged = set_ageing::bioavailability(
                shapes.forms.set_ageing,
                life.sets.age_days(step),
                shapes.set_ageing_onset,
                amplitudes.of(Effect::SetAgeing),
            );
            let failed = set_failure::bioavailability(
                shapes.forms.set_failure,
                &happenings.set_failures,
                step,
                amplitudes.of(Effect::SetFailure),
            );
            Condition {
                production: dawn * alcohol * everyday.production,
                action: action * awake_action[step] * by_clock * trained[step],
                liver_action: action * liver_by_clock,
                insulin_time: (amplitudes.of(Effect::InsulinAbsorption)
                    * happenings.absorption(shapes.forms.absorption, life, step))
                .exp()
                    * always
                    * everyday.insulin_time,
                gut_time: days.gut_time[step].exp() * slow * everyday.gut_time,
                bioavailability: aged * failed * everyday.amount,
                renal_slope: renal_threshold::slope_factor(&own, kidneys),
                renal_threshold: renal_threshold::threshold_factor(&own, kidneys),
                low_response: counter_regulation::response(
                    shapes.counter_regulation,
                    amplitudes.of(Effect::CounterRegulation),
                ),
                low_response_time: shapes.counter_regulation_time,
                low_form: shapes.forms.low,
                felt: if exercises {
                    exercise_forms::felt(shapes.forms.exercise, life, step)
                } else {
                    None
                },
                ..Condition::AS_DRAWN
            }
        })
        .collect();
    outside::act(&mut course, &happenings.outside, amplitudes);
    course
}

/// Hours from one step to another.
fn hours_between(from: usize, to: usize) -> f64 {
    (to as f64 - from as f64) / STEPS_PER_HOUR as f64
}

/// Factor of sleep loss on each step: that of the last night from waking to the next sleep.
fn after_nights(life: &Life, shapes: &Shapes, amplitude: f64) -> Vec<f64> {
    let mut factors = vec![1.0; life.calendar.steps()];
    for (k, pair) in life.nights.windows(2).enumerate() {
        let [night, following] = pair else { continue };
        let before = &life.nights[k.saturating_sub(2)..k];
        for step in night.wake.max(0)..following.onset {
            if let Some(slot) = usize::try_from(step).ok().and_then(|s| factors.get_mut(s)) {
                let awake = (step - night.wake) as f64 / STEPS_PER_HOUR as f64;
                let form = shapes.forms.sleep_loss;
                *slot = sleep_loss::action_factor(form, night, before, awake, amplitude);
            }
        }
    }
    factors
}
