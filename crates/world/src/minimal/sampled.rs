//! People of this hand: draws that are accepted.

use physiology::MgPerDl;
use rand::Rng;

use super::body::MinimalBody;
use super::parameters::MinimalParameters;
use crate::error::WorldError;
use crate::therapy::{LEAST_FALL, fall_by_a_unit};
use crate::virtual_body::VirtualBody;

/// Basal needs that are accepted, U/h, as for the other generators.
const BASAL_RANGE: (f64, f64) = (0.45, 1.35);
/// Draws after which the search for an acceptable body ends.
const MAX_DRAWS: usize = 200;
/// Glucose at which the basal need of a body is judged.
const REFERENCE_GLUCOSE: MgPerDl = MgPerDl(115.0);

impl MinimalParameters {
    /// Draws a body around the nominal one.
    ///
    /// Log-normal factors with these standard deviations, assumed of the order of the spreads
    /// between the ten patients of Kanderian et al. 2009, which also hold error: 0.22 shared by S_I
    /// and S_L and 0.15 for each alone; p_2 0.25, p_L 0.20; clearance 0.12, V_I 0.08; k_h and k_a
    /// 0.18 shared and k_a 0.10 alone, D_50 0.30; t_half 0.22, k_abs 0.20; P_0 0.10, k_g 0.25, R_d0
    /// 0.08; V_G 0.06; k_r 0.30. beta normal 1.35 (SD 0.18), f 0.90 (SD 0.03), G_r 190 (SD 12)
    /// mg/dL; weight as for the other generators. A body is accepted if its basal need at 115 mg/dL
    /// lies between 0.45 and 1.35 U/h and a unit lowers glucose by 12 mg/dL or more.
    ///
    /// # Errors
    /// [`WorldError::NoBody`] if no draw is accepted, [`WorldError::Body`] if the model fails.
    pub fn sample(person: usize, rng: &mut (impl Rng + ?Sized)) -> Result<Self, WorldError> {
        let (lowest, highest) = BASAL_RANGE;
        for _ in 0..MAX_DRAWS {
            let body = Self::draw(rng);
            let plain = MinimalBody::undisturbed(body);
            match plain.at_rest(REFERENCE_GLUCOSE) {
                Ok((_, basal)) if (lowest..=highest).contains(&basal.0) => {
                    // These rules of treatment do not apply to a person who hardly responds to
                    // insulin.
                    if fall_by_a_unit(&plain).is_ok_and(|fall| fall >= LEAST_FALL) {
                        return Ok(body);
                    }
                }
                Ok(_) | Err(ode_sim::OdeError::NoBasal { .. }) => {}
                Err(source) => return Err(WorldError::Body { person, source }),
            }
        }
        Err(WorldError::NoBody { person, draws: MAX_DRAWS, lowest, highest })
    }
}
