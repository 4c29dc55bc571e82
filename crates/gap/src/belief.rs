//! The posterior that decides what is said.

use std::sync::OnceLock;

use posterior::Posterior;

/// Its file: trained on worlds of all hands.
static WORKING: &[u8] = include_bytes!("../posterior/working.safetensors");

/// The posterior in use.
///
/// # Panics
/// Never: the file is part of the crate and tested.
#[must_use]
pub fn working_posterior() -> &'static Posterior {
    static READ: OnceLock<Posterior> = OnceLock::new();
    READ.get_or_init(|| Posterior::from_bytes(WORKING).expect("the crate's own file, tested"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_posterior_in_use_knows_the_library() {
        let names: Vec<String> = effects::names().into_iter().map(str::to_owned).collect();
        assert_eq!(working_posterior().effects(), names);
    }
}
