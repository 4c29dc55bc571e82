//! Every person: a fold with profile and times in ranges, or a row where there are many.

use crate::html::{Column, Html};
use crate::number::{count, ends, fixed, optional};
use crate::{Inputs, ReportError, figure};
use contract::GlucoseByPerson;
use contract::glucose_by_person::PersonGlucose;

/// People beyond whom nobody has a fold of their own.
const FOLDS: usize = 40;

pub(super) fn body(glucose: &GlucoseByPerson, inputs: &Inputs) -> Result<Html, ReportError> {
    let mut html = Html::default();
    if glucose.people.is_empty() {
        html.absent("Nobody has two readings that are in use.");
        return Ok(html);
    }
    overview(&mut html, glucose);
    if glucose.people.len() > FOLDS {
        html.paragraph(&format!(
            "Profiles by time of day are drawn for {FOLDS} people at most; those of all {} stand in \
             glucose_by_person.json.",
            glucose.people.len()
        ));
        return Ok(html);
    }
    for person in &glucose.people {
        let name = format!("Glucose of {} by time of day", person.person_id);
        let mut fold = Html::default();
        fold.push(&Html::ranges(&person.ranges));
        let caption = format!(
            "Ambulatory glucose profile of {}: the median by time of day, with the middle half and the \
             middle nine tenths of all days. Dashed: 70 and 180 mg/dL.",
            person.person_id
        );
        fold.figure(figure::agp(&name, &glucose.hour, &person.percentiles, None)?, &caption);
        amounts(&mut fold, person, inputs);
        let says = format!(
            "{}: TIR {}\u{a0}%, mean {} mg/dL",
            person.person_id,
            fixed(person.ranges.from_70_to_180, 0),
            fixed(person.mean_mg_dl, 0)
        );
        html.folded(&says, &fold);
    }
    Ok(html)
}

/// One row a person.
fn overview(html: &mut Html, glucose: &GlucoseByPerson) {
    let rows: Vec<(bool, Vec<Html>)> = glucose
        .people
        .iter()
        .map(|person| {
            let number = |value: f64, digits: usize| Html::of_text(&fixed(value, digits));
            let ranges = &person.ranges;
            let cells = vec![
                Html::of_text(&person.person_id),
                Html::ranges_bar(ranges),
                number(ranges.below_54 + ranges.from_54_to_70, 1),
                number(ranges.from_70_to_180, 1),
                number(ranges.from_180_to_250 + ranges.above_250, 1),
                number(person.mean_mg_dl, 0),
                number(person.cv, 0),
                number(person.gmi, 1),
                Html::of_text(&optional(person.insulin_u_day, 1)),
                Html::of_text(&optional(person.carbs_g_day, 0)),
            ];
            (false, cells)
        })
        .collect();
    html.table_of(
        &format!("Measured glucose of {}", count(rows.len(), "person", "people")),
        &[
            ("Person", Column::Text),
            ("Below, in and above range", Column::Text),
            ("TBR, %", Column::Number),
            ("TIR, %", Column::Number),
            ("TAR, %", Column::Number),
            ("Mean, mg/dL", Column::Number),
            ("CV, %", Column::Number),
            ("GMI, %", Column::Number),
            ("Insulin, U/day", Column::Number),
            ("Carbohydrate, g/day", Column::Number),
        ],
        &rows,
    );
}

/// What else is known of the person, in a sentence or two.
fn amounts(html: &mut Html, person: &PersonGlucose, inputs: &Inputs) {
    let mut text = format!(
        "{}, CV {}\u{a0}%, GMI {}\u{a0}%.",
        count(person.readings, "reading", "readings"),
        fixed(person.cv, 0),
        fixed(person.gmi, 1)
    );
    let in_use = inputs.data_in_use.iter().flat_map(|data| &data.people);
    if let Some(used) = in_use.into_iter().find(|used| used.person_id == person.person_id) {
        let days = used.days.saturating_sub(used.days_left_out.len());
        text.push_str(&format!(" {days} of {} in use.", count(used.days, "day", "days")));
    }
    let effects = inputs.diagnosis.iter().flat_map(|diagnosis| &diagnosis.effects);
    for effect in effects {
        let Some(own) = effect.people.iter().find(|own| own.person_id == person.person_id) else {
            continue;
        };
        text.push_str(&format!(
            " {}: {}{} times the published size.",
            super::words::sentence(&super::words::effect(&effect.effect)),
            fixed(own.amplitude, 2),
            ends(own.lower, own.upper, 2)
        ));
    }
    html.paragraph(&text);
}
