//! The embedded cohort looks like free-living people.

use cohort::Therapy;
use world::{EMBEDDED_DAYS, EMBEDDED_SEED, embedded_cohort, plausibility};

#[test]
fn every_person_of_the_embedded_cohort_is_plausible() {
    let (cohort, _) = embedded_cohort(EMBEDDED_SEED).expect("the embedded cohort");
    for person in &cohort.people {
        assert_eq!(person.record.len(), EMBEDDED_DAYS * physiology::STEPS_PER_DAY);
        for check in plausibility::checks(&person.record) {
            assert!(check.holds(), "{}: {check:?}", person.id);
        }
    }
    let on_aid = cohort.people.iter().filter(|p| p.therapy == Therapy::Aid).count();
    assert!((2..=4).contains(&on_aid));
}

#[test]
fn the_folder_reads_back_as_it_was_written_and_is_small() {
    let (cohort, _) = embedded_cohort(EMBEDDED_SEED).expect("the embedded cohort");
    let folder = tempfile::tempdir().expect("a folder");
    cohort::write_folder(&cohort, folder.path(), cohort::RecordsFormat::Parquet).expect("written");
    let again = cohort::read_folder(folder.path()).expect("read");
    assert!(again == cohort);
    let bytes = std::fs::metadata(folder.path().join("records.parquet")).expect("written").len();
    assert!(bytes < 1_000_000, "{bytes} bytes are too many to commit");
}
