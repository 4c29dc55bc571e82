//! T1DEXI.

use std::fs;

use cohort::{Channel, ImportFormat, Therapy, import};

use super::{check, fixture, notes, refusal};

const FORMAT: ImportFormat = ImportFormat::T1dexi;

#[test]
fn the_morning_is_read() {
    let channels = [
        Channel::Cgm,
        Channel::Basal,
        Channel::Bolus,
        Channel::Carbs,
        Channel::HeartRate,
        Channel::Steps,
        Channel::SleepEfficiency,
    ];
    let import = check(FORMAT, &channels);
    let person = &import.cohort.people[0];
    assert_eq!(person.therapy, Therapy::OpenLoopPump);
    assert!(person.weight.is_some_and(|weight| (weight.0 - 70.0).abs() < 1e-6)); // LB and back
    let notes = notes(&import);
    for says in [
        "FACM.xpt, row 1, column FAORRES: basal amounts, which the rates repeat: left out (7x)",
        "FACM.xpt, row 8, column FAORRES: missing rates: a suspension, 0 U/h (1x)",
        "PR.xpt, row 1, column PRTRT: exercise: a record has no column for it, left out (1x)",
    ] {
        assert!(notes.contains(says), "{says} is not in\n{notes}");
    }
}

/// The bytes of a domain.
fn domain(name: &str) -> Vec<u8> {
    fs::read(fixture("t1dexi").join(name)).expect("readable")
}

/// The domain with every occurrence of some bytes replaced by as many others.
fn changed(name: &str, from: &[u8], to: &[u8]) -> Vec<u8> {
    let mut bytes = domain(name);
    let mut found = 0;
    for at in 0..bytes.len() - from.len() {
        if bytes[at..].starts_with(from) {
            bytes[at..at + from.len()].copy_from_slice(to);
            found += 1;
        }
    }
    assert!(found > 0, "nothing to change in {name}");
    bytes
}

#[test]
fn stages_of_sleep_are_shares_of_the_night() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("LB.xpt"), domain("LB.xpt")).expect("writable");
    let first = |night: Vec<u8>| {
        fs::write(folder.path().join("NV.xpt"), night).expect("writable");
        let import = import(FORMAT, folder.path()).expect("a good folder");
        (import.cohort.people[0].record.sleep_efficiency()[0], notes(&import))
    };
    // 300 s deep and 75 s light of 750 s.
    let (half, _) = first(changed("NV.xpt", b"450", b"075"));
    assert!(half.is_some_and(|share| (share - 0.5).abs() < 1e-9), "{half:?}");
    // Without an end the stages are the night: 75 s of them light, 300 s deep, none awake.
    let (whole, _) = first(changed("NV.xpt", b"NVENDTC ", b"NVTPTREF"));
    assert_eq!(whole, Some(1.0));
    let (all, said) = first(changed("NV.xpt", b"450", b"990"));
    assert_eq!(all, Some(1.0));
    assert!(said.contains("stages of sleep longer than the night"), "{said}");
    let (none, said) = first(changed("NV.xpt", b"sec", b"lap"));
    assert_eq!(none, None);
    assert!(said.contains("column NVTESTCD: sleep without a duration in seconds"), "{said}");
}

#[test]
fn injections_have_no_rate_and_are_left_out() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in ["LB.xpt", "FACM.xpt"] {
        fs::write(folder.path().join(name), domain(name)).expect("writable");
    }
    let pump =
        changed("DX.xpt", b"MEDTRONIC 670G IN MANUAL MODE", b"MULTIPLE DAILY INJECTIONS    ");
    fs::write(folder.path().join("DX.xpt"), pump).expect("writable");
    let import = import(FORMAT, folder.path()).expect("a good folder");
    let person = &import.cohort.people[0];
    assert_eq!(person.therapy, Therapy::Mdi);
    assert!(person.record.basal().iter().all(Option::is_none));
    let totals = &import.report.people[0].totals.as_ref().expect("totals")[0];
    // 0.8 + 0.8 + 0.4 + 0 + 1/3 + 2/15 + 0.9 U.
    assert!((totals.left_out - 3.366_666_666_666).abs() < 1e-9, "{totals:?}");
    assert!(totals.closes() && totals.record == 0.0, "{totals:?}");
}

#[test]
fn broken_files_are_refused_with_their_place() {
    let lb = domain("LB.xpt");
    let cut = &lb[..lb.len() - 33];
    let early = &lb[..700];
    let utf16: Vec<u8> = lb.iter().flat_map(|byte| [*byte, 0]).collect();
    let version_8 = changed("LB.xpt", b"LIBRARY HEADER", b"LIBV8   HEADER");
    let unit = changed("LB.xpt", b"mg/dL", b"stone");
    let person = changed("LB.xpt", b"T1DEXIp1GLUC", b"T1DEXI=1GLUC");
    let other = changed("LB.xpt", b"USUBJID ", b"SUBJECT ");
    let cases: [(&[u8], &str); 9] = [
        (b"", "LB.xpt: no data row"),
        (cut, "LB.xpt: not a readable table: the file is cut off"),
        (early, "the file is cut off in its headers"),
        (b"person,glucose\n1,2\n", "the file is cut off in its headers"),
        (&utf16, "not a SAS transport file of version 5"),
        (&version_8, "version 8; write version 5"),
        (&unit, "LB.xpt, row 1, column LBSTRESU: 'stone' is not mg/dL or mmol/L"),
        (&other, "LB.xpt: no column 'USUBJID'; found STUDYID, SUBJECT"),
        (&person, "LB.xpt, row 1, column USUBJID: '=1' is not a person's identifier"),
    ];
    for (bytes, says) in cases {
        let message = refusal(FORMAT, &[("LB.xpt", bytes)]);
        assert!(message.contains(says), "{says}: {message}");
    }
    let message = refusal(FORMAT, &[("LB.xpt", &lb), ("lb.XPT", &lb)]);
    assert!(message.contains("lb.XPT: not in the layout of t1dexi: 'LB.xpt' is of"), "{message}");
    let facm = changed("FACM.xpt", b"PT60M", b"sixty");
    let message = refusal(FORMAT, &[("LB.xpt", &lb), ("FACM.xpt", &facm)]);
    assert!(message.contains("FACM.xpt, row 2, column FADUR: 'sixty' is not"), "{message}");
    // Words longer than any number.
    let nv = changed("NV.xpt", b"NVTEST  ", b"NVSTRESN");
    let message = refusal(FORMAT, &[("LB.xpt", &lb), ("NV.xpt", &nv)]);
    let says = "NV.xpt, row 1, column NVSTRESN: 'Deep Sleep Duration' is not a number";
    assert!(message.contains(says), "{message}");
    // The exponent of 154.3 lb, one higher in base 16.
    let vs = changed("VS.xpt", &[0x42, 0x9a, 0x52], &[0x43, 0x9a, 0x52]);
    let message = refusal(FORMAT, &[("LB.xpt", &lb), ("VS.xpt", &vs)]);
    assert!(message.contains("is not a weight of 1 to 500 kg"), "{message}");
    let message = refusal(FORMAT, &[("VS.xpt", &domain("VS.xpt"))]);
    assert!(message.contains("no file LB.xpt"), "{message}");
}
