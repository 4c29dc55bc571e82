//! The basal rate that was given: the schedule in force, changed by temporary rates.

use std::borrow::Cow;

use super::profile::{Profiles, Schedule};
use super::treatments::{Change, Switch, Treatments};
use crate::error::{CohortError, Place};
use crate::import::diary::{Diary, Rate, second};

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
    let Some((first, last)) = diary.record_span()? else { return Ok(()) };
    // The last reading's step is part of the record.
    let (first, end) = (first, last + 300);
    let clock = treatments.clock();
    let Treatments { mut temporaries, mut switches, .. } = treatments;
    switches.sort_by_key(|switch| switch.from);
    temporaries.sort_by_key(|temporary| temporary.from);
    let mut in_force: Vec<InForce<'_>> = profiles
        .documents()
        .iter()
        .filter_map(|document| {
            let local = clock.map_or(document.from.naive_utc(), |clock| clock.local(document.from));
            Some(InForce {
                from: second(local),
                schedule: Cow::Borrowed(document.active()?),
                share: 1.0,
            })
        })
        .collect();
    // The clock may go back from one document to the next; no document ends before it begins.
    let mut latest = i64::MIN;
    for one in &mut in_force {
        latest = latest.max(one.from);
        one.from = latest;
    }
    if in_force.is_empty() && !temporaries.is_empty() {
        diary.note("no profile: the basal rate is known during temporary rates only", || {
            temporaries[0].place.clone()
        });
    }
    switch(&mut in_force, &switches, profiles, diary);
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
        let to = temporary
            .seconds
            .map_or(temporary.from + LONGEST_SUSPENSION, |seconds| temporary.from + seconds)
            .min(next)
            .clamp(first, end);
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

/// Adds the switches to the schedules in force, in order of time.
fn switch<'a>(
    in_force: &mut Vec<InForce<'a>>,
    switches: &'a [Switch],
    profiles: &'a Profiles,
    diary: &mut Diary,
) {
    for switch in switches {
        let own = switch.schedule.as_ref();
        let named = || profiles.named(switch.name.as_deref()?);
        let Some(schedule) = own.or_else(named) else {
            diary.note("switches to a profile that no file has: left out", || switch.place.clone());
            continue;
        };
        let at = in_force.partition_point(|one| one.from <= switch.from);
        let before = at.checked_sub(1);
        let schedule = match switch.hours {
            0.0 => Cow::Borrowed(schedule),
            hours => Cow::Owned(schedule.shifted(hours)),
        };
        let new = InForce { from: switch.from, schedule, share: switch.share };
        if switch.seconds > 0
            && let Some(before) = before
        {
            let InForce { schedule, share, .. } = &in_force[before];
            let from = switch.from + switch.seconds;
            let back = InForce { from, schedule: schedule.clone(), share: *share };
            if in_force.get(at).is_none_or(|next| back.from < next.from) {
                in_force.insert(at, back);
            }
        }
        in_force.insert(at, new);
    }
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
    use crate::import::diary::GlucoseUnit;

    #[test]
    fn a_span_that_is_too_long_is_refused_before_a_schedule_is_laid() {
        let mut diary = Diary::new("p", "entries.json", GlucoseUnit::MgPerDl);
        for at in [-2_208_988_800, 7_258_000_000] {
            diary.reading(at, 100.0, || Place::file("entries.json")).expect("a reading");
        }
        let placed = place(&Profiles::default(), Treatments::new(None), &mut diary);
        assert!(matches!(placed, Err(CohortError::TooLong { .. })), "{placed:?}");
    }
}
