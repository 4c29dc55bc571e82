//! Sealed labels: hashes that are published before the data, and opened after the answers.
//!
//! The hash of a world covers a salt and the exact bytes of its label. The salt prevents a reader
//! from trying out the few possible labels; the hash prevents the author from changing a label once
//! the answer is known.
//!
//! ```
//! use blind::seal::{seal, verify};
//! use contract::blind_check::OpenedLabel;
//!
//! let label = OpenedLabel::new("world_0001", "5f3a", r#"{"effect":"dawn"}"#);
//! let sealed = seal(std::slice::from_ref(&label));
//! assert!(verify(&sealed, std::slice::from_ref(&label)).is_ok());
//! let other = OpenedLabel::new("world_0001", "5f3a", r#"{"effect":"none"}"#);
//! assert!(verify(&sealed, &[other]).is_err());
//! ```

use contract::Document as _;
use contract::blind_check::{OpenedLabel, Seal, SealedWorld};

use sha2::{Digest as _, Sha256};

use crate::error::BlindError;

/// SHA-256 of the salt, a line feed, and the label.
#[must_use]
pub fn sha256(label: &OpenedLabel) -> String {
    let hash = Sha256::digest(format!("{}\n{}", label.salt, label.label));
    hash.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The seal of these labels.
#[must_use]
pub fn seal(labels: &[OpenedLabel]) -> Seal {
    let worlds = labels
        .iter()
        .map(|label| SealedWorld { id: label.id.clone(), sha256: sha256(label) })
        .collect();
    let hash = "SHA-256 of salt, line feed (0x0a), label".to_owned();
    Seal { schema: Seal::SCHEMA.to_owned(), hash, worlds }
}

/// Checks that these are the labels that were sealed: all of them, in their order.
///
/// # Errors
/// [`BlindError::Tampered`] names the first changed label; [`BlindError::Unmatched`] one that is
/// missing or was never sealed.
pub fn verify(seal: &Seal, labels: &[OpenedLabel]) -> Result<(), BlindError> {
    if let Some(sealed) = seal.worlds.get(labels.len()) {
        let problem = "sealed, but its label is missing";
        return Err(BlindError::Unmatched { id: sealed.id.clone(), problem });
    }
    for (index, label) in labels.iter().enumerate() {
        let Some(sealed) = seal.worlds.get(index).filter(|sealed| sealed.id == label.id) else {
            let problem = "has a label in a place where another or none was sealed";
            return Err(BlindError::Unmatched { id: label.id.clone(), problem });
        };
        if sealed.sha256 != sha256(label) {
            return Err(BlindError::Tampered { id: label.id.clone() });
        }
    }
    Ok(())
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
            sha256(&label),
            "b4157e40dd21db67528800eb46fe6641eaa5e321734b6890e43e9ce6ed37d91b"
        );
        assert_ne!(sha256(&label), sha256(&OpenedLabel::new("w", "abd", "{}")));
    }

    #[test]
    fn labels_as_sealed_pass_and_a_changed_one_is_named() {
        let seal = seal(&labels());
        verify(&seal, &labels()).expect("as sealed");
        for change in
            [|l: &mut OpenedLabel| l.label.push(' '), |l: &mut OpenedLabel| l.salt.push('0')]
        {
            let mut changed = labels();
            change(&mut changed[1]);
            let error = verify(&seal, &changed).expect_err("changed");
            assert!(matches!(&error, BlindError::Tampered { id } if id == "w2"), "{error}");
        }
    }

    #[test]
    fn missing_added_and_exchanged_labels_are_named() {
        let seal = seal(&labels());
        let all = labels();
        assert!(
            matches!(verify(&seal, &all[..2]), Err(BlindError::Unmatched { id, .. }) if id == "w3")
        );
        let mut more = labels();
        more.push(OpenedLabel::new("w4", "s", "{}"));
        assert!(
            matches!(verify(&seal, &more), Err(BlindError::Unmatched { id, .. }) if id == "w4")
        );
        let mut exchanged = labels();
        exchanged.swap(0, 1);
        assert!(verify(&seal, &exchanged).is_err());
    }
}
