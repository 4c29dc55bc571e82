//! Rescue carbohydrate against low glucose, by the rules of the authors' test program.

use physiology::{FastCarbs, Grams, InputSource, MgPerDl, Minutes, STEP, StepInput};

/// Glucose below which a rescue is due.
pub const RESCUE_THRESHOLD: MgPerDl = MgPerDl(70.0);
/// Carbohydrate of one rescue.
pub const RESCUE_AMOUNT: Grams = Grams(20.0);
/// Steps from a first low to the snack: 20 min.
const DELAY: usize = 4;
/// Steps since the last snack after which a low counts as a new one: 60 min.
const NEW_LOW_AFTER: usize = 12;
/// Steps since the last snack within which a low calls for another at once: 40 min.
const REPEAT_WITHIN: usize = 8;
/// Steps since the last snack after which glucose is looked at again.
const WAIT: usize = 7;

/// Adds rescue carbohydrate to the inputs of another source.
///
/// After each step k, if glucose is below [`RESCUE_THRESHOLD`] and none is awaited, 20 g are eaten:
/// at step k + 4 for the first low and for one more than 12 steps after the last snack; at step k
/// for one at most 8 steps after it; none in between. Then none is considered until a step at
/// least 7 past the snack has ended. (Resalat et al. 2019, test program.) Insulin is not cut:
/// the authors compute a cut and never apply it.
///
/// Glucose is the plant's own, as in the authors' program. The start (before step 0) is not
/// looked at. A source that brings rescue carbohydrate of its own keeps it in the steps where this
/// wrapper has none to give.
#[derive(Debug, Clone)]
pub struct RescueCarbs<S> {
    source: S,
    ready: bool,
    last_snack: Option<usize>,
}

impl<S: InputSource> RescueCarbs<S> {
    /// Watches over a person fed by `source`.
    #[must_use]
    pub fn new(source: S) -> Self {
        Self { source, ready: true, last_snack: None }
    }

    /// Looks at the glucose after step `k`; the snack it calls for, as the step it belongs to.
    fn after_step(&mut self, k: usize, glucose: MgPerDl) {
        if glucose < RESCUE_THRESHOLD && self.ready {
            // `k` lies past the last snack whenever `ready` holds.
            let due = match self.last_snack.map(|last| k - last) {
                None => Some(k + DELAY),
                Some(since) if since > NEW_LOW_AFTER => Some(k + DELAY),
                Some(since) if since <= REPEAT_WITHIN => Some(k),
                Some(_) => None,
            };
            if due.is_some() {
                self.last_snack = due;
                self.ready = false;
            }
        }
        if self.last_snack.is_some_and(|last| k >= last + WAIT) {
            self.ready = true;
        }
    }
}

impl<S: InputSource> InputSource for RescueCarbs<S> {
    fn next(&mut self, step: usize, glucose: MgPerDl) -> Option<StepInput> {
        let mut input = self.source.next(step, glucose)?;
        let before = self.last_snack;
        if let Some(k) = step.checked_sub(1) {
            self.after_step(k, glucose);
        }
        let eaten_before = match self.last_snack {
            Some(last) if last == step => Some(Minutes(0.0)),
            // One of the step before, decided from the glucose at its end.
            Some(last) if last + 1 == step && self.last_snack != before => Some(STEP),
            _ => None,
        };
        if let Some(eaten_before) = eaten_before {
            input.rescue = FastCarbs { amount: RESCUE_AMOUNT, eaten_before };
        }
        Some(input)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use physiology::OpenLoop;

    /// The steps in which a snack appears, with the minutes since it was eaten.
    fn snacks(low_after: impl Fn(usize) -> bool, steps: usize) -> Vec<(usize, f64)> {
        let inputs = vec![StepInput::default(); steps];
        let mut source = RescueCarbs::new(OpenLoop::new(&inputs));
        let mut found = Vec::new();
        for step in 0..steps {
            let low = step > 0 && low_after(step - 1);
            let glucose = MgPerDl(if low { 65.0 } else { 120.0 });
            let input = source.next(step, glucose).expect("within the inputs");
            if input.rescue.amount.0 > 0.0 {
                found.push((step, input.rescue.eaten_before.0));
            }
        }
        found
    }

    #[test]
    fn a_first_low_is_treated_after_twenty_minutes() {
        assert_eq!(snacks(|k| k == 10, 60), vec![(14, 0.0)]);
    }

    #[test]
    fn a_lasting_low_is_treated_again_after_forty_minutes() {
        // Snack at 14; seven steps on the counter is set, so step 22 is the first to look again.
        assert_eq!(snacks(|k| (10..=22).contains(&k), 60), vec![(14, 0.0), (23, 5.0)]);
    }

    #[test]
    fn a_low_nine_to_twelve_steps_on_is_left_alone_and_later_ones_are_new() {
        assert_eq!(snacks(|k| k == 10 || k == 24, 60), vec![(14, 0.0)]);
        assert_eq!(snacks(|k| k == 10 || k == 26, 60), vec![(14, 0.0)]);
        assert_eq!(snacks(|k| k == 10 || k == 27, 60), vec![(14, 0.0), (31, 0.0)]);
    }

    #[test]
    fn seventy_itself_is_not_low_and_the_start_is_not_looked_at() {
        let inputs = [StepInput::default(); 12];
        let mut source = RescueCarbs::new(OpenLoop::new(&inputs));
        assert!(source.next(0, MgPerDl(50.0)).is_some());
        for step in 1..12 {
            let input = source.next(step, MgPerDl(70.0)).expect("within the inputs");
            assert_eq!(input.rescue.amount, Grams(0.0));
        }
    }
}
