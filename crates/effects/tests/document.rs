//! `docs/effects.md` says what the library says.

use std::path::Path;

#[test]
fn the_document_is_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/effects.md");
    let written =
        std::fs::read_to_string(&path).expect("docs/effects.md is part of the repository");
    assert!(
        written == effects::overview(&effects::library()),
        "write it again: cargo run -p effects --example table > docs/effects.md"
    );
}
