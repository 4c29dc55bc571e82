//! The factor on an effect's amplitudes at which it moves glucose as far as planned.

/// Largest number of evaluations of a search; each is a few simulated weeks.
const MOST_EVALUATIONS: usize = 6;
/// A search ends at a shift from the target to this share above it. So a world that is planned at 5
/// mg/dL moves glucose by at least that.
const ABOVE: f64 = 0.06;
/// Smallest factor that is tried.
const SMALLEST: f64 = 1.0 / 64.0;

/// Where a search ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reached<T> {
    /// The best factor of those tried.
    pub(super) factor: f64,
    /// The shift it gives, in the unit of the target.
    pub(super) shift: f64,
    /// Whether the largest factor falls short of the target.
    pub(super) at_limit: bool,
    /// What was found beside the shift; `None` where no trial counts.
    pub(super) found: Option<T>,
}

/// Finds a factor from 1/64 to `largest` whose shift lies from `target` to 6 % above it, in at most
/// [`MOST_EVALUATIONS`] evaluations; otherwise the nearest that was tried.
///
/// For small factors the shift grows about in proportion to the factor, so the search uses secants
/// of the logarithms, kept within a bracket. `shift_of` gives the shift and what else is to be kept
/// of the best trial, or `None` where a body fails; the search then looks below.
pub(super) fn search<T>(
    target: f64,
    largest: f64,
    mut shift_of: impl FnMut(f64) -> Option<(f64, T)>,
) -> Reached<T> {
    let aim = target * (1.0 + 0.5 * ABOVE);
    let mut below: Option<(f64, f64)> = None; // largest factor known to fall short, with its shift
    let mut above: Option<(f64, Option<f64>)> = None; // smallest known to exceed, or to fail
    let mut best = Reached { factor: SMALLEST, shift: 0.0, at_limit: false, found: None };
    let mut factor = 1.0_f64.min(largest);
    for _ in 0..MOST_EVALUATIONS {
        let Some((shift, found)) = shift_of(factor) else {
            above = Some((factor, None));
            factor = next(aim, largest, below, above);
            continue;
        };
        let at_limit = shift < target && factor >= largest;
        if at_limit || (shift - aim).abs() <= (best.shift - aim).abs() {
            best = Reached { factor, shift, at_limit, found: Some(found) };
        }
        if at_limit || (target..=target * (1.0 + ABOVE)).contains(&shift) {
            return best;
        }
        if shift < aim {
            below = Some((factor, shift));
        } else {
            above = Some((factor, Some(shift)));
        }
        factor = next(aim, largest, below, above);
    }
    best
}

/// The next factor to try.
fn next(
    aim: f64,
    largest: f64,
    below: Option<(f64, f64)>,
    above: Option<(f64, Option<f64>)>,
) -> f64 {
    let proportional = |(factor, shift): (f64, f64)| factor * aim / shift.max(0.02 * aim);
    match (below, above) {
        // A little further than in proportion, because most effects saturate.
        (Some(below), None) => (1.1 * proportional(below)).min(largest),
        (None, Some((factor, Some(shift)))) => proportional((factor, shift)).max(SMALLEST),
        (None, Some((factor, None))) => (0.5 * factor).max(SMALLEST),
        (Some((low, shift_low)), Some((high, Some(shift_high)))) if shift_low > 0.0 => {
            let share = (aim / shift_low).ln() / (shift_high / shift_low).ln();
            // Not too near an end, because then the bracket would not shrink.
            let share = if share.is_finite() { share.clamp(0.08, 0.92) } else { 0.5 };
            low * (high / low).powf(share)
        }
        (Some((low, _)), Some((high, _))) => (low * high).sqrt(),
        (None, None) => 1.0_f64.min(largest),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counted(
        target: f64,
        largest: f64,
        shift: impl Fn(f64) -> Option<f64>,
    ) -> (Reached<f64>, usize) {
        let mut evaluations = 0;
        let reached = search(target, largest, |factor| {
            evaluations += 1;
            assert!((SMALLEST..=largest).contains(&factor), "{factor}");
            shift(factor).map(|shift| (shift, factor))
        });
        (reached, evaluations)
    }

    #[test]
    fn straight_saturating_and_steepening_effects_are_met() {
        type Case = (&'static str, fn(f64) -> f64);
        let effects: [Case; 4] = [
            ("straight", |a| 4.0 * a),
            ("saturating", |a| 25.0 * a / (1.0 + a)),
            ("steepening", |a| 2.0 * a.powf(1.6)),
            ("strong", |a| 90.0 * a),
        ];
        for (name, effect) in effects {
            for target in [2.5, 5.0, 10.0, 15.0] {
                let (reached, evaluations) = counted(target, 6.0, |a| Some(effect(a)));
                let above = reached.shift / target - 1.0;
                assert!((0.0..=ABOVE).contains(&above), "{name} {target}: {reached:?}");
                assert!(!reached.at_limit && evaluations <= MOST_EVALUATIONS, "{name} {target}");
                assert_eq!(reached.shift, effect(reached.factor));
                assert_eq!(reached.found, Some(reached.factor));
            }
        }
    }

    #[test]
    fn a_target_out_of_reach_keeps_the_limit() {
        let (reached, _) = counted(15.0, 6.0, |a| Some(1.2 * a));
        let found = Some(6.0);
        assert_eq!(reached, Reached { factor: 6.0, shift: 1.2 * 6.0, at_limit: true, found });
        let (nothing, evaluations) = counted(5.0, 2.0, |_| Some(0.0));
        let found = Some(2.0);
        assert_eq!(nothing, Reached { factor: 2.0, shift: 0.0, at_limit: true, found });
        assert!(evaluations <= 2);
    }

    #[test]
    fn a_body_that_fails_is_left_alone() {
        let (reached, _) = counted(10.0, 6.0, |a| (a < 0.9).then_some(20.0 * a));
        assert!((10.0..=10.6).contains(&reached.shift), "{reached:?}");
    }
}
