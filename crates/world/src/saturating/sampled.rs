//! People of this hand: draws that are accepted.

use physiology::MgPerDl;
use rand::Rng;

use super::body::SaturatingBody;
use super::parameters::SaturatingParameters;
use crate::error::WorldError;
use crate::therapy::{LEAST_FALL, fall_by_a_unit};
use crate::virtual_body::VirtualBody;

/// Basal needs that are accepted, U/h, as for the other generators.
const BASAL_RANGE: (f64, f64) = (0.45, 1.35);
/// Draws after which the search for an acceptable body ends.
const MAX_DRAWS: usize = 200;
/// Glucose at which the basal need of a body is judged.
const REFERENCE_GLUCOSE: MgPerDl = MgPerDl(115.0);

impl SaturatingParameters {
    /// Draws a body around the nominal one.
    ///
    /// Log-normal factors with these standard deviations: 0.22 shared by x_50 and y_50 (inverse)
    /// and 0.15 for each alone; k_a1 and k_a2 0.15 shared and 0.15 for each alone, V_LD 0.40
    /// (ranges of Wilinska et al. 2005, narrowed, since they hold error); V_b 0.06, V_i 0.12, K_m
    /// 0.10, V_0 0.20; G_ng 0.10, E_max 0.12, n_0 0.15, n_low 0.40; k_x and k_y 0.20; k_e 0.10,
    /// volumes 0.06; E_m 0.22, its half-content 0.25, k_u and k_l 0.20 shared; k_r 0.30; transport
    /// 0.15 (assumed). k normal 0.62 (SD 0.07), f 0.88 (SD 0.03), G_r 10.5 (SD 0.7) mmol/L; weight
    /// as for the other generators. A body is accepted if its basal need at 115 mg/dL lies between
    /// 0.45 and 1.35 U/h and a unit lowers glucose by 12 mg/dL or more.
    ///
    /// # Errors
    /// [`WorldError::NoBody`] if no draw is accepted, [`WorldError::Body`] if the model fails.
    pub fn sample(person: usize, rng: &mut (impl Rng + ?Sized)) -> Result<Self, WorldError> {
        let (lowest, highest) = BASAL_RANGE;
        for _ in 0..MAX_DRAWS {
            let body = Self::draw(rng);
            let plain = SaturatingBody::undisturbed(body);
            match plain.at_rest(REFERENCE_GLUCOSE) {
                Ok((_, basal)) if (lowest..=highest).contains(&basal.0) => {
                    // These rules of treatment do not apply to a person who hardly responds to
                    // insulin.
                    if fall_by_a_unit(&plain).is_ok_and(|fall| fall >= LEAST_FALL) {
                        return Ok(body);
                    }
                }
                Ok(_)
                | Err(ode_sim::OdeError::NoBasal { .. } | ode_sim::OdeError::SteadyState { .. }) => {
                }
                Err(source) => return Err(WorldError::Body { person, source }),
            }
        }
        Err(WorldError::NoBody { person, draws: MAX_DRAWS, lowest, highest })
    }
}
