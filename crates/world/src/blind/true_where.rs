//! Where the effects of a world act: in a life, and in the equations.

use rayon::prelude::*;

use super::realised::LivedWorld;
use crate::effects::Amplitudes;
use crate::error::WorldError;
use crate::true_gap::{PersonGap, PortCourse, TrueGap};

/// The truth for the question "where".
#[derive(Debug, Clone, PartialEq)]
pub struct TrueWhere {
    /// The gap that all effects of the world cause together.
    pub gap: TrueGap,
    /// What each effect does at its port in the presence of the others.
    pub courses: Vec<PortCourse>,
}

impl LivedWorld {
    /// Where the effects act; `None` in a world without any.
    ///
    /// Everything is measured on the days as lived, before any part of the record is removed.
    ///
    /// # Errors
    /// If a body fails.
    pub fn true_where(&self) -> Result<Option<TrueWhere>, WorldError> {
        if self.world.effects.is_empty() {
            return Ok(None);
        }
        let everybody = self.everybody();
        let gaps: Vec<(String, PersonGap)> = everybody
            .par_iter()
            .map(|(person, days)| Ok((person.id.clone(), person.gap(days, &Amplitudes::NONE)?)))
            .collect::<Result<_, WorldError>>()?;
        let with_gaps = everybody.into_iter().zip(&gaps);
        let people: Vec<_> =
            with_gaps.map(|((person, days), (_, gap))| (person, days, gap)).collect();
        let courses = self
            .world
            .effects
            .par_iter()
            .map(|found| PortCourse::of(found.effect, &people))
            .collect::<Result<_, WorldError>>()?;
        Ok(Some(TrueWhere { gap: TrueGap::of(&gaps), courses }))
    }
}
