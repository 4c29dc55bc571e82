//! One person's events on the five-minute grid.
//!
//! Times are floored to their step. Readings of a step are averaged; boluses, carbohydrate and
//! steps are summed; a basal rate holds until the next one and a step has the mean over its five
//! minutes. The record spans the first to the last glucose reading; doses outside are counted.

use physiology::STEPS_PER_DAY;

use super::clock::Hour;
use super::log::{Event, Log};
use super::options::Role;
use super::unit::Unit;
use crate::error::{CohortError, Place};
use crate::import::rates::{COVERED, Held, lay, therapy_of, unless_rounding};
use crate::import::report::Imported;
use crate::import::steps::{Span, step_of, time_of};
use crate::person::{Person, Therapy};
use crate::range::{check_value, median};
use crate::record::{Channel, Record, check_span};

/// Longest time a rate holds that is written at its changes alone, s.
const HOLD: i64 = 86_400;
/// Rates that are at most this far apart stand in every row, s; they hold for three rows.
const EVERY_ROW: i64 = 900;
/// Share of rows that differ from the row before, from which rows are changes and no others.
const CHANGES_ALONE: f64 = 0.9;
/// Steps from one amount to the next, zeros among them, up to which an empty cell means that nothing is known.
const DENSE: f64 = 2.0;

/// The person and the account; nobody without a glucose reading.
pub(super) fn person(mut log: Log, basal_unit: Unit) -> Result<Imported, CohortError> {
    for (role, events) in &mut log.events {
        if !events.is_sorted_by_key(|event| event.second) {
            let late = events.windows(2).filter(|pair| pair[1].second < pair[0].second).count();
            // Newest first is a habit of exports and no disorder.
            if late + 1 < events.len() {
                let place = log.columns.get(role).cloned().unwrap_or_default();
                log.account.note(place, "rows earlier than the row above: sorted", late);
            }
            events.sort_by_key(|event| event.second);
        }
    }
    let readings = log.events.get(&Role::Glucose);
    let ends = readings.and_then(|events| Some((events.first()?, events.last()?)));
    let Some((first, last)) = ends else {
        return Ok(Imported { person: None, account: log.account });
    };
    let span = Span { first: step_of(first.second), end: step_of(last.second) + 1 };
    let days = (span.end - span.first) / STEPS_PER_DAY as i64;
    let entries = log.events.values().map(Vec::len).sum();
    check_span(days, entries, &log.account.id, || log.place(Role::Glucose))?;
    let mut record = Record::new(time_of(span.first), span.len())?;
    for role in [Role::Glucose, Role::HeartRate, Role::Sleep] {
        mean(&mut log, role, span, &mut record);
    }
    let mut therapy = Therapy::Unknown;
    if log.events.contains_key(&Role::Basal) {
        therapy = basal(&mut log, basal_unit, span, &mut record)?;
    } else if let (Unit::PerMinutes(_), Some(&amount)) =
        (basal_unit, log.left_out.get(&Role::Basal))
    {
        log.account.total(Channel::Basal, "U", amount, 0.0, amount);
    }
    for (role, unit) in
        [(Role::Bolus, "U"), (Role::Carbs, "g"), (Role::Steps, ""), (Role::SetChange, "")]
    {
        sum(&mut log, role, unit, span, &mut record)?;
    }
    therapy = long_acting(&mut log, therapy);
    let silent = pump_is_silent(&mut record);
    let what = "steps with a basal rate and without a bolus: 0, since the pump was recorded";
    log.note_of(Role::Bolus, what, silent);
    let id = log.account.id.clone();
    let person = Person { id, weight: None, therapy, heart_rate_baseline: None, record };
    Ok(Imported { person: Some(person), account: log.account })
}

/// The mean of each step's readings.
fn mean(log: &mut Log, role: Role, span: Span, record: &mut Record) {
    let (Some(events), Some(channel)) = (log.events.get(&role), role.channel()) else { return };
    let mut sums = vec![(0.0, 0_u32, false); record.len()];
    let (mut outside, mut beside, mut again) = (0, 0, 0);
    // The hour that comes again only fills gaps, so the first one is laid first.
    for second in [false, true] {
        for event in events.iter().filter(|event| (event.hour == Hour::Second) == second) {
            let Some(k) = span.index(step_of(event.second)) else {
                outside += 1;
                continue;
            };
            let (sum, count, of_second) = &mut sums[k];
            if second && *count > 0 && !*of_second {
                again += 1;
                continue;
            }
            beside += usize::from(*count > 0);
            *of_second = second;
            *sum += event.value;
            *count += 1;
        }
    }
    for (cell, (sum, count, _)) in record.channel_mut(channel).iter_mut().zip(sums) {
        *cell = (count > 0).then(|| sum / f64::from(count));
    }
    log.note_of(role, "readings in a step that has another one: averaged", beside);
    log.note_of(role, "readings in the hour that came again: left out", again);
    log.note_of(role, "readings outside the span of glucose: left out", outside);
}

/// The sum of each step's amounts. Where amounts are written only when there is one, a step
/// between the first and the last one without any holds 0.
fn sum(
    log: &mut Log,
    role: Role,
    unit: &str,
    span: Span,
    record: &mut Record,
) -> Result<(), CohortError> {
    let (events, untimed) = (log.events.remove(&role), log.left_out.get(&role).copied());
    if events.is_none() && untimed.is_none() {
        return Ok(());
    }
    let events = events.unwrap_or_default();
    let channel = role.channel().expect("a dose has a channel");
    let (mut source, mut left_out) = (untimed.unwrap_or(0.0), untimed.unwrap_or(0.0));
    let own = match (events.first(), events.last()) {
        (Some(first), Some(last)) => {
            step_of(first.second).max(span.first)..(step_of(last.second) + 1).min(span.end)
        }
        _ => 0..0,
    };
    let (mut written, mut outside, mut more) = (0, 0, 0);
    let cells = record.channel_mut(channel);
    for event in &events {
        source += event.value;
        let Some(k) = span.index(step_of(event.second)) else {
            left_out += event.value;
            outside += 1;
            continue;
        };
        more += usize::from(event.value > 0.0 && cells[k].is_some_and(|amount| amount > 0.0));
        written += usize::from(cells[k].is_none());
        let sum = cells[k].unwrap_or(0.0) + event.value;
        cells[k] = Some(if role == Role::SetChange { sum.min(1.0) } else { sum });
    }
    let steps = usize::try_from((own.end - own.start).max(0)).unwrap_or(0);
    let log_of_events = events.iter().all(|event| event.value > 0.0);
    let apart = events.windows(2).map(|pair| step_of(pair[1].second) - step_of(pair[0].second));
    let apart = apart.filter(|apart| *apart > 0).map(|apart| apart as f64);
    // Where most amounts follow each other closely, longer pauses were not recorded.
    let dense = median(apart.collect()).is_some_and(|apart| apart <= DENSE);
    let sparse = role != Role::Steps && (log_of_events || !dense);
    if sparse {
        for k in own.filter_map(|step| span.index(step)) {
            cells[k].get_or_insert(0.0);
        }
    }
    for (k, value) in cells.iter().enumerate() {
        let Some(value) = value else { continue };
        check_value(channel, *value, false, || {
            let at = time_of(span.first + k as i64);
            Place::file(format!("{}, the step at {at}", log.place(role)))
        })?;
    }
    let kept: f64 = cells.iter().flatten().sum();
    if sparse && steps > 0 {
        let evidence =
            format!("{written} of {steps} steps between the first and the last have one");
        log.infer(role, "written only where there is one; other steps hold 0", evidence);
    }
    log.note_of(role, "amounts in a step that already has one: summed", more);
    log.note_of(role, "amounts outside the span of glucose: left out", outside);
    if !unit.is_empty() {
        log.account.total(channel, unit, source, kept, left_out);
    }
    Ok(())
}

/// Puts the mean rate of each step into the record; the therapy is that of the rates.
fn basal(
    log: &mut Log,
    unit: Unit,
    span: Span,
    record: &mut Record,
) -> Result<Therapy, CohortError> {
    let mut events = log.events.remove(&Role::Basal).unwrap_or_default();
    let (all, mut replaced) = (events.len(), 0.0);
    events.dedup_by(|later, kept| {
        let again = later.second == kept.second;
        if again {
            replaced += kept.value;
            *kept = *later;
        }
        again
    });
    let twice = all - events.len();
    log.note_of(Role::Basal, "rates at one time: the last one of the file holds", twice);
    let rates = rates(log, &events, unit)?;
    for (_, _, u_h) in &rates {
        check_value(Channel::Basal, *u_h, false, || log.place(Role::Basal))?;
    }
    // Amounts whose row gives no rate are part of the source; rates without a time have none.
    let source = match unit {
        Unit::PerMinutes(_) => replaced + log.left_out.get(&Role::Basal).copied().unwrap_or(0.0),
        _ => 0.0,
    };
    let laid = lay(rates.iter().copied(), span, COVERED, source, record);
    log.note_of(Role::Basal, "steps without a rate: not recorded", laid.silent);
    let left_out = unless_rounding(laid.source - laid.kept, laid.source);
    let what = format!("{left_out:.2} U of basal outside the record: left out");
    log.note_of(Role::Basal, &what, usize::from(left_out != 0.0));
    log.account.total(Channel::Basal, "U", laid.source, laid.kept, left_out);
    let Some((therapy, conclusion, evidence)) = therapy_of(&rates) else {
        return Ok(Therapy::Unknown);
    };
    log.infer(Role::Basal, conclusion, evidence);
    Ok(therapy)
}

/// The rates and how long each holds.
fn rates(log: &mut Log, events: &[Event], unit: Unit) -> Result<Vec<Held>, CohortError> {
    let next = |i: usize| events.get(i + 1).map(|event| event.second);
    let gaps = events.windows(2).map(|pair| (pair[1].second - pair[0].second) as f64);
    let gap = median(gaps.collect()).map(|gap| gap as i64);
    if let Unit::PerMinutes(minutes) = unit {
        let seconds = match (minutes, gap) {
            (Some(minutes), _) => (minutes * 60.0).round() as i64,
            (None, Some(gap)) if (60..=3600).contains(&gap) => {
                let evidence = "the usual distance of rows".to_owned();
                log.infer(Role::Basal, &format!("an amount for {} min", gap / 60), evidence);
                gap
            }
            _ => {
                return Err(CohortError::Undecided {
                    place: log.place(Role::Basal),
                    reason: "amounts of basal insulin at irregular times".into(),
                    remedy: "say --unit basal=U/5min or so; map injections as long_acting",
                });
            }
        };
        let rate = |(i, event): (usize, &Event)| {
            // Clocks are not exact: the next row ends an amount that is nearly through.
            let usual = event.second + seconds;
            let near = |next: &i64| (next - usual).abs() * 5 <= seconds || *next < usual;
            let to = next(i).filter(near).unwrap_or(usual);
            let u_h = event.value * 3600.0 / (to - event.second).max(1) as f64;
            (event.second, to, u_h)
        };
        return Ok(events.iter().enumerate().map(rate).collect());
    }
    // A controller's changes may be as close as rows; between two of them the rate still holds.
    let pairs = events.windows(2);
    let changed = pairs.clone().filter(|pair| pair[0].value != pair[1].value).count();
    let paused = |gap| pairs.clone().any(|pair| pair[1].second - pair[0].second > 3 * gap);
    let changes_alone = changed as f64 >= CHANGES_ALONE * pairs.len() as f64;
    let every_row = gap.is_some_and(|gap| gap <= EVERY_ROW && !(changes_alone && paused(gap)));
    let (hold, last) = match gap {
        Some(gap) if every_row => (3 * gap, gap),
        _ => (HOLD, 0),
    };
    let (conclusion, evidence) = if every_row {
        ("a rate in every row", format!("rows {} s apart", gap.unwrap_or(0)))
    } else {
        let evidence = gap.map_or_else(String::new, |gap| format!("rows {} min apart", gap / 60));
        ("rates at their changes: each holds until the next, for a day at most", evidence)
    };
    log.infer(Role::Basal, conclusion, evidence);
    Ok(events
        .iter()
        .enumerate()
        .map(|(i, event)| {
            let to = next(i).map_or(event.second + last, |next| next.min(event.second + hold));
            (event.second, to, event.value)
        })
        .collect())
}

/// Counts injections of long-acting insulin, which no basal rate describes without a model of
/// their absorption.
fn long_acting(log: &mut Log, therapy: Therapy) -> Therapy {
    let events = log.events.remove(&Role::LongActing).unwrap_or_default();
    let without_time = log.left_out.get(&Role::LongActing).copied();
    if events.is_empty() && without_time.is_none() {
        return therapy;
    }
    let injected: f64 =
        events.iter().map(|event| event.value).sum::<f64>() + without_time.unwrap_or(0.0);
    let what = "long-acting injections, which no basal rate describes: left out";
    log.note_of(Role::LongActing, what, events.len());
    let column = Channel::Basal.name();
    if let Some(total) = log.account.totals.iter_mut().find(|total| total.column == column) {
        total.source += injected;
        total.left_out += injected;
        return therapy;
    }
    let evidence = match events.len() {
        0 => "long-acting injections without a time of day, and no rate".to_owned(),
        count => format!("{count} long-acting injections and no rate"),
    };
    log.infer(Role::LongActing, "therapy mdi", evidence);
    log.account.total(Channel::Basal, "U", injected, 0.0, injected);
    Therapy::Mdi
}

/// Where a pump's rate is recorded, a step without a bolus had none; returns how many there are.
/// Without any bolus at all nothing is known of them.
fn pump_is_silent(record: &mut Record) -> usize {
    if record.bolus().iter().all(Option::is_none) {
        return 0;
    }
    let basal: Vec<bool> = record.basal().iter().map(Option::is_some).collect();
    let mut silent = 0;
    for (bolus, basal) in record.channel_mut(Channel::Bolus).iter_mut().zip(basal) {
        if basal && bolus.is_none() {
            *bolus = Some(0.0);
            silent += 1;
        }
    }
    silent
}
