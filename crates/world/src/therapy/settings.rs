//! Therapy settings: found on the body by trial, then given small errors, as in a clinic.

use ode_sim::dosing::Correction;
use ode_sim::{BolusCalculator, OdeError};
use physiology::{
    Grams, GramsPerUnit, MgPerDl, OpenLoop, Plant as _, SimulationError, StepInput, Units,
    UnitsPerHour, simulate,
};
use rand::{Rng, RngExt};
use serde::{Serialize, Serializer, ser::SerializeStruct};

use crate::body::{Body, BodyModel, BodyState};
use crate::stream::standard_normal;

/// Glucose that the basal profile aims at, and the target of the bolus calculator.
const TARGET: MgPerDl = MgPerDl(125.0);
/// Steps of a trial: six hours.
const TRIAL: usize = 72;
/// Least plausible ISF, mg/dL per U.
pub(crate) const LEAST_FALL: f64 = 12.0;
/// Meal of the trial that finds ICR.
const TRIAL_MEAL: Grams = Grams(50.0);

/// Settings of a pump and its bolus calculator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TherapySettings {
    /// Programmed basal rate, U/h, by hour of the day.
    pub basal: [f64; 24],
    /// Insulin-to-carbohydrate ratio.
    pub icr: GramsPerUnit,
    /// Insulin sensitivity factor, mg/dL per U.
    pub isf: f64,
    /// Target of the bolus calculator.
    pub target: MgPerDl,
}

impl TherapySettings {
    /// The settings that trials on a body give; pass an undisturbed body.
    ///
    /// Basal: the rate that holds 125 mg/dL where nothing warps the body. ISF: how much lower 1 U
    /// makes glucose within six hours from 180 mg/dL. ICR: the ratio with which glucose six hours
    /// after a meal of 50 g is what it would have been without meal and bolus.
    ///
    /// # Errors
    /// If the body has no steady state at these values or its simulation fails.
    pub fn by_trial<M: BodyModel>(body: &Body<'_, M>) -> Result<Self, OdeError> {
        let fall = fall_by_a_unit(body)?;

        let (start, basal) = body.at_rest(TARGET)?;
        let fasting = glucose_after_trial(body, &start, basal, StepInput::default())?;
        let ends_high = |bolus: f64| -> Result<bool, SimulationError> {
            let meal = StepInput { carbs: TRIAL_MEAL, bolus: Units(bolus), ..StepInput::default() };
            Ok(glucose_after_trial(body, &start, basal, meal)? > fasting)
        };
        let (mut low, mut high) = (0.0, 50.0);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if ends_high(middle)? { low = middle } else { high = middle }
        }
        Ok(Self {
            basal: [basal.0; 24],
            icr: GramsPerUnit(TRIAL_MEAL.0 / high),
            isf: fall,
            target: TARGET,
        })
    }

    /// Whether a clinic would believe them: 4 to 30 g/U and 12 to 120 mg/dL per U.
    #[must_use]
    pub(crate) fn are_usual(&self) -> bool {
        (4.0..=30.0).contains(&self.icr.0) && (LEAST_FALL..=120.0).contains(&self.isf)
    }

    /// The settings that a person really uses: those found by trial, each with an error.
    ///
    /// Log errors: basal 0.08, ICR 0.15, ISF 0.15 (assumed). The profile is raised by 5 to 20 %
    /// from 3 to 8 h against the dawn, and lowered by 0 to 10 % from 22 to 2 h, whatever the
    /// person's own need is.
    #[must_use]
    pub fn in_use(self, rng: &mut (impl Rng + ?Sized)) -> Self {
        let mut error = |sd: f64| (sd * standard_normal(rng)).clamp(-2.0 * sd, 2.0 * sd).exp();
        let (basal, icr, isf) = (error(0.08), error(0.15), error(0.15));
        let (dawn, night) = (rng.random_range(0.05..0.20), rng.random_range(0.0..0.10));
        Self {
            basal: std::array::from_fn(|hour| {
                let shape = match hour {
                    3..=7 => 1.0 + dawn,
                    22.. | 0..=1 => 1.0 - night,
                    _ => 1.0,
                };
                let rate = self.basal[hour] * basal * shape;
                (rate * 40.0).round() / 40.0 // pumps are programmed in steps of 0.025 U/h
            }),
            icr: GramsPerUnit((2.0 * self.icr.0 * icr).round() / 2.0),
            isf: (self.isf * isf).round(),
            target: self.target,
        }
    }

    /// The bolus calculator with these settings.
    ///
    /// # Errors
    /// If a setting is not a positive number.
    pub fn calculator(&self) -> Result<BolusCalculator, OdeError> {
        let correction = Correction { factor: self.isf, target: self.target };
        BolusCalculator::new(self.icr, Some(correction))
    }

    /// The programmed rate at an hour of the day.
    #[must_use]
    pub fn basal_at(&self, hour: f64) -> UnitsPerHour {
        UnitsPerHour(self.basal[(hour as usize).min(23)])
    }
}

impl Serialize for TherapySettings {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut state = serializer.serialize_struct("TherapySettings", 4)?;
        state.serialize_field("basal_u_h", &self.basal)?;
        state.serialize_field("icr_g_u", &self.icr.0)?;
        state.serialize_field("isf_mg_dl_u", &self.isf)?;
        state.serialize_field("target_mg_dl", &self.target.0)?;
        state.end()
    }
}

/// How much lower, mg/dL, glucose is six hours after 1 U was given at 180 mg/dL than without it. A
/// body with warps moves from there by itself.
///
/// # Errors
/// If the body has no steady state there or its simulation fails.
pub(crate) fn fall_by_a_unit<M: BodyModel>(body: &Body<'_, M>) -> Result<f64, OdeError> {
    let (start, basal) = body.at_rest(MgPerDl(180.0))?;
    let after = |bolus: f64| {
        let first = StepInput { bolus: Units(bolus), ..StepInput::default() };
        glucose_after_trial(body, &start, basal, first)
    };
    Ok(after(0.0)? - after(1.0)?)
}

/// Glucose, mg/dL, six hours after `first`, with basal insulin held.
fn glucose_after_trial<M: BodyModel>(
    body: &Body<'_, M>,
    start: &BodyState<M::State>,
    basal: UnitsPerHour,
    first: StepInput,
) -> Result<f64, SimulationError> {
    let mut inputs = [StepInput { basal, ..StepInput::default() }; TRIAL];
    inputs[0] = StepInput { basal, ..first };
    let run = simulate(body, *start, &mut OpenLoop::new(&inputs), TRIAL)?;
    Ok(run.states.last().map_or(f64::NAN, |state| body.glucose(state).0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hovorka::HovorkaParameters;
    use crate::padova::PadovaParameters;
    use crate::stream::{Concept, stream};
    use crate::warp::Warps;

    #[test]
    fn trials_on_the_nominal_body_give_settings_of_the_usual_size() {
        let body = HovorkaParameters::nominal();
        let hovorka = TherapySettings::by_trial(&Body::undisturbed(body));
        let padova = TherapySettings::by_trial(&Body::undisturbed(PadovaParameters::nominal()));
        for found in [hovorka, padova] {
            let found = found.expect("the nominal body has a steady state");
            // Resalat et al. 2019: 42.3 U a day, of which 1/1.78 basal (0.99 U/h), ICR 1700 / (3 x
            // 42.3) = 13 g/U; trials and that rule of thumb agree within a factor of two.
            assert!((0.5..=2.0).contains(&(found.basal[0] / 0.99)), "{}", found.basal[0]);
            assert!((0.5..=2.0).contains(&(found.icr.0 / 13.4)), "{}", found.icr.0);
            assert!((20.0..90.0).contains(&found.isf), "{}", found.isf);
        }
    }

    /// A warped body moves from 180 mg/dL by itself, which is not the insulin's doing.
    #[test]
    fn nearly_every_warped_body_has_usual_settings() {
        let parameters = HovorkaParameters::nominal();
        let is_usual = |person: &usize| {
            let warps = Warps::sample(0.2, &mut stream(1, *person, Concept::Warps));
            let body = Body::undisturbed(parameters).with_warps(warps).expect("a steady state");
            TherapySettings::by_trial(&body).expect("finite").are_usual()
        };
        let usual = (0..100).filter(is_usual).count();
        assert!(usual >= 90, "{usual} of 100");
    }
}
