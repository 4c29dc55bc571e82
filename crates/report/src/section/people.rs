//! Every person: a fold with profile and times in ranges, or a row where there are many.

use super::words::{effect, sentence};
use crate::html::{Column, Html};
use crate::number::{count, ends, fixed, optional};
use crate::{Inputs, figure};
use contract::GlucoseByPerson;
use contract::glucose_by_person::PersonGlucose;

/// People beyond whom nobody has a fold of their own.
const FOLDS: usize = 40;

pub(super) fn body(html: &mut Html, (glucose, inputs): (&GlucoseByPerson, &Inputs)) {
    if glucose.people.is_empty() {
        html.absent("Nobody has two readings that are in use.");
        return;
    }
    overview(html, glucose);
    if glucose.people.len() > FOLDS {
        html.paragraph(&format!(
            "Profiles by time of day are drawn for {FOLDS} people at most; those of all {} stand in \
             glucose_by_person.json.",
            glucose.people.len()
        ));
        return;
    }
    for person in &glucose.people {
        let id = &person.person_id;
        let says = format!(
            "{id}: TIR {}\u{a0}%, mean {} mg/dL",
            fixed(person.ranges.from_70_to_180, 0),
            fixed(person.mean_mg_dl, 0)
        );
        html.folded(&says, |html| {
            html.push(&Html::ranges(&person.ranges));
            let name = format!("Glucose of {id} by time of day");
            let caption = format!(
                "Ambulatory glucose profile of {id}: the median by time of day, with the middle half and the \
                 middle nine tenths of all days. Dashed: 70 and 180 mg/dL."
            );
            html.figure(figure::agp(&name, &glucose.hour, &person.percentiles, None), &caption);
            html.paragraph(&amounts(person, inputs));
        });
    }
}

/// One row a person.
fn overview(html: &mut Html, glucose: &GlucoseByPerson) {
    html.rows(
        &format!("Measured glucose of {}", count(glucose.people.len(), "person", "people")),
        &glucose.people,
        &[
            ("Person", Column::Text, &|p| Html::from(p.person_id.clone())),
            ("Below, in and above range", Column::Text, &|p| Html::ranges_bar(&p.ranges)),
            ("TBR, %", Column::Number, &|p| {
                Html::from(fixed(p.ranges.below_54 + p.ranges.from_54_to_70, 1))
            }),
            ("TIR, %", Column::Number, &|p| Html::from(fixed(p.ranges.from_70_to_180, 1))),
            ("TAR, %", Column::Number, &|p| {
                Html::from(fixed(p.ranges.from_180_to_250 + p.ranges.above_250, 1))
            }),
            ("Mean, mg/dL", Column::Number, &|p| Html::from(fixed(p.mean_mg_dl, 0))),
            ("CV, %", Column::Number, &|p| Html::from(fixed(p.cv, 0))),
            ("GMI, %", Column::Number, &|p| Html::from(fixed(p.gmi, 1))),
            ("Insulin, U/day", Column::Number, &|p| Html::from(optional(p.insulin_u_day, 1))),
            ("Carbohydrate, g/day", Column::Number, &|p| Html::from(optional(p.carbs_g_day, 0))),
        ],
    );
}

/// What else is known of the person, in a sentence or two.
fn amounts(person: &PersonGlucose, inputs: &Inputs) -> String {
    let mut text = format!(
        "{}, CV {}\u{a0}%, GMI {}\u{a0}%.",
        count(person.readings, "reading", "readings"),
        fixed(person.cv, 0),
        fixed(person.gmi, 1)
    );
    let mut in_use = inputs.data_in_use.iter().flat_map(|data| &data.people);
    if let Some(used) = in_use.find(|used| used.person_id == person.person_id) {
        let days = used.days.saturating_sub(used.days_left_out.len());
        text.push_str(&format!(" {days} of {} in use.", count(used.days, "day", "days")));
    }
    for found in inputs.diagnosis.iter().flat_map(|diagnosis| &diagnosis.effects) {
        if let Some(own) = found.people.iter().find(|own| own.person_id == person.person_id) {
            text.push_str(&format!(
                " {}: {}{} times the published size.",
                sentence(&effect(&found.effect)),
                fixed(own.amplitude, 2),
                ends(own.lower, own.upper, 2)
            ));
        }
    }
    text
}
