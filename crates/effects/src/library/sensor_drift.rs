//! Sensor drift: the gain changes as the sensor ages.

use super::prelude::*;

/// Change of the gain's logarithm over the life of a sensor at amplitude 1.
const OVER_LIFE: f64 = 0.1;
/// Life of a sensor where its age is known, days.
const LIFE: f64 = 10.0;
/// Change of the gain's logarithm right after insertion at amplitude 1, where the age is known.
const FIRST_HOURS: f64 = 0.1;
/// Time in which a new sensor settles, days.
const SETTLES: f64 = 0.5;
/// Lives that are tried where the age is unknown, days, with so many phases.
const CYCLES: [(f64, usize); 2] = [(7.0, 4), (10.0, 5)];
/// Hour at which sensors are taken to be changed where nobody says.
const CHANGE_HOUR: f64 = 15.0;

/// See the module.
#[derive(Debug, Clone, Copy)]
pub(super) struct SensorDrift;

impl Effect for SensorDrift {
    fn card(&self) -> Card {
        Card {
            id: EffectId::SENSOR_DRIFT,
            port: Port::Sensor,
            summary: "the sensor's gain falls or rises as it ages, and is new after a change",
            size_at_one: "gain 10 % lower (or higher) at the end of its life than at the start",
            source: "gain and offset over the life of a sensor: Facchinetti et al., Med Biol Eng Comput 2015;53:1259; \
                     Vettoretti et al., Sensors 2019;19:5320",
            signature: "errors in proportion to glucose that grow over the days of a sensor and jump at its change",
            channels: &[Channel::Clock],
            confusable_with: &[EffectId::SET_AGEING, EffectId::INSULIN_ABSORPTION],
            relations: Relations::USUAL,
            prior: Prior { median: 1.0, log_sd: 0.5, largest: 3.0 },
        }
    }

    fn form(&self, course: &Course) -> Option<Form> {
        (!course.is_empty()).then_some(Form::Driven)
    }

    /// Odd variants rise where even ones fall. A known age takes the first four: over the life of the sensor,
    /// and in its first hours. Without it cycles of 7 and 10 days are tried in nine phases.
    fn variants(&self) -> usize {
        2 * CYCLES.iter().map(|(_, phases)| phases).sum::<usize>()
    }

    fn variants_for(&self, course: &Course) -> usize {
        if course.sensor_age.is_some() { 4 } else { self.variants() }
    }

    fn modulate(&self, variant: usize, amplitude: f64, course: &Course, into: &mut [Modulation]) {
        let sign = if variant.is_multiple_of(2) { -1.0 } else { 1.0 };
        let change = match &course.sensor_age {
            Some(ages) => changes_by_age(variant / 2 % 2, ages),
            None => changes_by_cycle(variant / 2, course),
        };
        let centred = centre_within_clock_slots(course, &change);
        for (change, modulation) in centred.iter().zip(into) {
            modulation[Field::SensorGain] *= (sign * amplitude * change).exp();
        }
    }
}

/// Change of the logarithm of the gain by known age: over life (0) or in the first hours (1).
fn changes_by_age(kind: usize, ages: &[f64]) -> Vec<Option<f64>> {
    let change = |age: f64| match kind {
        0 => OVER_LIFE * age / LIFE,
        _ => FIRST_HOURS * (-age / SETTLES).exp(),
    };
    ages.iter().map(|age| age.is_finite().then(|| change(*age))).collect()
}

/// Change of the logarithm of the gain of sensors that are changed in a cycle.
fn changes_by_cycle(which: usize, course: &Course) -> Vec<Option<f64>> {
    let mut cycles = CYCLES.into_iter().flat_map(|(life, phases)| {
        (0..phases).map(move |phase| (life, life * phase as f64 / phases as f64))
    });
    let (life, phase) = cycles.nth(which).unwrap_or((CYCLES[0].0, 0.0));
    let steps = course.day.iter().zip(&course.hour);
    let days = steps.map(|(day, hour)| *day as f64 + (hour - CHANGE_HOUR) / 24.0 + phase);
    days.map(|days| Some(OVER_LIFE * days.rem_euclid(life) / life)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{DAY, fortnight, looks_only_back, modulated, zero_mean_by_slot};

    #[test]
    fn an_old_sensor_shows_less_in_even_variants_and_more_in_odd_ones() {
        let course = fortnight();
        assert_eq!(SensorDrift.variants_for(&course), 4);
        for variant in 0..4 {
            let steps = modulated(&SensorDrift, variant, 1.0, &course);
            // Changed at noon of days 0.5 and 7.5: 14 h of day 7 is new, 14 h of day 6 old.
            let (new, old) =
                (steps[7 * DAY + 168][Field::SensorGain], steps[6 * DAY + 168][Field::SensorGain]);
            let over_life = variant < 2;
            assert_eq!(
                (old < new) == over_life,
                variant % 2 == 0,
                "variant {variant}: {old} against {new}"
            );
            zero_mean_by_slot(&course, &steps, Field::SensorGain);
        }
    }

    #[test]
    fn every_latent_cycle_is_another() {
        let course = Course { sensor_age: None, ..fortnight() };
        let all: Vec<Vec<f64>> = (0..SensorDrift.variants_for(&course))
            .map(|v| {
                modulated(&SensorDrift, v, 1.0, &course)
                    .iter()
                    .map(|m| m[Field::SensorGain])
                    .collect()
            })
            .collect();
        assert_eq!(all.len(), 18);
        for (k, one) in all.iter().enumerate() {
            assert!(all[..k].iter().all(|other| other != one), "variant {k}");
        }
    }

    #[test]
    fn a_life_changes_the_gain_by_what_was_published() {
        let changes = changes_by_age(0, &[0.0, LIFE]);
        assert_eq!(changes, [Some(0.0), Some(OVER_LIFE)]);
        assert_eq!(changes_by_age(0, &[f64::NAN]), [None]);
    }

    #[test]
    fn the_age_looks_only_back() {
        looks_only_back(|course| {
            changes_by_age(0, course.sensor_age.as_ref().expect("the sample knows the age"))
        });
    }
}
