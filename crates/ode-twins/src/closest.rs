//! The closest of a virtual population (paper, "Closest ODE-based digital twin").

use ode_sim::{OdeParameters, OdePlant};
use physiology::Kilograms;

use crate::error::OdeTwinError;
use crate::windows::FitWindows;

/// A member of a virtual population: parameters and the weight that goes with them.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// What the population calls it.
    pub id: String,
    /// Model parameters.
    pub parameters: OdeParameters,
    /// Body weight, by which doses are divided: the virtual patient's own, not the person's.
    pub weight: Kilograms,
}

/// What a choice came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Closest {
    /// Place among the candidates.
    pub place: usize,
    /// Its mean training loss.
    pub loss: f64,
}

/// The candidate with the least training loss; of equals the first.
///
/// # Errors
/// [`OdeTwinError::NoCandidate`] if none can be simulated.
pub fn closest(
    windows: &FitWindows<'_>,
    candidates: &[Candidate],
) -> Result<Closest, OdeTwinError> {
    let mut best: Option<Closest> = None;
    let mut last = "there is no candidate".to_owned();
    for (place, candidate) in candidates.iter().enumerate() {
        match windows.loss(&OdePlant::reproduction(candidate.parameters, candidate.weight)) {
            Ok(loss) if loss.is_finite() => {
                if best.as_ref().is_none_or(|best| loss < best.loss) {
                    best = Some(Closest { place, loss });
                }
            }
            Ok(loss) => last = format!("the loss is {loss}"),
            Err(error) => last = error.to_string(),
        }
    }
    best.ok_or(OdeTwinError::NoCandidate { tried: candidates.len(), last })
}
