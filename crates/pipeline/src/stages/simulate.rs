//! `simulate`: virtual patients of the ODE model through the authors' test scenario.
//!
//! Reads the layout of the published virtual patient population and writes one row a patient,
//! scenario and step.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail, ensure};
use cohort::TextTable;
use ode_sim::vpp_scenario::{Meal, Row, START_GLUCOSE, Scenario, VirtualPatient, trace};
use ode_sim::{OdeParameters, OdeState, OdeVector};
use physiology::{Compartment, Grams, Kilograms, STEP, STEPS_PER_DAY, Units};
use rayon::prelude::*;

use crate::bounds::within;
use crate::{Manifest, OutputFolder, Progress, note};

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
const STATES: [Compartment; 8] = {
    use Compartment::{I, Q1, Q2, S1, S2, X1, X2, X3};
    [Q1, Q2, S1, S2, I, X1, X2, X3]
};

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    let scenarios = match &args.scenario {
        None => Scenario::ALL.to_vec(),
        Some(name) => vec![Scenario::from_name(name).with_context(|| {
            let known = Scenario::ALL.map(Scenario::name).join(" and ");
            format!("there is no scenario '{name}'; the scenarios are {known}")
        })?],
    };
    within("--days", args.days, 1, MOST_DAYS)?;
    let patients = read_patients(&args.patients)?;
    let meals = read_meals(&args.meals, args.days * STEPS_PER_DAY)?;
    let initial = args.initial.as_deref().map(|path| anyhow::Ok((path, read_initial(path)?)));
    let initial = initial.transpose()?;

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
                Some((path, rows)) => start_of(name, path, rows)?,
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
        let _ = write!(text, "{patient},{scenario},{},{minutes}", row.step);
        let numbers = [row.glucose.0, row.insulin.0];
        for value in numbers.into_iter().chain(STATES.map(|compartment| x[compartment])) {
            let _ = write!(text, ",{}", rounded(value));
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
    let mut patients: Vec<(String, VirtualPatient)> = Vec::with_capacity(table.0.height());
    for row in 0..table.0.height() {
        let number = |column| table.number(column, row);
        let positive = |column| {
            let value = number(column)?;
            ensure!(value > 0.0, "{}: {value} must be positive", table.place(column, row));
            Ok(value)
        };
        let name = table.text("patient", row)?;
        let place = table.place("patient", row);
        ensure!(
            !name.contains([',', '"', '\n', '\r']),
            "{place}: the name '{name}' cannot stand in a CSV file; rename the patient"
        );
        let is_twice = patients.iter().any(|(known, _)| *known == name);
        ensure!(!is_twice, "{place}: '{name}' stands there twice");
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
    let meal = |row| {
        let grams = table.number("carbs_g", row)?;
        let place = table.place("carbs_g", row);
        ensure!(grams >= 0.0, "{place}: a meal of {grams} g");
        ensure!(
            grams <= LARGEST_MEAL,
            "{place}: a meal of {grams} g is more than {LARGEST_MEAL} g; check the unit"
        );
        if grams > LARGE_MEAL {
            note(format!("{place}: a meal of {grams} g; check the unit"));
        }
        let step = table.whole("step", row)?;
        if step > last_step {
            note(format!(
                "{}: the meal lies after the last step, {last_step}, and is not eaten",
                table.place("step", row)
            ));
        }
        Ok(Meal { step, carbs: Grams(grams) })
    };
    (0..table.0.height()).map(meal).collect()
}

/// The initial states of a table, by patient.
fn read_initial(path: &Path) -> Result<Vec<(String, OdeState)>> {
    let table = Table::read(path)?;
    let mut rows: Vec<(String, OdeState)> = Vec::with_capacity(table.0.height());
    for row in 0..table.0.height() {
        let mut x = OdeVector::default();
        for compartment in STATES {
            let column = compartment.name().to_lowercase();
            let value = table.number(&column, row)?;
            ensure!(value >= 0.0, "{}: {value} must not be negative", table.place(&column, row));
            x[compartment] = value;
        }
        let name = table.text("patient", row)?;
        let is_twice = rows.iter().any(|(known, _)| *known == name);
        ensure!(!is_twice, "{}: '{name}' has two rows", table.place("patient", row));
        rows.push((name, OdeState::default().with_vector(&x)));
    }
    Ok(rows)
}

/// A patient's initial state among those of a file.
fn start_of(patient: &str, path: &Path, rows: &[(String, OdeState)]) -> Result<OdeState> {
    let own = rows.iter().find(|(name, _)| name == patient);
    own.map(|(_, state)| *state)
        .with_context(|| format!("'{}' has no row for patient {patient}", path.display()))
}

/// A CSV file with a header, whose cells are required; every fault has its place.
struct Table(TextTable);

impl Table {
    /// Reads the file.
    ///
    /// # Errors
    /// If it is missing, is not text, has no header, no rows or ragged ones.
    fn read(path: &Path) -> Result<Self> {
        if path.is_dir() {
            bail!("'{}' is a folder; a CSV file is needed", path.display());
        }
        Ok(Self(TextTable::read(path, &path.display().to_string(), b',')?))
    }

    /// The text of a cell.
    fn text(&self, column: &str, row: usize) -> Result<String> {
        let text = self.0.column(column)?.text(row).map(str::to_owned);
        text.with_context(|| format!("{}: the cell is empty", self.place(column, row)))
    }

    /// A cell as a finite number.
    fn number(&self, column: &str, row: usize) -> Result<f64> {
        Ok(self.0.column(column)?.required_number(row)?)
    }

    /// A cell as a whole number that is not negative.
    fn whole(&self, column: &str, row: usize) -> Result<usize> {
        let text = self.text(column, row)?;
        text.parse().with_context(|| {
            format!("{}: '{text}' is not a whole number of 0 or more", self.place(column, row))
        })
    }

    /// Where a cell stands, for a message.
    fn place(&self, column: &str, row: usize) -> String {
        let column = self.0.column(column);
        column.map_or_else(|_| self.0.place(row), |column| column.place(row)).to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_patient_without_a_start_is_named_with_the_file() {
        let path = Path::new("initial_states.csv");
        let error = start_of("p1", path, &[]).expect_err("no row");
        assert_eq!(error.to_string(), "'initial_states.csv' has no row for patient p1");
    }

    fn table(text: &str) -> Result<Table> {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("t.csv");
        std::fs::write(&path, text).expect("writable");
        Table::read(&path)
    }

    #[test]
    fn cells_are_found_by_name_and_row() {
        let table = table("a,b\n1,2.5\n3,x\n").expect("a table");
        assert_eq!(table.0.height(), 2);
        assert_eq!(table.number("b", 0).expect("a number"), 2.5);
        assert_eq!(table.whole("a", 1).expect("whole"), 3);
    }

    #[test]
    fn faults_name_their_place() {
        let table = table("a,b\n1,2.5\n-3,x\n").expect("a table");
        for (error, words) in [
            (table.number("b", 1).err(), "row 3, column b: 'x' is not a number"),
            (table.whole("a", 1).err(), "row 3, column a: '-3' is not a whole number"),
            (table.number("c", 0).err(), "no column 'c'; found a, b"),
        ] {
            let message = error.expect("refused").to_string();
            assert!(message.contains(words), "{message}");
        }
    }
}
