//! Readable names of factors, levels and effects.

use contract::blind_check::Outcome;

/// A key of the JSON files in words: `day_after_short_sleep` becomes `day after short sleep`.
/// Words, which have no underscore, stay as they are.
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
        ("glucose_band", _) => format!("while glucose is {} mg/dL", band(level)),
        ("person", _) => format!("in person {level}"),
        ("horizon", _) => format!("{level} min ahead"),
        _ => format!("where {} is {}", plain(factor), plain(level)),
    }
}

/// A situation as a name: `set_day_3_plus` becomes `infusion set, day 3+`.
pub(super) fn context(level: &str) -> String {
    plain(match level {
        "other" => "none of these",
        "set_day_3_plus" => "infusion set, day 3+",
        _ => level,
    })
}

/// What sets a cell apart, in words.
pub(super) fn factor(key: &str) -> String {
    plain(match key {
        "hour" => "hour of the day",
        "context" => "situation",
        "horizon" => "time ahead",
        _ => key,
    })
}

/// A plant in words; one that this version does not know keeps its key.
pub(super) fn model(plant: &str) -> String {
    match plant {
        "ode" => "the ODE model with parameters fitted to each person".to_owned(),
        "network" => "the population network with parameters fitted to each person".to_owned(),
        "twin" => "each person's own digital twin".to_owned(),
        other => format!("the model \u{201c}{other}\u{201d}"),
    }
}

/// A band of glucose in words.
fn band(level: &str) -> String {
    match (level.strip_prefix('<'), level.strip_prefix('>')) {
        (Some(bound), _) => format!("below {bound}"),
        (_, Some(bound)) => format!("above {bound}"),
        _ => level.replacen('-', " to ", 1),
    }
}

/// An effect in words; one that this version does not know keeps its key.
pub(super) fn effect(key: &str) -> String {
    if let Some(name) = key.strip_prefix("outside:") {
        return format!("outside the library: {}", plain(name));
    }
    plain(match key {
        "exercise" => "glucose uptake during exercise",
        "post_exercise_sensitivity" => "higher insulin sensitivity after exercise",
        "dawn" => "dawn phenomenon",
        "circadian_sensitivity" => "insulin sensitivity that follows the clock",
        "sleep_loss" => "lower insulin sensitivity after short sleep",
        "slow_meals" => "slow meals (fat and protein)",
        "carb_miscount" => "miscounted carbohydrate",
        "missed_meals" => "meals that were not logged",
        "unlogged_rescue_carbs" => "rescue carbohydrate that was not logged",
        "set_ageing" => "ageing of the infusion set",
        "set_failure" => "failure of the infusion set",
        "insulin_absorption" => "insulin absorption that varies by day",
        "counter_regulation" => "counter-regulation after low glucose",
        "alcohol" => "alcohol",
        "renal_threshold" => "another renal threshold",
        "sensor_lag" => "lag of the sensor",
        "sensor_drift" => "drift of the sensor",
        "compression_lows" => "compression lows of the sensor",
        "none" => "none: nothing is missing",
        "unknown" => "unknown: something that the library does not hold",
        "failed" => "no answer",
        _ => key,
    })
}

/// An effect, short enough for a column heading.
pub(super) fn short_effect(key: &str) -> String {
    match key.strip_prefix("outside:") {
        Some(name) => format!("({})", plain(name)),
        None => plain(key),
    }
}

/// A check of the data in words; what this version does not know keeps its key.
pub(super) fn check(key: &str) -> String {
    plain(match key {
        "missing_channel" => "a channel that is not recorded",
        "interpolated_cgm" => "interpolated sensor readings",
        "flat_cgm" => "a sensor that stands still",
        "discontinuous_cgm" => "jumps between sensor readings",
        "interleaved_cgm" => "two sensors in one record",
        "capillary_in_cgm" => "capillary readings among those of the sensor",
        "insulin_incomplete" => "incomplete insulin",
        "dose_is_flag" => "doses that are flags, not amounts",
        "basal_unit" => "the unit of basal insulin",
        "carb_unit" => "the unit of carbohydrate",
        "plausible_day" => "days with implausible amounts",
        "heart_rate_alignment" => "the alignment of heart rate",
        "insulin_clock_offset" => "the clock of insulin",
        "meal_clock_offset" => "the clock of meals",
        "identical_people" => "two people with one record",
        _ => key,
    })
}

/// Why somebody is left out: the key of a check before the colon becomes words.
pub(super) fn reason(text: &str) -> String {
    let is_key = |word: &str| word.bytes().all(|b| b == b'_' || b.is_ascii_lowercase());
    match text.split_once(": ") {
        Some((key, says)) if is_key(key) => format!("{}: {says}", check(key)),
        _ => text.to_owned(),
    }
}

/// A channel of a record in words; one that this version does not know keeps its key.
pub(super) fn channel(key: &str) -> String {
    plain(match key {
        "cgm_mg_dl" => "sensor glucose",
        "basal_u_h" => "basal insulin",
        "bolus_u" => "bolus insulin",
        "carbs_g" => "carbohydrate",
        "heart_rate_bpm" => "heart rate",
        _ => key,
    })
}

/// A therapy in words; one that this version does not know keeps its key.
pub(super) fn therapy(key: &str) -> String {
    plain(match key {
        "open_loop_pump" => "open-loop pump",
        "aid" => "automated insulin delivery",
        "mdi" => "multiple daily injections",
        _ => key,
    })
}

/// A glucose outcome with its unit, if it has one.
pub(super) fn metric(key: &str) -> String {
    let name = key.to_uppercase();
    let unit = match name.as_str() {
        "TIR" | "TAR" | "TBR" => " (%)",
        "MG" => " (mg/dL)",
        _ => "",
    };
    format!("{name}{unit}")
}

/// A port of the model in words; one that this version does not know keeps its key.
pub(super) fn port(key: &str) -> String {
    plain(match key {
        "insulin_input" => "the share of the delivered insulin that becomes available",
        "insulin_absorption" => "the speed of insulin absorption",
        "insulin_action" => "insulin action on glucose uptake",
        "insulin_action_liver" => "insulin action on the liver",
        "egp" => "the liver's glucose production",
        "gut_absorption" => "the speed of meal absorption",
        "carb_amount" => "the amount of carbohydrate eaten",
        "glucose_flux" => "a glucose flux that the model does not have",
        "sensor" => "the sensor",
        _ => key,
    })
}

/// A target of the blind check in words; one that this version does not know keeps its key.
pub(super) fn target(key: &str) -> String {
    plain(match key {
        "named_at_5" => "named from 5 mg/dL",
        "named_at_10" => "named from 10 mg/dL",
        "false_alarms_limit" => "false alarms, limit",
        "right_port" => "right place",
        "pairs_f1" => "names in pairs (F1)",
        "failed" => "without an answer",
        _ => key,
    })
}

/// How an answer of the blind check compares with the truth, in words.
pub(super) const fn outcome(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Correct => "correct",
        Outcome::Missed => "missed",
        Outcome::WithExtra => "right, and another besides",
        Outcome::Partial => "one of two",
        Outcome::InSet => "in the set",
        Outcome::Wrong => "wrong name",
        Outcome::Unknown => "called unknown",
        Outcome::Failed => "no answer",
    }
}

/// A time ahead: minutes below two hours, hours above.
pub(super) fn ahead(minutes: u32) -> String {
    match minutes {
        120.. if minutes.is_multiple_of(60) => format!("{} h", minutes / 60),
        _ => format!("{minutes} min"),
    }
}

/// A small number at the start of a sentence: `One` to `Nine`, then digits.
pub(super) fn number(n: usize) -> String {
    let words = ["One", "Two", "Three", "Four", "Five", "Six", "Seven", "Eight", "Nine"];
    let word = n.checked_sub(1).and_then(|place| words.get(place));
    word.map_or_else(|| n.to_string(), |word| (*word).to_owned())
}

/// Joins with commas and a final "and".
pub(super) fn list<S: Into<String>>(items: impl IntoIterator<Item = S>) -> String {
    let items: Vec<String> = items.into_iter().map(Into::into).collect();
    match items.as_slice() {
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
            ("glucose_band", "70-180", "while glucose is 70 to 180 mg/dL"),
            ("glucose_band", "<70", "while glucose is below 70 mg/dL"),
            ("person", "p7", "in person p7"),
            ("set", "x_y", "where set is x y"),
        ] {
            assert_eq!(situation(factor, level), words);
        }
        let items = ["a", "b", "c"].map(str::to_owned);
        assert_eq!(list(&items), "a, b and c");
        for (words, expected) in [
            (effect("dawn"), "dawn phenomenon"),
            (effect("new_effect"), "new effect"),
            (effect("outside:injection_site"), "outside the library: injection site"),
            (short_effect("outside:injection_site"), "(injection site)"),
            (port("egp"), "the liver's glucose production"),
            (port("new_port"), "new port"),
            (target("pairs_f1"), "names in pairs (F1)"),
            (target("new_target"), "new target"),
            (ahead(60), "60 min"),
            (ahead(300), "5 h"),
            (ahead(1440), "24 h"),
            (ahead(130), "130 min"),
            (number(2), "Two"),
            (number(9), "Nine"),
            (channel("basal_u_h"), "basal insulin"),
            (channel("sleep_efficiency"), "sleep efficiency"),
            (therapy("mdi"), "multiple daily injections"),
            (therapy("unknown"), "unknown"),
            (metric("tbr"), "TBR (%)"),
            (metric("lbgi"), "LBGI"),
            (number(12), "12"),
        ] {
            assert_eq!(words, expected);
        }
        assert_eq!(sentence("dawn"), "Dawn");
        assert_eq!(sentence(""), "");
    }
}
