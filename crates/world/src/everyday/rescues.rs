//! How a person treats lows.

use rand::{Rng, RngExt};

/// What is eaten against a low.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rescues {
    /// Least amount, g.
    pub least: f64,
    /// Further amount at most, g.
    pub range: f64,
    /// Share of treatments with food that is absorbed as a meal is (chocolate, bread).
    pub slow_share: f64,
}

impl Rescues {
    /// As advised: 12 to 20 g of fast carbohydrate.
    pub const ADVISED: Self = Self { least: 12.0, range: 8.0, slow_share: 0.0 };

    /// Draws them: from 6 to 15 g on, up to 4 to 20 g more. In half of the people 10 to 80 % of the
    /// treatments are slow (most people treat with more than 15 g and many with food: Savard et
    /// al., Can J Diabetes 2016;40:143, of the order).
    #[must_use]
    pub(super) fn sample(own: &mut impl Rng) -> Self {
        let (least, range) = (own.random_range(6.0..15.0), own.random_range(4.0..20.0));
        let (slow, share) = (own.random_bool(0.5), own.random_range(0.1..0.8));
        Self { least, range, slow_share: if slow { share } else { 0.0 } }
    }

    /// The amount of a treatment for a draw from 0 to 1, g.
    #[must_use]
    pub fn amount(&self, draw: f64) -> f64 {
        (self.least + self.range * draw).round()
    }

    /// Whether the treatment with this draw of its size is slow.
    ///
    /// One draw serves for both: its digits from the thousandths on are independent of the first
    /// ones.
    #[must_use]
    pub fn is_slow(&self, draw: f64) -> bool {
        (1000.0 * draw).fract() < self.slow_share
    }
}
