//! How regular the hours of the day are: irregular lives and shift work.

use rand::{Rng, RngExt};

use crate::calendar::Calendar;

/// The hours of one person's days.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hours {
    /// Factor on the spread of the times of bed, waking, meals and exercise between days.
    pub irregularity: f64,
    /// Work that shifts whole days.
    pub shift: Shift,
    /// Probability that a breakfast or a lunch is left out; for a dinner it is a quarter of this.
    pub meals_left_out: f64,
    /// How much more often alcohol is drunk on a Friday or Saturday than on another evening.
    pub weekend_drinking: f64,
}

/// Work that shifts whole days.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shift {
    /// None.
    None,
    /// Every day is later by this many hours.
    Late(f64),
    /// Blocks of days that are later by some hours alternate with blocks that are not.
    Rotating {
        /// Days of each block.
        days: usize,
        /// Hours by which the days of every other block are later.
        hours: f64,
        /// Days of the first block that lie before the record.
        before: usize,
    },
}

impl Hours {
    /// Regular hours.
    pub const REGULAR: Self =
        Self { irregularity: 1.0, shift: Shift::None, meals_left_out: 0.0, weekend_drinking: 3.0 };

    /// Draws them. Spreads are 0.6 to 2.5 times the regular ones (SDs of sleep timing of 0.5 to 2 h
    /// between nights, Bei et al., Sleep Med Rev 2016;28:108). One person in ten lives 1.5 to 4 h
    /// later than others; one in ten works in shifts that rotate every 2 to 7 days by 6 to 9 h (a
    /// fifth of workers do shift work, Kecklund and Axelsson, BMJ 2016;355:i5210). Alcohol on
    /// Fridays and Saturdays is as frequent as on other days to five times that. 0 to 60 % of
    /// breakfasts and lunches are left out (people in two open studies log one to six meals a day).
    #[must_use]
    pub(crate) fn sample(own: &mut impl Rng) -> Self {
        let (irregularity, kind) = (own.random_range(0.6..2.5), own.random::<f64>());
        let (late, hours) = (own.random_range(1.5..4.0), own.random_range(6.0..9.0));
        let days = own.random_range(2..=7_usize);
        let before = own.random_range(0..7_usize) % days;
        let weekend_drinking = own.random_range(1.0..5.0);
        let meals_left_out = own.random_range(0.0..0.6);
        let shift = if kind < 0.1 {
            Shift::Late(late)
        } else if kind < 0.2 {
            Shift::Rotating { days, hours, before }
        } else {
            Shift::None
        };
        Self { irregularity, shift, meals_left_out, weekend_drinking }
    }

    /// Hours by which every day is later.
    #[must_use]
    pub(crate) fn always_later(&self) -> f64 {
        if let Shift::Late(hours) = self.shift { hours } else { 0.0 }
    }

    /// Hours by which each day of a calendar is later, and one more for its last evening.
    #[must_use]
    pub(crate) fn later(&self, calendar: &Calendar) -> Vec<f64> {
        (0..=calendar.days())
            .map(|day| match self.shift {
                Shift::None => 0.0,
                Shift::Late(hours) => hours,
                Shift::Rotating { days, hours, before } => {
                    if ((day + before) / days.max(1)) % 2 == 1 { hours } else { 0.0 }
                }
            })
            .collect()
    }
}
