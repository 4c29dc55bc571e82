//! The cohort in the repository is the one that this crate makes.
//!
//! Mathematical functions differ in their last digit between platforms, and a body under a
//! controller amplifies that. The comparison holds where the fixture was made.
#![cfg(all(target_os = "linux", target_arch = "x86_64"))]

use std::path::Path;

use world::{EMBEDDED_SEED, embedded_cohort};

#[test]
fn the_embedded_cohort_is_made_again_as_it_lies_in_the_repository() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/embedded/cohort");
    let stored = cohort::read_folder(&folder).expect("the fixture");
    let (made, _) = embedded_cohort(EMBEDDED_SEED).expect("the embedded cohort");
    for (made, stored) in made.people.iter().zip(&stored.people) {
        assert!(made == stored, "{} differs", made.id);
    }
    assert_eq!(made.people.len(), stored.people.len());
}
