//! People for tests: a linear model in which every direction has steps of its own, so that what is found of one can be
//! worked out by hand.

use effects::{EffectId, Field};
use physiology::STEPS_PER_DAY;

use super::round::RoundPerson;
use super::statistics::RANDOM;
use super::tried::Tried;
use crate::design::{Background, Column, Design, HiddenEvents, UnitBank};

/// The columns behind those of the random factors.
pub(super) const CLOCK: usize = RANDOM.len();
pub(super) const DAWN: [usize; 2] = [CLOCK + 1, CLOCK + 2];
pub(super) const EXERCISE: usize = CLOCK + 3;
pub(super) const RENAL: usize = CLOCK + 4;
pub(super) const COLUMNS: usize = CLOCK + 5;
/// The column that the time of insulin has.
pub(super) const INSULIN_TIME: usize = 3;
/// Steps of each column in a day.
pub(super) const A_DAY: usize = STEPS_PER_DAY / COLUMNS;
/// Standard deviation of the prior of the background.
pub(super) const PRIOR_SD: f64 = 0.1;

/// A design without noise: an amplitude of each column, and what each day adds to that of the time of insulin.
pub(super) fn design(amplitudes: [f64; COLUMNS], by_day: &[f64]) -> Design {
    let background = |which| Column::Background { which, prior_sd: PRIOR_SD };
    let effect = |effect, variant| Column::Effect { effect, variant };
    let mut columns: Vec<Column> = RANDOM.map(|random| background(random.background)).to_vec();
    columns.extend([
        background(Background::Clock),
        effect(EffectId::DAWN, 0),
        effect(EffectId::DAWN, 1),
        effect(EffectId::EXERCISE, 0),
        effect(EffectId::RENAL_THRESHOLD, 0),
    ]);
    let steps = by_day.len() * STEPS_PER_DAY;
    let acts = |column: usize, step: usize| f32::from(u8::from(step % COLUMNS == column));
    let residual = |step: usize| {
        let column = step % COLUMNS;
        let own = if column == INSULIN_TIME { by_day[step / STEPS_PER_DAY] } else { 0.0 };
        -amplitudes[column] - own
    };
    let answer: Vec<f32> = (0..STEPS_PER_DAY).map(|step| acts(INSULIN_TIME, step)).collect();
    let bank = UnitBank {
        effect: EffectId::INSULIN_ABSORPTION,
        field: Field::InsulinTime,
        log_sd: 0.18,
        starts: (0..by_day.len()).map(|day| day * STEPS_PER_DAY).collect(),
        answers: vec![answer; by_day.len()],
    };
    Design {
        residuals: (0..steps).map(residual).collect(),
        weights: vec![1.0; steps],
        columns,
        signatures: (0..COLUMNS).map(|c| (0..steps).map(|k| acts(c, k)).collect()).collect(),
        events: HiddenEvents::default(),
        random: vec![bank],
        untried: Vec::new(),
    }
}

/// Amplitudes of which one is not 0.
pub(super) fn only(column: usize, amplitude: f64) -> [f64; COLUMNS] {
    std::array::from_fn(|c| if c == column { amplitude } else { 0.0 })
}

/// A week of a person in whom one column acts.
pub(super) fn week(column: usize, amplitude: f64) -> RoundPerson {
    RoundPerson::of(&design(only(column, amplitude), &[0.0; 7]))
}

/// Does something with a list of effects of the library.
pub(super) fn with_tried<T>(names: &[&str], of: impl FnOnce(&Tried<'_>) -> T) -> T {
    let library: Vec<_> =
        names.iter().map(|name| effects::find(name).expect("in the library")).collect();
    of(&Tried::of(&library))
}
