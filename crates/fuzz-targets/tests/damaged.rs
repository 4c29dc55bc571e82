//! Damaged inputs of every target: read or refused with a message, never a panic. Each input that a
//! fuzzer found lies in `regressions/`.

use std::fs;
use std::path::Path;

use fuzz_targets::{TARGETS, Target, target};
use proptest::prelude::*;
use proptest::sample::Index;
use proptest::test_runner::{Config, RngSeed, TestRunner};

/// A change to bytes: cut, overwritten, with something between, or with a piece once more.
#[derive(Debug, Clone)]
enum Damage {
    Cut(Index),
    Set(Index, u8),
    Insert(Index, Vec<u8>),
    Repeat(Index, Index),
}

fn damage() -> impl Strategy<Value = Damage> {
    let spiteful: Vec<Vec<u8>> = [
        b"\"".as_slice(),
        b",",
        b";",
        b"\n",
        b"\r",
        b"\0",
        b"\xEF\xBB\xBF",
        b"\xFF\xFE",
        b"\xFF",
        b"-",
        b"1e999",
        b"1e15",
        b"NaN",
        b"=1+1",
        b"9999-12-31T23:55:00",
        b"0000-01-01",
        b"\"\n\"",
        b"#",
        b"null",
        b"[[[[[[[[",
        b"<!-- ",
        b"&lt;",
        b"../",
    ]
    .map(<[u8]>::to_vec)
    .to_vec();
    let spiteful = prop::sample::select(spiteful);
    prop_oneof![
        any::<Index>().prop_map(Damage::Cut),
        (any::<Index>(), any::<u8>()).prop_map(|(at, byte)| Damage::Set(at, byte)),
        (any::<Index>(), spiteful).prop_map(|(at, bytes)| Damage::Insert(at, bytes)),
        (any::<Index>(), any::<Index>()).prop_map(|(from, to)| Damage::Repeat(from, to)),
    ]
}

fn damaged(mut bytes: Vec<u8>, changes: &[Damage]) -> Vec<u8> {
    for change in changes {
        if bytes.is_empty() {
            break;
        }
        let at = |index: &Index| index.index(bytes.len());
        match change {
            Damage::Cut(place) => bytes.truncate(at(place)),
            Damage::Set(place, byte) => {
                let place = at(place);
                bytes[place] = *byte;
            }
            Damage::Insert(place, extra) => {
                let place = at(place);
                bytes.splice(place..place, extra.iter().copied());
            }
            Damage::Repeat(from, to) => {
                let (from, to) = (at(from), at(to));
                let piece = bytes[from.min(to)..from.max(to)].to_vec();
                bytes.extend(piece);
            }
        }
    }
    bytes
}

/// Runs a target on its seeds, and on them with some damage.
fn damaged_seeds(target: &Target, cases: u32) {
    let seeds = (target.seeds)();
    assert!(!seeds.is_empty(), "{} has no seeds", target.name);
    seeds.iter().for_each(|seed| (target.run)(seed));
    let config = Config {
        failure_persistence: None,
        // The reader of Parquet belongs to the table library: a damaged page length can make it
        // request more memory than there is, which no caller can catch.
        rng_seed: RngSeed::Fixed(2026),
        ..Config::with_cases(cases)
    };
    let inputs = (any::<Index>(), prop::collection::vec(damage(), 1..5));
    let outcome = TestRunner::new(config).run(&inputs, |(seed, changes)| {
        (target.run)(&damaged(seeds[seed.index(seeds.len())].clone(), &changes));
        Ok(())
    });
    if let Err(failure) = outcome {
        panic!("{}: {failure}", target.name);
    }
}

macro_rules! each {
    ($($name:ident: $cases:literal;)*) => {
        $(#[test]
        fn $name() {
            damaged_seeds(target(stringify!($name)).expect("a target"), $cases);
        })*

        #[test]
        fn every_target_is_tested() {
            let tested = [$(stringify!($name)),*];
            assert_eq!(TARGETS.iter().map(|target| target.name).collect::<Vec<_>>(), tested);
        }
    };
}

each! {
    cohort_csv: 400;
    cohort_parquet: 200;
    table: 300;
    workbook: 400;
    dexcom: 200;
    libre: 200;
    hupa_ucm: 300;
    t1d_uom: 200;
    t1dsim: 300;
    nightscout: 200;
    tidepool: 200;
    t1dexi: 200;
    metabonet: 200;
    babelbetes: 200;
    ohio: 200;
    simglucose: 200;
    replaybg: 200;
    weights: 200;
    twin: 100;
    region: 300;
    certificate: 100;
    documents: 400;
}

#[test]
fn what_a_fuzzer_found_stays_mended() {
    let place = Path::new(env!("CARGO_MANIFEST_DIR")).join("regressions");
    for entry in fs::read_dir(place).expect("the folder of regressions") {
        let path = entry.expect("readable").path();
        let name = path.file_name().expect("a file").to_string_lossy().into_owned();
        let Some((of, _)) = name.split_once('-') else { continue };
        let target = target(of).unwrap_or_else(|| panic!("'{name}' names no target"));
        (target.run)(&fs::read(&path).expect("readable"));
    }
}
