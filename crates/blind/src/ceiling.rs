//! The ceiling: what the exact course of an effect would name.

use serde::{Deserialize, Serialize};

use crate::check::BlindCheck;
use crate::error::BlindError;
use crate::label::Kind;
use crate::outcome::Outcome;
use crate::power::PowerRow;
use crate::share::Share;

/// Evidence of the exact course of one effect in one world, against the threshold that the answer was given.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExactCourse {
    /// The world.
    pub id: String,
    /// The effect.
    pub effect: String,
    /// Whether it acts there.
    pub acts: bool,
    /// Held-out evidence, nats; `None` where nobody of the world can be diagnosed.
    pub gain_nats: Option<f64>,
    /// Estimated share of the course that is there, mean over people: 1 where filter and background leave an effect
    /// as it is.
    #[serde(default)]
    pub amplitude: Option<f64>,
    /// What must be exceeded for the effect to be named, nats.
    pub threshold_nats: f64,
}

impl ExactCourse {
    /// Whether the evidence exceeds the threshold.
    #[must_use]
    pub fn is_above(&self) -> bool {
        self.gain_nats.is_some_and(|gain| gain > self.threshold_nats)
    }
}

/// What exact courses would name, with the background and the thresholds of the answers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Ceiling {
    /// Worlds with one effect whose exact course is above its threshold.
    pub named: Share,
    /// The same of effects that move glucose by 5 mg/dL or more, and what the answers named of those worlds.
    pub named_at_5: Share,
    /// What the answers named of those worlds.
    pub answered_at_5: Share,
    /// The same from 10 mg/dL.
    pub named_at_10: Share,
    /// What the answers named of those worlds.
    pub answered_at_10: Share,
    /// Courses of effects that do not act, in worlds without an effect, that are above their threshold.
    pub false_alarms: Share,
    /// Every course.
    pub courses: Vec<ExactCourse>,
}

impl BlindCheck {
    /// The same check with what exact courses would name beside the power.
    ///
    /// # Errors
    /// If an interval cannot be formed.
    pub fn with_ceiling(mut self, courses: Vec<ExactCourse>) -> Result<Self, BlindError> {
        let singles: Vec<(Single<'_>, bool)> = self
            .worlds
            .iter()
            .filter(|row| row.kind == Kind::Single)
            .filter_map(|row| {
                let truth = row.truth.first()?;
                let course = courses.iter().find(|c| c.acts && c.id == row.id)?;
                let shift = truth.achieved_mg_dl;
                let single = Single { effect: &truth.effect, shift, above: course.is_above() };
                Some((single, row.outcome == Outcome::Correct))
            })
            .collect();
        let moved = |from: f64| singles.iter().filter(move |(single, _)| single.shift >= from);
        let above = |from: f64| Share::among(moved(from), |(single, _)| single.above);
        let right = |from: f64| Share::among(moved(from), |(_, right)| *right);
        let ceiling = Ceiling {
            named: above(0.0)?,
            named_at_5: above(5.0)?,
            answered_at_5: right(5.0)?,
            named_at_10: above(10.0)?,
            answered_at_10: right(10.0)?,
            false_alarms: Share::among(courses.iter().filter(|c| !c.acts), |c| c.is_above())?,
            courses: Vec::new(),
        };
        for row in &mut self.power {
            let within = singles.iter().filter(|(single, _)| single.is_of(row));
            row.ceiling = Some(Share::among(within, |(single, _)| single.above)?);
        }
        self.ceiling = Some(Ceiling { courses, ..ceiling });
        Ok(self)
    }
}

/// A world with one effect.
struct Single<'a> {
    effect: &'a str,
    shift: f64,
    above: bool,
}

impl Single<'_> {
    fn is_of(&self, row: &PowerRow) -> bool {
        row.effect.as_deref().is_none_or(|effect| effect == self.effect)
            && row.from_mg_dl <= self.shift
            && row.to_mg_dl.is_none_or(|to| self.shift < to)
    }
}
