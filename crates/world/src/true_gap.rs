//! Where in a life an effect moves glucose: the truth for the question "where".
//!
//! The body restarts without the effect from states of its run with it, under the insulin delivered
//! and the carbohydrate logged, and the two courses are compared: after 60 and 300 min, and over
//! whole days from their midnight. The signed difference is averaged by hour, by what the person
//! truly did, by true glucose and by person. Means of a cohort are means over people of each
//! person's mean, so every person counts the same.

mod differences;
mod port_course;
mod situation;

pub use port_course::{CourseUnit, PortCourse};
pub use situation::Situation;

use physiology::STEPS_PER_HOUR;

use crate::effects::Amplitudes;
use crate::error::WorldError;
use crate::virtual_person::{LivedDays, VirtualPerson};

use self::differences::differences;
use self::situation::Situations;

/// Lengths of the runs after which a difference is taken, min; the third stands for whole days.
pub const MINUTES: [u32; 3] = [60, 300, 1440];
/// Names of the levels of glucose: below 70, to 180, above 180 mg/dL.
pub const BANDS: [&str; 3] = ["<70", "70-180", ">180"];

named::named! {
    /// The factor that defines a cell of the truth.
    CellFactor {
        /// An hour of the clock, `00` to `23`.
        Hour: "hour",
        /// What the person does or did: a [`Situation`].
        Context: "context",
        /// True glucose: one of [`BANDS`].
        GlucoseBand: "glucose_band",
        /// One person.
        Person: "person",
    }
}

/// The gap in one cell.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueCell {
    /// The factor that defines the cell.
    pub factor: CellFactor,
    /// Its level of the factor.
    pub level: String,
    /// Share of all runs of 60 min that lie in it.
    pub share: f64,
    /// Mean difference, with minus without, mg/dL, by [`MINUTES`]; `None` where no run lies in the
    /// cell.
    pub mean: [Option<f64>; 3],
}

/// The gap of a cohort.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueGap {
    /// Mean difference over everything, mg/dL, by [`MINUTES`].
    pub mean: [f64; 3],
    /// Mean absolute difference over everything, mg/dL, by [`MINUTES`].
    pub mean_absolute: [f64; 3],
    /// The cells: hours, contexts, bands, people.
    pub cells: Vec<TrueCell>,
}

/// Index of the first context, of the first band and of the cell of everything; number of cells.
const CONTEXTS: usize = 24;
const FIRST_BAND: usize = CONTEXTS + Situation::ALL.len();
const EVERYTHING: usize = FIRST_BAND + BANDS.len();
const CELLS: usize = EVERYTHING + 1;

/// Sums over one horizon of one person.
#[derive(Debug, Clone, PartialEq)]
struct Sums {
    counts: [f64; CELLS],
    sums: [f64; CELLS],
    absolute: f64,
}

impl Sums {
    const NONE: Self = Self { counts: [0.0; CELLS], sums: [0.0; CELLS], absolute: 0.0 };

    fn add(&mut self, cells: impl Iterator<Item = usize>, difference: f64) {
        for cell in cells.chain(std::iter::once(EVERYTHING)) {
            self.counts[cell] += 1.0;
            self.sums[cell] += difference;
        }
        self.absolute += difference.abs();
    }

    fn mean(&self, cell: usize) -> Option<f64> {
        (self.counts[cell] > 0.0).then(|| self.sums[cell] / self.counts[cell])
    }

    /// A sum or a count per run, if there is any.
    fn per_run(&self, sum: f64) -> Option<f64> {
        (self.counts[EVERYTHING] > 0.0).then(|| sum / self.counts[EVERYTHING])
    }
}

/// The gap of one person.
#[derive(Debug, Clone, PartialEq)]
pub struct PersonGap {
    sums: [Sums; 3],
}

impl VirtualPerson {
    /// Where in the days lived the effects that `without` switches off move glucose.
    ///
    /// A difference after 60 or 300 min belongs to the hour in the middle of its run, and to the
    /// situation at its start. One within a day belongs to hour and situation of its own step. An
    /// effect on the sensor adds the difference that it makes to the reading at that step.
    ///
    /// # Errors
    /// If the body's model fails.
    pub fn gap(&self, lived: &LivedDays, without: &Amplitudes) -> Result<PersonGap, WorldError> {
        let situations = &Situations::of(self, lived);
        let calendar = &lived.life.calendar;
        let cells = |hour_at: usize, start: usize| {
            let hour = calendar.hour(hour_at) as usize;
            let band = FIRST_BAND + band(lived.glucose[start].0);
            let contexts = Situation::ALL.into_iter().enumerate();
            let contexts = contexts.filter(move |(_, s)| situations.holds(*s, start));
            [hour, band].into_iter().chain(contexts.map(|(index, _)| CONTEXTS + index))
        };
        let mut sums = [Sums::NONE, Sums::NONE, Sums::NONE];
        for found in differences(self, lived, without)? {
            sums[found.horizon].add(cells(found.hour_at, found.situation_at), found.value);
        }
        Ok(PersonGap { sums })
    }
}

fn band(glucose: f64) -> usize {
    usize::from(glucose >= 70.0) + usize::from(glucose > 180.0)
}

impl TrueGap {
    /// The gap of these people, each with their identifier.
    #[must_use]
    pub fn of(people: &[(String, PersonGap)]) -> Self {
        let over = |of: &dyn Fn(&PersonGap) -> Option<f64>| {
            let values: Vec<f64> = people.iter().filter_map(|(_, gap)| of(gap)).collect();
            (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
        };
        let mean = |horizon: usize, cell: usize| over(&|gap| gap.sums[horizon].mean(cell));
        let share = |cell: usize| {
            let of = |gap: &PersonGap| gap.sums[0].per_run(gap.sums[0].counts[cell]);
            over(&of).unwrap_or(0.0)
        };
        let size = |horizon: usize| {
            over(&|gap| gap.sums[horizon].per_run(gap.sums[horizon].absolute)).unwrap_or(0.0)
        };
        // In the order of the cells' indices.
        let hours = (0..24).map(|hour| (CellFactor::Hour, format!("{hour:02}")));
        let contexts = Situation::ALL.map(|it| (CellFactor::Context, it.name().to_owned()));
        let bands = BANDS.map(|level| (CellFactor::GlucoseBand, level.to_owned()));
        let levels = hours.chain(contexts).chain(bands).enumerate();
        let shared = levels.map(|(cell, (factor, level))| TrueCell {
            factor,
            level,
            share: share(cell),
            mean: std::array::from_fn(|horizon| mean(horizon, cell)),
        });
        let alone = people.iter().map(|(id, gap)| TrueCell {
            factor: CellFactor::Person,
            level: id.clone(),
            share: 1.0 / people.len() as f64,
            mean: std::array::from_fn(|horizon| gap.sums[horizon].mean(EVERYTHING)),
        });
        Self {
            mean: std::array::from_fn(|horizon| mean(horizon, EVERYTHING).unwrap_or(0.0)),
            mean_absolute: std::array::from_fn(size),
            cells: shared.chain(alone).collect(),
        }
    }

    /// The cell of a level.
    #[must_use]
    pub fn cell(&self, factor: CellFactor, level: &str) -> Option<&TrueCell> {
        self.cells.iter().find(|cell| cell.factor == factor && cell.level == level)
    }
}

/// Steps of a run of `minutes`.
fn steps_of(minutes: u32) -> usize {
    minutes as usize * STEPS_PER_HOUR / 60
}
