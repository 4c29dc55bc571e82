//! What twins predict for meals under other doses, and which of them keep the order.

use super::words::list;
use crate::html::{Column, Html};
use crate::number::{compact, count, fixed};
use crate::{Inputs, ReportError, figure};
use contract::WhatIf;
use contract::what_if::WhatIfOrder;

pub(super) fn body(inputs: &Inputs) -> Result<Html, ReportError> {
    let mut html = Html::default();
    if let Some(answers) = &inputs.what_if {
        let name = "Glucose after meals under several doses";
        curves(&mut html, answers, name, ["twin", "twins"])?;
        order(&mut html, "Order of the answers", answers);
    }
    if let Some(answers) = &inputs.what_if_constrained {
        html.element("h3", "Twins that keep physiology's signs");
        let name = "Glucose after meals under several doses, with signs kept";
        let whose = ["twin that keeps physiology's signs", "twins that keep physiology's signs"];
        curves(&mut html, answers, name, whose)?;
        order(&mut html, "Order of the answers of twins that keep physiology's signs", answers);
    }
    Ok(html)
}

/// The courses under the name of their figure; `one` and `many` are what the twins are called.
fn curves(
    html: &mut Html,
    answers: &WhatIf,
    name: &str,
    [one, many]: [&str; 2],
) -> Result<(), ReportError> {
    let caption = caption(answers, &count(answers.order.len(), one, many));
    if !html.figure(figure::what_if(answers, name)?, &caption) {
        html.absent("There is no course of glucose to show.");
    }
    Ok(())
}

fn caption(answers: &WhatIf, of: &str) -> String {
    let first = answers.plan.starts_mg_dl.first().zip(answers.plan.hours.first());
    let circumstances =
        first.map(|(start, hour)| format!(" at {} mg/dL and {hour}:00", compact(*start)));
    format!(
        "Glucose after meals of several sizes, from left to right, taken{} with the bolus that an \
         insulin-to-carbohydrate ratio (g/U) asks for: median (thick) and middle half (shaded) of {of}. \
         A higher ratio means less insulin, so within a panel the line of a higher ratio has to lie \
         above that of a lower one, and from panel to panel the peak has to grow with the meal.",
        circumstances.unwrap_or_default(),
    )
}

/// Glucose difference that the check of the order ignores, mg/dL: below what a sensor resolves.
pub(super) const SAME: f64 = WhatIfOrder::SAME_MG_DL;

/// For how many twins the order holds, and where it does not for the others.
fn order(html: &mut Html, heading: &str, answers: &WhatIf) {
    html.element("h3", heading);
    if answers.order.is_empty() {
        html.absent("The order of the answers was not checked.");
        return;
    }
    let of = answers.order.len();
    let out: Vec<&WhatIfOrder> = answers.order.iter().filter(|twin| !twin.ordered).collect();
    let plan = &answers.plan;
    let starts: Vec<String> = plan.starts_mg_dl.iter().map(|start| compact(*start)).collect();
    let hours: Vec<String> = plan.hours.iter().map(|hour| format!("{hour}:00")).collect();
    let conditions = format!(", checked from {} mg/dL at {}", list(&starts), list(&hours));
    html.paragraph(&format!(
        "Less insulin never means less glucose (by more than {SAME} mg/dL), and mean glucose grows from \
         each ratio to the next, in {} of {}{conditions}.{}",
        of - out.len(),
        count(of, "twin", "twins"),
        if out.is_empty() { "" } else { " The others are not to be used for what-ifs:" }
    ));
    html.rows(
        "Twins that are not to be used for what-ifs, and where more insulin did not mean less glucose",
        &out,
        |_| false,
        &[
            ("Twin", Column::Text, &|twin| twin.person_id.clone()),
            ("Out of order by, mg/dL", Column::Number, &|twin| fixed(twin.worst_mg_dl, 1)),
            ("Worst at", Column::Text, &|twin| match twin.worst_mg_dl > SAME {
                true => twin.worst_at.clone(),
                false => "mean glucose does not grow with the ratio".to_owned(),
            }),
            ("Peak grows with the meal", Column::Text, &|twin| {
                let grows = if twin.peaks_grow_with_meals { "yes" } else { "no" };
                grows.to_owned()
            }),
        ],
    );
    peaks(html, &answers.order);
}

/// In which twins the peak grows with the meal.
fn peaks(html: &mut Html, order: &[WhatIfOrder]) {
    let without: Vec<String> = order
        .iter()
        .filter(|twin| !twin.peaks_grow_with_meals)
        .map(|twin| twin.person_id.clone())
        .collect();
    let mut text = format!(
        "The peak grows with the meal at every ratio in {} of {}",
        order.len() - without.len(),
        count(order.len(), "twin", "twins")
    );
    if !without.is_empty() {
        text.push_str(&format!(
            "; not in {}, where meals are not to be compared with each other",
            list(&without)
        ));
    }
    html.paragraph_of("note", &format!("{text}."));
}
