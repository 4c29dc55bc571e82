//! Held-out errors of every person before and after.

use super::super::words::ahead;
use crate::figure::ErrorPair;
use crate::html::{Column, Html};
use crate::number::{count, optional};
use crate::{ReportError, figure};
use contract::diagnosis::{HorizonChange, HowFar, PersonChange};

pub(super) fn body(html: &mut Html, how_far: &HowFar) -> Result<(), ReportError> {
    // People have one error for each horizon of a true prediction, in that order.
    let horizons: Vec<&HorizonChange> =
        how_far.horizons.iter().filter(|row| !row.reconstructed).collect();
    if how_far.people.is_empty() || horizons.is_empty() {
        return Ok(());
    }
    let at = |errors: &[Option<f64>], place: usize| errors.get(place).copied().flatten();
    // The horizon shown is the one with the clearest change; ties go to the first.
    let surest = (0..horizons.len()).min_by(|a, b| {
        let of = |place: usize| horizons[place].difference.upper;
        of(*a).total_cmp(&of(*b))
    });
    if let Some(place) = surest {
        let minutes = ahead(horizons[place].minutes);
        let pair =
            |p: &'_ PersonChange| Some((at(&p.mae_before, place)?, at(&p.mae_after, place)?));
        let points: Vec<ErrorPair<'_>> = how_far
            .people
            .iter()
            .filter_map(|person| {
                let (first, second) = pair(person)?;
                Some(ErrorPair { person: &person.person_id, first, second })
            })
            .collect();
        let x = format!("Before, {minutes} ahead (mg/dL)");
        let y = format!("After, {minutes} ahead (mg/dL)");
        let titles = ["Held-out error of every person before and after", &x, &y];
        html.figure(
            figure::error_pairs(titles, ["before", "after"], &points)?,
            "Mean absolute error of every person on held-out days. Marks below the line are \
             people for whom the effects help. A person's values show under a pointer.",
        );
    }
    let mut names = vec!["Person".to_owned(), "Days".to_owned()];
    for horizon in &horizons {
        let minutes = ahead(horizon.minutes);
        names.extend([format!("{minutes}: before"), format!("{minutes}: after")]);
    }
    let columns: Vec<(&str, Column)> = names
        .iter()
        .enumerate()
        .map(|(place, name)| {
            (name.as_str(), if place == 0 { Column::Text } else { Column::Number })
        })
        .collect();
    let rows: Vec<(bool, Vec<String>)> = how_far
        .people
        .iter()
        .map(|p| {
            let mut cells = vec![p.person_id.clone(), p.days.to_string()];
            for place in 0..horizons.len() {
                cells.push(optional(at(&p.mae_before, place), 1));
                cells.push(optional(at(&p.mae_after, place), 1));
            }
            (false, cells)
        })
        .collect();
    let mut table = Html::default();
    table.table("Mean absolute error on held-out days, mg/dL", &columns, &rows);
    let people = count(how_far.people.len(), "person", "people");
    html.folded(&format!("Errors of {people}"), &table);
    Ok(())
}
