//! The basal rate that was given: the schedule in force, changed by temporary rates.

use std::borrow::Cow;

use super::profile::{Profiles, Schedule};
use super::treatments::{Change, Switch, Treatments};
use crate::error::{CohortError, Place};
use crate::import::diary::{Diary, Rate, second};
use crate::import::steps::STEP;

/// The longest a suspension holds if nothing follows, s.
const LONGEST_SUSPENSION: i64 = 86_400;

/// A schedule that is in force from a second on, and the share of its rates.
struct InForce<'a> {
    from: i64,
    schedule: Cow<'a, Schedule>,
    share: f64,
}

/// Puts the rates between the first and the last reading into the diary.
pub(super) fn place(
    profiles: &Profiles,
    treatments: Treatments,
    diary: &mut Diary,
) -> Result<(), CohortError> {
    // A schedule is laid day by day, so a wrong date is refused before.
    let Some(span) = diary.record_span()? else { return Ok(()) };
    let (first, end) = (span.first * STEP, span.end * STEP);
    let Treatments { clock, mut temporaries, switches } = treatments;
    temporaries.sort_by_key(|temporary| temporary.from);
    // The clock may go back from one document to the next; no document ends before it begins.
    let mut latest = i64::MIN;
    let documents = profiles.documents.iter().filter_map(|document| {
        let schedule = Cow::Borrowed(document.active()?);
        let local = clock.map_or(document.from.naive_utc(), |clock| clock.local(document.from));
        latest = latest.max(second(local));
        Some(InForce { from: latest, schedule, share: 1.0 })
    });
    let in_force: Vec<InForce<'_>> = documents.collect();
    if let Some(place) = &profiles.other_zone {
        let what = "profiles state several time zones: that of the latest holds throughout";
        diary.note(what, || place.clone());
    }
    if in_force.is_empty() && !temporaries.is_empty() {
        diary.note("no profile: the basal rate is known during temporary rates only", || {
            temporaries[0].place.clone()
        });
    }
    let mut in_force = with_switches(in_force, &switches, profiles, diary);
    if let Some(earliest) = in_force.first_mut()
        && earliest.from > first
    {
        diary.note("the earliest profile also holds before its date", || Place::file("profile"));
        earliest.from = first;
    }

    let base = |from: i64, to: i64| -> Vec<(i64, i64, f64)> {
        let mut pieces = Vec::new();
        // The last one that begins before, and those that follow.
        let before = in_force.partition_point(|one| one.from <= from).saturating_sub(1);
        for (i, one) in in_force.iter().enumerate().skip(before) {
            if one.from >= to {
                break;
            }
            let until = in_force.get(i + 1).map_or(i64::MAX, |next| next.from);
            let (from, to) = (from.max(one.from), to.min(until));
            if from < to {
                let own = one.schedule.pieces(from, to).into_iter();
                pieces.extend(own.map(|(from, to, u_h)| (from, to, u_h * one.share)));
            }
        }
        pieces
    };
    let mut at = first;
    for (i, temporary) in temporaries.iter().enumerate() {
        let next = temporaries.get(i + 1).map_or(i64::MAX, |next| next.from);
        let from = temporary.from.clamp(first, end);
        let to = temporary.from + temporary.seconds.unwrap_or(LONGEST_SUSPENSION);
        let to = to.min(next).clamp(first, end);
        push(diary, base(at, from), &temporary.place)?;
        let pieces = match temporary.change {
            Change::End => base(from, to),
            Change::Rate(u_h) => vec![(from, to, u_h)],
            Change::Percent(percent) => base(from, to)
                .into_iter()
                .map(|(from, to, u_h)| (from, to, u_h * (1.0 + percent / 100.0)))
                .collect(),
        };
        let pieces = pieces.into_iter().filter(|(from, to, _)| from < to).collect();
        push(diary, pieces, &temporary.place)?;
        at = at.max(to);
    }
    push(diary, base(at, end), &Place::file("profile"))
}

/// The schedules in force with the switches among them: at any time the one that began last and has not ended.
fn with_switches<'a>(
    documents: Vec<InForce<'a>>,
    switches: &'a [Switch],
    profiles: &'a Profiles,
    diary: &mut Diary,
) -> Vec<InForce<'a>> {
    let mut all: Vec<(InForce<'a>, i64)> =
        documents.into_iter().map(|one| (one, i64::MAX)).collect();
    for switch in switches {
        let own = switch.schedule.as_ref();
        let named = || profiles.named(switch.name.as_deref()?);
        let Some(schedule) = own.or_else(named) else {
            diary.note("switches to a profile that no file has: left out", || switch.place.clone());
            continue;
        };
        let schedule = match switch.hours {
            0.0 => Cow::Borrowed(schedule),
            hours => Cow::Owned(schedule.shifted(hours)),
        };
        let until = if switch.seconds > 0 { switch.from + switch.seconds } else { i64::MAX };
        all.push((InForce { from: switch.from, schedule, share: switch.share }, until));
    }
    // At the same second a switch comes after a document.
    all.sort_by_key(|(one, _)| one.from);
    let mut times: Vec<i64> = all.iter().flat_map(|(one, until)| [one.from, *until]).collect();
    times.sort_unstable();
    times.dedup();
    let mut found: Vec<InForce<'a>> = Vec::new();
    let (mut next, mut begun, mut last) = (0, Vec::new(), None);
    for at in times.into_iter().filter(|at| *at < i64::MAX) {
        while all.get(next).is_some_and(|(one, _)| one.from <= at) {
            begun.push(next);
            next += 1;
        }
        while begun.last().is_some_and(|place| all[*place].1 <= at) {
            begun.pop();
        }
        // Where nothing was in force before, a switch that has ended goes on.
        if let Some(place) = begun.last().copied()
            && last != Some(place)
        {
            let InForce { schedule, share, .. } = &all[place].0;
            found.push(InForce { from: at, schedule: schedule.clone(), share: *share });
            last = Some(place);
        }
    }
    found
}

fn push(diary: &mut Diary, pieces: Vec<(i64, i64, f64)>, place: &Place) -> Result<(), CohortError> {
    for (from, to, u_h) in pieces {
        diary.rate(Rate { from, to: Some(to), u_h }, || place.clone())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_span_that_is_too_long_is_refused_before_a_schedule_is_laid() {
        let mut diary = Diary::new("p", "entries.json");
        for at in [-2_208_988_800, 7_258_000_000] {
            diary.reading(at, 100.0, || Place::file("entries.json")).expect("a reading");
        }
        let placed = place(&Profiles::default(), Treatments::default(), &mut diary);
        assert!(matches!(placed, Err(CohortError::TooLong { .. })), "{placed:?}");
    }

    #[test]
    fn at_any_time_the_switch_holds_that_began_last_and_has_not_ended() {
        let schedule = |u_h: f64| Schedule { rates: vec![(0, u_h)] };
        let switch = |from, minutes: i64, u_h| Switch {
            from,
            seconds: 60 * minutes,
            name: None,
            schedule: Some(schedule(u_h)),
            share: 1.0,
            hours: 0.0,
            place: Place::file("treatments.json"),
        };
        let in_force = |switches: &[Switch]| -> Vec<(i64, f64)> {
            let usual = schedule(1.0);
            let documents = vec![InForce { from: 0, schedule: Cow::Borrowed(&usual), share: 1.0 }];
            let profiles = Profiles::default();
            let mut diary = Diary::new("p", "treatments.json");
            let found = with_switches(documents, switches, &profiles, &mut diary);
            found.iter().map(|one| (one.from, one.schedule.rates[0].1)).collect()
        };
        // A temporary switch ends, and the schedule before it goes on.
        assert_eq!(in_force(&[switch(600, 60, 1.5)]), [(0, 1.0), (600, 1.5), (4200, 1.0)]);
        // One for good in the middle of it stays; so does a temporary one that lasts longer.
        let for_good = [switch(600, 60, 1.5), switch(1200, 0, 2.0)];
        assert_eq!(in_force(&for_good), [(0, 1.0), (600, 1.5), (1200, 2.0)]);
        let longer = [switch(600, 60, 1.5), switch(1200, 120, 2.0)];
        assert_eq!(in_force(&longer), [(0, 1.0), (600, 1.5), (1200, 2.0), (8400, 1.0)]);
        // After one within another the outer one goes on.
        let within = [switch(600, 60, 1.5), switch(1200, 10, 2.0)];
        let expected = [(0, 1.0), (600, 1.5), (1200, 2.0), (1800, 1.5), (4200, 1.0)];
        assert_eq!(in_force(&within), expected);
    }
}
