//! The body of one person, of any kind.

use std::collections::BTreeMap;
use std::ops::Range;

use ode_sim::OdeError;
use physiology::{InputSource, Kilograms, MgPerDl, OpenLoop, StepInput, simulate};
use rand::Rng;

use crate::body::{Body, BodyModel};
use crate::effects::{Amplitudes, Condition};
use crate::error::WorldError;
use crate::generator::Generator;
use crate::hovorka::HovorkaParameters;
use crate::minimal::MinimalParameters;
use crate::padova::PadovaParameters;
use crate::saturating::SaturatingParameters;
use crate::therapy::TherapySettings;
use crate::warp::Warps;

/// Glucose at the start of the record.
const FIRST_GLUCOSE: MgPerDl = MgPerDl(140.0);

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

/// What acts on a body: its circumstances, and the doses of each step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Acting<'a> {
    pub(crate) conditions: &'a [Condition],
    pub(crate) amplitudes: Amplitudes,
    pub(crate) inputs: &'a [StepInput],
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

    /// The model's parameters by the name of their field, in its units.
    #[must_use]
    pub fn named(&self) -> BTreeMap<&'static str, f64> {
        for_kind!(self, model => model.named()).into_iter().collect()
    }

    /// Runs the body, with its warps, from a steady state at [`FIRST_GLUCOSE`] under the course of
    /// `conditions`: what acted, and glucose at the start of each step.
    ///
    /// # Errors
    /// If there is no such steady state or a compartment is not finite.
    pub(crate) fn run(
        &self,
        conditions: &[Condition],
        amplitudes: Amplitudes,
        warps: Warps,
        source: &mut impl InputSource,
    ) -> Result<(Vec<StepInput>, Vec<MgPerDl>), OdeError> {
        for_kind!(self, model => {
            let body = Body::new(*model, conditions, amplitudes).with_warps(warps)?;
            let (start, _) = body.at_rest(FIRST_GLUCOSE)?;
            let run = simulate(&body, start, source, conditions.len())?;
            let mut glucose = run.glucose(&body);
            glucose.truncate(run.inputs.len());
            Ok((run.inputs, glucose))
        })
    }

    /// Glucose of runs that start in states of the course under `lived` and continue under `other`.
    /// One list per restart; its first entry is the glucose at its start.
    ///
    /// # Errors
    /// As [`Self::run`].
    pub(crate) fn restarted(
        &self,
        lived: Acting<'_>,
        other: Acting<'_>,
        warps: Warps,
        restarts: &[Range<usize>],
    ) -> Result<Vec<Vec<MgPerDl>>, OdeError> {
        for_kind!(self, model => {
            let with = Body::new(*model, lived.conditions, lived.amplitudes).with_warps(warps)?;
            let without = Body::new(*model, other.conditions, other.amplitudes).with_warps(warps)?;
            let (start, _) = with.at_rest(FIRST_GLUCOSE)?;
            let mut source = OpenLoop::new(lived.inputs);
            let states = simulate(&with, start, &mut source, lived.inputs.len())?.states;
            restarts
                .iter()
                .map(|restart| {
                    let mut source = OpenLoop::new(&other.inputs[restart.start..]);
                    let state = states[restart.start];
                    let run = simulate(&without, state, &mut source, restart.len())?;
                    Ok(run.glucose(&without))
                })
                .collect()
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
