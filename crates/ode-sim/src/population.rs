//! Virtual people: sensitivities and weights drawn as in Resalat et al. 2019, pruned by two
//! physiological tests, each with the insulin needs that follow from the model.

use physiology::Plant;
use physiology::{
    GramsPerUnit, Kilograms, MgPerDl, OpenLoop, StepInput, Units, UnitsPerHour, simulate,
};
use rand::{Rng, RngExt};
use rand_distr::{Distribution, Normal, StandardNormal};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use crate::dosing::{insulin_to_carb_ratio, total_daily_insulin};
use crate::equations::EgpMode;
use crate::error::OdeError;
use crate::integrator::Integrator;
use crate::parameters::{OdeParameters, T1D_SENSITIVITY_FACTOR};
use crate::plant::OdePlant;
use crate::random::{Purpose, stream};
use crate::state::OdeState;
use crate::steady_state;

/// Mean body weight, kg (Resalat et al. 2019).
pub const MEAN_WEIGHT: f64 = 76.3;
/// Standard deviation of body weight, kg (Resalat et al. 2019).
pub const SD_WEIGHT: f64 = 15.9;
/// Glucose that the basal rate holds; it defines total daily insulin (Resalat et al. 2019).
pub const BASAL_TARGET: MgPerDl = MgPerDl(115.0);

/// Mean and SD of S_f2 without diabetes, L/mU/min (Resalat et al. 2019).
const S_F2: (f64, f64) = (8.2e-4, 3.2e-4);
/// Mean and SD of S_f1 without diabetes, L/mU/min (Resalat et al. 2019).
const S_F1: (f64, f64) = (51.2e-4, 14.4e-4);
/// Mean and SD of S_f3 without diabetes, L/mU (Resalat et al. 2019).
const S_F3: (f64, f64) = (520e-4, 137.5e-4);
/// Half width of what S_f1 has of its own, in SD (1 minus its correlation 0.75 with S_f2).
const OWN_S_F1: f64 = 0.25;
/// Half width of what S_f3 has of its own, in SD (1 minus its correlation 0.25 with S_f2).
const OWN_S_F3: f64 = 0.75;

/// Steps of each physiological test.
const TEST_STEPS: usize = 1000;
/// Glucose that must be reached without insulin, mg/dL.
const HIGH_WITHOUT_INSULIN: f64 = 300.0;
/// Insulin of the second test, U/h.
const MUCH_INSULIN: UnitsPerHour = UnitsPerHour(15.0);
/// Where the second test starts.
const SECOND_START: MgPerDl = MgPerDl(160.0);
/// Glucose that must be reached with much insulin, mg/dL.
const LOW_WITH_INSULIN: f64 = 100.0;
/// Draws for one person before giving up; about one in a hundred fails.
const MAX_DRAWS: usize = 1000;

/// A virtual person with T1D.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VirtualPerson {
    /// Place in the population.
    pub index: u64,
    /// Model parameters.
    pub parameters: OdeParameters,
    /// Body weight.
    pub weight: Kilograms,
    /// Basal rate that holds [`BASAL_TARGET`].
    pub basal: UnitsPerHour,
    /// Total daily insulin, 1.78 times the daily basal.
    pub total_daily_insulin: Units,
    /// Insulin-to-carbohydrate ratio 1700 / (3 TDIR).
    pub ratio: GramsPerUnit,
}

/// Outcome of the physiological tests.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Physiology {
    /// Both passed.
    Plausible,
    /// Without insulin glucose stays below 300 mg/dL.
    LowWithoutInsulin,
    /// 15 U/h do not bring glucose to 100 mg/dL.
    ResistsInsulin,
}

/// Draws parameters: the nominal ones with sensitivities
/// S_f2 = s (8.2e-4 + 3.2e-4 z), S_f1 = s (51.2e-4 + 14.4e-4 (z + 0.25 w)),
/// S_f3 = s (520e-4 + 137.5e-4 (z + 0.75 w)); z standard normal, w uniform in -1..1, s = 0.4.
///
/// One z and one w serve all three, as in the authors' program. (The 99 patients stored beside it
/// share z and w as well, but were drawn with SDs of 13.1e-4 and 125e-4 for S_f1 and S_f3; see
/// `tests/it/published_population.rs`.) `None` if a sensitivity is not positive.
pub fn draw_parameters(rng: &mut impl Rng) -> Option<OdeParameters> {
    let z: f64 = StandardNormal.sample(rng);
    let w = 2.0 * rng.random::<f64>() - 1.0;
    let s = T1D_SENSITIVITY_FACTOR;
    let parameters = OdeParameters {
        s_f1: s * (S_F1.0 + S_F1.1 * (z + OWN_S_F1 * w)),
        s_f2: s * (S_F2.0 + S_F2.1 * z),
        s_f3: s * (S_F3.0 + S_F3.1 * (z + OWN_S_F3 * w)),
        ..OdeParameters::nominal()
    };
    parameters.validated().ok()
}

/// The two physiological tests, each over 1000 steps.
///
/// From empty compartments and without insulin glucose must reach 300 mg/dL; from the steady state
/// at 160 mg/dL, 15 U/h must bring it to 100 mg/dL or below. The authors set negative states to
/// zero after each step; here production is kept from turning negative instead
/// ([`EgpMode::NonNegative`]), under which no state turns negative. The method is RK4 at half a
/// minute, since 15 U/h make Euler's 5 min unstable (X1 then exceeds 0.4/min).
///
/// # Errors
/// Those of [`steady_state::at_glucose`] and [`OdeError::Simulation`].
pub fn physiological_tests(
    parameters: &OdeParameters,
    weight: Kilograms,
) -> Result<Physiology, OdeError> {
    let plant = OdePlant {
        parameters: *parameters,
        weight,
        integrator: Integrator::RungeKutta4 { substeps: 10 },
        egp: EgpMode::NonNegative,
    };
    let end = |start: OdeState, basal: UnitsPerHour| -> Result<MgPerDl, OdeError> {
        let inputs = vec![StepInput { basal, ..StepInput::default() }; TEST_STEPS];
        let run = simulate(&plant, start, &mut OpenLoop::new(&inputs), TEST_STEPS)?;
        Ok(run.states.last().map_or(MgPerDl(0.0), |state| plant.glucose(state)))
    };
    if end(OdeState::default(), UnitsPerHour(0.0))?.0 < HIGH_WITHOUT_INSULIN {
        return Ok(Physiology::LowWithoutInsulin);
    }
    let start = steady_state::at_glucose(parameters, weight, SECOND_START)?.state;
    if end(start, MUCH_INSULIN)?.0 > LOW_WITH_INSULIN {
        return Ok(Physiology::ResistsInsulin);
    }
    Ok(Physiology::Plausible)
}

impl VirtualPerson {
    /// Person `index` of the population under `seed`, whatever the size of the population.
    ///
    /// Draws are repeated until sensitivities and weight are positive and both tests are passed.
    ///
    /// # Errors
    /// [`OdeError::NoVirtualPerson`] after 1000 draws.
    pub fn draw(seed: u64, index: u64) -> Result<Self, OdeError> {
        let mut rng = stream(seed, Purpose::VirtualPerson, index);
        let weights = Normal::new(MEAN_WEIGHT, SD_WEIGHT).expect("both constants are positive");
        for _ in 0..MAX_DRAWS {
            let parameters = draw_parameters(&mut rng);
            let weight = Kilograms(weights.sample(&mut rng));
            let Some(parameters) = parameters.filter(|_| weight.0 > 0.0) else { continue };
            if physiological_tests(&parameters, weight)? == Physiology::Plausible {
                return Self::of(index, parameters, weight);
            }
        }
        Err(OdeError::NoVirtualPerson { index, draws: MAX_DRAWS })
    }

    /// The person with these parameters and the insulin needs that follow from them.
    ///
    /// # Errors
    /// Those of [`steady_state::at_glucose`].
    pub fn of(index: u64, parameters: OdeParameters, weight: Kilograms) -> Result<Self, OdeError> {
        let basal = steady_state::at_glucose(&parameters, weight, BASAL_TARGET)?.basal;
        let total_daily_insulin = total_daily_insulin(basal);
        let ratio = insulin_to_carb_ratio(total_daily_insulin);
        Ok(Self { index, parameters, weight, basal, total_daily_insulin, ratio })
    }
}

/// A population of `size` virtual people, in order of their index.
///
/// # Errors
/// The first error of [`VirtualPerson::draw`].
pub fn population(seed: u64, size: u64) -> Result<Vec<VirtualPerson>, OdeError> {
    (0..size).into_par_iter().map(|index| VirtualPerson::draw(seed, index)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tests_tell_who_fails_which() {
        let weight = Kilograms(76.3);
        let nominal = OdeParameters::nominal();
        assert_eq!(physiological_tests(&nominal, weight), Ok(Physiology::Plausible));
        // Production so low that the kidneys hold glucose below 300 mg/dL without insulin:
        // 9 + (EGP0 - F01) / (0.003 V_G) mmol/L = 248 mg/dL.
        let low = OdeParameters { egp_0: 0.012, ..nominal };
        assert_eq!(physiological_tests(&low, weight), Ok(Physiology::LowWithoutInsulin));
        // A hundredth of the nominal sensitivity: 15 U/h suppress a tenth of production.
        let resistant = nominal.with_sensitivity_scaled(0.02);
        assert_eq!(physiological_tests(&resistant, weight), Ok(Physiology::ResistsInsulin));
    }

    #[test]
    fn a_person_does_not_depend_on_the_size_of_the_population() {
        let few = population(5, 3).expect("people");
        let many = population(5, 6).expect("people");
        assert_eq!(few[..], many[..3]);
    }
}
