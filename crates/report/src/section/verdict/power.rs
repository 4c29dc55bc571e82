//! Which effects would have been found.

use super::POWER;
use crate::number::{fixed, percent};
use crate::section::words::{effect, list};
use contract::Diagnosis;

/// From which shift on effects would have been found, and which effects would not have been found
/// at any.
pub(super) fn would_have_been_found(diagnosis: &Diagnosis) -> Option<String> {
    let mut names: Vec<&str> = Vec::new();
    for row in &diagnosis.power {
        if !names.contains(&row.effect.as_str()) {
            names.push(&row.effect);
        }
    }
    let (mut largest, mut never): (Option<f64>, Vec<String>) = (None, Vec::new());
    for name in names {
        let least = least_found(diagnosis, name);
        match least {
            Some(shift) => largest = Some(largest.map_or(shift, |known| known.max(shift))),
            None => never.push(effect(name)),
        }
    }
    let found = largest.map(|shift| {
        format!(
            "Effects that move glucose by at least {} mg/dL would have been found with {} \
             probability.",
            fixed(shift, if shift.fract() == 0.0 { 0 } else { 1 }),
            percent(POWER)
        )
    });
    let not = (!never.is_empty()).then(|| {
        let also =
            if found.is_some() { "This does not hold for" } else { "There was no such power for" };
        format!("{also} {}, at any size that was tried.", list(&never))
    });
    let both: Vec<String> = [found, not].into_iter().flatten().collect();
    (!both.is_empty()).then(|| both.join(" "))
}

/// The smallest shift from which every tested larger one has the power.
fn least_found(diagnosis: &Diagnosis, name: &str) -> Option<f64> {
    let mut rows: Vec<(f64, f64)> = diagnosis
        .power
        .iter()
        .filter(|row| row.effect == name)
        .map(|row| (row.shift_mg_dl, row.power))
        .collect();
    rows.sort_by(|a, b| b.0.total_cmp(&a.0));
    rows.iter().take_while(|(_, power)| *power >= POWER).last().map(|(shift, _)| *shift)
}
