//! Names that are close to a known one: a slip of the fingers, or the same word without its unit.

/// Other words for the columns of a cohort folder.
const OTHER_WORDS: [(&str, &[&str]); 12] = [
    ("person_id", &["id", "person", "patient_id", "subject_id", "participant", "ptid"]),
    ("time", &["timestamp", "datetime", "date_time", "date"]),
    ("cgm_mg_dl", &["cgm", "glucose", "glucose_mg_dl", "cgm_mmol_l", "bg", "sgv"]),
    ("basal_u_h", &["basal", "basal_rate", "basal_u"]),
    ("bolus_u", &["bolus"]),
    ("carbs_g", &["carbs", "carb", "carbohydrate", "carbohydrates", "cho"]),
    ("heart_rate_bpm", &["heart_rate", "hr"]),
    ("steps", &["step_count"]),
    ("sleep_efficiency", &["sleep"]),
    ("set_change", &["site_change"]),
    ("weight_kg", &["weight", "body_weight"]),
    ("heart_rate_baseline_bpm", &["heart_rate_baseline", "resting_heart_rate"]),
];
/// Words that are close to a known name and mean something else.
const OWN_MEANING: [&str; 1] = ["height"];

/// The name of `known` that `found` probably stands for; `None` if it is a name of its own.
pub(crate) fn near<'a>(found: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let plain_found = plain(found);
    if plain_found.is_empty() || OWN_MEANING.contains(&plain_found.as_str()) {
        return None;
    }
    known
        .into_iter()
        .filter_map(|name| {
            let others = OTHER_WORDS.iter().find(|(column, _)| *column == name);
            let words = others.map_or(&[][..], |(_, words)| words);
            let nearest = std::iter::once(&name)
                .chain(words)
                .map(|word| plain(word))
                .filter_map(|word| {
                    let slips = distance(&plain_found, &word);
                    (slips <= allowed(word.len())).then_some(slips)
                })
                .min()?;
            Some((nearest, name))
        })
        .min_by_key(|(slips, _)| *slips)
        .map(|(_, name)| name)
}

/// Slips that leave a word of this length recognisable.
const fn allowed(length: usize) -> usize {
    match length {
        0..=3 => 0,
        4..=6 => 1,
        _ => 2,
    }
}

/// Letters and digits alone, in lower case.
pub(crate) fn plain(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// Letters inserted, left out, replaced, or exchanged with their neighbour (optimal string
/// alignment).
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().take(64).collect(), b.chars().collect());
    let mut rows = vec![(0..=b.len()).collect::<Vec<usize>>()];
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let same = usize::from(a[i - 1] != b[j - 1]);
            let mut least = (rows[i - 1][j] + 1).min(row[j - 1] + 1).min(rows[i - 1][j - 1] + same);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                least = least.min(rows[i - 2][j - 2] + 1);
            }
            row.push(least);
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_and_words_without_unit_are_found_and_other_columns_are_not() {
        let known = OTHER_WORDS.map(|(name, _)| name);
        for (found, name) in [
            ("set_chnage", "set_change"),
            ("Bolus", "bolus_u"),
            ("CGM (mg/dL)", "cgm_mg_dl"),
            ("carbs", "carbs_g"),
            ("basal_u_hr", "basal_u_h"),
            ("heartrate", "heart_rate_bpm"),
            ("Patient ID", "person_id"),
            ("step", "steps"),
            ("tiem", "time"),
        ] {
            assert_eq!(near(found, known), Some(name), "{found}");
        }
        for other in ["note", "age", "sex", "height", "device", "protein_g", "", "x", "visit"] {
            assert_eq!(near(other, known), None, "{other}");
        }
    }
}
