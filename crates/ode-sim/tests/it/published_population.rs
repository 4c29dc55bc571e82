//! The published virtual patients: traces of the authors' own program, digit by digit.

use std::collections::HashMap;
use std::path::Path;

use ode_sim::equations::{Forcing, derivative};
use ode_sim::vpp_scenario::{Meal, Scenario, VirtualPatient, trace};
use ode_sim::{EgpMode, OdeParameters, OdeState, VirtualPerson};
use physiology::{Compartment, Grams, Kilograms, Units};

/// A CSV file of numbers and names: the rows as maps from column name to text.
fn rows(path: &Path) -> Vec<HashMap<String, String>> {
    let text = std::fs::read_to_string(path).expect("a reference file can be read");
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    lines
        .map(|line| {
            let cells = line.split(',').map(str::to_owned);
            header.iter().map(|name| (*name).to_owned()).zip(cells).collect()
        })
        .collect()
}

fn number(row: &HashMap<String, String>, column: &str) -> f64 {
    row[column].parse().expect("a number")
}

fn patients(folder: &Path) -> HashMap<String, VirtualPatient> {
    let patient = |row: &HashMap<String, String>| VirtualPatient {
        parameters: OdeParameters {
            f_01: number(row, "f01c_mmol_kg_min"),
            v_g: number(row, "vg_l_kg"),
            k_12: number(row, "k12_per_min"),
            a_g: number(row, "ag"),
            t_max_g: number(row, "tmax_g_min"),
            egp_0: number(row, "egp0_mmol_kg_min"),
            t_max_i: number(row, "tmax_i_min"),
            k_e: number(row, "ke_per_min"),
            v_i: number(row, "vi_l_kg"),
            k_a1: number(row, "ka1_per_min"),
            k_a2: number(row, "ka2_per_min"),
            k_a3: number(row, "ka3_per_min"),
            s_f1: number(row, "sf1"),
            s_f2: number(row, "sf2"),
            s_f3: number(row, "sf3"),
        },
        weight: Kilograms(number(row, "weight_kg")),
        total_daily_insulin: Units(number(row, "tdir_u")),
    };
    rows(&folder.join("patients.csv")).iter().map(|r| (r["patient"].clone(), patient(r))).collect()
}

fn initial_states(folder: &Path) -> HashMap<String, OdeState> {
    let state = |row: &HashMap<String, String>| OdeState {
        q1: number(row, "q1"),
        q2: number(row, "q2"),
        s1: number(row, "s1"),
        s2: number(row, "s2"),
        i: number(row, "i"),
        x1: number(row, "x1"),
        x2: number(row, "x2"),
        x3: number(row, "x3"),
        ..OdeState::default()
    };
    rows(&folder.join("initial_states.csv"))
        .iter()
        .map(|r| (r["patient"].clone(), state(r)))
        .collect()
}

/// Half a unit in the ninth significant digit, as far as the file prints states.
fn half_a_digit(value: f64) -> f64 {
    if value == 0.0 { 5e-10 } else { 0.5 * 10f64.powf(value.abs().log10().floor() - 8.0) }
}

#[test]
fn every_published_trace_is_reproduced_to_its_printed_digits() {
    let Some(folder) = reference_data::find("t1d_vpp", "published traces") else { return };
    let patients = patients(&folder);
    let starts = initial_states(&folder);
    let meals: Vec<Meal> = rows(&folder.join("meals.csv"))
        .iter()
        .map(|r| Meal { step: number(r, "step") as usize, carbs: Grams(number(r, "carbs_g")) })
        .collect();
    let expected = rows(&folder.join("traces.csv"));

    let mut checked = 0;
    for block in
        expected.chunk_by(|a, b| a["patient"] == b["patient"] && a["scenario"] == b["scenario"])
    {
        let id = &block[0]["patient"];
        let scenario = Scenario::from_name(&block[0]["scenario"]).expect("one of the two");
        let ours = trace(&patients[id], &meals, starts[id], scenario, 4).expect("finite");
        assert_eq!(ours.len(), block.len(), "rows of patient {id}, {scenario}");
        for (row, published) in ours.iter().zip(block) {
            let place = format!("patient {id}, {scenario}, step {}", row.step);
            assert_eq!(row.step, number(published, "step") as usize, "{place}");
            let deviation = (row.glucose.0 - number(published, "bg_mg_dl")).abs();
            // Printed to nine digits: half a unit of 1e-6 for glucose of 100 mg/dL and more.
            assert!(deviation <= 5.1e-7, "{place}: glucose off by {deviation}");
            let x = row.state;
            let quantities = [
                ("insulin_u_h", row.insulin.0),
                ("q1", x.q1),
                ("q2", x.q2),
                ("s1", x.s1),
                ("s2", x.s2),
                ("i", x.i),
                ("x1", x.x1),
                ("x2", x.x2),
                ("x3", x.x3),
            ];
            for (column, value) in quantities {
                let printed = number(published, column);
                // The patients file gives parameters to twelve digits, the states carry that on.
                let tolerance = half_a_digit(printed) + 1e-10 * printed.abs();
                assert!(
                    (value - printed).abs() <= tolerance,
                    "{place}: {column} {value} is not {printed}"
                );
            }
            checked += 1;
        }
    }
    assert_eq!(checked, 11_530, "five patients, two scenarios, 1153 rows each");
}

#[test]
fn insulin_needs_follow_from_the_steady_state_at_115() {
    let Some(folder) = reference_data::find("t1d_vpp", "published insulin needs") else { return };
    for (id, patient) in patients(&folder) {
        let person = VirtualPerson::of(0, patient.parameters, patient.weight).expect("basal");
        let published = patient.total_daily_insulin.0;
        let deviation = (person.total_daily_insulin.0 / published - 1.0).abs();
        // The authors' solver stops at its default tolerance of 1e-6 on the sum of squares.
        assert!(
            deviation < 1e-3,
            "patient {id}: {} U against {published} U",
            person.total_daily_insulin.0
        );
    }
}

#[test]
fn published_initial_states_stand_still_to_their_solvers_tolerance() {
    let Some(folder) = reference_data::find("t1d_vpp", "published initial states") else { return };
    let starts = initial_states(&folder);
    let mut largest = 0.0_f64;
    for (id, patient) in patients(&folder) {
        let x = starts[&id].vector();
        let p = patient.parameters;
        let forcing = Forcing { insulin: x[Compartment::S1] / p.t_max_i, ..Forcing::default() };
        let dx = derivative(&p, &x, &forcing, EgpMode::Reproduction);
        largest = dx.0.iter().fold(largest, |max, rate| max.max(rate.abs()));
    }
    // `fsolve` stops at a sum of squares of 1e-6, so a single residual stays below 1e-3.
    assert!(largest < 1e-3, "largest derivative {largest}");
}

#[test]
fn the_published_patients_share_one_uniform_draw_and_have_narrower_spreads_than_the_program() {
    let Some(folder) = reference_data::find("t1d_vpp", "published sensitivities") else { return };
    for (id, patient) in patients(&folder) {
        let p = patient.parameters;
        let z = (p.s_f2 / 0.4 - 8.2e-4) / 3.2e-4;
        // The program of the repository has SDs of 14.4e-4 and 137.5e-4; its stored patients were
        // drawn with these.
        let w1 = ((p.s_f1 / 0.4 - 51.2e-4) / 13.1e-4 - z) / 0.25;
        let w3 = ((p.s_f3 / 0.4 - 520e-4) / 125e-4 - z) / 0.75;
        // Parameters are printed to twelve digits.
        assert!((w1 - w3).abs() < 1e-8, "patient {id}: {w1} and {w3}");
        assert!(w1.abs() <= 1.0, "patient {id}: {w1}");
    }
}
