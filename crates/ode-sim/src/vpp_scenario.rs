//! The test scenario of the authors' virtual patient population: four days of large meals with
//! open-loop insulin, with or without exercise and rescue carbohydrate.
//!
//! Source: Resalat et al. 2019 and its test program (single hormone). Everything that is fixed
//! there is a constant here; patients, meals, the start and the number of steps are arguments.

use physiology::{
    Exercise, Grams, InputSource, Kilograms, MgPerDl, OpenLoop, STEPS_PER_DAY, StepInput, Units,
    UnitsPerHour, simulate,
};

use crate::dosing::{BolusCalculator, basal_of, insulin_to_carb_ratio};
use crate::error::{OdeError, not_negative, positive};
use crate::parameters::OdeParameters;
use crate::plant::OdePlant;
use crate::rescue::RescueCarbs;
use crate::state::OdeState;
use crate::steady_state;

/// First step of the exercise bout: one hour after the start.
pub const EXERCISE_ONSET: usize = 12;
/// Last step of the exercise bout: 45 min after its onset.
pub const EXERCISE_END: usize = 21;
/// The bout: 60 % of maximal oxygen uptake with half of the muscle mass.
pub const BOUT: Exercise = Exercise { vo2max_percent: 60.0, active_muscle_share: 0.5 };
/// Glucose at the start.
pub const START_GLUCOSE: MgPerDl = MgPerDl(160.0);

/// A patient of the published population.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VirtualPatient {
    /// Model parameters.
    pub parameters: OdeParameters,
    /// Body weight.
    pub weight: Kilograms,
    /// Total daily insulin, which sets the basal rate and the insulin-to-carbohydrate ratio.
    pub total_daily_insulin: Units,
}

/// A meal of the scenario.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Meal {
    /// Step in which it is eaten and, from step 1 on, dosed for.
    pub step: usize,
    /// Its carbohydrate.
    pub carbs: Grams,
}

named::named! {
    /// The two scenarios.
    Scenario {
        /// Meals, one bout of exercise, and rescue carbohydrate when glucose falls below 70 mg/dL.
        ExerciseAndRescue: "exercise_and_rescue",
        /// Meals only.
        MealsOnly: "meals_only",
    }
}

/// One line of a trace.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// The step, from 0.
    pub step: usize,
    /// Glucose after the step.
    pub glucose: MgPerDl,
    /// Insulin during the step, basal and bolus as a rate.
    pub insulin: UnitsPerHour,
    /// The state after the step.
    pub state: OdeState,
}

impl VirtualPatient {
    /// The patient as a plant, integrated as the authors do.
    #[must_use]
    pub fn plant(&self) -> OdePlant {
        OdePlant::reproduction(self.parameters, self.weight)
    }

    /// The steady state at [`START_GLUCOSE`], for patients without an initial state of their own.
    ///
    /// # Errors
    /// Those of [`steady_state::at_glucose`].
    pub fn initial_state(&self) -> Result<OdeState, OdeError> {
        Ok(steady_state::at_glucose(&self.parameters, self.weight, START_GLUCOSE)?.state)
    }
}

/// The inputs of the first `steps` steps.
///
/// Basal is the patient's own throughout; each meal is eaten in its step and dosed for in the same
/// step by the insulin-to-carbohydrate ratio, except in step 0, where the authors give basal alone.
/// Meals beyond the last step are left out.
///
/// # Errors
/// [`OdeError::Argument`] if total daily insulin or a meal is not a number that can be.
pub fn inputs(
    patient: &VirtualPatient,
    meals: &[Meal],
    scenario: Scenario,
    steps: usize,
) -> Result<Vec<StepInput>, OdeError> {
    let calculator =
        BolusCalculator::new(insulin_to_carb_ratio(patient.total_daily_insulin), None)?;
    let basal = basal_of(patient.total_daily_insulin);
    let mut inputs = vec![StepInput { basal, ..StepInput::default() }; steps];
    for meal in meals {
        not_negative("meal carbohydrate, g", meal.carbs.0)?;
        let Some(input) = inputs.get_mut(meal.step) else { continue };
        input.carbs = input.carbs + meal.carbs;
        if meal.step > 0 {
            input.bolus = input.bolus + calculator.meal_bolus(meal.carbs);
        }
    }
    if scenario == Scenario::ExerciseAndRescue {
        for input in inputs.iter_mut().take(EXERCISE_END + 1).skip(EXERCISE_ONSET) {
            input.exercise = Some(BOUT);
        }
    }
    Ok(inputs)
}

/// The trace of a patient over `days` days: steps 0 to 288 `days`, both included, as the authors
/// count them.
///
/// # Errors
/// [`OdeError::Parameter`] and [`OdeError::Argument`] for a patient or meal that cannot be;
/// [`OdeError::Simulation`] if a state leaves the finite numbers.
pub fn trace(
    patient: &VirtualPatient,
    meals: &[Meal],
    initial: OdeState,
    scenario: Scenario,
    days: usize,
) -> Result<Vec<Row>, OdeError> {
    patient.parameters.validated()?;
    positive("weight, kg", patient.weight.0)?;
    let steps = days * STEPS_PER_DAY + 1;
    let fixed = inputs(patient, meals, scenario, steps)?;
    let open_loop = OpenLoop::new(&fixed);
    match scenario {
        Scenario::MealsOnly => rows(patient, initial, open_loop, steps),
        Scenario::ExerciseAndRescue => rows(patient, initial, RescueCarbs::new(open_loop), steps),
    }
}

fn rows(
    patient: &VirtualPatient,
    initial: OdeState,
    mut source: impl InputSource,
    steps: usize,
) -> Result<Vec<Row>, OdeError> {
    let plant = patient.plant();
    let run = simulate(&plant, initial, &mut source, steps)?;
    let glucose = run.glucose(&plant);
    let after = run.states.iter().zip(glucose).skip(1);
    let rows = run.inputs.iter().zip(after).enumerate();
    Ok(rows
        .map(|(step, (input, (state, glucose)))| Row {
            step,
            glucose,
            insulin: input.insulin(),
            state: *state,
        })
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patient() -> VirtualPatient {
        VirtualPatient {
            parameters: OdeParameters::nominal(),
            weight: Kilograms(76.3),
            total_daily_insulin: Units(42.3),
        }
    }

    #[test]
    fn names_lead_back_to_their_scenario() {
        for scenario in Scenario::ALL {
            assert_eq!(Scenario::from_name(scenario.name()), Some(scenario));
        }
        assert_eq!(Scenario::from_name("fasting"), None);
    }

    #[test]
    fn the_bout_lasts_ten_steps_and_a_day_has_one_row_more_than_steps() {
        let patient = patient();
        let start = patient.initial_state().expect("nominal");
        let rows = trace(&patient, &[], start, Scenario::MealsOnly, 2).expect("finite");
        assert_eq!(rows.len(), 577);
        let inputs = inputs(&patient, &[], Scenario::ExerciseAndRescue, 100).expect("no meals");
        assert_eq!(inputs.iter().filter(|i| i.exercise.is_some()).count(), 10);
        assert!(inputs[12].exercise.is_some() && inputs[21].exercise.is_some());
    }

    #[test]
    fn meals_are_dosed_in_their_own_step_except_the_first() {
        let meals = [
            Meal { step: 0, carbs: Grams(20.0) },
            Meal { step: 3, carbs: Grams(40.0) },
            Meal { step: 900, carbs: Grams(40.0) },
        ];
        let inputs = inputs(&patient(), &meals, Scenario::MealsOnly, 10).expect("meals are fine");
        assert_eq!((inputs[0].carbs, inputs[0].bolus), (Grams(20.0), Units(0.0)));
        // 40 g at 1700 / (3 x 42.3) g/U; rounding.
        assert!((inputs[3].bolus.0 - 40.0 * 3.0 * 42.3 / 1700.0).abs() < 1e-12);
    }

    #[test]
    fn a_meal_that_is_not_a_number_is_an_error() {
        let meals = [Meal { step: 3, carbs: Grams(f64::NAN) }];
        assert!(inputs(&patient(), &meals, Scenario::MealsOnly, 10).is_err());
    }

    #[test]
    fn a_patient_who_cannot_be_is_an_error() {
        let start = patient().initial_state().expect("nominal");
        let trace_of = |patient: VirtualPatient| {
            trace(&patient, &[], start, Scenario::MealsOnly, 1).expect_err("cannot be")
        };
        let weightless = VirtualPatient { weight: Kilograms(0.0), ..patient() };
        assert!(matches!(trace_of(weightless), OdeError::Argument { name: "weight, kg", .. }));
        let parameters = OdeParameters { v_g: f64::NAN, ..OdeParameters::nominal() };
        let broken = VirtualPatient { parameters, ..patient() };
        assert!(matches!(trace_of(broken), OdeError::Parameter { name: "v_g", .. }));
        let no_insulin = VirtualPatient { total_daily_insulin: Units(0.0), ..patient() };
        assert!(matches!(trace_of(no_insulin), OdeError::Argument { .. }));
    }
}
