//! Mixed-up sensors and heart rates planted in made records.

use cohort::Channel;
use gap::quality::{Consequence, ignored_channels};

use crate::planted::{changed, checks, doubts, embedded, estimate};

#[test]
fn two_sensors_in_one_column_are_found_with_their_disagreement() {
    for (days, consequence) in [(2, Consequence::Note), (8, Consequence::ExcludePerson)] {
        for person in embedded() {
            let faulty = changed(&person, Channel::Cgm, |k, glucose| {
                if k < days * 288 && k % 2 == 1 { glucose + 20.0 } else { glucose }
            });
            let found = doubts(&faulty);
            assert_eq!(checks(&found), ["interleaved_cgm"], "{}: {found:?}", person.id);
            assert_eq!(found[0].consequence, consequence, "{}: {found:?}", person.id);
            let (value, ..) = estimate(&found, "interleaved_cgm").expect("an estimate");
            // Sensor noise adds a few mg/dL to the 20 between the two.
            assert!((18.0..26.0).contains(&value), "{}: {value}", person.id);
        }
    }
}

#[test]
fn noise_is_not_taken_for_two_sensors() {
    for person in embedded() {
        // Pseudo-random whole numbers within 12 mg/dL, without memory: as large as a
        // disagreement of two sensors.
        let noisy = changed(&person, Channel::Cgm, |k, glucose| {
            glucose + (k.wrapping_mul(2_654_435_761) >> 7) as f64 % 25.0 - 12.0
        });
        assert_eq!(doubts(&noisy), [], "{}", person.id);
    }
}

#[test]
fn a_heart_rate_of_other_hours_is_ignored() {
    for person in embedded() {
        let old = person.record.heart_rate().to_vec();
        let mut scattered = person.clone();
        let values = scattered.record.channel_mut(Channel::HeartRate);
        for (k, value) in values.iter_mut().enumerate() {
            *value = old[(k * 7919) % old.len()];
        }
        let found = doubts(&scattered);
        assert_eq!(checks(&found), ["heart_rate_alignment"], "{}: {found:?}", person.id);
        assert_eq!(ignored_channels(&found), [Channel::HeartRate]);

        let mut late = person.clone();
        late.record.channel_mut(Channel::HeartRate).rotate_right(24);
        let found = doubts(&late);
        let (value, lower, upper) = estimate(&found, "heart_rate_alignment").expect("found");
        // Bins of 15 min.
        assert!((value - 120.0).abs() <= 15.0 && lower < upper, "{}: {found:?}", person.id);
    }
}
