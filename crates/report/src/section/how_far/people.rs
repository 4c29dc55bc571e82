//! Held-out errors of every person before and after.

use super::super::words::ahead;
use crate::figure::{ErrorPair, error_pairs};
use crate::html::{Column, Html};
use crate::number::{count, optional};
use contract::diagnosis::{HorizonChange, HowFar};

pub(super) fn body(html: &mut Html, how_far: &HowFar) {
    // People have one error for each horizon of a true prediction, in that order.
    let horizons: Vec<&HorizonChange> =
        how_far.horizons.iter().filter(|row| !row.reconstructed).collect();
    if how_far.people.is_empty() {
        return;
    }
    // The horizon shown is the one with the clearest change; ties go to the first.
    let upper = |place: &usize| horizons[*place].difference.upper;
    let surest = (0..horizons.len()).min_by(|a, b| upper(a).total_cmp(&upper(b)));
    let Some(place) = surest else { return };
    let at = |errors: &[Option<f64>], place: usize| errors.get(place).copied().flatten();
    let minutes = ahead(horizons[place].minutes);
    let points = how_far.people.iter().filter_map(|person| {
        let (before, after) = (at(&person.mae_before, place)?, at(&person.mae_after, place)?);
        Some((person.person_id.as_str(), before, after))
    });
    let x = format!("Before, {minutes} ahead (mg/dL)");
    let y = format!("After, {minutes} ahead (mg/dL)");
    let titles = ["Held-out error of every person before and after", &x, &y];
    html.figure(
        error_pairs(titles, ["before", "after"], &points.collect::<Vec<ErrorPair<'_>>>()),
        "Mean absolute error of every person on held-out days. Marks below the line are \
         people for whom the effects help. A person's values show under a pointer.",
    );
    let mut names = vec!["Days".to_owned()];
    for horizon in &horizons {
        let minutes = ahead(horizon.minutes);
        names.extend([format!("{minutes}: before"), format!("{minutes}: after")]);
    }
    let mut columns = vec![("Person", Column::Text)];
    columns.extend(names.iter().map(|name| (name.as_str(), Column::Number)));
    let rows = how_far.people.iter().map(|p| {
        let mut cells = vec![p.person_id.clone(), p.days.to_string()];
        for place in 0..horizons.len() {
            let errors = [at(&p.mae_before, place), at(&p.mae_after, place)];
            cells.extend(errors.map(|error| optional(error, 1)));
        }
        (false, cells)
    });
    let people = count(how_far.people.len(), "person", "people");
    html.folded(&format!("Errors of {people}"), |html| {
        html.table("Mean absolute error on held-out days, mg/dL", &columns, rows.collect());
    });
}
