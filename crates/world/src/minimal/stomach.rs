//! A stomach in which each meal empties by its own clock.

/// Number of meals that are kept apart; beyond it, the two oldest become one.
const PORTIONS: usize = 6;

/// What is left of one meal.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Portion {
    /// Carbohydrate left in the stomach, mg.
    pub left: f64,
    /// Age on the clock of emptying, in half-times.
    pub age: f64,
    /// Half-time relative to that of solid food.
    pub slowness: f64,
}

impl Portion {
    /// Share of the rest that leaves while the clock advances by `half_times`.
    ///
    /// 1 - 2^((a)^beta - (a + da)^beta), from the retention 2^(-a^beta) of Elashoff et al. 1982.
    #[must_use]
    pub fn emptied_share(&self, half_times: f64, beta: f64) -> f64 {
        1.0 - (self.age.powf(beta) - (self.age + half_times).powf(beta)).exp2()
    }
}

/// The meals in a stomach, first eaten first.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Stomach {
    portions: [Portion; PORTIONS],
    count: usize,
}

impl Stomach {
    /// Adds a meal of `mg` of carbohydrate.
    pub fn eat(&mut self, mg: f64, slowness: f64) {
        if mg <= 0.0 {
            return;
        }
        if self.count == PORTIONS {
            let (old, next) = (self.portions[0], self.portions[1]);
            let both = old.left + next.left;
            // The clock of the larger part; no carbohydrate is lost.
            let kept = if old.left > next.left { old } else { next };
            self.portions[0] = Portion { left: both, ..kept };
            self.portions.copy_within(2.., 1);
            self.count -= 1;
        }
        self.portions[self.count] = Portion { left: mg, age: 0.0, slowness };
        self.count += 1;
    }

    /// What leaves the stomach in `minutes`, mg, when half of solid food takes `half_time` minutes.
    pub fn pass(&mut self, minutes: f64, half_time: f64, beta: f64) -> f64 {
        let mut emptied = 0.0;
        for portion in &mut self.portions[..self.count] {
            let half_times = minutes / (half_time * portion.slowness);
            let gone = portion.left * portion.emptied_share(half_times, beta);
            portion.left -= gone;
            portion.age += half_times;
            emptied += gone;
        }
        // A portion of less than a milligram leaves with the next step.
        if self.count > 0 && self.portions[0].left < 1.0 {
            emptied += self.portions[0].left;
            self.portions.copy_within(1.., 0);
            self.count -= 1;
        }
        emptied
    }

    /// Carbohydrate in the stomach, mg.
    #[must_use]
    pub fn content(&self) -> f64 {
        self.portions[..self.count].iter().map(|portion| portion.left).sum()
    }

    /// Whether every number is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.portions[..self.count].iter().all(|p| p.left.is_finite() && p.age.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_is_gone_after_the_half_time_whatever_the_step() {
        for minutes in [0.5, 1.0, 5.0] {
            let mut stomach = Stomach::default();
            stomach.eat(60_000.0, 1.0);
            let mut gone = 0.0;
            for _ in 0..(60.0 / minutes) as usize {
                gone += stomach.pass(minutes, 60.0, 1.4);
            }
            assert!((gone - 30_000.0).abs() < 1e-6, "{gone}"); // steps are exact
            assert!((gone + stomach.content() - 60_000.0).abs() < 1e-6);
        }
    }

    #[test]
    fn emptying_begins_late_and_nothing_is_lost_when_many_meals_meet() {
        let mut stomach = Stomach::default();
        stomach.eat(60_000.0, 1.0);
        let (first, _) = (stomach.pass(5.0, 60.0, 1.6), stomach.pass(5.0, 60.0, 1.6));
        let third = stomach.pass(5.0, 60.0, 1.6);
        assert!(third > 1.5 * first, "{first} {third}");
        let mut crowded = Stomach::default();
        let mut out = 0.0;
        for _ in 0..10 {
            crowded.eat(10_000.0, 1.0);
            out += crowded.pass(5.0, 60.0, 1.3);
        }
        assert!((out + crowded.content() - 100_000.0).abs() < 1e-6); // rounding
        for _ in 0..300 {
            out += crowded.pass(5.0, 60.0, 1.3);
        }
        assert!((out - 100_000.0).abs() < 10.0 && crowded.content() < 10.0, "{out}");
    }
}
