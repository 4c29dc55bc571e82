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

impl Candidate {
    /// The plant as the authors run it.
    #[must_use]
    pub fn plant(&self) -> OdePlant {
        OdePlant::reproduction(self.parameters, self.weight)
    }
}

/// What a choice came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Closest {
    /// Place among the candidates.
    pub place: usize,
    /// Its mean training loss.
    pub loss: f64,
    /// Candidates that could not be simulated on every window.
    pub failed: usize,
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
    let (mut failed, mut last) = (0, "there is no candidate".to_owned());
    for (index, candidate) in candidates.iter().enumerate() {
        match windows.loss(&candidate.plant()) {
            Ok(loss) if loss.is_finite() => {
                if best.as_ref().is_none_or(|best| loss < best.loss) {
                    best = Some(Closest { place: index, loss, failed: 0 });
                }
            }
            Ok(loss) => {
                failed += 1;
                last = format!("the loss is {loss}");
            }
            Err(error) => {
                failed += 1;
                last = error.to_string();
            }
        }
    }
    let best = best.ok_or(OdeTwinError::NoCandidate { tried: candidates.len(), last })?;
    Ok(Closest { failed, ..best })
}
