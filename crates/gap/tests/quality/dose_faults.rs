//! Units and flags planted in made records.

use cohort::{Channel, Person};
use gap::quality::{Consequence, exclusion};

use crate::planted::{changed, checks, doubts, embedded, estimate};

/// Plants a fault in everyone and asserts that `check` alone finds it and leaves them out.
fn check(check: &str, plant: impl Fn(&Person) -> Person) -> Vec<(f64, f64, f64)> {
    let people = embedded().into_iter();
    people
        .map(|person| {
            let found = doubts(&plant(&person));
            let case = format!("{}: {found:?}", person.id);
            assert!(checks(&found).contains(&check), "{case}");
            assert!(found.iter().any(|f| f.consequence == Consequence::ExcludePerson), "{case}");
            assert!(exclusion(&found).is_some(), "{case}");
            estimate(&found, check).expect("an estimate")
        })
        .collect()
}

#[test]
fn carbohydrate_in_servings_is_found_with_their_size() {
    for grams in [10.0, 12.0, 15.0] {
        let found = check("carb_unit", |p| changed(p, Channel::Carbs, |_, carbs| carbs / grams));
        for (_, lower, upper) in found {
            assert!((lower..=upper).contains(&grams), "{grams} g in {lower} to {upper}");
        }
    }
}

#[test]
fn carbohydrate_in_milligrams_is_found() {
    check("carb_unit", |p| changed(p, Channel::Carbs, |_, carbs| 1000.0 * carbs));
}

#[test]
fn doses_that_are_flags_are_found() {
    for channel in [Channel::Bolus, Channel::Carbs] {
        check("dose_is_flag", |p| {
            changed(p, channel, |_, dose| if dose > 0.0 { 1.0 } else { 0.0 })
        });
    }
}

#[test]
fn basal_insulin_in_the_wrong_unit_is_found() {
    check("basal_unit", |p| changed(p, Channel::Basal, |_, rate| 12.0 * rate));
    // Controllers of two of the six give so many boluses at night that a twelfth of the basal rate
    // leaves a plausible day; those on a programmed pump are all found.
    let found = embedded()
        .iter()
        .filter(|person| {
            let faulty = changed(person, Channel::Basal, |_, rate| rate / 12.0);
            checks(&doubts(&faulty)).contains(&"basal_unit")
        })
        .count();
    assert!(found >= 5, "{found} of 6");
}

#[test]
fn basal_units_that_change_within_the_record_are_found() {
    let from_day_5 = |k: usize, rate: f64| if k >= 5 * 288 { rate / 12.0 } else { rate };
    check("basal_unit", |p| changed(p, Channel::Basal, from_day_5));
}

#[test]
fn doses_in_thousandths_are_found() {
    check("plausible_day", |p| changed(p, Channel::Bolus, |_, dose| 1000.0 * dose));
    let found = check("plausible_day", |p| {
        let p = changed(p, Channel::Bolus, |_, dose| 1000.0 * dose);
        changed(&p, Channel::Basal, |_, rate| 1000.0 * rate)
    });
    assert!(found.iter().all(|(value, ..)| *value > 100.0));
}

#[test]
fn a_day_that_lacks_most_of_its_insulin_is_found() {
    let tenth = |_, dose| 0.1 * dose;
    let found = check("plausible_day", |p| {
        changed(&changed(p, Channel::Bolus, tenth), Channel::Basal, tenth)
    });
    assert!(found.iter().all(|(.., upper)| *upper < 0.2));
}
