//! `carb_unit`.

use cohort::Person;

use super::Finding;

pub(super) fn finding(_person: &Person) -> Option<Finding> {
    None
}
