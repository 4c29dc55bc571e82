//! What acts on the body beyond its inputs: one [`Condition`] a step.

use physiology::{Exercise, MgPerDl, Minutes, STEPS_PER_DAY, STEPS_PER_HOUR};

use super::counter_regulation::LowTrace;
use super::forms::{LowForm, SleepLossForm};
use super::happenings::Happenings;
use super::outside;
use super::shapes::Shapes;
use super::{
    Amplitudes, Effect, alcohol, circadian_sensitivity, dawn, exercise_forms, renal_threshold,
    set_ageing, set_failure, sleep_loss, slow_meals,
};
use crate::behaviour::{Life, Meal};
use crate::calendar::within;

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
    let (forms, of) = (&shapes.forms, |effect| amplitudes.of(effect));
    let days = &happenings.variability;
    let rested = after_nights(life, forms.sleep_loss, of(Effect::SleepLoss));
    let after = of(Effect::PostExerciseSensitivity);
    let trained = exercise_forms::after(forms.after_exercise, life, after);
    let exercises = of(Effect::Exercise) != 0.0 || after != 0.0;
    let by_clock = of(Effect::CircadianSensitivity);
    let clock = circadian_sensitivity::day(forms.circadian, &shapes.circadian, by_clock);
    let (renal_slope, renal_threshold) =
        renal_threshold::factors(forms.renal, &shapes.renal, of(Effect::RenalThreshold));
    let slow: Vec<(&Meal, f64)> = life
        .meals
        .iter()
        .map(|meal| (meal, slow_meals::slowness(forms.slow_meals, meal)))
        .filter(|(_, slowness)| *slowness > 0.0)
        .collect();
    let mut course: Vec<Condition> = (0..life.calendar.steps())
        .map(|step| {
            let wake_hour = life.usual_wake_hour + shapes.dawn_shift;
            let hour = life.calendar.hour(step);
            let dawn = dawn::production_factor(forms.dawn, hour, wake_hour, of(Effect::Dawn));
            let evenings = life.evenings.iter().map(|evening| {
                let hours = hours_between(evening.step, step);
                alcohol::production_factor(forms.alcohol, hours, evening.dose, of(Effect::Alcohol))
            });
            let slowed = slow.iter().map(|(meal, slowness)| {
                let hours = hours_between(meal.step, step);
                slow_meals::gut_time_factor(*slowness, hours, of(Effect::SlowMeals))
            });
            let (acts, acts_on_liver) = clock[step % STEPS_PER_DAY];
            let everyday = happenings.everyday.get(step).copied().unwrap_or_default();
            let action = days.action[step].exp() * everyday.action.exp();
            let absorption = happenings.absorption(forms.absorption, life, step);
            let always = days.insulin_time_always.get(step).map_or(1.0, |log| log.exp());
            let (age, ageing) = (life.sets.age_days(step), of(Effect::SetAgeing));
            let aged =
                set_ageing::bioavailability(forms.set_ageing, age, shapes.set_ageing_onset, ageing);
            let (sets, failing) = (&happenings.set_failures, of(Effect::SetFailure));
            let failed = set_failure::bioavailability(forms.set_failure, sets, step, failing);
            Condition {
                production: dawn * evenings.product::<f64>() * everyday.production.exp(),
                action: action * rested[step] * acts * trained[step],
                liver_action: action * acts_on_liver,
                insulin_time: (of(Effect::InsulinAbsorption) * absorption).exp()
                    * always
                    * everyday.insulin_time.exp(),
                gut_time: days.gut_time[step].exp()
                    * slowed.fold(1.0, f64::max)
                    * everyday.gut_time.exp(),
                bioavailability: aged * failed * everyday.amount.exp(),
                renal_slope,
                renal_threshold,
                low_response: of(Effect::CounterRegulation) * shapes.counter_regulation,
                low_response_time: shapes.counter_regulation_time,
                low_form: forms.low,
                felt: exercises.then(|| exercise_forms::felt(forms.exercise, life, step)).flatten(),
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
fn after_nights(life: &Life, form: SleepLossForm, amplitude: f64) -> Vec<f64> {
    let mut factors = vec![1.0; life.calendar.steps()];
    for (k, pair) in life.nights.windows(2).enumerate() {
        let [night, following] = pair else { continue };
        let before = &life.nights[k.saturating_sub(2)..k];
        for step in within(night.wake..following.onset, factors.len()) {
            let awake = (step as i64 - night.wake) as f64 / STEPS_PER_HOUR as f64;
            factors[step] = sleep_loss::action_factor(form, night, before, awake, amplitude);
        }
    }
    factors
}
