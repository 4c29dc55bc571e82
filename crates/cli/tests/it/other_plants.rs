//! `diagnose --model` for networks and twins: what comes out, and what is refused.
//!
//! The network is written down, not trained: two units per compartment give the ODE linear about its steady state.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::Arc;

use cohort::{Cohort, RecordsFormat, read_folder, write_folder};
use nn_statespace::{
    CentreAndScale, GlucoseClamp, HiddenLayerNetwork, ModelCard, PerCompartment, PopulationModel,
    Scaler, Signal, Wiring,
};
use ode_sim::OdeParameters;
use physiology::Compartment::{self, C1, C2, I, Q1, Q2, S1, S2, X1, X2, X3};
use serde_json::Value;
use twins::{HIDDEN, INPUTS, InputSet, ResidualNetwork, Twin, TwinCard};

fn xtask(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_t1d-twins"))
        .args(arguments)
        .output()
        .expect("the program starts")
}

fn text(path: &Path) -> &str {
    path.to_str().expect("temporary paths are UTF-8")
}

fn centre_and_scale(signal: Signal) -> CentreAndScale {
    let (centre, scale) = match signal {
        Signal::State(S1 | S2) => (12.0, 6.0),
        Signal::State(I) => (13.0, 6.0),
        Signal::State(X1) => (0.025, 0.01),
        Signal::State(X2) => (0.004, 0.002),
        Signal::State(X3) => (0.25, 0.1),
        Signal::State(Q1) => (140.0, 50.0),
        Signal::State(Q2) => (0.4, 0.2),
        Signal::State(C1) => (0.0, 1.0),
        Signal::State(C2) => (0.01, 0.01),
        Signal::Insulin => (1.0, 0.5),
        Signal::Carbs => (0.0, 1.0),
    };
    CentreAndScale { centre, scale }
}

/// Rates linear in the signals of each network: slopes in the wiring's order and a constant, physical units.
fn linear_rates(compartment: Compartment) -> (Vec<f64>, f64) {
    let p = OdeParameters::nominal();
    let weight = 75.0;
    let infusion = 1000.0 / 60.0 / weight; // mU/kg/min per U/h
    let per_gram = p.a_g / (0.18 * weight) / 5.0; // mmol/kg/min
    let mg_dl = 18.0 / p.v_g; // per mmol/kg
    // The steady state of 1 U/h at 140 mg/dL.
    let insulin = infusion / (p.v_i * p.k_e);
    let (x1, x2) = (p.s_f1 * insulin, p.s_f2 * insulin);
    let q1 = 140.0 / mg_dl;
    let q2 = x1 * q1 / (p.k_12 + x2);
    let effect = |speed: f64, sensitivity: f64| (vec![speed * sensitivity, -speed], 0.0);
    match compartment {
        S1 => (vec![-1.0 / p.t_max_i, infusion], 0.0),
        S2 => (vec![1.0 / p.t_max_i, -1.0 / p.t_max_i], 0.0),
        I => (vec![1.0 / (p.t_max_i * p.v_i), -p.k_e], 0.0),
        X1 => effect(p.k_a1, p.s_f1),
        X2 => effect(p.k_a2, p.s_f2),
        X3 => effect(p.k_a3, p.s_f3),
        Q1 => (
            vec![-mg_dl * q1, -mg_dl * p.egp_0, -x1, mg_dl * p.k_12, mg_dl],
            mg_dl * (x1 * q1 + p.egp_0 - p.f_01),
        ),
        Q2 => (vec![q1, -q2, x1 / mg_dl, -(p.k_12 + x2)], -x1 * q1 + x2 * q2),
        C1 => (vec![-1.0 / p.t_max_g, per_gram], 0.0),
        C2 => (vec![p.t_max_g.powi(-2), -1.0 / p.t_max_g], 0.0),
    }
}

/// The linear rates as networks: a ReLU of a sum less that of its opposite is the sum.
fn population() -> PopulationModel {
    population_scaling(centre_and_scale(Signal::Carbs))
}

/// The same, told that carbohydrate was scaled in another way.
fn population_scaling(carbs: CentreAndScale) -> PopulationModel {
    let wiring = Wiring::paper();
    let networks = PerCompartment::from_fn(|compartment| {
        let (slopes, constant) = linear_rates(compartment);
        let own = centre_and_scale(Signal::State(compartment)).scale;
        let (mut row, mut bias) = (Vec::new(), constant / own);
        for (signal, slope) in wiring.inputs(compartment).iter().zip(slopes) {
            let CentreAndScale { centre, scale } = centre_and_scale(*signal);
            row.push(slope * scale / own);
            bias += slope * centre / own;
        }
        let opposite: Vec<f64> = row.iter().map(|weight| -weight).collect();
        let inputs = row.len();
        let w1 = [row, opposite].concat();
        HiddenLayerNetwork::new(inputs, w1, vec![bias, -bias], vec![1.0, -1.0], 0.0).expect("fits")
    });
    let states = PerCompartment::from_fn(|c| centre_and_scale(Signal::State(c)));
    let scaler = Scaler::new(states, centre_and_scale(Signal::Insulin), carbs).expect("positive");
    let card = ModelCard {
        origin: "written down for a test".to_owned(),
        version: "0".to_owned(),
        training_data_sha256: None,
        training: None,
    };
    PopulationModel::new(wiring, networks, scaler, GlucoseClamp::Off, card).expect("fits")
}

/// A twin whose residual network adds `rate` scaled units of Q1 a minute times the cosine of the hour.
fn twin(person: &str, population: &Arc<PopulationModel>, rate: f64, days: Option<usize>) -> Twin {
    let shapes =
        [(INPUTS, HIDDEN[0]), (HIDDEN[0], HIDDEN[1]), (HIDDEN[1], HIDDEN[2]), (HIDDEN[2], 1)];
    let mut w: Vec<Vec<f64>> = shapes.iter().map(|(i, o)| vec![0.0; i * o]).collect();
    let b: Vec<Vec<f64>> = shapes.iter().map(|(_, o)| vec![0.0; *o]).collect();
    // Units 0 and 1 carry the cosine (input 7) and its opposite through every layer.
    for (unit, sign) in [(0, 1.0), (1, -1.0)] {
        w[0][unit * INPUTS + 7] = sign;
        w[1][unit * HIDDEN[0] + unit] = 1.0;
        w[2][unit * HIDDEN[1] + unit] = 1.0;
        w[3][unit] = sign * rate;
    }
    let residual =
        ResidualNetwork::from_tensors([&w[0], &w[1], &w[2], &w[3]], [&b[0], &b[1], &b[2], &b[3]])
            .expect("shapes");
    Twin {
        population: Arc::clone(population),
        residual,
        heart_rate_scaler: None,
        inputs: InputSet::All,
        card: TwinCard {
            person_id: person.to_owned(),
            origin: "written down for a test".to_owned(),
            version: "0".to_owned(),
            training_data_sha256: None,
            training: days.map(|days| serde_json::json!({ "training_days": days })),
        },
    }
}

/// Three of the embedded people, twelve days each.
fn some_people() -> Cohort {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/embedded/cohort");
    let mut cohort = read_folder(&folder).expect("the fixture");
    cohort.people.truncate(3);
    for person in &mut cohort.people {
        person.record = person.record.slice(0..12 * 288).expect("not empty");
    }
    cohort
}

/// A folder with a cohort, a network and twins as the command twin writes them.
struct Made {
    folder: tempfile::TempDir,
}

impl Made {
    fn new() -> Self {
        let made = Self { folder: tempfile::tempdir().expect("a folder") };
        fs::create_dir_all(made.at("twin/twins")).expect("a folder");
        let population = Arc::new(population());
        fs::write(made.at("twin/population.safetensors"), population.to_safetensors())
            .expect("writable");
        for (person, days) in [("P01", Some(4)), ("P02", None)] {
            let twin = twin(person, &population, 0.002, days).to_bytes().expect("a file");
            fs::write(made.at(&format!("twin/twins/{person}.safetensors")), twin)
                .expect("writable");
        }
        write_folder(&some_people(), &made.at("cohort"), RecordsFormat::Csv).expect("writable");
        made
    }

    fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn diagnose(&self, model: &str, more: &[&str]) -> Output {
        let (cohort, model, out) = (self.at("cohort"), self.at(model), self.at("out"));
        let arguments = ["diagnose", "--cohort", text(&cohort), "--model", text(&model)];
        xtask(&[&arguments[..], &["--out", text(&out), "-q"], more].concat())
    }

    fn diagnosed(&self, model: &str) -> (Value, String) {
        let output = self.diagnose(model, &[]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let read = |name: &str| fs::read_to_string(self.at("out").join(name)).expect("written");
        (serde_json::from_str(&read("diagnosis.json")).expect("JSON"), read("report.html"))
    }

    fn refused(&self, model: &str, more: &[&str], words: &[&str]) {
        let output = self.diagnose(model, more);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{model}: {message}");
        assert!(!message.contains("panicked"), "{message}");
        for word in words {
            assert!(message.contains(word), "'{word}' is not in: {message}");
        }
        assert!(!self.at("out").exists(), "{model} left something behind");
    }
}

fn excluded<'a>(diagnosis: &'a Value, person: &str) -> Option<&'a str> {
    let people = diagnosis["people"].as_array().expect("a list");
    let found = people.iter().find(|p| p["person_id"] == person).expect("named");
    found["excluded"].as_str()
}

#[test]
fn a_network_is_diagnosed_and_says_how_much_to_believe() {
    let made = Made::new();
    let (diagnosis, html) = made.diagnosed("twin/population.safetensors");
    assert_eq!(diagnosis["plant"], "network");
    for person in ["P01", "P02", "P03"] {
        assert_eq!(excluded(&diagnosis, person), None, "{person}");
    }
    let notes = diagnosis["notes"].as_array().expect("a list");
    assert!(notes[0].as_str().expect("text").contains("direction to look in"), "{notes:?}");
    assert!(html.contains("direction to look in"));
    assert!(diagnosis.get("absorbed").is_none());
    // A network near the ODE errs about as much as the ODE does, and follows the person.
    let ode = xtask(&[
        "diagnose",
        "--cohort",
        text(&made.at("cohort")),
        "--out",
        text(&made.at("ode")),
        "-q",
    ]);
    assert!(ode.status.success());
    let ode = fs::read(made.at("ode/diagnosis.json")).expect("written");
    let ode: Value = serde_json::from_slice(&ode).expect("JSON");
    let mae =
        |diagnosis: &Value| diagnosis["baseline"][0]["mae"]["value"].as_f64().expect("a number");
    let (own, other) = (mae(&diagnosis), mae(&ode));
    assert!((0.5..1.6).contains(&(own / other)), "{own} against {other} mg/dL an hour ahead");
    assert!(ode.get("absorbed").is_none(), "the ODE has no residual");
    let notes = ode["notes"].to_string();
    assert!(notes.contains("How much to believe"), "{notes}");
}

#[test]
fn twins_are_judged_on_other_days_than_trained_them_and_beside_the_network_alone() {
    let made = Made::new();
    let (diagnosis, html) = made.diagnosed("twin");
    assert_eq!(diagnosis["plant"], "twin");
    assert_eq!(excluded(&diagnosis, "P03"), Some("no twin of this person"));
    let days = |person: usize| diagnosis["people"][person]["days"].as_u64().expect("a number");
    // Four of P01's twelve days trained the twin; P02's file does not say.
    assert_eq!((days(0), days(1)), (8, 12));
    let notes = diagnosis["notes"].to_string();
    assert!(notes.contains("do not say on which days") && notes.contains("P02"), "{notes}");
    let absorbed = &diagnosis["absorbed"];
    assert_eq!(absorbed["without"], "network");
    let effects = absorbed["effects"].as_array().expect("a list");
    assert!(!effects.is_empty());
    for row in effects {
        let value = |key: &str| row[key].as_f64().expect("a number");
        let (before, after) = (value("evidence_before"), value("evidence_after"));
        match row["share"].as_f64() {
            Some(share) => assert!((share - (1.0 - after.max(0.0) / before)).abs() < 1e-9, "{row}"),
            None => assert!(before < 4.0, "{row}"),
        }
    }
    // A residual that follows the clock changes what the clock explains.
    let moved = |row: &Value| row["evidence_before"] != row["evidence_after"];
    assert!(effects.iter().any(moved), "{effects:?}");
    assert_eq!(absorbed["baseline"].as_array().map(Vec::len), Some(3));
    assert!(html.contains("What the residual networks have absorbed"));

    // One person's file, with the network in the folder above.
    fs::remove_dir_all(made.at("out")).expect("removable");
    let (alone, _) = made.diagnosed("twin/twins/P01.safetensors");
    assert_eq!(excluded(&alone, "P01"), None);
    assert_eq!(excluded(&alone, "P02"), Some("no twin of this person"));
}

#[test]
fn models_that_cannot_be_diagnosed_are_refused_in_words() {
    let made = Made::new();
    made.refused("nowhere.safetensors", &[], &["nowhere.safetensors", "ode"]);
    fs::write(made.at("words"), "not a model").expect("writable");
    made.refused("words", &[], &["words", "neither a population model nor a twin"]);
    fs::create_dir(made.at("empty")).expect("a folder");
    made.refused("empty", &[], &["no twins", "empty"]);

    // A network without the scaler of its carbohydrate.
    let bytes = fs::read(made.at("twin/population.safetensors")).expect("written");
    let place = bytes.windows(7).position(|w| w == b"u_carbs").expect("named in the header");
    let mut without = bytes.clone();
    without[place..place + 7].copy_from_slice(b"u_sugar");
    fs::write(made.at("without"), without).expect("writable");
    made.refused("without", &[], &["without", "u_sugar"]);

    // Twins away from their network, with another network, and of somebody else.
    fs::create_dir(made.at("alone")).expect("a folder");
    fs::copy(made.at("twin/twins/P01.safetensors"), made.at("alone/P01.safetensors"))
        .expect("copied");
    made.refused("alone", &[], &["population.safetensors", "--population"]);
    let other = population_scaling(CentreAndScale { centre: 0.0, scale: 2.0 });
    fs::write(made.at("other"), other.to_safetensors()).expect("writable");
    let named = made.at("other");
    made.refused("alone", &["--population", text(&named)], &["trained on the population model"]);
    let stranger = twin("somebody", &Arc::new(population()), 0.0, None);
    fs::write(made.at("twin/stranger.safetensors"), stranger.to_bytes().expect("a file"))
        .expect("writable");
    made.refused("twin/stranger.safetensors", &[], &["twins of somebody", "none of whom"]);
    let bytes = fs::read(made.at("twin/twins/P01.safetensors")).expect("written");
    fs::write(made.at("twin/twins/P09.safetensors"), bytes).expect("writable");
    made.refused("twin", &[], &["P09.safetensors", "second twin of person 'P01'"]);
}
