//! Automated insulin delivery: a predictive controller of the basal rate with suspension, a limit
//! on insulin on board and automatic corrections.

use physiology::{MgPerDl, STEPS_PER_HOUR, Units, UnitsPerHour};

use super::settings::TherapySettings;
use super::{Observation, Order};

/// Minutes ahead for which glucose is extrapolated.
const HORIZON: f64 = 30.0;
/// Target glucose of the controller, and in exercise.
const TARGET: MgPerDl = MgPerDl(110.0);
const EXERCISE_TARGET: MgPerDl = MgPerDl(140.0);
/// Predicted glucose below which basal insulin stops.
const SUSPEND_BELOW: MgPerDl = MgPerDl(75.0);
/// Hours over which a need is met through the basal rate.
const MEET_WITHIN: f64 = 2.0;
/// Highest basal rate, in multiples of the programmed one.
const HIGHEST: f64 = 3.0;
/// Insulin on board beyond which nothing is added, in hours of the programmed rate.
const MOST_ON_BOARD: f64 = 3.0;
/// Predicted glucose above which a part of the need is given as a bolus, at most once an hour.
const CORRECT_ABOVE: MgPerDl = MgPerDl(180.0);
const CORRECTED_SHARE: f64 = 0.4;

/// A controller like those of commercial systems. The need is the distance of predicted glucose
/// from the target divided by ISF, plus the remaining need of announced meals, minus the insulin on
/// board.
#[derive(Debug, Clone)]
pub struct Aid {
    settings: TherapySettings,
    steps_since_bolus: usize,
}

impl Aid {
    /// A controller with these settings.
    #[must_use]
    pub fn new(settings: TherapySettings) -> Self {
        Self { settings, steps_since_bolus: usize::MAX / 2 }
    }

    /// The order for one step.
    pub fn order(&mut self, observation: &Observation) -> Order {
        self.steps_since_bolus += 1;
        let programmed = self.settings.basal_at(observation.hour);
        let Some(glucose) = observation.glucose else {
            return Order { basal: programmed, bolus: Units(0.0) }; // falls back to the profile
        };
        let predicted = glucose.0 + HORIZON * observation.trend.clamp(-3.0, 3.0);
        if predicted < SUSPEND_BELOW.0 {
            return Order { basal: UnitsPerHour(0.0), bolus: Units(0.0) };
        }
        let target = if observation.exercising { EXERCISE_TARGET } else { TARGET };
        let on_board = observation.insulin_on_board.0;
        let meals = observation.carbs_on_board.0 / self.settings.icr.0;
        let room = MOST_ON_BOARD * programmed.0 + meals - on_board;
        let need =
            ((predicted - target.0) / self.settings.isf + meals - on_board).min(room.max(0.0));

        let rate = programmed.0 + need / MEET_WITHIN;
        let basal = UnitsPerHour(rate.clamp(0.0, HIGHEST * programmed.0));
        let correct = predicted > CORRECT_ABOVE.0
            && need > 0.2
            && self.steps_since_bolus >= STEPS_PER_HOUR
            && !observation.exercising;
        let bolus = if correct {
            self.steps_since_bolus = 0;
            Units(CORRECTED_SHARE * need)
        } else {
            Units(0.0)
        };
        Order { basal, bolus }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use physiology::{Grams, GramsPerUnit};

    fn order(glucose: Option<f64>, trend: f64, on_board: f64) -> Order {
        let settings = TherapySettings {
            basal: [1.0; 24],
            icr: GramsPerUnit(10.0),
            isf: 50.0,
            target: MgPerDl(120.0),
        };
        Aid::new(settings).order(&Observation {
            hour: 12.0,
            glucose: glucose.map(MgPerDl),
            trend,
            insulin_on_board: Units(on_board),
            carbs_on_board: Grams(0.0),
            exercising: false,
        })
    }

    #[test]
    fn basal_follows_predicted_glucose_within_its_limits() {
        assert_eq!(order(Some(90.0), -1.0, 0.0).basal.0, 0.0);
        assert!((order(Some(TARGET.0), 0.0, 0.0).basal.0 - 1.0).abs() < 1e-12); // rounding
        assert_eq!(order(Some(300.0), 1.0, 0.0).basal.0, 1.0 + 3.0 / MEET_WITHIN); // room for 3 U
        assert_eq!(order(Some(300.0), 1.0, -3.0).basal.0, HIGHEST);
        assert_eq!(order(None, 0.0, 0.0).basal.0, 1.0);
        assert!(order(Some(150.0), 0.0, 2.0).basal.0 < 1.0);
    }

    #[test]
    fn nothing_is_added_beyond_the_limit_on_board() {
        let limited = order(Some(350.0), 0.0, 3.5);
        assert!(limited.basal.0 <= 1.0 && limited.bolus.0 == 0.0);
        assert!(order(Some(350.0), 0.0, 0.0).bolus.0 > 0.0);
    }
}
