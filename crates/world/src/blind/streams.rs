//! Random streams of a plan, separate from those of the people.

use rand_chacha::ChaCha8Rng;

use crate::stream::numbered;

/// What a stream is used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    /// Which worlds there are.
    Plan = 0,
    /// Their order.
    Order = 1,
    /// Which person lacks which part of the record.
    Nuisances = 2,
    /// How strongly an effect outside the library acts in each person.
    Amplitudes = 3,
    /// Whose people inject.
    Injections = 4,
}

/// Separates these streams from the people's, which are drawn from the seed itself.
const APART: u64 = 0x626c_696e_6420_3031;

/// The stream of one item for one purpose.
pub(super) fn stream(seed: u64, purpose: Purpose, item: usize) -> ChaCha8Rng {
    numbered(seed ^ APART, item, purpose as u64)
}
