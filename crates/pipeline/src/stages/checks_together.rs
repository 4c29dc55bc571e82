//! `blind-check --together`: finished checks scored as one.
//!
//! One check of 402 worlds leaves wide intervals, above all of the stated probabilities and of the ceiling's bar. Nothing is
//! asked again: labels are held against their seals, and answers are read as they were written.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail, ensure};
use blind::ScoredWorld;
use blind::seal::verify;
use contract::Diagnosis;
use contract::blind_check::{Answer, BlindCheck, ExactCourse, Label, OpenedLabels, Seal, Verdict};
use contract::diagnosis::PosteriorSaid;

use crate::files::{read_bytes, read_document};
use crate::stages::blind_check::write_scored;
use crate::{Manifest, OutputFolder, note};

/// Settings of `blind-check --together`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Output folders of `blind-check`; two or more.
    pub checks: Vec<PathBuf>,
    /// Output folder.
    pub out: PathBuf,
}

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    ensure!(args.checks.len() > 1, "one check is scored already; give --together two or more");
    let finished = args.checks.iter().map(|folder| read(folder));
    let finished = finished.collect::<Result<Vec<Finished>>>()?;
    belong_together(&finished)?;

    let seed = finished[0].seed;
    let seeds: Vec<u64> = finished.iter().map(|check| check.seed).collect();
    let config = serde_json::json!({ "model": finished[0].model, "seeds": seeds });
    let manifest = Manifest::new("blind-check", config, Some(seed)).with_inputs(&args.checks)?;
    let output = OutputFolder::begin(&args.out, manifest)?;
    let courses: Option<Vec<Vec<ExactCourse>>> =
        finished.iter().map(|check| check.courses.clone()).collect();
    let worlds: Vec<ScoredWorld> = finished.into_iter().flat_map(|check| check.worlds).collect();
    note(format!("blind-check: {} worlds of {} checks", worlds.len(), args.checks.len()));
    let mut scored = blind::score(seed, &worlds).context("scoring the answers")?;
    scored.seeds = seeds;
    if let Some(courses) = courses {
        scored = blind::with_ceiling(scored, courses.concat())?;
    }
    write_scored(&scored, output)
}

/// A check that was finished.
pub(super) struct Finished {
    seed: u64,
    /// The plant that was asked, as its manifest has it: `ode`, or a file.
    model: String,
    /// Hashes of that file; none of the ODE.
    plant: Vec<String>,
    /// Hands, each with what the answers to its worlds say of the posterior that gave them.
    posteriors: BTreeSet<(String, String)>,
    pub(super) worlds: Vec<ScoredWorld>,
    /// Of its ceiling, if it has one.
    pub(super) courses: Option<Vec<ExactCourse>>,
}

/// Refuses checks of the same worlds, of different plants, and of different posteriors.
fn belong_together(finished: &[Finished]) -> Result<()> {
    let seeds: BTreeSet<u64> = finished.iter().map(|check| check.seed).collect();
    ensure!(
        seeds.len() == finished.len(),
        "two of these checks have the same seed, and so the same worlds; give each seed once"
    );
    let plants: BTreeSet<&Vec<String>> = finished.iter().map(|check| &check.plant).collect();
    let models: Vec<&str> = finished.iter().map(|check| check.model.as_str()).collect();
    ensure!(
        plants.len() == 1,
        "these checks asked about different plants ({}); give checks of one",
        models.join(", ")
    );
    let mut answered_by: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (hand, posterior) in finished.iter().flat_map(|check| &check.posteriors) {
        answered_by.entry(hand).or_default().insert(posterior);
    }
    if let Some((hand, posteriors)) = answered_by.iter().find(|(_, of)| of.len() > 1) {
        let posteriors = posteriors.iter().copied().collect::<Vec<_>>().join("; ");
        bail!(
            "different posteriors answered worlds of {hand} ({posteriors}); ask all checks again with one version"
        );
    }
    Ok(())
}

/// Reads the check in `folder`. Its worlds get its seed before their names, so that they differ from those of others.
pub(super) fn read(folder: &Path) -> Result<Finished> {
    let shown = folder.display();
    let manifest = Manifest::read(folder)
        .filter(|manifest| manifest.stage == "blind-check" && folder.join("seal.json").is_file())
        .with_context(|| {
            format!("'{shown}' holds no labels under seal; give finished folders of `blind-check`, each as it was asked")
        })?;
    ensure!(
        manifest.outputs_intact_in(folder),
        "a file of '{shown}' is not as `blind-check` wrote it; run the check again"
    );
    let check: BlindCheck = read_document(folder)?;
    let sealed: Seal = read_document(folder)?;
    let OpenedLabels(labels) = read_document(folder)?;
    verify(&sealed, &labels).with_context(|| format!("opening the labels of '{shown}'"))?;
    ensure!(
        labels.iter().map(|label| &label.id).eq(check.worlds.iter().map(|row| &row.id)),
        "labels and answers of '{shown}' are of different worlds; run the check again"
    );

    let seed = check.master_seed;
    let named = |id: &str| format!("{seed}/{id}");
    let mut posteriors = BTreeSet::new();
    let worlds = labels.iter().zip(&check.worlds).map(|(opened, row)| {
        let mut label: Label = serde_json::from_str(&opened.label)
            .with_context(|| format!("'{shown}': the label of {} cannot be read", opened.id))?;
        label.id = named(&label.id);
        let file = folder.join("answers").join(format!("{}.json", row.id));
        let text = read_bytes(&file)?;
        let unread = || format!("'{}'", file.display());
        let answer: Answer = if row.verdict == Verdict::Failed {
            contract::read(&text).with_context(unread)?
        } else {
            let diagnosis: Diagnosis = contract::read(&text).with_context(unread)?;
            let PosteriorSaid { source, speaks_from, .. } = &diagnosis.posterior;
            let said = format!("{source}, which speaks from {speaks_from}");
            posteriors.insert((label.generator.clone(), said));
            blind::answer(diagnosis, row.seconds)
        };
        Ok(ScoredWorld { label, answer })
    });
    let worlds = worlds.collect::<Result<_>>()?;
    Ok(Finished {
        seed,
        model: manifest.config["model"].as_str().unwrap_or_default().to_owned(),
        plant: manifest.inputs.iter().map(|file| file.sha256.clone()).collect(),
        posteriors,
        worlds,
        courses: check.ceiling.map(|ceiling| {
            let mut courses = ceiling.courses;
            courses.iter_mut().for_each(|course| course.id = named(&course.id));
            courses
        }),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use blind::seal::seal;
    use contract::blind_check::{Kind, OpenedLabel};

    /// A check of two worlds in which nothing acts, whose diagnoses failed.
    fn check(parent: &Path, seed: u64, model: &str) -> PathBuf {
        let folder = parent.join(format!("{model}-{seed}"));
        let config = serde_json::json!({ "model": model });
        let asked = (model != "ode").then(|| parent.join(model));
        asked.iter().for_each(|file| std::fs::write(file, model).expect("written"));
        let manifest = Manifest::new("blind-check", config, Some(seed));
        let manifest = manifest.with_inputs(asked).expect("hashed");
        let output = OutputFolder::begin(&folder, manifest).expect("new");
        let worlds: Vec<ScoredWorld> = (1..=2)
            .map(|number| ScoredWorld {
                label: Label {
                    id: format!("world_{number:04}"),
                    kind: Kind::Null,
                    effects: Vec::new(),
                    generator: "padova".to_owned(),
                    regime: "aid".to_owned(),
                    people: 3,
                    days: 7,
                    nuisances: Vec::new(),
                    seed,
                    gap: None,
                },
                answer: Answer::failed("nobody is left", 1.0),
            })
            .collect();
        let labels: Vec<OpenedLabel> = worlds
            .iter()
            .map(|world| {
                let text = serde_json::to_string(&world.label).expect("a label");
                OpenedLabel::new(&world.label.id, "salt", text)
            })
            .collect();
        output.write_document(&seal(&labels)).expect("written");
        output.write_document(&OpenedLabels(labels)).expect("written");
        for world in &worlds {
            let file = format!("answers/{}.json", world.label.id);
            output.write_document_as(&file, &world.answer).expect("written");
        }
        write_scored(&blind::score(seed, &worlds).expect("countable"), output).expect("written");
        folder
    }

    #[test]
    fn the_worlds_of_several_checks_are_scored_as_one() {
        let parent = tempfile::tempdir().expect("a folder");
        let checks = vec![check(parent.path(), 7, "ode"), check(parent.path(), 8, "ode")];
        let out = parent.path().join("both");
        run(&Settings { checks, out: out.clone() }).expect("scored");
        let both: BlindCheck = read_document(&out).expect("a document");
        let ids: Vec<&str> = both.worlds.iter().map(|row| row.id.as_str()).collect();
        assert_eq!(ids, ["7/world_0001", "7/world_0002", "8/world_0001", "8/world_0002"]);
        assert_eq!((both.master_seed, both.failed.count, both.failed.of), (7, 4, 4));
        let manifest = Manifest::read(&out).expect("a manifest");
        assert_eq!(manifest.config["seeds"], serde_json::json!([7, 8]));
    }

    #[test]
    fn what_does_not_belong_together_is_refused() {
        let parent = tempfile::tempdir().expect("a folder");
        let first = check(parent.path(), 7, "ode");
        let said = |checks: Vec<PathBuf>| {
            let settings = Settings { checks, out: parent.path().join("out") };
            format!("{:#}", run(&settings).expect_err("refused"))
        };
        assert!(said(vec![first.clone()]).contains("two or more"));
        assert!(said(vec![first.clone(), first.clone()]).contains("the same seed"));
        let other = check(parent.path(), 8, "another.safetensors");
        assert!(said(vec![first.clone(), other]).contains("ode, another.safetensors"));
        let nothing = parent.path().to_path_buf();
        assert!(said(vec![first.clone(), nothing]).contains("holds no labels under seal"));
        let changed = check(parent.path(), 9, "ode");
        std::fs::write(changed.join("answers/world_0001.json"), "{}").expect("written");
        assert!(said(vec![first, changed]).contains("not as `blind-check` wrote it"));
        assert!(!parent.path().join("out").exists());
    }
    #[test]
    fn one_posterior_answers_the_worlds_of_a_hand() {
        let check = |seed: u64, said: &[(&str, &str)]| Finished {
            seed,
            model: "ode".to_owned(),
            plant: Vec::new(),
            posteriors: said.iter().map(|(hand, by)| ((*hand).into(), (*by).into())).collect(),
            worlds: Vec::new(),
            courses: None,
        };
        // Each hand has a posterior that never saw it.
        let first = [("padova", "one"), ("hovorka", "another")];
        assert!(belong_together(&[check(1, &first), check(2, &first[..1])]).is_ok());
        let other = belong_together(&[check(1, &first), check(2, &[("padova", "other")])]);
        let message = other.expect_err("refused").to_string();
        assert!(message.contains("worlds of padova (one; other)"), "{message}");
    }
}
