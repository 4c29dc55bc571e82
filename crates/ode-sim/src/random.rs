//! One random stream per item, so that results do not depend on the number of threads.

use rand::SeedableRng;
use rand_chacha::ChaCha12Rng;

/// What the items are; keeps streams of the same seed and index apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Purpose {
    VirtualPerson,
    MealDay,
    Week,
    Scenario,
}

/// The stream of item `index` of a kind, under `seed`.
pub(crate) fn stream(seed: u64, purpose: Purpose, index: u64) -> ChaCha12Rng {
    let mut rng = ChaCha12Rng::seed_from_u64(seed);
    // The kind takes the upper bits; populations and sets are far smaller than 2^56 items.
    rng.set_stream(((purpose as u64) << 56) | index);
    rng
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;

    #[test]
    fn streams_differ_by_seed_purpose_and_index() {
        let draw = |seed, purpose, index| stream(seed, purpose, index).random::<u64>();
        let base = draw(1, Purpose::VirtualPerson, 0);
        assert_eq!(base, draw(1, Purpose::VirtualPerson, 0));
        assert_ne!(base, draw(2, Purpose::VirtualPerson, 0));
        assert_ne!(base, draw(1, Purpose::MealDay, 0));
        assert_ne!(base, draw(1, Purpose::VirtualPerson, 1));
    }
}
