//! How one virtual body differs from another.

use ode_sim::{OdeParameters, steady_state};
use physiology::{Kilograms, MgPerDl, UnitsPerHour};
use rand::Rng;

use crate::error::WorldError;
use crate::stream::standard_normal;

/// Basal needs that are accepted, U/h: with basal near half of the daily insulin these lie around
/// 20 to 70 U a day (Resalat et al. 2019: mean 42.3 U).
const BASAL_RANGE: (f64, f64) = (0.45, 1.35);
/// Draws after which the search for an acceptable body ends; one in two is accepted.
const MAX_DRAWS: usize = 200;
/// Glucose at which the basal need of a body is judged.
const REFERENCE_GLUCOSE: MgPerDl = MgPerDl(115.0);

/// The body of one person: model parameters and weight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyParameters {
    /// Parameters of the ODE model.
    pub model: OdeParameters,
    /// Body weight.
    pub weight: Kilograms,
}

impl BodyParameters {
    /// Draws a body around the nominal T1D parameters.
    ///
    /// Log-normal factors with these standard deviations: 0.25 shared by the three insulin
    /// sensitivities and 0.15 for each alone; EGP0 and F01 0.10; t_max,I 0.15; t_max,G 0.18; k_e
    /// and V_I 0.08; V_G 0.05; A_G normal 0.80 (SD 0.05). Resalat et al. 2019 vary the
    /// sensitivities alone (their relative spreads are 0.28 to 0.39); the others follow the
    /// between-person spreads of Hovorka et al. (Am J Physiol Endocrinol Metab 2002;282:E992),
    /// rounded. Weight normal 76.3 kg (SD 15.9), 50 to 115 kg. A body is accepted if its basal need
    /// at 115 mg/dL lies between 0.45 and 1.35 U/h.
    ///
    /// # Errors
    /// [`WorldError::NoBody`] if no draw is accepted, [`WorldError::Body`] if the model fails.
    pub fn sample(person: usize, rng: &mut (impl Rng + ?Sized)) -> Result<Self, WorldError> {
        let (lowest, highest) = BASAL_RANGE;
        for _ in 0..MAX_DRAWS {
            let body = Self::draw(rng);
            let basal = match body.basal_at(REFERENCE_GLUCOSE) {
                Ok(basal) => basal,
                Err(ode_sim::OdeError::NoBasal { .. }) => continue,
                Err(source) => return Err(WorldError::Body { person, source }),
            };
            if (lowest..=highest).contains(&basal.0) {
                return Ok(body);
            }
        }
        Err(WorldError::NoBody { person, draws: MAX_DRAWS, lowest, highest })
    }

    /// One draw, accepted or not.
    fn draw(rng: &mut (impl Rng + ?Sized)) -> Self {
        let nominal = OdeParameters::nominal();
        let mut factor = |sd: f64| (sd * standard_normal(rng)).clamp(-2.5 * sd, 2.5 * sd).exp();
        let shared = factor(0.25);
        let model = OdeParameters {
            s_f1: nominal.s_f1 * shared * factor(0.15),
            s_f2: nominal.s_f2 * shared * factor(0.15),
            s_f3: nominal.s_f3 * shared * factor(0.15),
            egp_0: nominal.egp_0 * factor(0.10),
            f_01: nominal.f_01 * factor(0.10),
            t_max_i: nominal.t_max_i * factor(0.15),
            t_max_g: nominal.t_max_g * factor(0.18),
            k_e: nominal.k_e * factor(0.08),
            v_i: nominal.v_i * factor(0.08),
            v_g: nominal.v_g * factor(0.05),
            ..nominal
        };
        let a_g = (0.80 + 0.05 * standard_normal(rng)).clamp(0.65, 0.95);
        let weight = (76.3 + 15.9 * standard_normal(rng)).clamp(50.0, 115.0);
        Self { model: OdeParameters { a_g, ..model }, weight: Kilograms(weight) }
    }

    /// The basal rate that holds a glucose concentration.
    ///
    /// # Errors
    /// As [`steady_state::at_glucose`].
    pub fn basal_at(&self, glucose: MgPerDl) -> Result<UnitsPerHour, ode_sim::OdeError> {
        Ok(steady_state::at_glucose(&self.model, self.weight, glucose)?.basal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::{Concept, stream};

    #[test]
    fn bodies_differ_and_none_is_nominal() {
        let bodies: Vec<BodyParameters> = (0..20)
            .map(|person| {
                BodyParameters::sample(person, &mut stream(5, person, Concept::Body))
                    .expect("one in two draws is accepted")
            })
            .collect();
        let nominal = OdeParameters::nominal();
        for body in &bodies {
            let basal = body.basal_at(REFERENCE_GLUCOSE).expect("accepted before").0;
            assert!((0.45..=1.35).contains(&basal), "{basal}");
            let untouched =
                body.model.named().iter().zip(nominal.named()).filter(|(a, b)| *a == b).count();
            assert_eq!(untouched, 4); // k_12, k_a1, k_a2 and k_a3 are shared by everybody
        }
        let mean = bodies.iter().map(|b| b.weight.0).sum::<f64>() / 20.0;
        // Four standard errors of the mean of twenty.
        assert!((mean - 76.3).abs() < 4.0 * 15.9 / 20.0_f64.sqrt(), "{mean}");
    }
}
