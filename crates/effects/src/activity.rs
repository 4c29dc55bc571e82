//! How hard a person is working, from heart rate or, where that is missing, from steps walked.

use crate::course::{Course, STEP_MINUTES, recorded, value_at};

/// Largest heart rate over rest that is believed, 1/min.
const LARGEST: f64 = 130.0;
/// Heart rate over rest up to which nothing is exercise, 1/min: standing, stress, a warm room.
const DAILY_LIFE: f64 = 15.0;
/// Heart rate over rest from which all of it counts, 1/min: about 3 MET at a reserve of 110.
const BRISK_WALK: f64 = 30.0;
/// Cadence at 3 MET, steps/min (Tudor-Locke et al., Br J Sports Med 2018;52:776).
const CADENCE_MODERATE: f64 = 100.0;
/// Cadence at 6 MET, steps/min (the same).
const CADENCE_VIGOROUS: f64 = 130.0;
/// Heart rate over rest at 3 MET, 1/min: the same share of its reserve (110) as of oxygen uptake (Swain &
/// Leutholtz, Med Sci Sports Exerc 1997;29:410), with a capacity of 10 MET.
const OVER_REST_MODERATE: f64 = 24.0;
/// Heart rate over rest at 6 MET, 1/min.
const OVER_REST_VIGOROUS: f64 = 61.0;

/// Whether either channel was recorded.
pub(crate) fn known(course: &Course) -> bool {
    recorded(course.heart_rate_over_rest.as_ref()) || recorded(course.walked.as_ref())
}

/// Exercise intensity per step as heart rate over rest, 1/min; 0 in daily life and in gaps.
///
/// Below 15 1/min nothing counts, above 30 everything, with a ramp between: a resting rate that is
/// a little wrong must not turn the whole day into exercise.
pub(crate) fn intensity(course: &Course) -> Vec<f64> {
    let heart_rate = course.heart_rate_over_rest.as_ref();
    let walked = course.walked.as_ref();
    (0..course.len())
        .map(|k| {
            let from_steps = || value_at(walked, k).map(over_rest_of_steps);
            let over_rest =
                value_at(heart_rate, k).or_else(from_steps).unwrap_or(0.0).clamp(0.0, LARGEST);
            let share = ((over_rest - DAILY_LIFE) / (BRISK_WALK - DAILY_LIFE)).clamp(0.0, 1.0);
            over_rest * share
        })
        .collect()
}

/// Heart rate over rest at which a person walks or runs that many steps in five minutes, 1/min.
fn over_rest_of_steps(steps: f64) -> f64 {
    let cadence = steps / STEP_MINUTES;
    if cadence <= CADENCE_MODERATE {
        OVER_REST_MODERATE * cadence / CADENCE_MODERATE
    } else {
        let share = (cadence - CADENCE_MODERATE) / (CADENCE_VIGOROUS - CADENCE_MODERATE);
        OVER_REST_MODERATE + share * (OVER_REST_VIGOROUS - OVER_REST_MODERATE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn course(heart_rate: Vec<Option<f64>>, walked: Vec<Option<f64>>) -> Course {
        let hour = vec![12.0; heart_rate.len()];
        Course {
            hour,
            heart_rate_over_rest: Some(heart_rate),
            walked: Some(walked),
            ..Course::default()
        }
    }

    #[test]
    fn heart_rate_is_believed_before_steps_and_daily_life_is_none() {
        let course = course(
            vec![Some(60.0), None, Some(10.0), None, Some(400.0)],
            vec![None, Some(650.0), Some(650.0), None, None],
        );
        // 650 steps in five minutes are 130 a minute.
        assert_eq!(intensity(&course), [60.0, OVER_REST_VIGOROUS, 0.0, 0.0, LARGEST]);
        assert!(known(&course));
    }

    #[test]
    fn without_either_channel_nothing_is_known() {
        assert!(!known(&Course { hour: vec![0.0; 3], ..Course::default() }));
    }
}
