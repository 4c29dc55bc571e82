//! Hidden events: a spike-and-slab over onsets, scored against its own mirror image.
//!
//! In each stretch (two hours, or as long as an event lasts) an event of the effect's kind starts with a small probability; sizes and
//! onsets are averaged over. The frequency is chosen on training days. The same score for events of the opposite
//! sign is subtracted: a background that is rough in both directions is no evidence for either.

use std::ops::Range;

use effects::EffectId;
use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};

use super::folds::{FOLDS, inside, outside};
use super::{Score, Test, index_of_largest};
use crate::design::EventBank;
use crate::log_sum::{log_sum, log_with_probability};

/// Fewest steps of a stretch in which at most one event starts. A stretch is at least as long as an event:
/// one event must not count as several.
const SHORTEST_STRETCH: usize = 2 * STEPS_PER_HOUR;
/// Probabilities of an event in a stretch that are tried.
const FREQUENCIES: [f64; 8] = [0.0005, 0.002, 0.01, 0.03, 0.06, 0.12, 0.25, 0.5];

/// A hidden event that is more likely than not: its onset, profile and size are those that explain most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundEvent {
    /// The person's index.
    pub person: usize,
    /// Step of its onset.
    pub onset: usize,
    /// Which of the effect's profiles it has.
    pub profile: usize,
    /// Its size relative to the published.
    pub size: f64,
    /// The probability that an event starts in its stretch.
    pub probability: f64,
}

/// Steps of the longest event of an effect.
fn longest(bank: &EventBank) -> usize {
    bank.shape.profiles.iter().map(Vec::len).max().unwrap_or(0)
}

/// Steps of a stretch of an effect.
fn stretch_of(bank: &EventBank) -> usize {
    SHORTEST_STRETCH.max(longest(bank))
}

/// Log likelihood ratio of an event in each stretch of one person: first step of the stretch, ratio.
type Ratios = Vec<(usize, f64)>;

/// The ratios of events of the effect's sign and of the opposite one.
fn ratios(bank: &EventBank) -> [Ratios; 2] {
    let length = stretch_of(bank);
    let profiles = bank.shape.profiles.len().max(1) as f64;
    let sizes: Vec<(f64, f64)> =
        bank.shape.sizes.iter().map(|(size, weight)| (*size, (weight / profiles).ln())).collect();
    let events: Vec<_> = bank.onsets.iter().zip(&bank.known).collect();
    [1.0, -1.0].map(|sign| {
        let mut logs = Vec::new();
        let stretches = events.chunk_by(|(a, _), (b, _)| *a / length == *b / length);
        stretches
            .map(|stretch| {
                let of_onsets = stretch.iter().map(|(_, known)| {
                    logs.clear();
                    for event in *known {
                        logs.extend(sizes.iter().map(|(size, prior)| {
                            let ratio =
                                size * sign * event.score - 0.5 * size * size * event.information;
                            prior + ratio.min(50.0)
                        }));
                    }
                    log_sum(&logs)
                });
                let all: Vec<f64> = of_onsets.collect();
                (stretch[0].0 / length * length, log_sum(&all) - (all.len() as f64).ln())
            })
            .collect()
    })
}

/// Held-out gain of each person for events of one sign.
fn held_out(people: &[Ratios], days: &[usize]) -> Vec<f64> {
    let of_person = |(ratios, days): (&Ratios, &usize)| {
        FREQUENCIES.map(|p| {
            let mut by_day = vec![0.0; *days];
            for (stretch, ratio) in ratios {
                by_day[(stretch / STEPS_PER_DAY).min(days - 1)] += log_with_probability(*ratio, p);
            }
            by_day
        })
    };
    // By person, frequency and day.
    let gains: Vec<_> = people.iter().zip(days).map(of_person).collect();
    let mut out = vec![0.0; people.len()];
    for index in 0..FOLDS {
        let trained = |frequency: usize| -> f64 {
            gains.iter().map(|person| outside(&person[frequency], index)).sum()
        };
        let scores: Vec<f64> = (0..FREQUENCIES.len()).map(trained).collect();
        let best = index_of_largest(&scores);
        if scores[best] > 0.0 {
            for (sum, person) in out.iter_mut().zip(&gains) {
                *sum += inside(&person[best], index);
            }
        }
    }
    out
}

/// Scores the events of one effect. `banks` has an entry a person, `None` where the record cannot show them; `days` the
/// length of each person's record. The amplitude is the frequency.
pub(super) fn score(effect: EffectId, banks: &[Option<&EventBank>], days: &[usize]) -> Score {
    let both = banks.iter().map(|bank| bank.map_or_else(Default::default, ratios));
    let (up, down): (Vec<Ratios>, Vec<Ratios>) = both.map(<(Ratios, Ratios)>::from).unzip();
    let (gains, mirror) = (held_out(&up, days), held_out(&down, days));
    let mirrored = mirror.iter().sum::<f64>() > 0.0;
    let net = |(gain, mirror): (&f64, &f64)| if mirrored { gain - mirror } else { *gain };
    let gains: Vec<f64> = gains.iter().zip(&mirror).map(net).collect();
    let events = found(banks, &up);
    let published = banks.iter().flatten().next().map_or(1.0, |bank| bank.shape.per_day);
    let of = |people: Range<usize>| frequency(&events, people, days, published);
    let (amplitude, personal) =
        (of(0..days.len()), (0..days.len()).map(|person| of(person..person + 1)).collect());
    Score { amplitude, personal, events, ..Score::of(effect, Test::Events, gains) }
}

/// Frequency of events of some people over the published one, and its standard error.
fn frequency(
    events: &[FoundEvent],
    people: Range<usize>,
    days: &[usize],
    published: f64,
) -> (f64, f64) {
    let expected = published * days[people.clone()].iter().sum::<usize>() as f64;
    let theirs = events.iter().filter(|event| people.contains(&event.person));
    // An empty sum is -0.
    let count = theirs.map(|e| e.probability * e.size).sum::<f64>() + 0.0;
    (count / expected, (count.sqrt() + 1.0) / expected)
}

/// Events that are more likely than not.
fn found(banks: &[Option<&EventBank>], ratios: &[Ratios]) -> Vec<FoundEvent> {
    let total = |p: f64| -> f64 {
        ratios.iter().flatten().map(|(_, ratio)| log_with_probability(*ratio, p)).sum()
    };
    let frequency = FREQUENCIES[index_of_largest(&FREQUENCIES.map(total))];
    let mut found = Vec::new();
    for (person, (bank, ratios)) in banks.iter().zip(ratios).enumerate() {
        let Some(bank) = bank else { continue };
        for (stretch, ratio) in ratios {
            let odds = frequency.ln() - (-frequency).ln_1p() + ratio;
            let probability = (1.0 + (-odds).exp()).recip();
            if probability > 0.5 {
                let best = largest(bank, *stretch);
                found.extend(best.map(|best| FoundEvent { person, probability, ..best }));
            }
        }
    }
    apart(found, banks)
}

/// Events without those that another, likelier one of the same person reaches: an event across the border of
/// two stretches shows in both.
fn apart(mut found: Vec<FoundEvent>, banks: &[Option<&EventBank>]) -> Vec<FoundEvent> {
    found.sort_by(|a, b| b.probability.total_cmp(&a.probability).then(a.onset.cmp(&b.onset)));
    let mut kept: Vec<FoundEvent> = Vec::new();
    for event in found {
        let length = banks[event.person].map_or(0, longest);
        let near =
            |k: &FoundEvent| k.person == event.person && k.onset.abs_diff(event.onset) < length;
        if !kept.iter().any(near) {
            kept.push(event);
        }
    }
    kept.sort_by_key(|event| (event.person, event.onset));
    kept
}

/// The event of a stretch that explains most; no size is believed beyond the largest of the effect's prior.
/// Person and probability are the caller's to fill in.
fn largest(bank: &EventBank, stretch: usize) -> Option<FoundEvent> {
    let most = bank.shape.sizes.iter().map(|(size, _)| *size).fold(0.0, f64::max);
    let length = stretch_of(bank);
    let here = bank.onsets.iter().zip(&bank.known).filter(|(o, _)| *o / length * length == stretch);
    here.flat_map(|(onset, known)| known.iter().enumerate().map(move |(k, e)| (*onset, k, *e)))
        .filter(|(_, _, event)| event.information > 0.0)
        .map(|(onset, profile, event)| {
            let score = event.score.max(0.0);
            let size = (score / event.information).min(most);
            (
                score * score / event.information,
                FoundEvent { person: 0, onset, profile, size, probability: 0.0 },
            )
        })
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, found)| found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frequency_is_chosen_on_other_days() {
        // One day speaks loudly for events, six speak against them.
        let days = 7;
        let ratios: Ratios = (0..days)
            .map(|day| (day * STEPS_PER_DAY, if day == 0 { 50.0 } else { -3.0 }))
            .collect();
        let gain = held_out(&[ratios], &[days])[0];
        // The six want no events for the loud day. Where it trains, 0.12 a stretch fits best (one of six), and each
        // of the six loses by it.
        let lost = 6.0 * log_with_probability(-3.0, FREQUENCIES[5]);
        assert!((gain - lost).abs() < 1e-12, "{gain} for {lost}");
    }

    #[test]
    fn the_frequency_is_what_events_add_up_to_over_what_was_published() {
        let event = |onset, size, probability| FoundEvent {
            person: 0,
            onset,
            profile: 0,
            size,
            probability,
        };
        let events = [event(10, 2.0, 1.0), event(500, 4.0, 0.5)];
        let of = |people| frequency(&events, people, &[7, 7], 0.5);
        // Two and half of four where 3.5 a week are usual; of both people 7.
        let (all, error) = of(0..2);
        assert!((all - 4.0 / 7.0).abs() < 1e-12 && (error - 3.0 / 7.0).abs() < 1e-12);
        assert!((of(0..1).0 - 4.0 / 3.5).abs() < 1e-12);
        assert_eq!(of(1..2).0.to_bits(), 0.0f64.to_bits(), "not minus zero");
    }
}
