//! Models with one wrong answer each: the check for it fails, and only that.

use behaviour::{BehaviourError, Check, CheckRule, Rest, Subject, Trajectories, check};
use ode_sim::{OdeParameters, OdePlant, OdeState, steady_state};
use physiology::{Kilograms, MgPerDl, NonFinite, Plant, States, StepInput, Units, UnitsPerHour};

const WEIGHT: Kilograms = Kilograms(76.3);

/// The ODE behind inputs that somebody tampers with.
struct Tampered {
    plant: OdePlant,
    tamper: fn(&mut StepInput),
}

impl Plant for Tampered {
    type State = OdeState;

    fn step(&self, state: &OdeState, input: &StepInput) -> Result<OdeState, NonFinite> {
        let mut input = *input;
        (self.tamper)(&mut input);
        self.plant.step(state, &input)
    }

    fn glucose(&self, state: &OdeState) -> MgPerDl {
        self.plant.glucose(state)
    }

    fn report(&self, state: &OdeState) -> States {
        self.plant.report(state)
    }
}

fn rest(glucose: MgPerDl) -> Result<Rest<OdeState>, String> {
    let found = steady_state::at_glucose(&OdeParameters::nominal(), WEIGHT, glucose);
    let found = found.map_err(|error| error.to_string())?;
    Ok(Rest { state: found.state, basal: found.basal, is_steady: true })
}

fn checked(tamper: fn(&mut StepInput)) -> Trajectories {
    let plant = OdePlant::reproduction(OdeParameters::nominal(), WEIGHT);
    let ode = Subject { plant: &plant, rest: &rest };
    let tampered = Tampered { plant, tamper };
    let model = Subject { plant: &tampered, rest: &rest };
    check(&model, &ode, &CheckRule::working()).expect("runs")
}

fn failed(report: &Trajectories) -> Vec<Check> {
    report.findings.iter().filter(|f| !f.passed).map(|f| f.check).collect()
}

#[test]
fn the_ode_passes_beside_itself() {
    let report = checked(|_| {});
    assert!(report.passed, "{:?}", report.findings);
    assert_eq!(report.findings.len(), 5);
    // 4 starts: once without insulin, 8 basal rates, 6 boluses, 7 meals, 8 ratios.
    assert_eq!(report.rungs.len(), 4 * (1 + 8 + 6 + 7 + 8));
    assert!(report.starts_not_at_rest.is_empty());
    for rung in &report.rungs {
        assert_eq!(rung.end_mg_dl, rung.reference_end_mg_dl);
    }
}

#[test]
fn a_model_with_insulin_of_its_own_never_runs_high() {
    let report = checked(|input| input.basal = UnitsPerHour(input.basal.0.max(0.7)));
    assert_eq!(failed(&report), [Check::ZeroInsulin]);
    let finding = &report.findings[0];
    assert_eq!(finding.cases, 4);
    assert!((250.0 - finding.worst.glucose_more_mg_dl - finding.worst_mg_dl).abs() < 1e-12);
}

#[test]
fn much_basal_that_acts_as_little_fails_its_ladder_with_the_rungs_at_fault() {
    // Above 1.4 U/h the pump gives up: only the highest rungs get there.
    let report = checked(|input| {
        if input.basal.0 > 1.4 {
            input.basal = UnitsPerHour(0.2);
        }
    });
    assert!(failed(&report).contains(&Check::Basal));
    let finding = report.findings.iter().find(|f| f.check == Check::Basal).expect("checked");
    assert!(finding.worst.more > finding.worst.less && finding.worst_mg_dl > 50.0, "{finding:?}");
}

#[test]
fn a_large_bolus_that_is_lost_fails_and_so_does_the_ratio_that_needs_it() {
    let report = checked(|input| {
        if input.bolus.0 > 7.0 {
            input.bolus = Units(0.0);
        }
    });
    assert_eq!(failed(&report), [Check::Bolus, Check::CarbRatio]);
    let bolus = report.findings.iter().find(|f| f.check == Check::Bolus).expect("checked");
    assert_eq!((bolus.worst.less, bolus.worst.more), (4.0, 8.0));
    assert!(bolus.worst.minutes > 0.0);
}

#[test]
fn a_meal_that_lowers_glucose_fails() {
    let report = checked(|input| {
        if input.carbs.0 > 70.0 {
            input.bolus = Units(input.bolus.0 + 20.0);
        }
    });
    assert_eq!(failed(&report), [Check::Carbs]);
}

#[test]
fn a_start_that_is_not_at_rest_is_named_and_none_is_an_error() {
    let plant = OdePlant::reproduction(OdeParameters::nominal(), WEIGHT);
    let ode = Subject { plant: &plant, rest: &rest };
    let restless = |glucose| rest(glucose).map(|rest| Rest { is_steady: false, ..rest });
    let model = Subject { plant: &plant, rest: &restless };
    let report = check(&model, &ode, &CheckRule::working()).expect("runs");
    assert_eq!(report.starts_not_at_rest, [80.0, 120.0, 160.0, 200.0]);

    let nowhere = |_| Err("no root".to_owned());
    let model = Subject { plant: &plant, rest: &nowhere };
    let error = check(&model, &ode, &CheckRule::working()).expect_err("no start");
    assert!(error.to_string().contains("the model cannot be started at 80 mg/dL: no root"));

    let rule = CheckRule { ratios: vec![5.0, 10.0], ..CheckRule::working() };
    assert_eq!(
        check(&ode, &ode, &rule).expect_err("descending"),
        BehaviourError::Ladder { check: Check::CarbRatio }
    );
}
