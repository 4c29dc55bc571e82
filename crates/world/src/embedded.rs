//! The embedded cohort: six people for four weeks, small enough for the repository.

use chrono::NaiveDate;
use cohort::Cohort;
use rayon::prelude::*;

use crate::background::Background;
use crate::calendar::Calendar;
use crate::effects::{Effect, Shapes};
use crate::error::WorldError;
use crate::therapy::Regime;
use crate::virtual_person::VirtualPerson;
use crate::world_info::WorldInfo;

/// Seed of the cohort in the repository: the first from 20,240,108 on with which every person
/// passes every check of [`plausibility`](crate::plausibility). About one seed in fifteen does. The
/// checks that fail most often are too little time below range and too low a CV with automated
/// delivery.
pub const EMBEDDED_SEED: u64 = 20_240_123;
/// Number of people in it.
pub const EMBEDDED_PEOPLE: usize = 6;
/// Number of days of each.
pub const EMBEDDED_DAYS: usize = 28;
/// The first effects of [`Effect::ALL`] act in it.
const EMBEDDED_EFFECTS: usize = 11;
/// Therapy of each person.
const REGIMES: [Regime; EMBEDDED_PEOPLE] = [
    Regime::OpenLoopPump,
    Regime::Aid,
    Regime::OpenLoopPump,
    Regime::OpenLoopPump,
    Regime::Aid,
    Regime::Aid,
];

/// The people of the embedded cohort.
///
/// They were made when the crate had fewer effects, in their typical forms, and one amplitude for
/// every error in counting carbohydrate. All of that is kept.
///
/// # Errors
/// As [`VirtualPerson::sample`].
pub fn embedded_people(seed: u64) -> Result<Vec<VirtualPerson>, WorldError> {
    REGIMES
        .into_par_iter()
        .enumerate()
        .map(|(index, regime)| {
            let person = VirtualPerson::sample(seed, index, regime)?;
            Ok(VirtualPerson {
                amplitudes: person.amplitudes.only(&Effect::ALL[..EMBEDDED_EFFECTS]),
                shapes: Shapes::TYPICAL,
                background: Background::ERRORS_IN_EFFECT,
                ..person
            })
        })
        .collect()
}

/// The embedded cohort of a seed and what it was made of.
///
/// The result depends on the seed alone, for any number of threads.
///
/// # Errors
/// If a body, its settings or its days cannot be made.
pub fn embedded_cohort(seed: u64) -> Result<(Cohort, WorldInfo), WorldError> {
    let people = embedded_people(seed)?;
    let monday = NaiveDate::from_ymd_opt(2024, 1, 8).expect("a date of the calendar");
    let recorded = people
        .par_iter()
        .map(|person| {
            // Four weeks from a Monday, a week later for each person.
            let start = monday + chrono::TimeDelta::days(7 * person.index as i64);
            Ok(person.live(Calendar::new(start, EMBEDDED_DAYS))?.recorded)
        })
        .collect::<Result<_, WorldError>>()?;
    Ok((Cohort { people: recorded }, WorldInfo::new(seed, EMBEDDED_DAYS, &people)))
}
