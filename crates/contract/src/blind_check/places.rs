//! Whether the answers tell where the gap lies.

use std::collections::BTreeMap;

use super::Share;

/// How well "where" is answered.
#[apply(strict!)]
pub struct WhereScore {
    /// In context: against the truth after each of the horizons.
    pub context: Vec<ContextScore>,
    /// Whether the answer's intervals hold the truth.
    pub coverage: CoverageScore,
    /// In the equations.
    pub equations: EquationScore,
}

/// The answer's three largest cells against the truth after one horizon.
#[apply(strict!)]
pub struct ContextScore {
    /// Length of the runs of the truth, min; 1440 stands for whole days from midnight.
    pub minutes: u32,
    /// Worlds with a truth that has a hot place, of those with a truth.
    pub comparable: Share,
    /// Comparable worlds in which one of the three cells is hot.
    pub hit: Share,
    /// Probability that three cells drawn from the same factors of the same answer would have hit: mean over the
    /// worlds of which the answer has cells.
    pub chance: Option<f64>,
    /// Hits whose first hot cell has the sign of the truth.
    pub sign_right: Share,
}

/// Simultaneous intervals against the truth after the horizon of the answer's own runs.
#[apply(strict!)]
pub struct CoverageScore {
    /// Cells of worlds with an effect whose interval holds the true mean.
    pub cells: Share,
    /// Worlds with an effect in which every interval does.
    pub worlds: Share,
    /// Cells of worlds without an effect whose interval holds 0.
    pub null_cells: Share,
    /// Worlds without an effect in which every interval does.
    pub null_worlds: Share,
}

/// The true port among the answer's; one entry a true effect.
#[apply(strict!)]
pub struct EquationScore {
    /// True ports that stand first.
    pub first: Share,
    /// True ports that stand first, or that the first cannot be told from.
    pub first_or_in_set: Share,
    /// True ports among the first three.
    pub among_three: Share,
    /// Mean rank of the true ports that the answer lists, counted from 1.
    pub mean_rank: Option<f64>,
    /// Mean number of ports that an answer lists: a port drawn at random stands first in one of as many.
    pub mean_listed: Option<f64>,
    /// True ports that the answer does not list.
    pub not_listed: Share,
    /// The same by true port: how often it stands first.
    pub first_by_port: BTreeMap<String, Share>,
    /// Worlds with an effect of which the port of the first named effect is a true one, of those in which an
    /// effect is named.
    pub port_of_first_name: Share,
    /// Effects named rightly whose amplitude is certain to be above zero: the only sign that an answer states.
    pub sign_of_amplitude: Share,
    /// Answers that state a course over the day at the true port, in the unit of the truth.
    pub course_answered: Share,
    /// Of those, courses whose sign is right where the true one is farthest from its mean.
    pub course_sign: Share,
    /// The same where the answer's interval there leaves 0 out.
    pub course_sign_if_certain: Share,
    /// Parts of the day whose interval holds the true course, and courses that are held in all of them.
    pub course_parts_held: Share,
    /// See [`course_parts_held`](Self::course_parts_held).
    pub courses_held: Share,
}

/// "Where" in one world.
#[apply(strict!)]
pub struct WorldWhere {
    /// By horizon: whether the truth has a hot place.
    pub comparable: [bool; 3],
    /// By horizon: whether one of the three largest cells is hot.
    pub hit: [bool; 3],
    /// By horizon: what chance would have hit.
    pub chance: [Option<f64>; 3],
    /// By horizon: whether the first hot cell has the right sign.
    pub sign_right: [Option<bool>; 3],
    /// The true ports, each with its rank in the answer from 1; `None` where it is not listed.
    pub port_ranks: Vec<(String, Option<usize>)>,
}
