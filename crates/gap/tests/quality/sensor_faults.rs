//! Mixed-up sensors and heart rates planted in made records.

use cohort::{Channel, Person};
use gap::quality::{Consequence, ignored_channels};
use gap::{Observations, Reading};

use crate::planted::{changed, checks, doubts, drawn_over_15_minutes, embedded, estimate};

/// Steps at which a bolus is given, each followed by an hour without another.
fn boluses(person: &Person) -> Vec<usize> {
    let mut steps: Vec<usize> = Vec::new();
    for (k, dose) in person.record.bolus().iter().enumerate() {
        let clear = steps.last().is_none_or(|last| k >= last + 12);
        if clear && k > 3 && k + 4 < person.record.len() && dose.is_some_and(|dose| dose > 0.3) {
            steps.push(k);
        }
    }
    steps
}

/// The person with a value of the CGM column `mg_dl` higher at some steps.
fn raised(person: &Person, steps: &[usize], mg_dl: f64) -> Person {
    changed(
        person,
        Channel::Cgm,
        |k, glucose| {
            if steps.contains(&k) { glucose + mg_dl } else { glucose }
        },
    )
}

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
fn two_sensors_that_read_every_15_minutes_are_found_and_their_hours_left_out() {
    for person in embedded() {
        let alternating = changed(&person, Channel::Cgm, |k, glucose| {
            // The readings stand at every third step; lines are drawn between them below.
            if k < 2 * 288 && (k / 3) % 2 == 1 { glucose + 60.0 } else { glucose }
        });
        let faulty = drawn_over_15_minutes(&alternating);
        let found = doubts(&faulty);
        assert_eq!(checks(&found), ["interleaved_cgm"], "{}: {found:?}", person.id);
        let (value, ..) = estimate(&found, "interleaved_cgm").expect("an estimate");
        assert!((55.0..70.0).contains(&value), "{}: {value}", person.id);
        let observations = Observations::from_person(&faulty).expect("good values");
        let (beginning, rest) = observations.readings.split_at(2 * 288);
        let read = |r: &&Reading| matches!(r, Reading::Within(_));
        // Of 96 readings a day some lie on a line by chance, and some blocks have a steep meal.
        let (left, kept) =
            (beginning.iter().filter(read).count(), rest.iter().filter(read).count());
        assert!(left < 2 * 32 && kept > 12 * 80, "{}: {left} and {kept}", person.id);
    }
}

#[test]
fn finger_sticks_between_readings_of_15_minutes_are_found_and_not_fed() {
    for person in embedded() {
        let drawn = drawn_over_15_minutes(&person);
        assert_eq!(doubts(&drawn), [], "{}", person.id);
        let recorded =
            |k: &usize| drawn.record.cgm()[k / 3 * 3..=k / 3 * 3 + 3].iter().all(Option::is_some);
        let steps: Vec<usize> =
            boluses(&person).into_iter().filter(|k| k % 3 != 0 && recorded(k)).collect();
        assert!(steps.len() > 5, "{}: {} boluses", person.id, steps.len());
        // What the source does: a line from the sensor's reading to the stick and on to the next one.
        let mut faulty = drawn.clone();
        let values = faulty.record.channel_mut(Channel::Cgm);
        for step in &steps {
            let (before, after) = (step / 3 * 3, step / 3 * 3 + 3);
            let stick = values[*step].expect("recorded") + 40.0;
            let other = if step % 3 == 1 { step + 1 } else { step - 1 };
            let end = if step % 3 == 1 { after } else { before };
            values[*step] = Some(stick);
            values[other] = values[end].map(|end| 0.5 * (end + stick));
        }
        let found = doubts(&faulty);
        assert_eq!(checks(&found), ["capillary_in_cgm"], "{}: {found:?}", person.id);
        let text = &found[0].reported.finding;
        let counted = format!("{0} readings stand between the sensor's, {0} of them", steps.len());
        assert!(text.starts_with(&counted), "{}: {text}", person.id);
        let (value, ..) = estimate(&found, "capillary_in_cgm").expect("an estimate");
        assert!((value - 40.0).abs() < 1e-6, "{}: {value}", person.id);
        assert_eq!(found[0].consequence, Consequence::Note);

        // The filter sees what it sees without them.
        let clean = Observations::from_person(&drawn).expect("good values");
        let mended = Observations::from_person(&faulty).expect("good values");
        for (k, (clean, mended)) in clean.readings.iter().zip(&mended.readings).enumerate() {
            let (a, b) = (clean.value(), mended.value());
            let apart = a.zip(b).map_or(0.0, |(a, b)| (a - b).abs());
            assert!(a.is_some() == b.is_some() && apart < 1e-6, "{} {k}: {a:?} {b:?}", person.id);
            // Beside a stick no value that was drawn passes for a reading.
            let read = |reading: &Reading| matches!(reading, Reading::Within(_));
            assert!(k % 3 == 0 || !read(mended) || read(clean), "{} {k}: {mended:?}", person.id);
        }
    }
}

#[test]
fn finger_sticks_among_readings_of_five_minutes_are_found_at_doses() {
    for person in embedded() {
        let steps = boluses(&person);
        let faulty = raised(&person, &steps, 70.0);
        let found = doubts(&faulty);
        assert_eq!(checks(&found), ["capillary_in_cgm"], "{}: {found:?}", person.id);
        let observations = Observations::from_person(&faulty).expect("good values");
        let fed = |k: &&usize| !matches!(observations.readings[**k], Reading::Interpolated(_));
        let kept = steps.iter().filter(fed).count();
        // Where glucose rises or falls fast, or the sensor's range ends, a stick may hide.
        assert!(4 * kept <= steps.len(), "{}: {kept} of {}", person.id, steps.len());
    }
}

#[test]
fn spikes_away_from_doses_are_a_sensors_own() {
    for person in embedded() {
        let doses = |k: usize| {
            let given = |dose: Option<f64>| dose.is_some_and(|dose| dose > 0.0);
            given(person.record.bolus()[k]) || given(person.record.carbs()[k])
        };
        let far = |k: &usize| !(k - 6..k + 6).any(doses);
        let steps: Vec<usize> = (100..4000).step_by(97).filter(far).take(20).collect();
        assert_eq!(doubts(&raised(&person, &steps, 70.0)), [], "{}", person.id);
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
