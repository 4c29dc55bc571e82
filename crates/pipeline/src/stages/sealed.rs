//! Streams of a master seed that belong to sealed checks: salts, and seeds that a diagnosis is told.

use std::hash::{BuildHasher as _, Hasher as _};

use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use crate::manifest::hexadecimal;

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

pub(super) fn salt(seed: u64, index: usize) -> String {
    let mut bytes = [0; 32];
    stream(seed, 1, index).fill_bytes(&mut bytes);
    hexadecimal(&bytes)
}

/// The seed that a diagnosis is told: not that of its world.
pub(super) fn diagnosis_seed(seed: u64, index: usize) -> u64 {
    stream(seed, 2, index).next_u64() >> (u64::BITS - SEED_BITS)
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
