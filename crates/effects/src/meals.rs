//! Logged meals, as they can be told at the time.

use crate::course::{Course, STEP_MINUTES};

/// Entries this far apart are one meal, min.
const ONE_MEAL: f64 = 30.0;

/// Carbohydrate logged in the half hour up to and with each step, g; 0 where none is logged in the step.
pub(crate) fn so_far(course: &Course) -> Vec<f64> {
    let back = steps(ONE_MEAL);
    (0..course.len())
        .map(|k| {
            if logged(course, k) <= 0.0 {
                return 0.0;
            }
            (k.saturating_sub(back)..=k).map(|j| logged(course, j)).sum()
        })
        .collect()
}

/// Whether carbohydrate was ever logged.
pub(crate) fn any(course: &Course) -> bool {
    course.carbs.iter().any(|grams| *grams > 0.0)
}

/// Whether each step lies at most `before` minutes before logged carbohydrate, or at most `after` minutes after it.
pub(crate) fn near(course: &Course, before: f64, after: f64) -> Vec<bool> {
    let (before, after) = (steps(before), steps(after));
    let mut near = vec![false; course.len()];
    for k in (0..course.len()).filter(|k| logged(course, *k) > 0.0) {
        let until = (k + after + 1).min(near.len());
        near[k.saturating_sub(before)..until].fill(true);
    }
    near
}

/// Carbohydrate logged in a step, g.
pub(crate) fn logged(course: &Course, step: usize) -> f64 {
    course.carbs.get(step).copied().unwrap_or(0.0)
}

/// Whole steps in so many minutes.
pub(crate) fn steps(minutes: f64) -> usize {
    (minutes / STEP_MINUTES).round() as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_within_half_an_hour_are_one_meal() {
        let mut carbs = vec![0.0; 20];
        (carbs[2], carbs[8], carbs[15]) = (10.0, 30.0, 5.0);
        let course = Course { hour: vec![0.0; 20], carbs, ..Course::default() };
        let sums = so_far(&course);
        assert_eq!((sums[2], sums[8], sums[9], sums[15]), (10.0, 40.0, 0.0, 5.0));
        let near = near(&course, 5.0, 10.0);
        assert_eq!(
            [0, 1, 4, 5, 6, 7, 17, 18].map(|k| near[k]),
            [false, true, true, false, false, true, true, false]
        );
    }
}
