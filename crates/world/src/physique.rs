//! The body of one person, of any kind.

use std::collections::BTreeMap;

use ode_sim::OdeError;
use physiology::{InputSource, Kilograms, MgPerDl, OpenLoop, StepInput, UnitsPerHour, simulate};
use rand::Rng;

use crate::body::{Body, BodyModel};
use crate::calendar::Calendar;
use crate::effects::{Amplitudes, Condition, Happenings, Spreads};
use crate::error::WorldError;
use crate::generator::Generator;
use crate::hovorka::HovorkaParameters;
use crate::minimal::MinimalParameters;
use crate::padova::{PadovaParameters, action_within_days};
use crate::saturating::SaturatingParameters;
use crate::stream::{Concept, stream};
use crate::therapy::TherapySettings;
use crate::warp::Warps;

/// Parameters of a body, with the equations they belong to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Physique {
    /// A body of [`Generator::Hovorka`].
    Hovorka(HovorkaParameters),
    /// A body of [`Generator::Padova`].
    Padova(PadovaParameters),
    /// A body of [`Generator::Minimal`].
    Minimal(MinimalParameters),
    /// A body of [`Generator::Saturating`].
    Saturating(SaturatingParameters),
}

/// The same expression for every kind of body, with `$model` its parameters.
macro_rules! for_kind {
    ($physique:expr, $model:ident => $result:expr) => {
        match $physique {
            Physique::Hovorka($model) => $result,
            Physique::Padova($model) => $result,
            Physique::Minimal($model) => $result,
            Physique::Saturating($model) => $result,
        }
    };
}

/// A body of the same kind, with other parameters.
macro_rules! of_same_kind {
    ($physique:expr, $model:ident => $other:expr) => {
        match $physique {
            Physique::Hovorka($model) => Physique::Hovorka($other),
            Physique::Padova($model) => Physique::Padova($other),
            Physique::Minimal($model) => Physique::Minimal($other),
            Physique::Saturating($model) => Physique::Saturating($other),
        }
    };
}

/// What acted on a body and its glucose.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Course {
    /// What acted, one entry a step.
    pub(crate) inputs: Vec<StepInput>,
    /// Glucose at the start of each step, and at the end of the last.
    pub(crate) glucose: Vec<MgPerDl>,
}

/// What acts on a body: its circumstances, and the doses of each step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Acting<'a> {
    pub(crate) conditions: &'a [Condition],
    pub(crate) amplitudes: Amplitudes,
    pub(crate) warps: Warps,
    pub(crate) inputs: &'a [StepInput],
}

/// A run from a state of another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Restart {
    /// Step of the state.
    pub(crate) start: usize,
    /// Length.
    pub(crate) steps: usize,
}

impl Physique {
    /// Draws a body of a generator.
    ///
    /// # Errors
    /// As [`BodyModel::sample`].
    pub fn sample(
        generator: Generator,
        person: usize,
        rng: &mut (impl Rng + ?Sized),
    ) -> Result<Self, WorldError> {
        match generator {
            Generator::Hovorka => HovorkaParameters::sample(person, rng).map(Self::Hovorka),
            Generator::Padova => PadovaParameters::sample(person, rng).map(Self::Padova),
            Generator::Minimal => MinimalParameters::sample(person, rng).map(Self::Minimal),
            Generator::Saturating => {
                SaturatingParameters::sample(person, rng).map(Self::Saturating)
            }
        }
    }

    /// The generator of this body.
    #[must_use]
    pub const fn generator(&self) -> Generator {
        match self {
            Self::Hovorka(_) => Generator::Hovorka,
            Self::Padova(_) => Generator::Padova,
            Self::Minimal(_) => Generator::Minimal,
            Self::Saturating(_) => Generator::Saturating,
        }
    }

    /// Body weight.
    #[must_use]
    pub const fn weight(&self) -> Kilograms {
        for_kind!(self, model => model.weight)
    }

    /// The same body with insulin `factor` times as effective: `1 / factor` of it does the same
    /// work.
    #[must_use]
    pub fn with_action_scaled(self, factor: f64) -> Self {
        of_same_kind!(self, model => model.with_action_scaled(factor))
    }

    /// The model's parameters by the name of their field, in its units.
    #[must_use]
    pub fn named(&self) -> BTreeMap<&'static str, f64> {
        for_kind!(self, model => model.named()).into_iter().collect()
    }

    /// The basal rate that holds a glucose concentration in the undisturbed body.
    ///
    /// # Errors
    /// As [`BodyModel::at_rest`].
    pub fn basal_at(&self, glucose: MgPerDl) -> Result<UnitsPerHour, OdeError> {
        for_kind!(self, model => Ok(Body::undisturbed(*model).at_rest(glucose)?.1))
    }

    /// Replaces the drawn day-to-day variability by that of this kind of body.
    pub(crate) fn vary(
        &self,
        happenings: &mut Happenings,
        calendar: &Calendar,
        spreads: &Spreads,
        seed: u64,
        person: usize,
    ) {
        match self {
            Self::Hovorka(_) | Self::Minimal(_) | Self::Saturating(_) => {}
            Self::Padova(_) => {
                let mut rng = stream(seed, person, Concept::ActionWithinDays);
                happenings.variability.action = action_within_days(calendar, spreads, &mut rng);
            }
        }
    }

    /// Runs the body, with its warps, from a steady state at `start` under the course of
    /// `conditions`.
    ///
    /// # Errors
    /// If there is no such steady state or a compartment is not finite.
    pub(crate) fn run(
        &self,
        conditions: &[Condition],
        amplitudes: Amplitudes,
        warps: Warps,
        start: MgPerDl,
        source: &mut impl InputSource,
        steps: usize,
    ) -> Result<Course, OdeError> {
        for_kind!(self, model => {
            let body = Body::new(*model, conditions, amplitudes).with_warps(warps)?;
            course(&body, start, source, steps)
        })
    }

    /// Glucose of runs that start in states of the course under `lived` and continue under `other`.
    /// One list per restart; its first entry is the glucose at its start.
    ///
    /// # Errors
    /// As [`Self::run`].
    pub(crate) fn restarted(
        &self,
        start: MgPerDl,
        lived: Acting<'_>,
        other: Acting<'_>,
        restarts: &[Restart],
    ) -> Result<Vec<Vec<MgPerDl>>, OdeError> {
        let inputs = (lived.inputs, other.inputs);
        for_kind!(self, model => {
            let with = Body::new(*model, lived.conditions, lived.amplitudes);
            let without = Body::new(*model, other.conditions, other.amplitudes);
            let (with, without) =
                (with.with_warps(lived.warps)?, without.with_warps(other.warps)?);
            restarted(&with, &without, start, inputs, restarts)
        })
    }

    /// The settings that trials on the undisturbed body with these warps give.
    ///
    /// # Errors
    /// As [`TherapySettings::by_trial`].
    pub fn settings_by_trial(&self, warps: Warps) -> Result<TherapySettings, OdeError> {
        for_kind!(self, model => {
            TherapySettings::by_trial(&Body::undisturbed(*model).with_warps(warps)?)
        })
    }
}

fn course<M: BodyModel>(
    body: &Body<'_, M>,
    start: MgPerDl,
    source: &mut impl InputSource,
    steps: usize,
) -> Result<Course, OdeError> {
    let (start, _) = body.at_rest(start)?;
    let run = simulate(body, start, source, steps)?;
    let glucose = run.glucose(body);
    Ok(Course { inputs: run.inputs, glucose })
}

fn restarted<M: BodyModel>(
    lived: &Body<'_, M>,
    other: &Body<'_, M>,
    start: MgPerDl,
    (inputs, others): (&[StepInput], &[StepInput]),
    restarts: &[Restart],
) -> Result<Vec<Vec<MgPerDl>>, OdeError> {
    let (start, _) = lived.at_rest(start)?;
    let states = simulate(lived, start, &mut OpenLoop::new(inputs), inputs.len())?.states;
    restarts
        .iter()
        .map(|restart| {
            let state = states[restart.start];
            let inputs = &others[restart.start..];
            let run = simulate(other, state, &mut OpenLoop::new(inputs), restart.steps)?;
            Ok(run.glucose(other))
        })
        .collect()
}
