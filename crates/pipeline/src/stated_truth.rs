//! What the makers of a cohort state beside its folder. Read when a report is written, after the diagnosis is final.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use contract::blind_check::Label;
use contract::truth::ActingEffect;
use contract::{Diagnosis, Document as _, StatedTruth};
use serde::Deserialize;

/// The provenance of a made cohort, beside its folder.
const INFO: &str = "info.json";

/// What is needed of [`INFO`]; it holds much else.
#[derive(Deserialize)]
struct Info {
    world: World,
}

#[derive(Deserialize)]
struct World {
    /// What an amplitude of 1 does, by effect.
    effects: BTreeMap<String, String>,
    people: Vec<WorldPerson>,
}

#[derive(Deserialize)]
struct WorldPerson {
    person_id: String,
    /// Amplitude by effect, of those that act.
    effects: BTreeMap<String, f64>,
}

/// The truth that lies beside the cohort folder; `None` where nothing there states any for these people.
pub(crate) fn stated_truth(cohort: &Path, diagnosis: &Diagnosis) -> Option<StatedTruth> {
    let beside = cohort.canonicalize().ok()?.parent()?.to_path_buf();
    let read = |name: &str| std::fs::read(beside.join(name)).ok();
    let info = || of_info(serde_json::from_slice(&read(INFO)?).ok()?, diagnosis);
    let label = || of_label(contract::read(&read(Label::FILE)?).ok()?, diagnosis);
    info().or_else(label)
}

/// The truth by person, if it is about the people who were diagnosed.
fn of_info(info: Info, diagnosis: &Diagnosis) -> Option<StatedTruth> {
    let World { effects, people } = info.world;
    let stated: BTreeSet<&String> = people.iter().map(|person| &person.person_id).collect();
    let diagnosed: BTreeSet<&String> =
        diagnosis.people.iter().map(|person| &person.person_id).collect();
    if diagnosed.is_empty() || !diagnosed.is_subset(&stated) {
        return None;
    }
    let people: Vec<&WorldPerson> =
        people.iter().filter(|person| diagnosed.contains(&person.person_id)).collect();
    let effects = effects.into_iter().filter_map(|(effect, says)| {
        let sizes: Vec<f64> = people
            .iter()
            .filter_map(|person| person.effects.get(&effect).copied())
            .filter(|size| *size > 0.0)
            .collect();
        (!sizes.is_empty()).then(|| ActingEffect {
            effect,
            amplitude: sizes.iter().sum::<f64>() / sizes.len() as f64,
            lowest: sizes.iter().copied().reduce(f64::min),
            highest: sizes.iter().copied().reduce(f64::max),
            people: sizes.len(),
            says: Some(says),
            shift_mg_dl: None,
        })
    });
    Some(truth(INFO, effects.collect()))
}

/// The truth of a world of a blind check, if it has as many people as were diagnosed.
fn of_label(label: Label, diagnosis: &Diagnosis) -> Option<StatedTruth> {
    if label.people != diagnosis.people.len() {
        return None;
    }
    let people = label.people;
    let effects = label.effects.into_iter().map(|acting| ActingEffect {
        effect: match acting.in_library {
            true => acting.effect,
            false => format!("outside:{}", acting.effect),
        },
        amplitude: acting.amplitude,
        lowest: None,
        highest: None,
        people,
        says: acting.form,
        shift_mg_dl: Some(acting.achieved_mg_dl),
    });
    Some(truth(Label::FILE, effects.collect()))
}

fn truth(source: &str, mut effects: Vec<ActingEffect>) -> StatedTruth {
    // Those outside the library last.
    effects.sort_by_key(|acting| (acting.effect.contains(':'), acting.effect.clone()));
    StatedTruth { schema: StatedTruth::SCHEMA.to_owned(), source: source.to_owned(), effects }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::stages::diagnose;
    use crate::workspace_root;

    #[test]
    fn a_diagnosis_is_the_same_with_and_without_the_truth_beside_it() {
        let temporary = tempfile::tempdir().expect("a temporary folder");
        let embedded = workspace_root().join("fixtures/embedded");
        // The same cohort twice: alone, and with its makers' file beside it.
        let run = |name: &str, truth: bool| {
            let folder = temporary.path().join(name);
            fs::create_dir_all(folder.join("cohort")).expect("a folder");
            for file in ["people.csv", "records.parquet"] {
                fs::copy(embedded.join("cohort").join(file), folder.join("cohort").join(file))
                    .expect("the embedded cohort");
            }
            if truth {
                fs::copy(embedded.join(INFO), folder.join(INFO)).expect("its truth");
            }
            let settings = diagnose::Settings {
                cohort: folder.join("cohort"),
                model: crate::diagnosed::ODE.to_owned(),
                population: None,
                out: folder.join("out"),
                seed: 1,
                posterior: None,
            };
            diagnose::run(&settings).expect("a diagnosis");
            folder.join("out")
        };
        let (blind, seen) = (run("blind", false), run("seen", true));
        let bytes = |folder: &Path| fs::read(folder.join("diagnosis.json")).expect("written");
        assert!(bytes(&blind) == bytes(&seen), "the truth changed the diagnosis");
        assert!(!blind.join(StatedTruth::FILE).exists());
        let truth = fs::read(seen.join(StatedTruth::FILE)).expect("written");
        let truth: StatedTruth = contract::read(&truth).expect("a truth");
        assert_eq!((truth.source.as_str(), truth.effects.len()), (INFO, 11));
        let dawn = truth.effects.iter().find(|acting| acting.effect == "dawn").expect("it acts");
        assert!(dawn.people == 6 && dawn.lowest < Some(dawn.amplitude));
        let page = |folder: &Path| fs::read_to_string(folder.join("report.html")).expect("written");
        assert!(page(&seen).contains("11 effects act in this cohort"));
        assert!(!page(&blind).contains("Truth beside answer</a>"));
    }

    #[test]
    fn a_file_about_other_people_is_no_truth() {
        let temporary = tempfile::tempdir().expect("a temporary folder");
        fs::create_dir(temporary.path().join("cohort")).expect("a folder");
        fs::copy(
            workspace_root().join("fixtures/embedded").join(INFO),
            temporary.path().join(INFO),
        )
        .expect("a truth");
        let people = |id: &str| {
            let person = serde_json::json!({"person_id": id, "days": 9, "excluded": null, "calibration": null});
            let text = serde_json::json!({"schema": "diagnosis/3", "verdict": "none", "effects": [],
                "candidates": [], "untried": [], "ports": [],
                "posterior": {"something": 0.1, "sets": [], "speaks_from": 0.75, "names_from": 0.5, "source": "made up"},
                "evidence": {"person_days": 9.0, "gains": {}}, "where": [], "baseline": [],
                "how_far": {"horizons": [], "outcomes": [], "amplitudes": [], "innovations": null,
                    "people": [], "notes": []},
                "data_quality": [], "people": [person], "plant": "ode", "seed": 1, "config": null});
            let diagnosis: Diagnosis =
                contract::read(text.to_string().as_bytes()).expect("a diagnosis");
            stated_truth(&temporary.path().join("cohort"), &diagnosis)
        };
        assert!(people("someone").is_none());
        let one = people("P03").expect("one of the six");
        assert!(one.effects.iter().all(|acting| acting.people == 1));
    }
}
