//! The part of earlier doses that has still to act.

use physiology::{Minutes, STEP};

/// Amounts that pass through two equal compartments, as pumps compute insulin and carbohydrate on
/// board: after a time t the share (1 + t/tau) exp(-t/tau) remains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Depot {
    tau: f64,
    first: f64,
    second: f64,
}

impl Depot {
    /// An empty depot with time constant `tau` in each compartment.
    #[must_use]
    pub fn new(tau: Minutes) -> Self {
        Self { tau: tau.0, first: 0.0, second: 0.0 }
    }

    /// Adds an amount now; negative for what was withheld.
    pub fn add(&mut self, amount: f64) {
        self.first += amount;
    }

    /// Lets one step of five minutes pass.
    pub fn pass_step(&mut self) {
        let keep = (-STEP.0 / self.tau).exp();
        self.second = keep * (self.second + self.first * STEP.0 / self.tau);
        self.first *= keep;
    }

    /// What remains, in the unit of what was added.
    #[must_use]
    pub fn remaining(&self) -> f64 {
        self.first + self.second
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_remains_follows_the_closed_form() {
        let mut depot = Depot::new(Minutes(60.0));
        depot.add(4.0);
        for step in 1..60 {
            depot.pass_step();
            let t = 5.0 * f64::from(step) / 60.0;
            // Exact steps: rounding only.
            assert!((depot.remaining() - 4.0 * (1.0 + t) * (-t).exp()).abs() < 1e-12);
        }
    }
}
