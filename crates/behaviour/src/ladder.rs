//! Ladders of doses, run freely and compared rung by rung.

use contract::Document as _;
use contract::trajectories::{Check, Finding, Rung, Trajectories, WorstCase};
use physiology::{Grams, MgPerDl, Plant, STEP, STEPS_PER_DAY, StepInput, Units, UnitsPerHour};

use crate::error::BehaviourError;

/// A model at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Rest<S> {
    /// The state.
    pub state: S,
    /// The basal rate that holds it.
    pub basal: UnitsPerHour,
    /// Whether the model stands still there; `false` for the nearest state where it has none.
    pub is_steady: bool,
}

/// A model under check, or the reference beside it.
pub struct Subject<'a, P: Plant> {
    /// The model.
    pub plant: &'a P,
    /// Its rest at a glucose, or why there is none.
    pub rest: &'a dyn Fn(MgPerDl) -> Result<Rest<P::State>, String>,
}

/// What is run and asked.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckRule {
    /// Glucose at rest from which every ladder starts.
    pub starts: Vec<MgPerDl>,
    /// Multiples of the basal rate at rest, ascending.
    pub basal_factors: Vec<f64>,
    /// Boluses, ascending.
    pub boluses: Vec<Units>,
    /// Meals, ascending.
    pub meals: Vec<Grams>,
    /// The meal of the carbohydrate ratios.
    pub ratio_meal: Grams,
    /// Carbohydrate ratios, g/U, descending: more and more insulin.
    pub ratios: Vec<f64>,
    /// Steps after a bolus or a meal in which it is followed.
    pub dose_steps: usize,
    /// Steps without insulin and at another basal rate.
    pub day_steps: usize,
    /// Least glucose at the end of a day without insulin.
    pub without_insulin: MgPerDl,
    /// What does not count, mg/dL.
    pub tolerance: f64,
}

impl CheckRule {
    /// The values in use: from rest at 80, 120, 160 and 200 mg/dL; basal from none to twice, boluses to 8 U, meals to
    /// 100 g, ratios from 30 to 5 g/U on 60 g; doses followed for 5 h and basal for a day; 250 mg/dL after a day
    /// without insulin (level 2 hyperglycaemia: Battelino et al., Diabetes Care 2019;42:1593); half a mg/dL does not
    /// count.
    #[must_use]
    pub fn working() -> Self {
        Self {
            starts: [80.0, 120.0, 160.0, 200.0].map(MgPerDl).to_vec(),
            basal_factors: vec![0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0],
            boluses: [0.0, 0.5, 1.0, 2.0, 4.0, 8.0].map(Units).to_vec(),
            meals: [0.0, 10.0, 20.0, 40.0, 60.0, 80.0, 100.0].map(Grams).to_vec(),
            ratio_meal: Grams(60.0),
            ratios: vec![30.0, 20.0, 15.0, 12.0, 10.0, 8.0, 6.0, 5.0],
            dose_steps: 60,
            day_steps: STEPS_PER_DAY,
            without_insulin: MgPerDl(250.0),
            tolerance: 0.5,
        }
    }
}

/// Runs every ladder of a model and of its reference.
///
/// # Errors
/// [`BehaviourError`] if one of them has no state to start from or leaves the finite numbers, or a ladder is too
/// short.
pub fn check<P: Plant, R: Plant>(
    model: &Subject<'_, P>,
    reference: &Subject<'_, R>,
    rule: &CheckRule,
) -> Result<Trajectories, BehaviourError> {
    let mut report = Trajectories {
        schema: Trajectories::SCHEMA.to_owned(),
        passed: true,
        findings: Vec::new(),
        rungs: Vec::new(),
        starts_not_at_rest: Vec::new(),
    };
    let mut starts = Vec::with_capacity(rule.starts.len());
    for glucose in &rule.starts {
        let own = rest_of("the model", model, *glucose)?;
        if !own.is_steady {
            report.starts_not_at_rest.push(glucose.0);
        }
        starts.push((*glucose, own, rest_of("the reference", reference, *glucose)?));
    }
    for ladder in ladders(rule)? {
        let mut worst: Option<(f64, WorstCase)> = None;
        let mut cases = 0;
        for (glucose, own, other) in &starts {
            let mut courses = Vec::with_capacity(ladder.doses.len());
            for dose in &ladder.doses {
                let run = ladder.course("the model", model.plant, own, *glucose, *dose)?;
                let beside =
                    ladder.course("the reference", reference.plant, other, *glucose, *dose)?;
                report.rungs.push(Rung {
                    check: ladder.check,
                    start_mg_dl: glucose.0,
                    dose: *dose,
                    end_mg_dl: run[run.len() - 1],
                    reference_end_mg_dl: beside[beside.len() - 1],
                    range_mg_dl: [
                        run.iter().copied().fold(f64::INFINITY, f64::min),
                        run.iter().copied().fold(f64::NEG_INFINITY, f64::max),
                    ],
                });
                courses.push((run, beside));
            }
            for found in ladder.compare(&courses, *glucose, rule) {
                cases += 1;
                // What is not a number is worse than anything.
                if worst.is_none_or(|(most, _)| found.0.is_nan() || found.0 > most) {
                    worst = Some(found);
                }
            }
        }
        let Some((worst_mg_dl, worst)) = worst else {
            return Err(BehaviourError::Ladder { check: ladder.check });
        };
        let passed = worst_mg_dl <= rule.tolerance;
        report.passed &= passed;
        report.findings.push(Finding { check: ladder.check, passed, worst_mg_dl, worst, cases });
    }
    Ok(report)
}

fn rest_of<P: Plant>(
    who: &'static str,
    subject: &Subject<'_, P>,
    glucose: MgPerDl,
) -> Result<Rest<P::State>, BehaviourError> {
    (subject.rest)(glucose).map_err(|reason| BehaviourError::NoStart {
        who,
        glucose_mg_dl: glucose.0,
        reason,
    })
}

/// The doses of one check.
struct Ladder {
    check: Check,
    /// In the order in which glucose is to move in one direction.
    doses: Vec<f64>,
    steps: usize,
    /// Carbohydrate of every run, g.
    meal: Grams,
}

fn ladders(rule: &CheckRule) -> Result<[Ladder; 5], BehaviourError> {
    let none = Grams(0.0);
    let of = |check, doses: Vec<f64>, steps, meal| {
        let ascending = if check == Check::CarbRatio {
            doses.is_sorted_by(|a, b| a > b && *b > 0.0)
        } else {
            doses.is_sorted_by(|a, b| a < b)
        };
        let enough = doses.len() > usize::from(check != Check::ZeroInsulin);
        if ascending && enough && steps > 0 && !rule.starts.is_empty() {
            Ok(Ladder { check, doses, steps, meal })
        } else {
            Err(BehaviourError::Ladder { check })
        }
    };
    let boluses = rule.boluses.iter().map(|bolus| bolus.0).collect();
    let meals = rule.meals.iter().map(|meal| meal.0).collect();
    Ok([
        of(Check::ZeroInsulin, vec![0.0], rule.day_steps, none)?,
        of(Check::Basal, rule.basal_factors.clone(), rule.day_steps, none)?,
        of(Check::Bolus, boluses, rule.dose_steps, none)?,
        of(Check::Carbs, meals, rule.dose_steps, none)?,
        of(Check::CarbRatio, rule.ratios.clone(), rule.dose_steps, rule.ratio_meal)?,
    ])
}

impl Ladder {
    /// Glucose of one run, mg/dL, one entry a step and the start before them.
    fn course<P: Plant>(
        &self,
        who: &'static str,
        plant: &P,
        rest: &Rest<P::State>,
        start: MgPerDl,
        dose: f64,
    ) -> Result<Vec<f64>, BehaviourError> {
        let (factor, bolus, carbs) = match self.check {
            Check::ZeroInsulin | Check::Basal => (dose, 0.0, 0.0),
            Check::Bolus => (1.0, dose, 0.0),
            Check::Carbs => (1.0, 0.0, dose),
            Check::CarbRatio => (1.0, self.meal.0 / dose, self.meal.0),
        };
        let basal = UnitsPerHour(factor * rest.basal.0);
        let mut state = rest.state.clone();
        let mut glucose = vec![plant.glucose(&state).0];
        for step in 0..self.steps {
            let mut input = StepInput { basal, ..StepInput::default() };
            if step == 0 {
                (input.bolus, input.carbs) = (Units(bolus), Grams(carbs));
            }
            state = plant.step(&state, &input).map_err(|source| BehaviourError::NotFinite {
                who,
                glucose_mg_dl: start.0,
                minutes: step as f64 * STEP.0,
                source,
            })?;
            glucose.push(plant.glucose(&state).0);
        }
        Ok(glucose)
    }

    /// By how much each pair of neighbouring rungs misses what is asked, at its worst.
    fn compare(
        &self,
        courses: &[(Vec<f64>, Vec<f64>)],
        start: MgPerDl,
        rule: &CheckRule,
    ) -> Vec<(f64, WorstCase)> {
        let at = |less: usize, more: usize, step: usize| WorstCase {
            start_mg_dl: start.0,
            less: self.doses[less],
            more: self.doses[more],
            minutes: step as f64 * STEP.0,
            glucose_less_mg_dl: courses[less].0[step],
            glucose_more_mg_dl: courses[more].0[step],
        };
        if self.check == Check::ZeroInsulin {
            let missing = rule.without_insulin.0 - courses[0].0[self.steps];
            return vec![(missing, at(0, 0, self.steps))];
        }
        // Positive where the order is wrong: insulin lowers glucose, carbohydrate raises it.
        let sign = if self.check == Check::Carbs { -1.0 } else { 1.0 };
        let wrong = |less: &[f64], more: &[f64], step: usize| sign * (more[step] - less[step]);
        (1..courses.len())
            .map(|more| {
                let (less, [below, above]) = (more - 1, [&courses[more - 1], &courses[more]]);
                if self.check == Check::Basal {
                    return (wrong(&below.0, &above.0, self.steps), at(less, more, self.steps));
                }
                (1..=self.steps)
                    .map(|step| {
                        let allowed = wrong(&below.1, &above.1, step).max(0.0);
                        (wrong(&below.0, &above.0, step) - allowed, at(less, more, step))
                    })
                    .fold((f64::NEG_INFINITY, at(less, more, 0)), |worst, found| {
                        if found.0.is_nan() || found.0 > worst.0 { found } else { worst }
                    })
            })
            .collect()
    }
}
