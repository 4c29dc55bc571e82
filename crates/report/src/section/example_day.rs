//! One day of one person, measured and simulated.

use crate::html::Html;
use crate::{Inputs, ReportError, figure};

pub(super) fn body(inputs: &Inputs) -> Result<Html, ReportError> {
    let mut html = Html::default();
    let drawn = inputs
        .example_day
        .as_ref()
        .map(|day| Ok::<_, ReportError>((day, figure::example_day(day)?)));
    match drawn.transpose()? {
        Some((day, Some((svg, keys)))) => {
            let caption = format!(
                "Person {}, {}. Above, glucose: compare each broken line with the solid sensor line. \
                 Middle, what was given. Below, what the twin knows besides: heart rate and sleep. \
                 Gaps are missing data.",
                day.person_id, day.date
            );
            html.figure(&svg, &keys, &caption);
        }
        _ => {
            html.absent("There is no example day in this folder.");
        }
    }
    Ok(html)
}
