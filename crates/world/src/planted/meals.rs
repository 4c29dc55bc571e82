//! What a log says about meals.

use cohort::{Channel, Record};

/// Least carbohydrate of a meal, g; smaller entries are snacks or corrections of a low.
pub(super) const LEAST_MEAL: f64 = 15.0;

/// Steps and grams of the logged carbohydrate of at least `least` g, above 0.
pub(super) fn logged(record: &Record, least: f64) -> Vec<(usize, f64)> {
    let entries = record.carbs().iter().enumerate();
    entries
        .filter_map(|(step, grams)| grams.filter(|grams| *grams > 0.0).map(|grams| (step, grams)))
        .filter(|(_, grams)| *grams >= least)
        .collect()
}

/// Removes what is logged at some steps: they then say "nothing", as any other step does.
pub(super) fn strike(record: &mut Record, steps: impl IntoIterator<Item = usize>) {
    let carbs = record.channel_mut(Channel::Carbs);
    for step in steps {
        carbs[step] = Some(0.0);
    }
}

/// Moves recorded doses of a channel, those for which `which` holds, `earlier` steps back. There
/// they add to what is recorded. A dose stays if its new step lies before the record, or if the
/// channel is not recorded there.
pub(super) fn move_earlier(
    record: &mut Record,
    channel: Channel,
    earlier: impl Fn(usize) -> isize,
) {
    let old = record.channel(channel).to_vec();
    let new = record.channel_mut(channel);
    for (step, dose) in old.iter().enumerate() {
        let Some(dose) = dose.filter(|dose| *dose > 0.0) else { continue };
        let to = step.checked_add_signed(-earlier(step));
        let Some(to) = to.filter(|to| *to != step && matches!(old.get(*to), Some(Some(_)))) else {
            continue;
        };
        new[step] = new[step].map(|left| (left - dose).max(0.0));
        new[to] = new[to].map(|there| there + dose);
    }
}
