//! Labels under seal: hashes that are published before the data, and opened after the answers.
//!
//! The hash of a world covers a salt and the exact bytes of its label. The salt keeps a reader from
//! trying out the few labels there are; the hash keeps the author from changing a label once the
//! answer is known.
//!
//! ```
//! use blind::{OpenedLabel, Seal};
//!
//! let label = OpenedLabel::new("world_0001", "5f3a", r#"{"effect":"dawn"}"#);
//! let seal = Seal::of(std::slice::from_ref(&label));
//! assert!(seal.verify(std::slice::from_ref(&label)).is_ok());
//! let other = OpenedLabel::new("world_0001", "5f3a", r#"{"effect":"none"}"#);
//! assert!(seal.verify(&[other]).is_err());
//! ```

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::error::BlindError;

/// Value of [`Seal::schema`].
pub const SCHEMA: &str = "seal/1";

/// Hashes of all labels of a check: `seal.json`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Seal {
    /// [`SCHEMA`].
    pub schema: String,
    /// What is hashed, in words.
    pub hash: String,
    /// One entry a world.
    pub worlds: Vec<SealedWorld>,
}

/// The hash of one label.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SealedWorld {
    /// The world.
    pub id: String,
    /// Hexadecimal.
    pub sha256: String,
}

/// A label with what its hash was made of.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct OpenedLabel {
    /// The world.
    pub id: String,
    /// Random text.
    pub salt: String,
    /// The label as JSON, byte by byte as it was hashed.
    pub label: String,
}

impl OpenedLabel {
    /// A label to be sealed.
    #[must_use]
    pub fn new(id: impl Into<String>, salt: impl Into<String>, label: impl Into<String>) -> Self {
        Self { id: id.into(), salt: salt.into(), label: label.into() }
    }

    /// SHA-256 of the salt, a line feed, and the label.
    #[must_use]
    pub fn sha256(&self) -> String {
        let mut hasher = Sha256::new();
        hasher.update(self.salt.as_bytes());
        hasher.update(b"\n");
        hasher.update(self.label.as_bytes());
        hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

impl Seal {
    /// The seal of these labels.
    #[must_use]
    pub fn of(labels: &[OpenedLabel]) -> Self {
        let worlds = labels
            .iter()
            .map(|label| SealedWorld { id: label.id.clone(), sha256: label.sha256() })
            .collect();
        let hash = "SHA-256 of salt, line feed (0x0a), label".to_owned();
        Self { schema: SCHEMA.to_owned(), hash, worlds }
    }

    /// Checks that these are the labels that were sealed, all of them, in their order.
    ///
    /// # Errors
    /// [`BlindError::Tampered`] names the first label that is not; [`BlindError::Unmatched`] one
    /// that is missing or was never sealed.
    pub fn verify(&self, labels: &[OpenedLabel]) -> Result<(), BlindError> {
        if let Some(sealed) = self.worlds.get(labels.len()) {
            let problem = "sealed, but its label is missing";
            return Err(BlindError::Unmatched { id: sealed.id.clone(), problem });
        }
        for (place, label) in labels.iter().enumerate() {
            match self.worlds.get(place) {
                Some(sealed) if sealed.id == label.id => {
                    if sealed.sha256 != label.sha256() {
                        return Err(BlindError::Tampered { id: label.id.clone() });
                    }
                }
                _ => {
                    let problem = "has a label in a place where another or none was sealed";
                    return Err(BlindError::Unmatched { id: label.id.clone(), problem });
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels() -> Vec<OpenedLabel> {
        (1..=3).map(|k| OpenedLabel::new(format!("w{k}"), format!("salt{k}"), "{}")).collect()
    }

    #[test]
    fn the_hash_is_that_of_salt_line_feed_and_label() {
        // printf 'abc\n{}' | sha256sum
        let label = OpenedLabel::new("w", "abc", "{}");
        assert_eq!(
            label.sha256(),
            "b4157e40dd21db67528800eb46fe6641eaa5e321734b6890e43e9ce6ed37d91b"
        );
        assert_ne!(label.sha256(), OpenedLabel::new("w", "abd", "{}").sha256());
    }

    #[test]
    fn labels_as_sealed_pass_and_a_changed_one_is_named() {
        let seal = Seal::of(&labels());
        seal.verify(&labels()).expect("as sealed");
        for change in
            [|l: &mut OpenedLabel| l.label.push(' '), |l: &mut OpenedLabel| l.salt.push('0')]
        {
            let mut changed = labels();
            change(&mut changed[1]);
            let error = seal.verify(&changed).expect_err("changed");
            assert!(matches!(&error, BlindError::Tampered { id } if id == "w2"), "{error}");
        }
    }

    #[test]
    fn missing_added_and_exchanged_labels_are_named() {
        let seal = Seal::of(&labels());
        let all = labels();
        assert!(
            matches!(seal.verify(&all[..2]), Err(BlindError::Unmatched { id, .. }) if id == "w3")
        );
        let mut more = labels();
        more.push(OpenedLabel::new("w4", "s", "{}"));
        assert!(matches!(seal.verify(&more), Err(BlindError::Unmatched { id, .. }) if id == "w4"));
        let mut exchanged = labels();
        exchanged.swap(0, 1);
        assert!(seal.verify(&exchanged).is_err());
    }
}
