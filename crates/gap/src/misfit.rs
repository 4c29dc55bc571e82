//! Whether the plant describes a person at all, judged once it is calibrated.
//!
//! A factor far beyond what bodies are says that the log or its clock is not what the plant takes it for;
//! innovations that scatter by more than they do in made people, or a search without an end, that the person's
//! body or sensor is not of the plant's kind. Whatever is asked of such a plant next is asked under that doubt.

use crate::filter::calibration::{Calibration, FACTORS, Factor};
use contract::diagnosis::{DataQualityFinding, FindingEstimate};

/// Name of the check.
pub(crate) const CHECK: &str = "plant_misfit";
/// Half width of a 95 % interval, standard deviations.
const INTERVAL: f64 = 1.96;
/// Largest logarithm of a factor, up or down, in the order of [`Factor::ALL`]: the central 99 % of bodies or, where it is
/// wider, of made people. Bodies: log SD of 0.4 for action, 0.2 for EGP0, 0.25 for both times and for bioavailability,
/// 0.15 for F01 (assumed). Made people: the near ends of 95 % intervals in 100 worlds with narrow variation. How many people of wide worlds have a finding was not counted.
const LARGEST: [f64; FACTORS] = [1.05, 0.55, 0.85, 1.2, 0.7, 0.5];
/// Largest scale of whitened innovations, in standard deviations that the filter expects: 99.5 % of 316 people of wide
/// worlds (`xtask realism --worlds 80 --nulls 80 --seed 3`) have less than 1.64.
const LARGEST_SCALE: f64 = 1.65;

/// What the plant may lack to describe a person.
const CLOCK: &str = "clock";
const UNIT: &str = "unit or completeness of a log";
const STRUCTURE: &str = "structure";

/// What the plant lacks where a factor is beyond bodies, what the factor stands for, and what would mend it.
fn reading(factor: Factor, high: bool) -> (&'static str, &'static str, &'static str) {
    match (factor, high) {
        (Factor::TMaxG, true) => (
            CLOCK,
            "meals are absorbed more slowly than in anybody, as if they were logged early",
            "check the clock of the carbohydrate log, and whether meals are logged before they are eaten",
        ),
        (Factor::TMaxG, false) => (
            CLOCK,
            "meals are absorbed faster than in anybody, as if they were logged late",
            "check the clock of the carbohydrate log, and whether meals are logged after they are eaten",
        ),
        (Factor::TMaxI, true) => (
            CLOCK,
            "insulin acts later than in anybody, as if it were given after its time on record",
            "check the clock of the insulin log, and whether long-acting insulin is recorded as a bolus",
        ),
        (Factor::TMaxI, false) => (
            CLOCK,
            "insulin acts earlier than in anybody, as if it were given before its time on record",
            "check the clock of the insulin log",
        ),
        (Factor::Action, true) => (
            UNIT,
            "insulin on record acts more than in anybody",
            "check the unit of insulin, the body weight, and whether all insulin is on record",
        ),
        (Factor::Action, false) => (
            UNIT,
            "insulin on record acts less than in anybody",
            "check the unit of insulin, the body weight, and whether all carbohydrate is on record",
        ),
        (Factor::AG, true) => (
            UNIT,
            "carbohydrate on record raises glucose more than in anybody",
            "check the unit of carbohydrate, and whether all of it is on record",
        ),
        (Factor::AG, false) => (
            UNIT,
            "carbohydrate on record raises glucose less than in anybody",
            "check the unit of carbohydrate, and whether what is on record was eaten",
        ),
        (Factor::Egp0 | Factor::F01, _) => (
            STRUCTURE,
            "production or uptake of glucose is beyond that of bodies",
            "check whether basal insulin is on record",
        ),
    }
}

/// What says that the plant does not describe a person; empty for most.
pub(crate) fn findings(person: &str, calibration: &Calibration) -> Vec<DataQualityFinding> {
    let finding = |lack: &str, text: String, estimate| DataQualityFinding {
        check: CHECK.to_owned(),
        person_id: person.to_owned(),
        finding: format!(
            "the plant does not describe this person (lacking: {lack}): {text}; effects found in this person are in \
             doubt"
        ),
        estimate,
    };
    let mut found = Vec::new();
    for (k, factor) in Factor::ALL.into_iter().enumerate() {
        let (value, sd) = (calibration.factors.0[k], calibration.sd[k]);
        let certain = value.abs() - INTERVAL * sd > LARGEST[k];
        if certain || calibration.at_bound.contains(&factor) {
            let (lack, what, mend) = reading(factor, value > 0.0);
            let estimate = FindingEstimate {
                value: value.exp(),
                lower: (value - INTERVAL * sd).exp(),
                upper: (value + INTERVAL * sd).exp(),
                unit: format!("of the population's {}", factor.parameter()),
            };
            found.push(finding(lack, format!("{what}; {mend}"), Some(estimate)));
        }
    }
    if calibration.scale > LARGEST_SCALE {
        let n = calibration.whitened.iter().flatten().count().max(1) as f64;
        let half = INTERVAL * calibration.scale * (calibration.dependence / (2.0 * n)).sqrt();
        let estimate = FindingEstimate {
            value: calibration.scale,
            lower: calibration.scale - half,
            upper: calibration.scale + half,
            unit: "of the expected standard deviation of an innovation".to_owned(),
        };
        let text = "readings differ from what is expected five minutes before by more than in all but one of 200 made people; \
                    check the sensor channel for a second sensor or capillary readings";
        found.push(finding(STRUCTURE, text.to_owned(), Some(estimate)));
    }
    if !calibration.converged {
        let text = format!(
            "no parameters describe the record better than their neighbours (stopped after {} iterations); look \
             at the person's days for a change of pump, sensor or therapy",
            calibration.iterations
        );
        found.push(finding(STRUCTURE, text, None));
    }
    found
}
