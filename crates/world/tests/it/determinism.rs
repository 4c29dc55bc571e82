//! The same seed makes the same world, for any number of threads.

use world::{EMBEDDED_PEOPLE, EMBEDDED_SEED, embedded_cohort};

fn with_threads(threads: usize) -> (cohort::Cohort, world::WorldInfo) {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .expect("a thread pool")
        .install(|| embedded_cohort(EMBEDDED_SEED).expect("the embedded cohort"))
}

#[test]
fn one_seed_makes_one_cohort_whatever_the_threads() {
    let (alone, info) = with_threads(1);
    let (shared, info_again) = with_threads(3);
    assert!(alone == shared);
    assert!(info == info_again);
    assert_eq!(alone.people.len(), EMBEDDED_PEOPLE);
}

#[test]
fn another_seed_makes_another_cohort() {
    let (one, _) = embedded_cohort(1).expect("a cohort");
    let (two, _) = embedded_cohort(2).expect("a cohort");
    for (a, b) in one.people.iter().zip(&two.people) {
        assert!(a.record.cgm() != b.record.cgm() && a.record.carbs() != b.record.carbs());
    }
}
