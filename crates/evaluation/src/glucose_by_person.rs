//! Each person's measured glucose: ranges, mean, variation, and percentiles by time of day.

use chrono::Timelike as _;
use cohort::{Cohort, Person, insulin_u_day, mass_balance};
use contract::agp::Percentiles;
use contract::glucose_by_person::{GlucoseRanges, PersonGlucose};
use contract::{Document as _, GlucoseByPerson};
use physiology::{MgPerDl, STEPS_PER_DAY};
use stats::Outcomes;
use stats::profile::percentiles;

use crate::error::EvaluationError;

/// Slots of the day: half hours.
const SLOTS: usize = 48;
/// Least readings of a person: a spread needs two.
const LEAST: usize = 2;
/// Decimals of a percentile: a sensor has none.
const DECIMALS: f64 = 10.0;

/// Everybody's glucose; people with fewer than two readings are not in the list.
///
/// # Errors
/// A reading that is no glucose.
pub fn glucose_by_person(cohort: &Cohort) -> Result<GlucoseByPerson, EvaluationError> {
    let read = |person: &&Person| person.record.cgm().iter().flatten().count() >= LEAST;
    let of = |person: &Person| of_person(person).map_err(|error| error.of_person(&person.id));
    let people = cohort.people.iter().filter(read).map(of).collect::<Result<_, _>>()?;
    Ok(GlucoseByPerson {
        schema: GlucoseByPerson::SCHEMA.to_owned(),
        hour: (0..SLOTS).map(|slot| (slot as f64 + 0.5) * 24.0 / SLOTS as f64).collect(),
        people,
    })
}

fn of_person(person: &Person) -> Result<PersonGlucose, EvaluationError> {
    let record = &person.record;
    let readings =
        || record.cgm().iter().enumerate().filter_map(|(step, cgm)| Some((step, (*cgm)?)));
    let outcomes = Outcomes::of(readings().map(|(_, glucose)| MgPerDl(glucose)))?;
    let slots = readings().map(|(step, glucose)| {
        let step_of_day = record.time(step).num_seconds_from_midnight() as usize / 300;
        (step_of_day * SLOTS / STEPS_PER_DAY, glucose)
    });
    let Percentiles { p05, p25, p50, p75, p95 } = percentiles(slots, SLOTS)?;
    let [p05, p25, p50, p75, p95] = [p05, p25, p50, p75, p95].map(|series| {
        let rounded = |value: f64| (DECIMALS * value).round() / DECIMALS;
        series.into_iter().map(|value| value.map(rounded)).collect()
    });
    let balance = mass_balance(person);
    Ok(PersonGlucose {
        person_id: person.id.clone(),
        readings: readings().count(),
        mean_mg_dl: outcomes.mg,
        cv: outcomes.cv,
        gmi: outcomes.gmi,
        ranges: GlucoseRanges {
            below_54: outcomes.tbr54,
            from_54_to_70: outcomes.tbr - outcomes.tbr54,
            from_70_to_180: outcomes.tir,
            from_180_to_250: outcomes.tar - outcomes.tar250,
            above_250: outcomes.tar250,
        },
        insulin_u_day: insulin_u_day(&balance),
        carbs_g_day: balance.carbs_g_day,
        percentiles: Percentiles { p05, p25, p50, p75, p95 },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use cohort::{Channel, Record, Therapy};

    #[test]
    fn a_day_of_known_glucose_has_known_figures() {
        let start = "2024-03-08T00:00:00".parse().expect("a literal time");
        let person = |id: &str, readings: usize| {
            let mut record = Record::new(start, STEPS_PER_DAY).expect("on the grid");
            // A quarter of the day each at 50, 100, 200 and 300 mg/dL.
            for (step, cgm) in
                record.channel_mut(Channel::Cgm).iter_mut().enumerate().take(readings)
            {
                *cgm = Some([50.0, 100.0, 200.0, 300.0][step * 4 / STEPS_PER_DAY]);
            }
            let (weight, heart_rate_baseline) = (None, None);
            Person { id: id.into(), weight, therapy: Therapy::Unknown, heart_rate_baseline, record }
        };
        let cohort = Cohort { people: vec![person("a", STEPS_PER_DAY), person("b", 1)] };
        let found = glucose_by_person(&cohort).expect("glucose");
        let [one] = &found.people[..] else { panic!("one reading has no spread: {found:?}") };
        assert_eq!((one.person_id.as_str(), one.readings, one.mean_mg_dl), ("a", 288, 162.5));
        let GlucoseRanges { below_54, from_54_to_70, from_70_to_180, from_180_to_250, above_250 } =
            one.ranges;
        assert_eq!(
            [below_54, from_54_to_70, from_70_to_180, from_180_to_250, above_250],
            [25.0, 0.0, 25.0, 25.0, 25.0]
        );
        assert_eq!(one.percentiles.p50[0], Some(50.0));
        assert_eq!(one.percentiles.p95[47], Some(300.0));
        assert_eq!(one.insulin_u_day, None);

        let mut broken = person("c", STEPS_PER_DAY);
        broken.record.channel_mut(Channel::Cgm)[7] = Some(0.5);
        let error = glucose_by_person(&Cohort { people: vec![broken] }).expect_err("no glucose");
        assert!(error.to_string().starts_with("person 'c'"), "{error}");
    }
}
