//! The posterior that decides what is said, and those that a blind check needs.

use std::sync::OnceLock;

use posterior::Posterior;

/// The posterior in use: trained on worlds of all hands.
static WORKING: &[u8] = include_bytes!("../posterior/working.safetensors");
/// Those that have not seen the worlds of one hand.
static WITHOUT: [(&str, &[u8]); 5] = [
    ("another", include_bytes!("../posterior/without-another.safetensors")),
    ("hovorka", include_bytes!("../posterior/without-hovorka.safetensors")),
    ("padova", include_bytes!("../posterior/without-padova.safetensors")),
    ("minimal", include_bytes!("../posterior/without-minimal.safetensors")),
    ("saturating", include_bytes!("../posterior/without-saturating.safetensors")),
];

/// The posterior in use.
///
/// # Panics
/// Never: the file is part of the crate and tested.
#[must_use]
pub fn working_posterior() -> &'static Posterior {
    static READ: OnceLock<Posterior> = OnceLock::new();
    READ.get_or_init(|| Posterior::from_bytes(WORKING).expect("the crate's own file, tested"))
}

/// The file of a posterior that never saw the worlds of `hand`, for a blind check; that in use for a hand that it did not
/// see either.
#[must_use]
pub fn posterior_file_without(hand: &str) -> &'static [u8] {
    WITHOUT.iter().find(|(left_out, _)| *left_out == hand).map_or(WORKING, |(_, file)| file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_posterior_in_use_saw_all_hands_and_the_others_all_but_one() {
        let hands = |posterior: &Posterior| -> Vec<String> {
            posterior.card().hands.iter().map(|(hand, _)| hand.clone()).collect()
        };
        assert_eq!(hands(working_posterior()).len(), WITHOUT.len());
        for (hand, file) in WITHOUT {
            let found = Posterior::from_bytes(file).expect("a posterior");
            assert_eq!(hands(&found).len(), WITHOUT.len() - 1);
            assert!(!hands(&found).iter().any(|seen| seen == hand));
            let names: Vec<String> = effects::names().into_iter().map(str::to_owned).collect();
            assert_eq!(found.effects(), names);
        }
    }
}
