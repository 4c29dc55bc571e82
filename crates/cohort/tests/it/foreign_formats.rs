//! Each importer on the same made-up morning (`fixtures/import`), and on broken files.

use std::fs;
use std::path::{Path, PathBuf};

use cohort::{
    Channel, Import, ImportFormat, RecordsFormat, TableOptions, Totals, import, import_with,
    read_folder,
};

mod babelbetes;
mod metabonet;
mod nightscout;
mod ohio;
mod replaybg;
mod simglucose;
mod t1dexi;
mod tidepool;

/// The fixture of a format, or the morning itself as `expected`.
fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/import").join(name)
}

/// Imports a fixture, compares `channels` with the morning, and writes and reads the result.
fn check(format: ImportFormat, channels: &[Channel]) -> Import {
    check_at(format, &fixture(format.name()), &TableOptions::default(), channels)
}

/// The same of another fixture, with options.
fn check_at(
    format: ImportFormat,
    source: &Path,
    options: &TableOptions,
    channels: &[Channel],
) -> Import {
    let import = import_with(format, &[source.to_owned()], options).expect("a good fixture");
    let expected = read_folder(&fixture("expected")).expect("a good cohort");
    let (person, truth) = (&import.cohort.people[0], &expected.people[0]);
    assert_eq!(import.cohort.people.len(), 1);
    assert_eq!(
        (person.record.start(), person.record.len()),
        (truth.record.start(), truth.record.len())
    );
    for channel in Channel::ALL {
        let (found, truth) = (person.record.channel(channel), truth.record.channel(channel));
        for (k, (found, truth)) in found.iter().zip(truth).enumerate() {
            let truth = if channels.contains(&channel) { *truth } else { None };
            let near = match (found, truth) {
                // Digits of the files and rounding of a few sums.
                (Some(found), Some(truth)) => (found - truth).abs() <= 1e-6 * truth.abs().max(1.0),
                (found, truth) => *found == truth,
            };
            assert!(near, "{} of step {k}: {found:?}, not {truth:?}", channel.name());
        }
    }
    let totals = &import.report.people[0].totals;
    assert!(totals.iter().flatten().all(Totals::closes), "{totals:?}");

    let folder = tempfile::tempdir().expect("a temporary folder");
    cohort::write_folder(&import.cohort, folder.path(), RecordsFormat::Csv).expect("writable");
    assert_eq!(read_folder(folder.path()).expect("readable"), import.cohort);
    import
}

/// What the report notes, one line each.
fn notes(import: &Import) -> String {
    import.report.notes.iter().map(|note| format!("{note}\n")).collect()
}

/// The message that refuses a folder of files.
fn refusal(format: ImportFormat, files: &[(&str, &[u8])]) -> String {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let source = folder.path().join("p1");
    fs::create_dir(&source).expect("writable");
    for (name, bytes) in files {
        let path = source.join(name);
        fs::create_dir_all(path.parent().expect("inside a folder")).expect("writable");
        fs::write(path, bytes).expect("writable");
    }
    import(format, &source).map(|_| ()).expect_err("refused").to_string()
}
