//! `dose_is_flag`.

use cohort::Person;

use super::Finding;

pub(super) fn findings(_person: &Person) -> Vec<Finding> {
    Vec::new()
}
