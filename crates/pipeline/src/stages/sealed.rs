//! A check under seal: the labels are sealed before the first cohort is written, and opened when all answers are.
//! Also its streams of the master seed: salts, and seeds that a diagnosis is told.

use std::hash::{BuildHasher as _, Hasher as _};

use anyhow::{Context as _, Result};
use blind::seal::{seal, verify};
use contract::blind_check::{Answer, CalibratedPeople, OpenedLabel, OpenedLabels, Seal};
use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::Serialize;

use crate::asked::{Asked, ask};
use crate::documents::read_document;
use crate::manifest::hexadecimal;
use crate::output::OutputFolder;
use crate::progress::Progress;

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

/// Seals the labels, has an answer written to each, and opens them. Returns the answers.
///
/// Writes `seal.json` before the first answer, and `labels.json` after the last.
pub(super) fn under_seal<L: Serialize + Sync, A: Send>(
    labels: &[L],
    id: impl Fn(&L) -> &str,
    seed: u64,
    output: &OutputFolder,
    answer: impl Fn(usize, &L) -> Result<A> + Sync,
) -> Result<Vec<A>> {
    let closed = labels
        .iter()
        .enumerate()
        .map(|(index, label)| {
            Ok(OpenedLabel::new(id(label), salt(seed, index), serde_json::to_string(label)?))
        })
        .collect::<Result<Vec<_>>>()?;
    output.write_document(&seal(&closed))?;

    let progress = Progress::begin("diagnoses", labels.len());
    let answers = labels
        .par_iter()
        .enumerate()
        .map(|(index, label)| {
            let answer = answer(index, label)?;
            progress.advance("");
            Ok(answer)
        })
        .collect::<Result<Vec<A>>>()?;
    progress.finish(&format!("{} answers", answers.len()));

    // The seal as it lies on the disk, not as we remember it.
    let sealed: Seal = read_document(output.path())?;
    verify(&sealed, &closed).context("opening the labels")?;
    output.write_document(&OpenedLabels(closed))?;
    Ok(answers)
}

/// Asks about the cohort `id` of a check, which lies in `cohorts/`, and writes the answer to `answers/`. Returns it with
/// how its people were calibrated.
pub(super) fn answered(
    id: &str,
    (model, unseen): (&str, Option<&str>),
    (seed, index): (u64, usize),
    asked: Asked,
    output: &OutputFolder,
) -> Result<(Answer, CalibratedPeople)> {
    let folder = output.path().join("cohorts").join(id);
    let (answer, written) = ask(&folder, model, unseen, diagnosis_seed(seed, index), asked)?;
    let file = format!("answers/{id}.json");
    let Some(written) = written else {
        output.write_document_as(&file, &answer)?;
        return Ok((answer, CalibratedPeople::default()));
    };
    output.write(&file, &written.text)?;
    Ok((answer, written.calibrated))
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
