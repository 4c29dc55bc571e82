//! Where the effects of a world act: in a life, and in the equations.

use rayon::prelude::*;

use super::realised::RealisedWorld;
use crate::effects::Amplitudes;
use crate::error::WorldError;
use crate::true_gap::{PersonGap, PortCourse, TrueGap};
use crate::virtual_person::{LivedDays, VirtualPerson};

/// The truth for the question "where".
#[derive(Debug, Clone, PartialEq)]
pub struct TrueWhere {
    /// The gap that all effects of the world cause together.
    pub gap: TrueGap,
    /// What each effect does at its port in the presence of the others.
    pub courses: Vec<PortCourse>,
}

impl RealisedWorld {
    /// Where the effects act; `None` in a world without any.
    ///
    /// Everything is measured on the days as lived, before any part of the record is removed.
    ///
    /// # Errors
    /// If a body fails.
    pub fn true_where(&self) -> Result<Option<TrueWhere>, WorldError> {
        if self.effects.is_empty() {
            return Ok(None);
        }
        let lived = self.lived()?;
        let gaps: Vec<(String, PersonGap)> = lived
            .par_iter()
            .map(|(person, days)| Ok((person.id.clone(), person.gap(days, &Amplitudes::NONE)?)))
            .collect::<Result<_, WorldError>>()?;
        let people: Vec<(&VirtualPerson, &LivedDays)> =
            lived.iter().map(|(person, days)| (*person, days)).collect();
        let courses = self
            .effects
            .par_iter()
            .map(|found| PortCourse::of(found.effect, &people))
            .collect::<Result<_, WorldError>>()?;
        Ok(Some(TrueWhere { gap: TrueGap::of(&gaps), courses }))
    }
}
