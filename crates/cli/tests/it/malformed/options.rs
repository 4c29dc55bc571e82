//! Numbers that an option cannot have, refused before any work.

use super::case::{Cases, repository};

pub(super) fn add(cases: &mut Cases) {
    let cohort = repository("fixtures/embedded/cohort");
    let model = repository("crates/nn-statespace/model/population.safetensors");
    let patients = repository("fixtures/golden/patients.csv");
    let meals = repository("fixtures/golden/meals.csv");
    let simulate = ["simulate", "--patients", &patients, "--meals", &meals];
    let twin = ["twin", "--cohort", &cohort, "--model", &model];
    let verify = ["verify", "--model", &model];
    let baselines = ["baselines", "--cohort", &cohort, "--model", &model];
    let realism = ["realism", "--cohort", &cohort];
    let commands: [(&[&str], &str, &[&str]); 19] = [
        (&simulate, "--days", &["0", "1000000", "18446744073709551615"]),
        (&twin, "--epochs", &["0", "99999999999"]),
        (&twin, "--training-days", &["0", "99999999999"]),
        (&verify, "--widen", &["1e300", "inf", "nan", "1e9"]),
        (&verify, "--limit", &["0", "1e300", "nan", "inf"]),
        (&verify, "--delta", &["0", "nan", "inf", "1e300"]),
        (&baselines, "--training-days", &["0", "99999999999"]),
        (&["train"], "--patience", &["0"]),
        (&["worlds"], "--people", &["0", "99999999999"]),
        (&["worlds"], "--days", &["0", "99999999999"]),
        (&["worlds"], "--count", &["0", "99999999999"]),
        (&["worlds"], "--shift", &["0", "nan", "1e300"]),
        (&["worlds"], "--mixture", &["0", "99999999999"]),
        (&["blind-check", "--seed", "1", "--nulls", "0"], "--worlds", &["0", "99999999999"]),
        (&["evidence"], "--worlds", &["99999999999", "18446744073709551615"]),
        (&realism, "--people", &["0", "99999999999"]),
        (&realism, "--days", &["0", "99999999999"]),
        (&["widths"], "--explore", &["0", "99999999999"]),
        (&["widths"], "--at-once", &["0", "99999999999"]),
    ];
    for (command, option, values) in commands {
        for value in values {
            let typed = [command, &[option, value]].concat();
            cases.refused(&format!("{option} {value}"), &typed, &[option]);
        }
        let typed = [command, &[option, "-5"]].concat();
        negative(cases, option, &typed);
    }
    let bench = ["bench", "--what", "diagnosis"];
    for (option, value) in [
        ("--people", "0"),
        ("--people", "99999999999"),
        ("--days", "0"),
        ("--days", "99999999999"),
        ("--amplitude", "nan"),
        ("--amplitude", "1e300"),
        ("--effect", "magic"),
    ] {
        cases.refused(
            &format!("bench {option} {value}"),
            &[&bench[..], &[option, value]].concat(),
            &[option],
        );
    }
    cases.refused(
        "--sizes nan",
        &["blind-check", "--planted", &cohort, "--sizes", "nan"],
        &["--sizes"],
    );
    cases.refused(
        "--sizes 1e300",
        &["blind-check", "--planted", &cohort, "--sizes", "1e300"],
        &["--sizes"],
    );
    cases.refused("--effect magic", &["worlds", "--effect", "magic"], &["--effect", "magic"]);
    cases.refused("--effect of three", &["worlds", "--effect", "dawn+dawn+dawn"], &["--effect"]);
    cases.refused(
        "--scenario magic",
        &[&simulate[..], &["--scenario", "magic"]].concat(),
        &["magic"],
    );
    for value in ["0", "100000"] {
        cases.refused(
            &format!("--threads {value}"),
            &["train", "--threads", value],
            &["--threads"],
        );
    }
    negative(cases, "--threads", &["train", "--threads", "-2"]);
    negative(cases, "--seed", &["train", "--seed", "-1"]);
    for (name, typed) in [
        ("--seed of 20 digits", &["train", "--seed", "99999999999999999999"][..]),
        ("--seed in text", &["train", "--seed", "lucky"]),
        ("--seed of a half", &["train", "--seed", "0.5"]),
    ] {
        cases.usage(name, typed, &["--seed", "whole number"]);
    }
    cases.usage("an unknown option", &["train", "--speed", "1"], &["--speed"]);
    cases.usage("no value", &["train", "--seed"], &["--seed"]);
    cases.usage("an option twice", &["train", "--seed", "1", "--seed", "2"], &["--seed"]);
    cases.usage("an unknown command", &["trian"], &["trian", "train"]);
    cases.usage("an unknown format", &["import", "--from", "dexom", "x"], &["dexom", "dexcom"]);
    cases.usage("an unknown profile", &["train", "--profile", "fast"], &["fast", "quick"]);
}

/// A negative value is read as a value and refused in words.
fn negative(cases: &mut Cases, option: &str, typed: &[&str]) {
    let status_1 = matches!(option, "--widen" | "--limit" | "--delta" | "--shift");
    let name = format!("{option} below zero");
    if status_1 {
        cases.refused(&name, typed, &[option, "-5"]);
    } else {
        cases.usage(&name, typed, &[option, "'-", "whole number"]);
    }
}
