//! People of this hand: draws that are accepted.

use physiology::MgPerDl;
use rand::Rng;

use super::body::PadovaBody;
use super::parameters::PadovaParameters;
use crate::error::WorldError;
use crate::virtual_body::VirtualBody;

/// Basal needs that are accepted, U/h, as for the other generator.
const BASAL_RANGE: (f64, f64) = (0.45, 1.35);
/// Draws after which the search for an acceptable body ends; two in three are accepted.
const MAX_DRAWS: usize = 200;
/// Glucose at which the basal need of a body is judged.
const REFERENCE_GLUCOSE: MgPerDl = MgPerDl(115.0);

impl PadovaParameters {
    /// Draws a body around the nominal one.
    ///
    /// Log-normal factors with these standard deviations, assumed after the spread of the adults of
    /// the T1D simulator: 0.22 shared by V_mx and k_p3 and 0.15 for each alone; k_max and k_gri
    /// 0.20 shared, k_min 0.25, k_abs 0.25; k_d and k_a2 0.18 shared, k_a1 0.20; k_i and p_2U 0.20;
    /// m_2 and m_4 0.12 shared; K_m0 0.08; EGP_b 0.10; I_b 0.15; V_G and V_I 0.05; k_1 and k_2
    /// 0.08; k_p2 0.20. b normal 0.80 (SD 0.06), f normal 0.90 (SD 0.03), G_b normal 120 (SD 8)
    /// mg/dL, k_e2 normal 339 (SD 15) mg/kg; weight as for the other generator. A body is accepted
    /// if its basal need at 115 mg/dL lies between 0.45 and 1.35 U/h.
    ///
    /// # Errors
    /// [`WorldError::NoBody`] if no draw is accepted, [`WorldError::Body`] if the model fails.
    pub fn sample(person: usize, rng: &mut (impl Rng + ?Sized)) -> Result<Self, WorldError> {
        let (lowest, highest) = BASAL_RANGE;
        for _ in 0..MAX_DRAWS {
            let body = Self::draw(rng);
            match PadovaBody::undisturbed(body).at_rest(REFERENCE_GLUCOSE) {
                Ok((_, basal)) if (lowest..=highest).contains(&basal.0) => return Ok(body),
                Ok(_) | Err(ode_sim::OdeError::NoBasal { .. }) => {}
                Err(source) => return Err(WorldError::Body { person, source }),
            }
        }
        Err(WorldError::NoBody { person, draws: MAX_DRAWS, lowest, highest })
    }
}
