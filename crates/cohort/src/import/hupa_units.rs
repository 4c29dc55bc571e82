//! What the numbers of a HUPA-UCM file mean: the study mixes units and flags between people.

use physiology::STEPS_PER_DAY;

/// Fewest entries from which equal values count as a flag.
const FEWEST_FOR_FLAG: usize = 10;
/// Above this an entry cannot be a meal, g.
const LARGEST_MEAL_G: f64 = 300.0;
/// Grams in a serving ("ración").
const GRAMS_PER_SERVING: f64 = 10.0;
/// Typical ratio of carbohydrate to bolus insulin, g/U.
const TYPICAL_GRAMS_PER_UNIT: f64 = 10.0;
/// Below this median, entries without any bolus for comparison are servings.
const MEDIAN_OF_SERVINGS: f64 = 15.0;
/// Basal insulin per day that a pump may give, U.
const BASAL_U_DAY: (f64, f64) = (4.0, 100.0);

/// What a column of doses holds: the factor to the unit of the record (`None` where no amount is
/// known), the same in words, and the evidence.
pub(super) type Meaning = (Option<f64>, &'static str, String);

/// The values above zero.
fn entries(values: &[Option<f64>]) -> Vec<f64> {
    values.iter().copied().flatten().filter(|value| *value > 0.0).collect()
}

/// The evidence that entries only say that there was something; `None` where they say how much.
fn flag(entries: &[f64]) -> Option<String> {
    let is_flag = entries.len() >= FEWEST_FOR_FLAG && entries.iter().all(|value| *value == 1.0);
    is_flag.then(|| format!("all {} entries are exactly 1", entries.len()))
}

/// What the boluses are.
pub(super) fn bolus_unit(values: &[Option<f64>]) -> Meaning {
    let entries = entries(values);
    if entries.is_empty() {
        return (None, "no bolus was recorded: bolus_u is missing", "no entry above 0".into());
    }
    if let Some(evidence) = flag(&entries) {
        return (None, "a flag without an amount: bolus_u is missing", evidence);
    }
    let largest = entries.iter().copied().fold(0.0, f64::max);
    (Some(1.0), "U", format!("{} entries, largest {largest:.1}", entries.len()))
}

/// What the carbohydrate is. `bolus` is in units, or empty.
pub(super) fn carb_unit(values: &[Option<f64>], bolus: Option<&[Option<f64>]>) -> Meaning {
    let unit = |servings: bool, evidence: String| {
        let (factor, words) =
            if servings { (GRAMS_PER_SERVING, "servings of 10 g; x 10 g") } else { (1.0, "g") };
        (Some(factor), words, evidence)
    };
    let mut carbs = entries(values);
    carbs.sort_by(f64::total_cmp);
    let (Some(largest), Some(median)) = (carbs.last(), carbs.get(carbs.len() / 2)) else {
        return (None, "nothing was logged: carbs_g is missing", "no entry above 0".into());
    };
    if let Some(evidence) = flag(&carbs) {
        return (None, "a flag without an amount: carbs_g is missing", evidence);
    }
    let shape = format!("{} entries, median {median:.1}, largest {largest:.1}", carbs.len());
    let as_servings = largest * GRAMS_PER_SERVING;
    if as_servings > LARGEST_MEAL_G {
        return unit(false, format!("{shape}: as servings a meal of {as_servings:.0} g"));
    }
    let units: f64 = bolus.map_or(0.0, |bolus| entries(bolus).iter().sum());
    if units > 0.0 {
        let grams_per_unit = carbs.iter().sum::<f64>() / units;
        let distance = |ratio: f64| (ratio / TYPICAL_GRAMS_PER_UNIT).ln().abs();
        let servings = distance(grams_per_unit * GRAMS_PER_SERVING) < distance(grams_per_unit);
        let evidence = format!(
            "{shape}; over all boluses {grams_per_unit:.1} g/U if grams, {:.1} g/U if servings",
            grams_per_unit * GRAMS_PER_SERVING
        );
        return unit(servings, evidence);
    }
    unit(*median < MEDIAN_OF_SERVINGS, format!("{shape}; no bolus amounts to compare with"))
}

/// What the basal insulin is: the factor to U/h, the same in words, and the evidence. Documented as
/// U per 5 minutes; read as U/h only if the documented unit gives a day no pump gives and U/h does
/// not.
pub(super) fn basal_unit(values: &[Option<f64>]) -> (f64, &'static str, String) {
    let recorded: Vec<f64> = values.iter().copied().flatten().collect();
    let mean = recorded.iter().sum::<f64>() / recorded.len().max(1) as f64;
    let (per_step, per_hour) = (mean * STEPS_PER_DAY as f64, mean * 24.0);
    let fits = |day: f64| (BASAL_U_DAY.0..=BASAL_U_DAY.1).contains(&day);
    let hourly = !fits(per_step) && fits(per_hour);
    let (factor, words) = if hourly { (1.0, "U/h") } else { (12.0, "U per 5 min; x 12 U/h") };
    let evidence = format!("{per_step:.1} U/day if U per 5 min, {per_hour:.1} U/day if U/h");
    (factor, words, evidence)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some(values: &[f64]) -> Vec<Option<f64>> {
        values.iter().copied().map(Some).collect()
    }

    #[test]
    fn carbohydrate_is_told_apart() {
        let grams = (Some(1.0), "g");
        let servings = (Some(10.0), "servings of 10 g; x 10 g");
        let flag = (None, "a flag without an amount: carbs_g is missing");
        let nothing = (None, "nothing was logged: carbs_g is missing");
        let boluses = some(&[6.0; 12]);
        for (carbs, bolus, unit) in [
            // A meal of 1030 g does not exist.
            (some(&[55.0, 0.0, 103.0]), Some(&boluses), grams),
            // 72 U for 60 g would be 0.8 g/U; 8.3 g/U for servings.
            (some(&[2.0, 3.5, 7.5, 13.0, 34.0 / 2.0, 17.0]), Some(&boluses), servings),
            // 20 and 30 entered by hand, for 6 U each: grams.
            (some(&[30.0; 24]), Some(&boluses), grams),
            (some(&[1.0; 12]), Some(&boluses), flag),
            (some(&[1.0, 2.0]), None, servings),
            (some(&[20.0, 30.0]), None, grams),
            (some(&[0.0, 0.0]), None, nothing),
        ] {
            let (factor, words, evidence) = carb_unit(&carbs, bolus.map(Vec::as_slice));
            assert_eq!((factor, words), unit, "{carbs:?}: {evidence}");
        }
    }

    #[test]
    fn a_bolus_that_is_always_one_is_a_flag() {
        let meaning = |values: &[f64]| {
            let (factor, words, _) = bolus_unit(&some(values));
            (factor, words)
        };
        let flag = (None, "a flag without an amount: bolus_u is missing");
        assert_eq!(meaning(&[1.0; 10]), flag);
        assert_eq!(meaning(&[1.0; 9]), (Some(1.0), "U"));
        assert_eq!(meaning(&[1.0, 2.5, 0.0]), (Some(1.0), "U"));
        assert_eq!(meaning(&[0.0]), (None, "no bolus was recorded: bolus_u is missing"));
    }

    #[test]
    fn basal_is_per_five_minutes_unless_that_cannot_be() {
        // 0.075 U per 5 min is 21.6 U a day; 0.9 would be 259 U a day, but 21.6 U as a rate.
        assert_eq!(basal_unit(&some(&[0.075])).0, 12.0);
        assert_eq!(basal_unit(&some(&[0.9])).0, 1.0);
    }
}
