//! Large meals counted as smaller than they are: logged = k eaten^(1 / (1 + size)).
//!
//! Counts err more for larger meals (Brazeau et al. 2013: 20.9 % on average, large meals
//! underestimated). `k` keeps the mean of the log, so that no common factor on carbohydrate
//! corrects it.

use cohort::{Channel, Record};

use super::meals::logged;

/// Changes every entry of the log.
pub(super) fn plant(record: &mut Record, size: f64) {
    let eaten = logged(record, 0.0);
    let counted = |grams: f64| grams.powf(1.0 / (1.0 + size));
    let total: f64 = eaten.iter().map(|meal| meal.1).sum();
    let by_count: f64 = eaten.iter().map(|meal| counted(meal.1)).sum();
    if by_count <= 0.0 {
        return;
    }
    let carbs = record.channel_mut(Channel::Carbs);
    for (step, grams) in eaten {
        carbs[step] = Some(total / by_count * counted(grams));
    }
}
