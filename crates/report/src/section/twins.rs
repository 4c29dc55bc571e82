//! The twin of every person.

use crate::figure::ErrorPair;
use crate::html::{Column, Html};
use crate::number::{count, optional, significant};
use crate::{Inputs, ReportError, figure};

pub(super) fn body(inputs: &Inputs) -> Result<Html, ReportError> {
    let mut html = Html::default();
    let Some(twins) = &inputs.twins else {
        html.absent("There are no twins in this folder.");
        return Ok(html);
    };
    let made = twins.people.iter().filter(|person| person.excluded.is_none()).count();
    let others = match twins.people.len() - made {
        0 => "",
        _ => "; the others are listed below with the reason",
    };
    html.paragraph(&format!(
        "{} trained for {}{others}.",
        count(made, "twin was", "twins were"),
        count(twins.people.len(), "person", "people")
    ));
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
    if let Some((svg, keys)) = figure::error_pairs(titles, ["population network", "twin"], &points)?
    {
        html.figure(
            &svg,
            &keys,
            "Error on the test windows, one mark a person. Marks below the line are people whose twin \
             is closer than the population network; marks above it are people whom the twin made \
             worse. A person's values show under a pointer.",
        );
    } else {
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
                ("First loss", Column::Number),
                ("Last loss", Column::Number),
                ("RMSE population, mg/dL", Column::Number),
                ("RMSE twin, mg/dL", Column::Number),
            ],
            &rows,
        );
    }
    Ok(html)
}
