//! How the sites at which insulin enters differ.

use physiology::STEPS_PER_DAY;
use rand::{Rng, RngExt};

use super::course::EverydayLogs;
use crate::behaviour::Life;
use crate::calendar::within;
use crate::stream::standard_normal;

/// Spread between the sites of one person.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sites {
    /// Of the logarithm of the share of the insulin that arrives.
    pub amount: f64,
    /// Of the logarithm of the time of absorption.
    pub time: f64,
}

impl Sites {
    /// All alike.
    pub const ALIKE: Self = Self { amount: 0.0, time: 0.0 };

    /// Draws them by world, a person's within a quarter: amounts 1 to 8 %, times 2 to 15 % apart
    /// (within-person variation of absorption of 10 to 25 %, most of it between sites: Heinemann,
    /// Diabetes Technol Ther 2002;4:673; Gradel et al., J Diabetes Res 2018;2018:1205121).
    #[must_use]
    pub(super) fn sample(world: &mut impl Rng, own: &mut impl Rng) -> Self {
        let (amount, time) = (world.random_range(0.01..0.08), world.random_range(0.02..0.15));
        let mut about = |value: f64| value * (0.25 * standard_normal(own)).clamp(-0.5, 0.5).exp();
        Self { amount: about(amount), time: about(time) }
    }

    /// Adds the logarithms of the factors on amount and time for the sites of a life.
    ///
    /// Every site is that of one infusion set. A person who injects changes to another part of the
    /// body as often.
    pub(super) fn add(&self, course: &mut [EverydayLogs], life: &Life, rng: &mut impl Rng) {
        let end = life.calendar.steps() as i64;
        let changes = life.sets.changes();
        let first = changes.first().copied().unwrap_or(0).min(0);
        let mut bounds: Vec<i64> = std::iter::once(first).chain(changes.iter().copied()).collect();
        bounds.push(end.max(first + STEPS_PER_DAY as i64));
        bounds.dedup();
        for pair in bounds.windows(2) {
            let (a, t) = (
                self.amount * standard_normal(rng).clamp(-2.5, 2.5),
                self.time * standard_normal(rng).clamp(-2.5, 2.5),
            );
            for logs in &mut course[within(pair[0]..pair[1], life.calendar.steps())] {
                logs.amount += a;
                logs.insulin_time += t;
            }
        }
    }
}
