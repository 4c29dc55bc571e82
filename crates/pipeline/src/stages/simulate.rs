//! `simulate`: virtual patients of the ODE model through the authors' test scenario.
//!
//! Reads the layout of the published virtual patient population and writes one row a patient,
//! scenario and step.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use ode_sim::vpp_scenario::{Meal, Row, START_GLUCOSE, Scenario, VirtualPatient, trace};
use ode_sim::{OdeParameters, OdeState, OdeVector};
use physiology::{Compartment, Grams, Kilograms, STEP, STEPS_PER_DAY, Units};
use rayon::prelude::*;

use crate::bounds::within;
use crate::inputs::Table;
use crate::manifest::Manifest;
use crate::output::OutputFolder;
use crate::progress::{Progress, note};

/// Settings of `simulate`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Parameters of the patients, a row each.
    pub patients: PathBuf,
    /// Meals: step and grams.
    pub meals: PathBuf,
    /// Initial states, a row a patient; the steady state at 160 mg/dL if not given.
    pub initial: Option<PathBuf>,
    /// Days to simulate.
    pub days: usize,
    /// One scenario by name; both if not given.
    pub scenario: Option<String>,
    /// Output folder.
    pub out: PathBuf,
}

/// Most days of a trace: ten years, beyond which memory runs out before anyone reads it.
const MOST_DAYS: usize = 3650;
/// Largest plausible meal, g; a larger one is said.
const LARGE_MEAL: f64 = 250.0;
/// Largest meal, g.
const LARGEST_MEAL: f64 = 2000.0;
/// Columns of `traces.csv`.
const HEADER: &str = "patient,scenario,step,time_min,bg_mg_dl,insulin_u_h,q1,q2,s1,s2,i,x1,x2,x3";
/// The eight states of a trace, in the order of its columns.
const STATES: [(&str, Compartment); 8] = [
    ("q1", Compartment::Q1),
    ("q2", Compartment::Q2),
    ("s1", Compartment::S1),
    ("s2", Compartment::S2),
    ("i", Compartment::I),
    ("x1", Compartment::X1),
    ("x2", Compartment::X2),
    ("x3", Compartment::X3),
];

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    let scenarios = match &args.scenario {
        None => Scenario::ALL.to_vec(),
        Some(name) => match Scenario::from_name(name) {
            Some(scenario) => vec![scenario],
            None => bail!(
                "there is no scenario '{name}'; the scenarios are {}",
                Scenario::ALL.map(Scenario::name).join(" and ")
            ),
        },
    };
    within("--days", args.days, 1, MOST_DAYS)?;
    let patients = read_patients(&args.patients)?;
    let meals = read_meals(&args.meals, args.days * STEPS_PER_DAY)?;
    let initial = args.initial.as_deref().map(InitialStates::read).transpose()?;

    let config = serde_json::json!({
        "scenarios": scenarios.iter().map(|s| s.name()).collect::<Vec<_>>(),
        "days": args.days,
        "initial": if initial.is_some() { "table" } else { "steady state" },
        "start_glucose_mg_dl": START_GLUCOSE.0,
    });
    let manifest = Manifest::new("simulate", config, None)
        .with_input(&args.patients)?
        .with_input(&args.meals)?
        .with_inputs(&args.initial)?;
    let output = OutputFolder::begin(&args.out, manifest)?;

    let jobs: Vec<(&(String, VirtualPatient), Scenario)> =
        scenarios.iter().flat_map(|s| patients.iter().map(move |p| (p, *s))).collect();
    let progress = Progress::begin("simulate", jobs.len());
    let traces = jobs
        .par_iter()
        .map(|((name, patient), scenario)| {
            let start = match &initial {
                Some(table) => table.of(name)?,
                None => patient.initial_state().with_context(|| format!("patient {name}"))?,
            };
            let rows = trace(patient, &meals, start, *scenario, args.days)
                .with_context(|| format!("patient {name}, scenario {scenario}"))?;
            progress.advance(name);
            Ok(written(name, *scenario, &rows))
        })
        .collect::<Result<Vec<String>>>()?;
    let mut text = format!("{HEADER}\n");
    traces.iter().for_each(|t| text.push_str(t));
    output.write("traces.csv", text.as_bytes())?;
    let place = output.finish()?;
    progress.finish(&format!(
        "{} patients, {} scenarios, {} days in {}",
        patients.len(),
        scenarios.len(),
        args.days,
        place.join("traces.csv").display()
    ));
    Ok(())
}

fn written(patient: &str, scenario: Scenario, rows: &[Row]) -> String {
    let mut text = String::new();
    for row in rows {
        let x = row.state.vector();
        let minutes = row.step as f64 * STEP.0;
        write!(text, "{patient},{scenario},{},{minutes}", row.step)
            .expect("writing to a String cannot fail");
        let numbers = [row.glucose.0, row.insulin.0];
        for value in numbers.into_iter().chain(STATES.map(|(_, compartment)| x[compartment])) {
            write!(text, ",{}", rounded(value)).expect("writing to a String cannot fail");
        }
        text.push('\n');
    }
    text
}

/// A number with ten significant digits: no simulation knows more, and a comparison is limited by the
/// published traces, which have nine.
fn rounded(value: f64) -> f64 {
    format!("{value:.9e}").parse().unwrap_or(value)
}

pub(crate) fn read_patients(path: &Path) -> Result<Vec<(String, VirtualPatient)>> {
    let table = Table::read(path)?;
    let mut patients: Vec<(String, VirtualPatient)> = Vec::with_capacity(table.rows());
    for row in 0..table.rows() {
        let number = |column| table.number(column, row);
        let positive = |column| {
            let value = number(column)?;
            if value <= 0.0 {
                bail!("{}: {value} must be positive", table.place(column, row));
            }
            Ok(value)
        };
        let name = table.text("patient", row)?;
        if name.contains([',', '"', '\n', '\r']) {
            bail!(
                "{}: the name '{name}' cannot stand in a CSV file; rename the patient",
                table.place("patient", row)
            );
        }
        if patients.iter().any(|(known, _)| *known == name) {
            bail!("{}: '{name}' stands there twice", table.place("patient", row));
        }
        let parameters = OdeParameters {
            f_01: number("f01c_mmol_kg_min")?,
            v_g: number("vg_l_kg")?,
            k_12: number("k12_per_min")?,
            a_g: number("ag")?,
            t_max_g: number("tmax_g_min")?,
            egp_0: number("egp0_mmol_kg_min")?,
            t_max_i: number("tmax_i_min")?,
            k_e: number("ke_per_min")?,
            v_i: number("vi_l_kg")?,
            k_a1: number("ka1_per_min")?,
            k_a2: number("ka2_per_min")?,
            k_a3: number("ka3_per_min")?,
            s_f1: number("sf1")?,
            s_f2: number("sf2")?,
            s_f3: number("sf3")?,
        }
        .validated()
        .with_context(|| format!("'{}', row {}, patient {name}", path.display(), row + 2))?;
        let patient = VirtualPatient {
            parameters,
            weight: Kilograms(positive("weight_kg")?),
            total_daily_insulin: Units(positive("tdir_u")?),
        };
        patients.push((name, patient));
    }
    Ok(patients)
}

fn read_meals(path: &Path, last_step: usize) -> Result<Vec<Meal>> {
    let table = Table::read(path)?;
    (0..table.rows())
        .map(|row| {
            let grams = table.number("carbs_g", row)?;
            if grams < 0.0 {
                bail!("{}: a meal of {grams} g", table.place("carbs_g", row));
            }
            if grams > LARGEST_MEAL {
                bail!(
                    "{}: a meal of {grams} g is more than {LARGEST_MEAL} g; check the unit",
                    table.place("carbs_g", row)
                );
            }
            if grams > LARGE_MEAL {
                note(format!(
                    "{}: a meal of {grams} g; check the unit",
                    table.place("carbs_g", row)
                ));
            }
            let step = table.whole("step", row)?;
            if step > last_step {
                note(format!(
                    "{}: the meal lies after the last step, {last_step}, and is not eaten",
                    table.place("step", row)
                ));
            }
            Ok(Meal { step, carbs: Grams(grams) })
        })
        .collect()
}

/// A table of initial states.
struct InitialStates<'a> {
    path: &'a Path,
    rows: Vec<(String, OdeState)>,
}

impl<'a> InitialStates<'a> {
    fn read(path: &'a Path) -> Result<Self> {
        let table = Table::read(path)?;
        let mut rows: Vec<(String, OdeState)> = Vec::with_capacity(table.rows());
        for row in 0..table.rows() {
            let mut x = OdeVector::default();
            for (column, compartment) in STATES {
                let value = table.number(column, row)?;
                if value < 0.0 {
                    bail!("{}: {value} must not be negative", table.place(column, row));
                }
                x[compartment] = value;
            }
            let name = table.text("patient", row)?;
            if rows.iter().any(|(known, _)| *known == name) {
                bail!("{}: '{name}' has two rows", table.place("patient", row));
            }
            rows.push((name, OdeState::default().with_vector(&x)));
        }
        Ok(Self { path, rows })
    }

    fn of(&self, patient: &str) -> Result<OdeState> {
        let own = self.rows.iter().find(|(name, _)| name == patient);
        own.map(|(_, state)| *state)
            .with_context(|| format!("'{}' has no row for patient {patient}", self.path.display()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_patient_without_a_start_is_named_with_the_file() {
        let path = Path::new("initial_states.csv");
        let error = InitialStates { path, rows: Vec::new() }.of("p1").expect_err("no row");
        assert_eq!(error.to_string(), "'initial_states.csv' has no row for patient p1");
    }
}
