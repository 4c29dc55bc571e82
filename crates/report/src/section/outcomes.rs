//! The six outcomes of every method with margins and tests, and forecast errors.

mod crossed;

use self::crossed::{EQUIVALENT, TOO_FEW, crossed, digits};
use crate::distinct::distinct;
use crate::figure::equivalence;
use crate::html::{Column, Html};
use crate::number::{ABSENT, compact, count, fixed, interval, p_value, spread};
use contract::outcomes::{Comparison, MethodRows, OutcomeRow};
use contract::{OutcomesTable, Spread};

pub(super) fn body(html: &mut Html, outcomes: &OutcomesTable) {
    html.paragraph(&format!(
        "{} and {} of {} min, outcomes averaged over the windows of each person. Equivalence is \
         concluded where both one-sided paired t-tests reject at 0.05.",
        count(outcomes.people, "person", "people"),
        count(outcomes.windows, "window", "windows"),
        outcomes.window_minutes
    ));
    let shown = html.figure(
        equivalence(&outcomes.methods),
        "Simulated minus recorded with 90 % intervals, in units of the equivalence margin. An \
         outcome is equivalent where the whole interval lies in the shaded band. Values \
         beyond four margins are drawn at the edge; the tables have them in full.",
    );
    if !shown {
        html.absent("No outcome was tested.");
    }
    overall(html, outcomes);
    if !outcomes.ablation.is_empty() {
        html.element("h3", "Twins that see other personal inputs");
        table(html, "Twins by what they see, all windows", &judged(&outcomes.ablation));
    }
    for scenario in &outcomes.scenarios {
        html.element("h3", &format!("Windows that begin with: {}", scenario.label));
        html.paragraph(&format!(
            "{} and {}.",
            count(scenario.people, "person", "people"),
            count(scenario.windows, "window", "windows")
        ));
        if scenario.methods.is_empty() {
            html.absent("Fewer than two people have such windows, so nothing was tested.");
        } else {
            table(html, &scenario.label, &judged(&scenario.methods));
        }
    }
    if !outcomes.scenarios.is_empty() {
        html.element("h3", "Forecasts and comparisons");
    }
    forecast(html, outcomes);
    comparisons(html, outcomes);
}

/// Most methods that stand side by side.
const ACROSS: usize = 6;

/// The content of a column: a method, or the training days in place of one.
struct Judged<'a> {
    label: &'a str,
    rows: &'a [OutcomeRow],
    rmse_5h: Option<Spread>,
}

fn judged(methods: &[MethodRows]) -> Vec<Judged<'_>> {
    let judged = methods.iter().map(|method| Judged {
        label: &method.label,
        rows: &method.rows,
        rmse_5h: Some(method.rmse_5h),
    });
    judged.collect()
}

/// Every method over all windows, after the result of the training days themselves.
fn overall(html: &mut Html, outcomes: &OutcomesTable) {
    let mut all = judged(&outcomes.methods);
    if !outcomes.training_days.is_empty() {
        html.paragraph(
            "\u{201c}Training days\u{201d} is the sensor on these in the place of a method. An outcome that is \
             not equivalent there changes too much from week to week to be asked of a simulator that was \
             fitted to these days.",
        );
        let rows = &outcomes.training_days;
        all.insert(0, Judged { label: "Training days", rows, rmse_5h: None });
    }
    table(html, "Outcomes of every method, all windows", &all);
}

/// Methods over the same windows: one crossed table, and the differences of each method, folded.
fn table(html: &mut Html, what: &str, methods: &[Judged<'_>]) {
    let Some(table) = crossed(methods) else { return };
    // More methods than outcomes stand below each other, so that the page need not scroll.
    let table = if methods.len() > ACROSS { table.transposed("Method") } else { table };
    let rows = || methods.iter().flat_map(|method| method.rows);
    let mut caption =
        format!("{what}: mean \u{b1} SD over people, and p of equivalence within the margin");
    if rows().any(|row| row.equivalent) {
        caption.push_str(&format!("; {EQUIVALENT} and bold: equivalent"));
    }
    if rows().any(OutcomeRow::cannot_be_shown) {
        caption.push_str(&format!(
            "; {TOO_FEW}: so few people, scattered so much, could not have shown equivalence even of a \
             method without any bias"
        ));
    }
    html.crossed(&caption, &table);
    html.folded("Differences with their intervals, method by method", |html| {
        for method in methods {
            differences(html, method);
        }
    });
}

/// Differences of one method.
fn differences(html: &mut Html, method: &Judged<'_>) {
    let rows = method.rows.iter().map(|row| {
        let digits = digits(row);
        let name = row.metric.to_uppercase();
        let verdict = match (row.equivalent, row.cannot_be_shown()) {
            (true, _) => "yes",
            (false, true) => "not shown; too few people",
            (false, false) => "not shown",
        };
        let tested = row.difference_t;
        let cells = vec![
            if row.unit.is_empty() { name } else { format!("{name} ({})", row.unit) },
            spread(row.actual, digits),
            spread(row.simulated, digits),
            interval(row.difference, digits),
            format!("{} to {}", fixed(tested.lower, digits), fixed(tested.upper, digits)),
            format!("\u{b1}{}", compact(row.margin)),
            p_value(row.p),
            p_value(row.p_unbiased),
            verdict.to_owned(),
        ];
        (row.equivalent, cells)
    });
    html.table(
        &format!("{}: mean \u{b1} SD over people; bold: equivalent", method.label),
        &[
            ("Outcome", Column::Text),
            ("Records", Column::Number),
            ("Simulated", Column::Number),
            ("Difference (90 % interval)", Column::Number),
            ("Interval of the test", Column::Number),
            ("Margin", Column::Number),
            ("p (TOST)", Column::Number),
            ("p without bias", Column::Number),
            ("Equivalent", Column::Text),
        ],
        rows.collect(),
    );
}

/// Forecast errors: one row per method, one column per horizon.
fn forecast(html: &mut Html, outcomes: &OutcomesTable) {
    if outcomes.forecast.is_empty() {
        html.absent("No forecast was evaluated.");
        return;
    }
    let mut horizons: Vec<u32> = outcomes.forecast.iter().map(|row| row.minutes).collect();
    horizons.sort_unstable();
    horizons.dedup();
    let methods = distinct(outcomes.forecast.iter().map(|row| row.method.as_str()));
    let rows = methods.into_iter().map(|method| {
        let mut cells = vec![label(outcomes, method)];
        cells.extend(horizons.iter().map(|minutes| {
            let mut rows = outcomes.forecast.iter();
            match rows.find(|row| row.method == method && row.minutes == *minutes) {
                None => ABSENT.to_owned(),
                Some(row) if row.people == outcomes.people => spread(row.rmse, 1),
                Some(row) => format!("{} ({})", spread(row.rmse, 1), row.people),
            }
        }));
        (false, cells)
    });
    let titles: Vec<String> = horizons.iter().map(|m| format!("{m} min")).collect();
    let mut columns = vec![("Method", Column::Text)];
    columns.extend(titles.iter().map(|title| (title.as_str(), Column::Number)));
    html.table(
        "Forecast RMSE, mg/dL, mean \u{b1} SD over people (their number, where not all)",
        &columns,
        rows.collect(),
    );
}

/// Two methods within people: a table for each first method and quantity.
fn comparisons(html: &mut Html, outcomes: &OutcomesTable) {
    for compared in outcomes.comparisons.chunk_by(|a, b| shared(a) == shared(b)) {
        let level = fixed(100.0 * outcomes.interval.level, 0);
        let (first, quantity, unit) = shared(&compared[0]);
        let caption = format!(
            "{} minus other methods within people, {quantity} ({unit}); bold: the interval leaves out \
             zero; p (Holm): adjusted for all comparisons of this table",
            label(outcomes, first)
        );
        html.marked_rows(
            &caption,
            compared,
            |row| row.difference.upper < 0.0 || row.difference.lower > 0.0,
            &[
                ("Other", Column::Text, &|row| label(outcomes, &row.second)),
                (&format!("Difference ({level} % interval)"), Column::Number, &|row| {
                    interval(row.difference, 1)
                }),
                ("p (signed rank)", Column::Number, &|row| p_value(row.p)),
                ("p (Holm)", Column::Number, &|row| p_value(row.p_holm)),
            ],
        );
    }
}

/// The caption of a table of comparisons, which leaves space for the rest on a phone.
fn shared(row: &Comparison) -> (&str, &str, &str) {
    (&row.first, &row.quantity, &row.unit)
}

/// Readable name of a method, or its key if it is not among the methods.
fn label(outcomes: &OutcomesTable, name: &str) -> String {
    let mut judged = outcomes.methods.iter().chain(&outcomes.ablation);
    let known = judged.find(|method| method.name == name).map(|method| method.label.as_str());
    let other = match name {
        "persistence" => "Last reading held",
        "linear" => "Linear extrapolation",
        "arx" => "ARX",
        _ => name,
    };
    known.unwrap_or(other).to_owned()
}
