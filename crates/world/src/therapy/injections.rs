//! Multiple daily injections: long-acting insulin once or twice a day, boluses by pen.

use physiology::{STEP, STEPS_PER_DAY, Units};
use rand::{Rng, RngExt};

use super::settings::TherapySettings;
use crate::calendar::Calendar;
use crate::stream::standard_normal;

/// Days before the record whose injections still act at its start.
const DAYS_BEFORE: usize = 5;

/// How one person injects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pen {
    /// Injections of long-acting insulin a day, 1 or 2.
    pub a_day: usize,
    /// Hour of the first.
    pub hour: f64,
    /// Times in which long-acting insulin dissolves, and is absorbed, h.
    pub hours: (f64, f64),
    /// Units in which boluses are dialled.
    pub increment: Units,
    /// Share of the basal need that is injected.
    pub share: f64,
    /// Probability that an injection of long-acting insulin is forgotten.
    pub forgotten: f64,
}

impl Pen {
    /// One injection at 22:00, boluses in whole units.
    pub const USUAL: Self = Self {
        a_day: 1,
        hour: 22.0,
        hours: (4.0, 12.0),
        increment: Units(1.0),
        share: 1.0,
        forgotten: 0.0,
    };

    /// Draws one person's. One in three injects twice; in the morning or the evening. The insulin
    /// acts for 18 h to more than two days (dissolving over 2 to 6 h, absorbed over 8 to 18 h, 20
    /// to 30 h in a quarter of people: Heise and Pieber, Diabetes Obes Metab 2007;9:648; Heise et
    /// al., Diabetes Obes Metab 2012;14:859). Half of the people dial half units; they inject 85 to
    /// 115 % of the basal need and forget 0 to 6 % of injections (assumed).
    #[must_use]
    pub fn sample(rng: &mut (impl Rng + ?Sized)) -> Self {
        let (twice, evening) = (rng.random_bool(1.0 / 3.0), rng.random_bool(0.6));
        let hour = if evening && !twice {
            rng.random_range(20.5..23.5)
        } else {
            rng.random_range(6.5..9.0)
        };
        let (dissolves, usual) = (rng.random_range(2.0..6.0), rng.random_range(8.0..18.0));
        let (ultra_long, longest) = (rng.random_bool(0.25), rng.random_range(20.0..30.0));
        Self {
            a_day: if twice { 2 } else { 1 },
            hour,
            hours: (dissolves, if ultra_long { longest } else { usual }),
            increment: Units(if rng.random_bool(0.5) { 0.5 } else { 1.0 }),
            share: rng.random_range(0.85..1.15),
            forgotten: rng.random_range(0.0..0.06),
        }
    }

    /// The rates at which long-acting insulin arrives under the skin over a calendar, U/h, one a
    /// step.
    ///
    /// Doses are whole units; they are injected within about half an hour of their hour.
    #[must_use]
    pub fn rates(
        &self,
        settings: &TherapySettings,
        calendar: &Calendar,
        rng: &mut (impl Rng + ?Sized),
    ) -> Vec<f64> {
        let daily: f64 = self.share * settings.basal.iter().sum::<f64>();
        let dose = (daily / self.a_day as f64).round().max(1.0);
        let before = DAYS_BEFORE * STEPS_PER_DAY;
        let mut injected = vec![0.0; before + calendar.steps()];
        for day in 0..DAYS_BEFORE + calendar.days() {
            for k in 0..self.a_day {
                let late = 0.4 * standard_normal(rng).clamp(-2.0, 2.0);
                let forgotten = rng.random::<f64>() < self.forgotten;
                let hour = self.hour + 24.0 * k as f64 / self.a_day as f64 + late;
                let step = (day as f64 + hour / 24.0) * STEPS_PER_DAY as f64;
                if let Some(slot) = injected.get_mut(step.max(0.0) as usize).filter(|_| !forgotten)
                {
                    *slot += dose;
                }
            }
        }
        let share = |hours: f64| 1.0 - (-STEP.0 / (60.0 * hours)).exp();
        let (dissolving, absorbing) = (share(self.hours.0), share(self.hours.1));
        let (mut solid, mut free) = (0.0, 0.0);
        let arriving = injected.into_iter().map(|units| {
            solid += units;
            let dissolved = dissolving * solid;
            solid -= dissolved;
            free += dissolved;
            let arrives = absorbing * free;
            free -= arrives;
            60.0 / STEP.0 * arrives
        });
        arriving.skip(before).collect()
    }

    /// A bolus as it can be dialled.
    #[must_use]
    pub fn dialled(&self, bolus: Units) -> Units {
        Units((bolus.0 / self.increment.0).round() * self.increment.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::{Concept, stream};
    use chrono::NaiveDate;
    use physiology::{GramsPerUnit, MgPerDl};

    #[test]
    fn what_is_injected_arrives_over_the_day() {
        let settings = TherapySettings {
            basal: [1.0; 24],
            icr: GramsPerUnit(10.0),
            isf: 50.0,
            target: MgPerDl(120.0),
        };
        let start = NaiveDate::from_ymd_opt(2024, 1, 8).expect("a date");
        let calendar = Calendar::new(start, 20);
        for pen in [Pen::USUAL, Pen { a_day: 2, ..Pen::USUAL }] {
            let mut rng = stream(1, 0, Concept::Injections);
            let rates = pen.rates(&settings, &calendar, &mut rng);
            let daily = rates.iter().sum::<f64>() * STEP.0 / 60.0 / 20.0;
            assert!((daily - 24.0).abs() < 0.6, "{daily}"); // the hour of the last injections
            let (low, high) =
                rates.iter().fold((9.0_f64, 0.0_f64), |(l, h), r| (l.min(*r), h.max(*r)));
            assert!(low > 0.25 && high < 2.2 && high > 1.02, "{low} {high}");
        }
        assert_eq!(Pen::USUAL.dialled(Units(2.6)).0, 3.0);
    }
}
