//! Where the gap lies: one figure per factor, one table, and the error by horizon.

mod maps;

use super::verdict::LEVEL;
use super::words::{ahead, context, factor, model};
use crate::figure::{ForestFrame, ForestRow, forest};
use crate::html::{Column, Html};
use crate::number::{ABSENT, fixed, interval, optional, p_value};
use contract::diagnosis::{CellFactor, CellGap};
use contract::{Diagnosis, WithInterval};

/// Factors with a figure, in reading order: key, name of the figure, caption.
const FIGURES: [(CellFactor, &str, &str); 4] = [
    (
        CellFactor::Hour,
        "Mean error by time of day",
        "Mean error by time of day. Read from the dashed line: to its right glucose is \
         under-predicted, to its left over-predicted. Intervals hold for all situations together.",
    ),
    (
        CellFactor::Context,
        "Mean error by situation",
        "Mean error by situation. A filled mark is a situation in which the model is wrong on \
         average; a hollow one is a situation in which the data leave it open.",
    ),
    (
        CellFactor::GlucoseBand,
        "Mean error by glucose band",
        "Mean error by glucose band. An error that rises with glucose is one that the model shrinks \
         towards the middle.",
    ),
    (
        CellFactor::Person,
        "Mean error by person",
        "Mean error by person. Marks on both sides say that people differ, marks on one side that \
         the model misses the same thing in all.",
    ),
];

/// Title of the axis of every figure.
const AXIS: &str = "Observed \u{2212} predicted (mg/dL)";
/// Rows of one figure that a page can hold.
const SHOWN: usize = 40;

pub(super) fn body(html: &mut Html, diagnosis: &Diagnosis) {
    html.paragraph(&format!(
        "The sensor is compared with {}. Where observed \u{2212} predicted is above zero, the model \
         under-predicts glucose.",
        model(&diagnosis.plant)
    ));
    if let Some(hourly) = &diagnosis.hourly {
        maps::maps(html, hourly);
    }
    if diagnosis.cells.is_empty() {
        html.absent("The diagnosis holds no situation in which an error was measured.");
    }
    if diagnosis.hourly.is_some() {
        html.element("h3", "One thing at a time, with intervals");
    }
    for (factor, name, caption) in FIGURES {
        let of_factor = diagnosis.cells.iter().filter(|cell| cell.factor == factor);
        let mut cells: Vec<&CellGap> = of_factor.collect();
        let mut caption = caption.to_owned();
        if cells.len() > SHOWN {
            let all = cells.len();
            caption += &format!(" Shown are the {SHOWN} of {all} with the largest error.");
            let size = |cell: &CellGap| cell.mean_error_mg_dl.abs();
            cells.sort_by(|a, b| size(b).total_cmp(&size(a)));
            cells.truncate(SHOWN);
        }
        match factor {
            CellFactor::Hour => cells.sort_by(|a, b| a.level.cmp(&b.level)),
            CellFactor::GlucoseBand => {
                let rank = |level: &str| ["<70", "70-180", ">180"].iter().position(|l| *l == level);
                cells.sort_by_key(|cell| rank(&cell.level).unwrap_or(usize::MAX));
            }
            _ => cells.sort_by(|a, b| b.mean_error_mg_dl.total_cmp(&a.mean_error_mg_dl)),
        }
        let row = |cell: &CellGap| ForestRow {
            label: level(cell),
            value: mean(cell),
            stands_out: cell.p_adjusted < LEVEL,
        };
        let rows: Vec<ForestRow> = cells.into_iter().map(row).collect();
        html.figure(forest(&ForestFrame::around_zero(name, AXIS), &rows), &caption);
    }
    if !diagnosis.cells.is_empty() {
        html.folded("Every situation in numbers", |html| table(html, &diagnosis.cells));
    }
    html.rows(
        "Error of the calibrated model by horizon, mg/dL, with intervals over people",
        &diagnosis.baseline,
        &[
            ("Min ahead", Column::Number, &|row| row.minutes.to_string()),
            ("Mean absolute error", Column::Number, &|row| interval(row.mae, 1)),
            ("Root mean squared error", Column::Number, &|row| interval(row.rmse, 1)),
            ("Observed \u{2212} predicted", Column::Number, &|row| interval(row.bias, 1)),
        ],
    );
}

/// Its mean error, mg/dL.
fn mean(cell: &CellGap) -> WithInterval {
    WithInterval { value: cell.mean_error_mg_dl, lower: cell.lower, upper: cell.upper }
}

/// A level in words, with its unit.
fn level(cell: &CellGap) -> String {
    match cell.factor {
        CellFactor::Hour => format!("{} h", cell.level),
        CellFactor::GlucoseBand => format!("{} mg/dL", cell.level),
        CellFactor::Context => context(&cell.level),
        CellFactor::Horizon => cell.level.parse().map_or_else(|_| cell.level.clone(), ahead),
        CellFactor::Person => cell.level.clone(),
    }
}

/// Its share of the expected gap; people and horizons have none.
fn share(cell: &CellGap) -> String {
    match cell.factor {
        CellFactor::Person | CellFactor::Horizon => ABSENT.to_owned(),
        _ => format!("{} %", fixed(100.0 * cell.share_of_gap, 1)),
    }
}

fn table(html: &mut Html, cells: &[CellGap]) {
    html.marked_rows(
        "Every situation, first where the posterior expects most of what is missing (share of the expected \
         squared gap; people and horizons have none); errors are measured, bold: they differ from zero at a \
         family-wise level of 0.05",
        cells,
        |cell| cell.p_adjusted < LEVEL,
        &[
            ("Set apart by", Column::Text, &|cell| factor(cell.factor.name())),
            ("Level", Column::Text, &level),
            (
                "Observed \u{2212} predicted, mg/dL (simultaneous interval)",
                Column::Number,
                &|cell| interval(mean(cell), 1),
            ),
            ("Adjusted p", Column::Number, &|cell| p_value(cell.p_adjusted)),
            ("Share of expected gap", Column::Number, &share),
            ("Min ahead", Column::Number, &|cell| cell.horizon_minutes.to_string()),
            ("People", Column::Number, &|cell| cell.people.to_string()),
            ("Expected of what is missing, whole days, mg/dL", Column::Number, &|cell| {
                optional(cell.expected_mg_dl, 1)
            }),
        ],
    );
}
