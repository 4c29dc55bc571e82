//! What exact courses would name.

use super::Share;

/// Evidence of the exact course of one effect in one world.
#[apply(strict!)]
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
    pub amplitude: Option<f64>,
}

/// What exact courses would name, with the background of the answers.
#[apply(strict!)]
pub struct Ceiling {
    /// Evidence that at most one in fifty courses of effects that do not act exceeds, nats: what a name requires here.
    pub bar_nats: f64,
    /// The ceiling with the bar at the lower limit of its 95 % bootstrap interval over worlds; `None` where fewer than
    /// two worlds have courses of effects that do not act.
    pub at_lower_bar: Option<CeilingAtBar>,
    /// The same at the upper limit.
    pub at_upper_bar: Option<CeilingAtBar>,
    /// Worlds with one effect whose exact course is above the bar.
    pub named: Share,
    /// The same of effects that move glucose by 5 mg/dL or more, and what the answers named of those worlds.
    pub named_at_5: Share,
    /// What the answers named of those worlds.
    pub answered_at_5: Share,
    /// The same from 10 mg/dL.
    pub named_at_10: Share,
    /// What the answers named of those worlds.
    pub answered_at_10: Share,
    /// Worlds with an effect outside the library whose exact course is above the bar.
    pub unknown: Share,
    /// What the answers called unknown of those worlds.
    pub answered_unknown: Share,
    /// Courses of effects that do not act, in worlds without an effect, that are above the bar.
    pub false_alarms: Share,
    /// Every course.
    pub courses: Vec<ExactCourse>,
}

/// How many worlds are above another bar.
#[apply(strict!)]
#[derive(Copy)]
pub struct CeilingAtBar {
    /// The bar, nats.
    pub bar_nats: f64,
    /// Of those that `named_at_5` of the ceiling counts.
    pub named_at_5: usize,
    /// Of those that `named_at_10` of the ceiling counts.
    pub named_at_10: usize,
    /// Of those that `unknown` of the ceiling counts.
    pub unknown: usize,
}
