//! The twin of every person.

use crate::figure::{ErrorPair, error_pairs};
use crate::html::{Column, Html};
use crate::number::{count, optional, significant};
use contract::{TwinRow, TwinsTable};

pub(super) fn body(html: &mut Html, twins: &TwinsTable) {
    let made: Vec<&TwinRow> = twins.people.iter().filter(|p| p.excluded.is_none()).collect();
    let others = match twins.people.len() - made.len() {
        0 => "",
        1 => "; the other is listed below with the reason",
        _ => "; the others are listed below with the reason",
    };
    let verb = if made.len() == 1 || twins.people.len() == 1 { "has" } else { "have" };
    let all = count(twins.people.len(), "person", "people");
    html.paragraph(&format!("{} of {all} {verb} a twin{others}.", made.len()));
    let points = twins.people.iter();
    let points = points.filter_map(|p| Some((&*p.person_id, p.rmse_population?, p.rmse_twin?)));
    let points: Vec<ErrorPair<'_>> = points.collect();
    let titles = [
        "Error of each twin against the population model",
        "RMSE of the population network (mg/dL)",
        "RMSE of the twin (mg/dL)",
    ];
    let shown = html.figure(
        error_pairs(titles, ["population network", "twin"], &points),
        "Error on the test windows, one mark a person. Marks below the line are people whose twin \
         is closer than the population network; marks above it are people whom the twin made \
         worse. A person's values show under a pointer.",
    );
    if !shown {
        html.absent("No person has an error of both the population network and the twin.");
    }
    html.rows(
        "Twins by person",
        &made,
        &[
            ("Person", Column::Text, &|p| p.person_id.clone()),
            ("Windows, training", Column::Number, &|p| p.windows_train.to_string()),
            ("Windows, test", Column::Number, &|p| p.windows_test.to_string()),
            ("First loss, scaled units", Column::Number, &|p| significant(p.loss_first)),
            ("Last loss, scaled units", Column::Number, &|p| significant(p.loss_last)),
            ("RMSE population, mg/dL", Column::Number, &|p| optional(p.rmse_population, 1)),
            ("RMSE twin, mg/dL", Column::Number, &|p| optional(p.rmse_twin, 1)),
        ],
    );
}
