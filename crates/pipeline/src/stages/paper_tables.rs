//! The paper's result tables as text, with what they leave out.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::PathBuf;

use ::report::count;
use anyhow::{Context as _, Result};
use contract::WhatIf;
use contract::outcomes::{MethodRows, OutcomeRow, OutcomesTable};
use contract::what_if::WhatIfOrder;
use nn_statespace::{PopulationModel, Widths};
use physiology::Compartment;

/// Width of a column.
const COLUMN: usize = 24;

/// Every table of the paper: widths of a population network, then the texts of the stages, of which some
/// may not have run.
pub(crate) fn all(model: &PopulationModel, parts: &[PathBuf]) -> Result<String> {
    let mut text = widths(model);
    for part in parts {
        if part.is_file() {
            let found = std::fs::read_to_string(part)
                .with_context(|| format!("cannot read '{}'", part.display()))?;
            let _ = write!(text, "\n{}\n\n{}\n", "-".repeat(72), found.trim_end());
        } else {
            let _ = writeln!(text, "\n'{}' was not made", part.display());
        }
    }
    Ok(text)
}

/// Units of the hidden layers, the paper's beside them.
fn widths(model: &PopulationModel) -> String {
    let mut text = format!(
        "Hidden units (paper, Table 'best_archs')\n{:<5}{:>6}{:>7}\n",
        "net", "here", "paper"
    );
    let paper = Widths::paper();
    for compartment in Compartment::ALL {
        let here = model.network(compartment).b1().len();
        let _ = writeln!(text, "{:<5}{here:>6}{:>7}", compartment.name(), paper.of(compartment));
    }
    let layers = twins::HIDDEN.map(|units| units.to_string()).join("-");
    let _ = writeln!(text, "residual network of a twin: {layers} (the paper's)");
    text
}

/// Every table of an evaluation.
///
/// `candidates` says of whom the closest virtual patient was taken.
pub(crate) fn text(
    table: &OutcomesTable,
    candidates: Option<&str>,
    answers: &WhatIf,
    constrained: Option<&WhatIf>,
) -> String {
    let mut text = format!(
        "Cohort '{}': {} judged, {} left out, {} windows of {} min\n",
        table.cohort,
        count(table.people, "person", "people"),
        table.exclusions.len(),
        table.windows,
        table.window_minutes
    );
    for out in &table.exclusions {
        let _ = writeln!(text, "  left out: {}: {}", out.person_id, out.reason);
    }
    text.push_str(
        "\nOutcomes (paper, Table 'overall_glucoseOutcomes'): mean \u{b1} SD over people, \
         p of equivalence (* below 0.05; ^ so few people could not show it). 'training days' is the sensor \
         on these in place of a method:\nwhat is not equivalent there changes too much from week to week\n",
    );
    outcomes(&mut text, Some(&table.training_days), &table.methods);
    if let Some(candidates) = candidates {
        let _ = writeln!(text, "closest: of {candidates}");
    }
    comparisons(&mut text, table);
    if !table.ablation.is_empty() {
        text.push_str("\nTwins with other personal inputs, all windows\n");
        outcomes(&mut text, None, &table.ablation);
    }
    for scenario in &table.scenarios {
        let _ = writeln!(
            text,
            "\nScenario (paper, Table 'inputsContributions'): {}: {}, {}",
            scenario.label,
            count(scenario.people, "person", "people"),
            count(scenario.windows, "window", "windows")
        );
        if scenario.methods.is_empty() {
            text.push_str("fewer than two people have such windows\n");
        } else {
            outcomes(&mut text, None, &scenario.methods);
        }
    }
    forecast(&mut text, table);
    order(&mut text, "twins", answers);
    if let Some(constrained) = constrained {
        order(&mut text, "twins that keep physiology's signs", constrained);
    }
    text
}

/// Outcomes down, methods across, as the paper has them; what the training days tell comes first.
fn outcomes(text: &mut String, training_days: Option<&[OutcomeRow]>, methods: &[MethodRows]) {
    let Some(first) = methods.first() else { return };
    // A column's head, rows and foot.
    let days = training_days.map(|rows| ("training days", rows, String::new()));
    let columns = days.into_iter().chain(methods.iter().map(|method| {
        let rmse = format!("{:.1} \u{b1} {:.1}", method.rmse_5h.mean, method.rmse_5h.sd);
        (method.name.as_str(), method.rows.as_slice(), rmse)
    }));
    let columns: Vec<(&str, &[OutcomeRow], String)> = columns.collect();
    let _ = write!(text, "{:<6}{:<16}", "", "actual");
    for (head, ..) in &columns {
        let _ = write!(text, "{head:<COLUMN$}");
    }
    text.push('\n');
    for (index, row) in first.rows.iter().enumerate() {
        let actual = format!("{:.1} \u{b1} {:.1}", row.actual.mean, row.actual.sd);
        let _ = write!(text, "{:<6}{actual:<16}", row.metric.to_uppercase());
        for row in columns.iter().filter_map(|(_, rows, _)| rows.get(index)) {
            cell(text, row);
        }
        text.push('\n');
    }
    let _ = write!(text, "{:<6}{:<16}", "RMSE", "");
    for (.., rmse) in &columns {
        let _ = write!(text, "{rmse:<COLUMN$}");
    }
    text.push('\n');
}

fn cell(text: &mut String, row: &OutcomeRow) {
    let mark = match (row.equivalent, row.p_unbiased < 0.05) {
        (true, _) => "*",
        (false, true) => "",
        (false, false) => "^",
    };
    let (mean, sd) = (row.simulated.mean, row.simulated.sd);
    let cell = format!("{mean:.1} \u{b1} {sd:.1} ({}{mark})", p(row.p));
    let _ = write!(text, "{cell:<COLUMN$}");
}

fn p(p: f64) -> String {
    if p < 0.001 { "<0.001".to_owned() } else { format!("{p:.3}") }
}

fn comparisons(text: &mut String, table: &OutcomesTable) {
    let _ = writeln!(
        text,
        "\nFive-hour RMSE, first minus second, mg/dL, {:.0} % interval over people, p of the signed-rank \
         test, and adjusted for all of the same first method (Holm)",
        100.0 * table.interval.level
    );
    for row in &table.comparisons {
        let (d, p, p_holm) = (row.difference, p(row.p), p(row.p_holm));
        let _ = writeln!(
            text,
            "  {:<16} - {:<24} {:>7.1} ({:.1} to {:.1})  p {p}  {p_holm}",
            row.first, row.second, d.value, d.lower, d.upper
        );
    }
}

fn forecast(text: &mut String, table: &OutcomesTable) {
    text.push_str(
        "\nForecast RMSE, mg/dL, mean \u{b1} SD over people (their number, where not all)\n",
    );
    let minutes: BTreeSet<u32> = table.forecast.iter().map(|row| row.minutes).collect();
    let mut methods: Vec<&str> = Vec::new();
    for row in &table.forecast {
        if !methods.contains(&row.method.as_str()) {
            methods.push(&row.method);
        }
    }
    let _ = write!(text, "{:<18}", "");
    for minutes in &minutes {
        let _ = write!(text, "{:<16}", format!("{minutes} min"));
    }
    text.push('\n');
    for method in methods {
        let _ = write!(text, "{method:<18}");
        for minutes in &minutes {
            let mut rows = table.forecast.iter();
            let row = rows.find(|row| row.method == method && row.minutes == *minutes);
            let cell = row.map_or_else(String::new, |row| {
                let of_all = row.people == table.people;
                let of = if of_all { String::new() } else { format!(" ({})", row.people) };
                format!("{:.1} \u{b1} {:.1}{of}", row.rmse.mean, row.rmse.sd)
            });
            let _ = write!(text, "{cell:<16}");
        }
        text.push('\n');
    }
}

fn order(text: &mut String, whose: &str, answers: &WhatIf) {
    let ordered = answers.order.iter().filter(|row| row.ordered).count();
    let _ = writeln!(
        text,
        "\nWhat-if order of {whose} (less insulin never means less glucose): holds for {ordered} of {}; \
         peaks grow with meals for {}",
        answers.order.len(),
        answers.order.iter().filter(|row| row.peaks_grow_with_meals).count()
    );
    for row in answers.order.iter().filter(|row| !row.ordered) {
        let out_of_order = match row.worst_mg_dl > WhatIfOrder::SAME_MG_DL {
            true => format!("out of order by {:.1} mg/dL ({})", row.worst_mg_dl, row.worst_at),
            false => "mean glucose does not grow with the ratio".to_owned(),
        };
        let _ = writeln!(text, "  {}: not to be used for what-ifs: {out_of_order}", row.person_id);
    }
}
