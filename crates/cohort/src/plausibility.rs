//! Figures that are unlikely for a person: reported, never enforced.
//!
//! The bounds are wide. They catch a wrong unit, a rate read as an amount, a day without a pump, or
//! a meal in milligrams; they say nothing about a person's treatment.

use chrono::NaiveDate;
use contract::import_report::ImplausibleFigure;
use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};

use crate::mass_balance::{insulin_u_day, mass_balance};
use crate::person::Person;
use crate::record::Channel;

/// Plausible insulin a day, U, where the weight is unknown.
const INSULIN_U_DAY: (f64, f64) = (8.0, 150.0);
/// Plausible insulin a day per body weight, U/kg.
const INSULIN_U_KG_DAY: (f64, f64) = (0.2, 1.5);
/// Plausible carbohydrate a day, g.
const CARBS_G_DAY: (f64, f64) = (30.0, 500.0);
/// Plausible mean glucose, mg/dL.
const MEAN_GLUCOSE: (f64, f64) = (70.0, 350.0);
/// Plausible insulin in one calendar day, U.
const ONE_DAY_INSULIN_U: (f64, f64) = (4.0, 250.0);
/// Largest plausible meal in one step, g.
const LARGEST_MEAL_G: f64 = 250.0;
/// Largest plausible insulin in one step, U: the cap of pumps on a bolus, rounded up.
const LARGEST_BOLUS_U: f64 = 35.0;
/// Share of a calendar day's steps that must be recorded before the day is judged.
const JUDGED_SHARE: f64 = 0.9;

/// Everything implausible in a person's record, means first, then days and steps in order.
#[must_use]
pub fn findings(person: &Person) -> Vec<ImplausibleFigure> {
    let balance = mass_balance(person);
    let mut found = Vec::new();
    let mut judge = |channel: Channel,
                     date: Option<NaiveDate>,
                     step: Option<usize>,
                     what: &str,
                     value: f64,
                     unit: &str,
                     (low, high): (f64, f64)| {
        if !(low..=high).contains(&value) {
            found.push(ImplausibleFigure {
                person: person.id.clone(),
                column: channel.name().into(),
                date: date.map(|date| date.to_string()),
                step,
                time: step.map(|k| person.record.time(k).to_string()),
                what: what.into(),
                value,
                unit: unit.into(),
                plausible: (low, high),
            });
        }
    };
    let insulin = insulin_u_day(&balance);
    let (what, insulin, unit, range) = match person.weight {
        Some(weight) => {
            let what = "mean insulin a day per weight";
            (what, insulin.map(|units| units / weight.0), "U/kg", INSULIN_U_KG_DAY)
        }
        None => ("mean insulin a day", insulin, "U", INSULIN_U_DAY),
    };
    for (channel, what, mean, unit, range) in [
        (Channel::Basal, what, insulin, unit, range),
        (Channel::Carbs, "mean carbohydrate a day", balance.carbs_g_day, "g", CARBS_G_DAY),
        (Channel::Cgm, "mean glucose", balance.mean_glucose_mg_dl, "mg/dL", MEAN_GLUCOSE),
    ] {
        if let Some(mean) = mean {
            judge(channel, None, None, what, mean, unit, range);
        }
    }
    for (date, insulin) in insulin_by_day(person) {
        let (what, range) = ("insulin of the day", ONE_DAY_INSULIN_U);
        judge(Channel::Basal, Some(date), None, what, insulin, "U", range);
    }
    let record = &person.record;
    for k in 0..record.len() {
        for (channel, what, per_step, unit, largest) in [
            (Channel::Carbs, "meal", 1.0, "g", LARGEST_MEAL_G),
            (Channel::Bolus, "bolus", 1.0, "U", LARGEST_BOLUS_U),
            (Channel::Basal, "basal of the step", STEPS_PER_HOUR as f64, "U", LARGEST_BOLUS_U),
        ] {
            if let Some(value) = record.channel(channel)[k] {
                judge(channel, None, Some(k), what, value / per_step, unit, (0.0, largest));
            }
        }
    }
    found
}

/// Insulin of each calendar day on which basal and bolus are recorded nearly throughout.
fn insulin_by_day(person: &Person) -> Vec<(NaiveDate, f64)> {
    let record = &person.record;
    let mut days: Vec<(NaiveDate, f64, usize)> = Vec::new();
    for k in 0..record.len() {
        let (Some(basal), Some(bolus)) = (record.basal()[k], record.bolus()[k]) else { continue };
        let (date, dose) = (record.time(k).date(), basal / STEPS_PER_HOUR as f64 + bolus);
        match days.last_mut() {
            Some(day) if day.0 == date => {
                day.1 += dose;
                day.2 += 1;
            }
            _ => days.push((date, dose, 1)),
        }
    }
    let judged = JUDGED_SHARE * STEPS_PER_DAY as f64;
    days.into_iter().filter(|day| day.2 as f64 >= judged).map(|day| (day.0, day.1)).collect()
}

#[cfg(test)]
mod tests {
    use physiology::Kilograms;

    use super::*;
    use crate::{Record, Therapy};

    fn person(basal: f64) -> Person {
        let start = "2024-03-08T00:00:00".parse().expect("a literal time");
        let mut record = Record::new(start, 3 * STEPS_PER_DAY).expect("on the grid");
        record.channel_mut(Channel::Basal).fill(Some(basal));
        record.channel_mut(Channel::Bolus).fill(Some(0.0));
        record.channel_mut(Channel::Carbs).fill(Some(0.5));
        Person {
            id: "a".into(),
            weight: None,
            therapy: Therapy::OpenLoopPump,
            heart_rate_baseline: None,
            record,
        }
    }

    #[test]
    fn a_plausible_person_has_no_finding() {
        assert_eq!(findings(&person(1.0)), []);
    }

    #[test]
    fn a_basal_in_the_wrong_unit_shows_in_the_mean_and_in_every_day() {
        // 1 U/h written as U per 5 min: 2 U a day.
        let found = findings(&person(1.0 / 12.0));
        assert_eq!(found.len(), 4);
        assert_eq!(
            found[0].to_string(),
            "person 'a', column basal_u_h: mean insulin a day of 2.000 U is outside 8 to 150; \
             check the unit"
        );
        assert!(found[1].to_string().contains("2024-03-08, column basal_u_h: insulin of the day"));
    }

    #[test]
    fn a_meal_in_the_wrong_unit_and_a_light_person_are_found() {
        let mut big = person(1.0);
        big.record.channel_mut(Channel::Carbs)[7] = Some(900.0);
        big.weight = Some(Kilograms(10.0));
        let found: Vec<String> = findings(&big).iter().map(ToString::to_string).collect();
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].contains("mean insulin a day per weight of 2.400 U/kg"), "{found:?}");
        assert!(
            found[1].contains("2024-03-08 00:35:00, column carbs_g: meal of 900.000 g"),
            "{found:?}"
        );
    }
}
