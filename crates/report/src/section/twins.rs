//! The twin of every person.

use crate::figure::ErrorPair;
use crate::html::{Column, Html};
use crate::number::{count, optional, significant};
use crate::{ReportError, figure};
use contract::TwinsTable;

pub(super) fn body(twins: &TwinsTable) -> Result<Html, ReportError> {
    let mut html = Html::default();
    let made = twins.people.iter().filter(|person| person.excluded.is_none()).count();
    let others = match twins.people.len() - made {
        0 => "",
        1 => "; the other is listed below with the reason",
        _ => "; the others are listed below with the reason",
    };
    let verb = if made == 1 || twins.people.len() == 1 { "has" } else { "have" };
    let all = count(twins.people.len(), "person", "people");
    html.paragraph(&format!("{made} of {all} {verb} a twin{others}."));
    let points: Vec<ErrorPair<'_>> = twins
        .people
        .iter()
        .filter_map(|p| {
            let (first, second) = (p.rmse_population?, p.rmse_twin?);
            Some(ErrorPair { person: &p.person_id, first, second })
        })
        .collect();
    let titles = [
        "Error of each twin against the population model",
        "RMSE of the population network (mg/dL)",
        "RMSE of the twin (mg/dL)",
    ];
    let drawn = figure::error_pairs(titles, ["population network", "twin"], &points)?;
    let shown = html.figure(
        drawn,
        "Error on the test windows, one mark a person. Marks below the line are people whose twin \
         is closer than the population network; marks above it are people whom the twin made \
         worse. A person's values show under a pointer.",
    );
    if !shown {
        html.absent("No person has an error of both the population network and the twin.");
    }
    let rows: Vec<(bool, Vec<String>)> = twins
        .people
        .iter()
        .filter(|person| person.excluded.is_none())
        .map(|person| {
            let cells = vec![
                person.person_id.clone(),
                person.windows_train.to_string(),
                person.windows_test.to_string(),
                significant(person.loss_first),
                significant(person.loss_last),
                optional(person.rmse_population, 1),
                optional(person.rmse_twin, 1),
            ];
            (false, cells)
        })
        .collect();
    if !rows.is_empty() {
        html.table(
            "Twins by person",
            &[
                ("Person", Column::Text),
                ("Windows, training", Column::Number),
                ("Windows, test", Column::Number),
                ("First loss, scaled units", Column::Number),
                ("Last loss, scaled units", Column::Number),
                ("RMSE population, mg/dL", Column::Number),
                ("RMSE twin, mg/dL", Column::Number),
            ],
            &rows,
        );
    }
    Ok(html)
}
