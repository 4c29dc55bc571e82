//! What the driven effects found do in each step of one person's record.

use effects::{Course, Effect, Field, Form, Modulation};

/// Half the distance of amplitudes over which a modulation's slope is taken. Modulations are linear or
/// exponential in the amplitude.
const SPACING: f64 = 0.05;

/// A driven effect in its variant.
#[derive(Debug, Clone, Copy)]
pub(super) struct Driver<'a> {
    pub(super) effect: &'a dyn Effect,
    pub(super) variant: usize,
    /// Whether the person's record signals it; where not, it never acts.
    pub(super) signalled: bool,
    /// Whether it changes with glucose, so that a free run must feed it its own.
    pub(super) reads_glucose: bool,
}

impl<'a> Driver<'a> {
    pub(super) fn new(effect: &'a dyn Effect, variant: usize, course: &Course) -> Self {
        let signalled = effect.form(course) == Some(Form::Driven);
        let driver = Self { effect, variant, signalled, reads_glucose: false };
        let under = |course: &Course| modulations(&[driver], &[1.0], course, |_| true);
        let at = |glucose: f64| {
            under(&Course { glucose: vec![glucose; course.len()], ..course.clone() })
        };
        let as_is = under(course);
        Self { reads_glucose: [60.0, 240.0].into_iter().any(|g| at(g) != as_is), ..driver }
    }
}

/// Modulations of some drivers at their amplitudes, one entry a step.
pub(super) fn modulations(
    drivers: &[Driver<'_>],
    amplitudes: &[f64],
    course: &Course,
    only: impl Fn(&Driver<'_>) -> bool,
) -> Vec<Modulation> {
    let mut steps = vec![Modulation::NEUTRAL; course.len()];
    add(drivers, amplitudes, course, only, &mut steps);
    steps
}

/// Adds some drivers to modulations that are there: factors multiply and additions add, so that the order
/// does not matter.
pub(super) fn add(
    drivers: &[Driver<'_>],
    amplitudes: &[f64],
    course: &Course,
    only: impl Fn(&Driver<'_>) -> bool,
    steps: &mut [Modulation],
) {
    for (driver, amplitude) in drivers.iter().zip(amplitudes) {
        if driver.signalled && *amplitude != 0.0 && only(driver) {
            driver.effect.modulate(driver.variant, *amplitude, course, steps);
        }
    }
}

/// The slopes of the modulations along each amplitude: time courses of the fields that it changes.
pub(super) fn slopes(
    drivers: &[Driver<'_>],
    amplitudes: &[f64],
    course: &Course,
) -> Vec<Vec<(Field, Vec<f64>)>> {
    let moved = |index: usize, by: f64| {
        let mut amplitudes = amplitudes.to_vec();
        amplitudes[index] += by;
        modulations(drivers, &amplitudes, course, |_| true)
    };
    let slope = |(index, amplitude): (usize, &f64)| {
        // Amplitudes are never negative.
        let below = SPACING.min(*amplitude);
        let (low, high) = (moved(index, -below), moved(index, SPACING));
        let width = SPACING + below;
        let of = |field: Field| -> (Field, Vec<f64>) {
            let differences = high.iter().zip(&low).map(|(h, l)| h[field] - l[field]);
            (field, differences.map(|d| d / width).collect())
        };
        Modulation::differing(high.iter().zip(&low)).into_iter().map(of).collect()
    };
    amplitudes.iter().enumerate().map(slope).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn course() -> Course {
        let steps = 576;
        Course {
            hour: (0..steps).map(|k| (k % 288) as f64 / 12.0).collect(),
            day: (0..steps).map(|k| k / 288).collect(),
            carbs: (0..steps).map(|k| if k % 288 == 220 { 50.0 } else { 0.0 }).collect(),
            glucose: (0..steps).map(|k| 120.0 + 60.0 * (k as f64 / 30.0).sin()).collect(),
            heart_rate_over_rest: Some(
                (0..steps).map(|k| Some(if k % 100 < 9 { 60.0 } else { 0.0 })).collect(),
            ),
            ..Course::default()
        }
    }

    #[test]
    fn what_reads_glucose_is_found_out() {
        for (name, expected) in [("dawn", false), ("carb_miscount", false), ("exercise", true)] {
            let effect = effects::find(name).expect("in the library");
            let driver = Driver::new(effect.as_ref(), 0, &course());
            assert_eq!((driver.signalled, driver.reads_glucose), (true, expected), "{name}");
        }
        // A rescue is a hidden event: nothing signals it but the lows that it may follow.
        let lows = effects::find("unlogged_rescue_carbs").expect("in the library");
        assert!(!Driver::new(lows.as_ref(), 0, &course()).signalled);
    }

    #[test]
    fn slopes_belong_to_the_point_at_which_they_are_taken() {
        let course = course();
        let names = ["dawn", "carb_miscount"];
        let found: Vec<_> =
            names.iter().map(|name| effects::find(name).expect("in the library")).collect();
        let drivers: Vec<Driver<'_>> =
            found.iter().map(|effect| Driver::new(effect.as_ref(), 0, &course)).collect();
        let at = [0.0, 0.8];
        let here = modulations(&drivers, &at, &course, |_| true);
        let slopes = slopes(&drivers, &at, &course);
        let (_, carbs) = slopes[1].iter().find(|(f, _)| *f == Field::CarbAmount).expect("carbs");
        assert!(carbs.iter().any(|slope| slope.abs() > 0.01));
        for (step, slope) in carbs.iter().enumerate().filter(|(_, s)| **s != 0.0) {
            // d/da e^(ca) is c times the value, which tells c; central differences err by (0.05 c)^2 / 6.
            let value = here[step][Field::CarbAmount];
            let expected = value.ln() / at[1] * value;
            assert!((slope / expected - 1.0).abs() < 1e-4, "{slope} against {expected}");
        }
    }
}
