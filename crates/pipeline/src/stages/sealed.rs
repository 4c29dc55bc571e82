//! A check under seal: the labels are sealed before the first cohort is written, and opened when all answers are.
//! Also its streams of the master seed: salts, and seeds that a diagnosis is told.

use std::hash::{BuildHasher as _, Hasher as _};

use anyhow::{Context as _, Result};
use blind::seal::{seal, verify};
use cohort::{Cohort, RecordsFormat, write_folder};
use contract::blind_check::{Answer, CalibratedPeople, OpenedLabel, OpenedLabels, Seal};
use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use crate::asked::{Diagnose, ask};
use crate::files::read_document;
use crate::manifest::hexadecimal;
use crate::{OutputFolder, Progress};

/// Bits of a drawn seed: a number that every reader of JSON holds exactly, and a person can copy.
const SEED_BITS: u32 = 32;

/// A seed from the randomness of the operating system.
pub(super) fn drawn_seed() -> u64 {
    // The standard library seeds every hasher of this kind anew.
    let random = std::collections::hash_map::RandomState::new().build_hasher().finish();
    random >> (u64::BITS - SEED_BITS)
}

/// Streams of the master seed that belong to this stage, apart from those of the plan.
pub(super) fn stream(seed: u64, purpose: u64, index: usize) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x7365_616c);
    rng.set_stream(((index as u64) << 8) | purpose);
    rng
}

fn salt(seed: u64, index: usize) -> String {
    let mut bytes = [0; 32];
    stream(seed, 1, index).fill_bytes(&mut bytes);
    hexadecimal(&bytes)
}

/// The seed that a diagnosis is told: not that of its world.
fn diagnosis_seed(seed: u64, index: usize) -> u64 {
    stream(seed, 2, index).next_u64() >> (u64::BITS - SEED_BITS)
}

/// A check under seal.
pub(super) struct SealedCheck<'a> {
    /// What its cohorts are called; a number tells their place in an order that was drawn.
    pub(super) kind: &'static str,
    /// Master seed.
    pub(super) seed: u64,
    /// How a cohort is diagnosed.
    pub(super) diagnose: Diagnose,
    /// Where it is written.
    pub(super) output: &'a OutputFolder,
}

impl SealedCheck<'_> {
    /// The name of a cohort and of its folder.
    pub(super) fn id(&self, index: usize) -> String {
        format!("{}_{:04}", self.kind, index + 1)
    }

    /// Seals the labels, has an answer written to each, and opens them. Returns the answers.
    ///
    /// Writes `seal.json` before the first answer, and `labels.json` after the last.
    pub(super) fn answers<L: Serialize, A: Send>(
        &self,
        labels: &[L],
        answer: impl Fn(usize) -> Result<A> + Sync,
    ) -> Result<Vec<A>> {
        let closed = labels.iter().enumerate().map(|(index, label)| {
            let label = serde_json::to_string(label)?;
            Ok(OpenedLabel::new(self.id(index), salt(self.seed, index), label))
        });
        let closed = closed.collect::<Result<Vec<_>>>()?;
        self.output.write_document(&seal(&closed))?;

        let progress = Progress::begin("diagnoses", labels.len());
        let answers = progress.each(labels.len(), answer)?;
        progress.finish(&format!("{} answers", answers.len()));

        // The seal as it lies on the disk, not as we remember it.
        let sealed: Seal = read_document(self.output.path())?;
        verify(&sealed, &closed).context("opening the labels")?;
        self.output.write_document(&OpenedLabels(closed))?;
        Ok(answers)
    }

    /// Writes a cohort to `cohorts/`, asks about it, and writes the answer to `answers/`. Returns it with how its people
    /// were calibrated.
    pub(super) fn answer(
        &self,
        index: usize,
        cohort: Cohort,
        (model, unseen): (&str, Option<&str>),
    ) -> Result<(Answer, CalibratedPeople)> {
        let id = self.id(index);
        let folder = self.output.path().join("cohorts").join(&id);
        write_folder(&cohort, &folder, RecordsFormat::Parquet)
            .with_context(|| format!("{} {id}", self.kind))?;
        drop(cohort);
        let seed = diagnosis_seed(self.seed, index);
        let (answer, calibrated, text) = ask(&folder, model, unseen, seed, self.diagnose)?;
        let file = format!("answers/{id}.json");
        match text {
            Some(text) => self.output.write(&file, &text)?,
            None => self.output.write_document_as(&file, &answer)?,
        }
        Ok((answer, calibrated))
    }
}

/// Checks that a finished check has the seal of its labels and of no others, that it was written before the cohorts,
/// and that no file of theirs holds one of the words. Returns the labels.
#[cfg(test)]
pub(super) fn checked(check: &std::path::Path, words: &[&str]) -> Vec<OpenedLabel> {
    let sealed: Seal = read_document(check).expect("a seal");
    let OpenedLabels(labels) = read_document(check).expect("labels");
    verify(&sealed, &labels).expect("as sealed");
    let mut others = labels.clone();
    others[0].label.push(' ');
    assert!(verify(&sealed, &others).is_err());

    let written = |file: &std::path::Path| {
        std::fs::metadata(file).and_then(|m| m.modified()).expect("a time")
    };
    let sealed = written(&check.join("seal.json"));
    for label in &labels {
        let folder = check.join("cohorts").join(&label.id);
        assert_eq!(std::fs::read_dir(&folder).expect("a cohort").count(), 2);
        for file in ["people.csv", "records.parquet"].map(|name| folder.join(name)) {
            let bytes = std::fs::read(&file).expect("a file");
            for word in words {
                assert!(!bytes.windows(word.len()).any(|w| w == word.as_bytes()), "{word}");
            }
            assert!(sealed <= written(&file), "a cohort before the seal");
        }
    }
    labels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn salts_and_seeds_differ_and_follow_from_the_seed() {
        assert_eq!(salt(1, 0), salt(1, 0));
        assert_ne!(salt(1, 0), salt(1, 1));
        assert_ne!(salt(1, 0), salt(2, 0));
        assert_eq!(salt(1, 0).len(), 64);
        assert_ne!(diagnosis_seed(1, 0), diagnosis_seed(1, 1));
        assert_ne!(drawn_seed(), drawn_seed());
    }
}
