//! The figures by hand, "where" and the ceiling of a check, as lines of text.

use contract::blind_check::{BlindCheck, CeilingAtBar, PowerRow, Share, WhereScore};

/// The tables, a line each.
pub(super) fn tables(check: &BlindCheck) -> Vec<String> {
    let mut lines = vec!["by hand, for diagnoses that never saw that hand:".to_owned()];
    lines.extend(blind::hand_table(&check.by_hand).lines().map(|line| format!("  {line}")));
    if let Some(found) = &check.localisation {
        lines.extend(localisation(found));
    }
    lines.extend(ceiling(check));
    lines
}

fn localisation(found: &WhereScore) -> Vec<String> {
    let mut lines = vec![
        "where, in context: one of the answer's three largest cells is truly hot".to_owned(),
        "     truth  comparable worlds                hit   chance         sign right".to_owned(),
    ];
    for row in &found.context {
        let minutes = match row.minutes {
            1440 => "free day".to_owned(),
            minutes => format!("{minutes} min"),
        };
        lines.push(format!(
            "  {minutes:>8} {:>18} {:>18} {:>8} {:>18}",
            counted(&row.comparable),
            counted(&row.hit),
            row.chance.map_or_else(|| "-".to_owned(), |chance| format!("{chance:.2}")),
            counted(&row.sign_right),
        ));
    }
    let held = &found.coverage;
    lines.push(format!(
        "  intervals that hold the true mean (60 min): cells {}, all of a world {}; without an effect {}, {}",
        counted(&held.cells),
        counted(&held.worlds),
        counted(&held.null_cells),
        counted(&held.null_worlds),
    ));
    let port = &found.equations;
    let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |v| format!("{v:.1}"));
    lines.push("where, in the equations: the true port among the answer's".to_owned());
    lines.push(format!(
        "  first {}, with its set {}, among three {}, not listed {}; mean rank {} of {}",
        counted(&port.first),
        counted(&port.first_or_in_set),
        counted(&port.among_three),
        counted(&port.not_listed),
        number(port.mean_rank),
        number(port.mean_listed),
    ));
    let by_port = port.first_by_port.iter();
    let by_port: Vec<String> =
        by_port.map(|(port, first)| format!("{port} {}/{}", first.count, first.of)).collect();
    lines.push(format!("  first, by true port: {}", by_port.join(", ")));
    lines.push(format!(
        "  port of the first effect named {}; amplitude of right names above zero {}; course over the day: {}",
        counted(&port.port_of_first_name),
        counted(&port.sign_of_amplitude),
        if port.course_answered.count == 0 {
            "not answered".to_owned()
        } else {
            counted(&port.course_answered)
        },
    ));
    lines.push(format!(
        "  course at the true port: sign right where it is largest {}, where the answer is certain {}; intervals that hold it {}, all of a day {}",
        counted(&port.course_sign),
        counted(&port.course_sign_if_certain),
        counted(&port.course_parts_held),
        counted(&port.courses_held),
    ));
    lines
}

fn ceiling(check: &BlindCheck) -> Vec<String> {
    let Some(found) = &check.ceiling else { return Vec::new() };
    let mut lines = vec![
        "ceiling: worlds with one effect that are named, and that its exact course would name"
            .to_owned(),
        format!("  {:<28} {:>16} {:>18} {:>18}", "effect", "shift, mg/dL", "named", "ceiling"),
    ];
    for row in &check.power {
        lines.push(format!(
            "  {:<28} {:>16} {:>18} {:>18}",
            row.effect.as_deref().unwrap_or("all"),
            bin(row),
            counted(&row.named),
            row.ceiling.as_ref().map_or_else(|| "-".to_owned(), counted),
        ));
    }
    let ends = found.at_lower_bar.zip(found.at_upper_bar);
    let mut line = |what: &str, answered: &Share, above: &Share, of: fn(CeilingAtBar) -> usize| {
        let between = ends.map_or_else(String::new, |(lower, upper)| {
            format!(" ({} to {})", of(upper), of(lower))
        });
        let (answered, above) = (counted(answered), counted(above));
        lines.push(format!("  {what} {answered}, ceiling {above}{between}"));
    };
    line("from 5 mg/dL: named", &found.answered_at_5, &found.named_at_5, |at| at.named_at_5);
    line("from 10 mg/dL: named", &found.answered_at_10, &found.named_at_10, |at| at.named_at_10);
    let unknown = "outside the library: called unknown";
    line(unknown, &found.answered_unknown, &found.unknown, |at| at.unknown);
    let interval = ends.map_or_else(String::new, |(lower, upper)| {
        format!(" (95 % interval {:.1} to {:.1})", lower.bar_nats, upper.bar_nats)
    });
    lines.push(format!(
        "  above {:.1} nats{interval}: exact courses of effects that do not act {}",
        found.bar_nats,
        counted(&found.false_alarms)
    ));
    lines
}

fn bin(row: &PowerRow) -> String {
    match row.to_mg_dl {
        Some(to) => format!("{} to {to}", row.from_mg_dl),
        None => format!("{} and more", row.from_mg_dl),
    }
}

fn counted(share: &Share) -> String {
    match share.value {
        Some(value) => format!("{}/{} = {value:.2}", share.count, share.of),
        None => "none".to_owned(),
    }
}
