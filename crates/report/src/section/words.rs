//! Names of factors, levels and effects as people say them.

/// A key of the JSON files in words: `day_after_short_sleep` becomes `day after short sleep`.
pub(super) fn plain(key: &str) -> String {
    key.replace('_', " ")
}

/// A situation in words: `hour`, `04-08` becomes `from 04 to 08 h`.
pub(super) fn situation(factor: &str, level: &str) -> String {
    match (factor, level.split_once('-')) {
        ("hour", Some((from, to))) => format!("from {from} to {to} h"),
        ("context", _) => match level {
            "after_meal" | "after_dinner" | "after_exercise" | "after_low" => plain(level),
            "exercise" => "during exercise".to_owned(),
            "sleep" => "during sleep".to_owned(),
            "day_after_short_sleep" => "on the day after short sleep".to_owned(),
            "set_day_3_plus" => "from the third day of an infusion set".to_owned(),
            "sensor_late" => "late in a sensor's life".to_owned(),
            "fast_change" => "while glucose changes fast".to_owned(),
            "weekend" => "at weekends".to_owned(),
            "other" => "in no particular situation".to_owned(),
            _ => format!("in the situation '{}'", plain(level)),
        },
        ("glucose_band", _) => format!("while glucose is {level} mg/dL"),
        ("person", _) => format!("in person {level}"),
        ("horizon", _) => format!("{level} min ahead"),
        _ => format!("where {} is {}", plain(factor), plain(level)),
    }
}

/// Joins with commas and a final "and".
pub(super) fn list(items: &[String]) -> String {
    match items {
        [] => String::new(),
        [one] => one.clone(),
        [init @ .., last] => format!("{} and {last}", init.join(", ")),
    }
}

/// Upper case for the first letter.
pub(super) fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_become_words() {
        for (factor, level, words) in [
            ("hour", "04-08", "from 04 to 08 h"),
            ("context", "after_dinner", "after dinner"),
            ("context", "new_thing", "in the situation 'new thing'"),
            ("glucose_band", "70-180", "while glucose is 70-180 mg/dL"),
            ("person", "p7", "in person p7"),
            ("set", "x_y", "where set is x y"),
        ] {
            assert_eq!(situation(factor, level), words);
        }
        let items = ["a", "b", "c"].map(str::to_owned);
        assert_eq!(list(&items), "a, b and c");
        assert_eq!(sentence("dawn"), "Dawn");
        assert_eq!(sentence(""), "");
    }
}
