//! The same person under another therapy.

use chrono::NaiveDate;
use world::{Calendar, EMBEDDED_SEED, LivedDays, Regime, VirtualPerson, embedded_people};

fn percent_above_180(days: &LivedDays) -> f64 {
    100.0 * days.glucose.iter().filter(|g| g.0 > 180.0).count() as f64 / days.glucose.len() as f64
}

#[test]
fn automated_delivery_spends_less_time_high_than_the_profile_does() {
    let calendar = Calendar::new(NaiveDate::from_ymd_opt(2024, 1, 8).expect("a date"), 28);
    let mut gains = Vec::new();
    for (index, person) in embedded_people(EMBEDDED_SEED).expect("drawn").into_iter().enumerate() {
        let open = VirtualPerson { regime: Regime::OpenLoopPump, ..person };
        let closed = VirtualPerson { regime: Regime::Aid, ..open.clone() };
        let (open, closed) =
            (open.live(calendar).expect("open"), closed.live(calendar).expect("closed"));
        assert!(open.life == closed.life);
        gains.push(percent_above_180(&open) - percent_above_180(&closed));
        let suspended = closed.inputs.iter().filter(|i| i.basal.0 == 0.0).count();
        assert!(suspended > 0, "person {index} was never suspended");
    }
    assert!(gains.iter().all(|gain| *gain > 0.0), "{gains:?}");
}
