//! What adding the effects changes.

use crate::WithInterval;

/// What adding the effects found changes; empty where none was found.
///
/// Everything is measured on days that were held out of the fits.
#[apply(strict!)]
#[derive(Default)]
pub struct HowFar {
    /// Held-out errors before and after, one entry a horizon; then, if events or random factors were
    /// found, entries with [`HorizonChange::reconstructed`].
    pub horizons: Vec<HorizonChange>,
    /// Outcomes before and after, of free runs of 24 h on held-out days.
    pub outcomes: Vec<OutcomeChange>,
    /// Amplitudes from training days, one entry an effect that a driver explains.
    pub amplitudes: Vec<AmplitudeChange>,
    /// Held-out one-step fit.
    pub innovations: Option<InnovationChange>,
    /// Every person's errors.
    pub people: Vec<PersonChange>,
    /// What limits these figures, in sentences.
    pub notes: Vec<String>,
}

/// Held-out error at one horizon before and after the effects are added.
#[apply(strict!)]
pub struct HorizonChange {
    /// Horizon, min.
    pub minutes: u32,
    /// Mean absolute error before, mg/dL: mean over people.
    pub mae_before: f64,
    /// Mean absolute error after, mg/dL: mean over people.
    pub mae_after: f64,
    /// After minus before, mg/dL.
    pub difference: WithInterval,
    /// Whether the effects were reconstructed from the held-out readings themselves. Such a row is no
    /// prediction: it says what knowing the events would remove, and must not be added to the others.
    pub reconstructed: bool,
    /// The error that the model after would have if it were perfect: expected absolute error by the
    /// filter's own variance, mg/dL. A bound under the noise model, not a measurement.
    pub floor: Option<f64>,
    /// (before - after) / (before - floor): share of the error above the floor that is removed. `None`
    /// where the distance to the floor cannot be told from a small one.
    pub share_above_floor: Option<WithInterval>,
    /// People who contribute.
    pub people: usize,
    /// Free runs that contribute.
    pub runs: usize,
}

/// Equivalence of one outcome before and after the effects are added.
#[apply(strict!)]
pub struct OutcomeChange {
    /// The outcome.
    pub metric: String,
    /// Equivalence margin, in the outcome's unit.
    pub margin: f64,
    /// TOST p before.
    pub p_before: f64,
    /// TOST p after.
    pub p_after: f64,
    /// Simulated minus measured before, in the outcome's unit: mean over people.
    pub difference_before: f64,
    /// The same after.
    pub difference_after: f64,
    /// People who contribute.
    pub people: usize,
}

/// Amplitude of an effect in people's training days.
#[apply(strict!)]
pub struct AmplitudeChange {
    /// The effect.
    pub effect: String,
    /// Its variant, chosen on the training days of each fold.
    pub variants: Vec<usize>,
    /// Mean over people, with a 95 % interval.
    pub mean: WithInterval,
    /// Standard deviation between people.
    pub sd: f64,
    /// Each person's amplitude, mean over folds, in the order of [`HowFar::people`].
    pub people: Vec<f64>,
}

/// One-step predictions of held-out days before and after.
#[apply(strict!)]
pub struct InnovationChange {
    /// Log-likelihood of a day's readings before, nats: mean over people. Beyond 2.5 standard deviations
    /// it falls linearly.
    pub before: f64,
    /// The same after.
    pub after: f64,
    /// After minus before, nats a day.
    pub difference: WithInterval,
}

/// Held-out errors of one person.
#[apply(strict!)]
pub struct PersonChange {
    /// The person.
    pub person_id: String,
    /// Days held out that contribute a run.
    pub days: usize,
    /// Mean absolute errors before, mg/dL, one entry a horizon; `None` without a run.
    pub mae_before: Vec<Option<f64>>,
    /// Mean absolute errors after, mg/dL.
    pub mae_after: Vec<Option<f64>>,
    /// Mean absolute errors with hidden events and random factors reconstructed as well, mg/dL; empty
    /// where none were found. No prediction: see [`HorizonChange::reconstructed`].
    pub mae_reconstructed: Vec<Option<f64>>,
}

/// Errors of the calibrated plant at one horizon, with person-level 95 % intervals.
#[apply(strict!)]
pub struct HorizonError {
    /// Horizon, min.
    pub minutes: u32,
    /// Mean absolute error, mg/dL: mean over people.
    pub mae: WithInterval,
    /// Root of the mean over people of each person's mean squared error, mg/dL.
    pub rmse: WithInterval,
    /// Mean error, observed minus predicted, mg/dL: mean over people.
    pub bias: WithInterval,
    /// People who contribute.
    pub people: usize,
    /// Free runs that contribute.
    pub runs: usize,
}
