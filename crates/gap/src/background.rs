//! Directions that are always allowed for: what may differ between any two bodies and is no effect.
//!
//! A person's parameters, the plant's structure (how meals and insulin are absorbed and act over
//! time), and the clock. Each has a Gaussian prior; an effect must explain what these cannot. A plant of other
//! structure than the body's leaves errors after every meal and every bolus; without the kernels below the
//! effect that looks most like those errors would be named for them.

use effects::{Allowance, Field};
use ode_sim::gut::glucose_dose;
use physiology::{Grams, STEP, STEPS_PER_DAY, STEPS_PER_HOUR};

use crate::filter::calibration::{Factor, PARAMETERS};
use crate::filter::observations::Observations;
use crate::filter::tangent::{Direction, Parameter};

/// A direction that is allowed for: its column, and the mean and standard deviation of its amplitude's prior.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Allowed {
    pub(crate) column: usize,
    pub(crate) mean: f64,
    pub(crate) sd: f64,
}

/// What may differ between any two bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Background {
    /// A parameter.
    Parameter(Parameter),
    /// A field that differs for good: a port that no parameter stands for.
    Field(Field),
    /// The flux after meals in a bump.
    MealKernel,
    /// How much more slowly than others large meals are absorbed.
    GutTimeBySize,
    /// The flux after carbohydrate taken while glucose is low, in a bump.
    RescueKernel,
    /// The flux that brings glucose back to its usual value.
    Effectiveness,
    /// The flux against low glucose.
    Defence,
    /// The flux against high glucose.
    Shedding,
    /// The flux after insulin in a bump.
    InsulinKernel,
    /// A harmonic of the day in one phase.
    Clock,
}

impl Background {
    /// Whether the direction is part of an allowance.
    pub(crate) fn is(self, allowance: Allowance) -> bool {
        match allowance {
            Allowance::Clock => self == Self::Clock,
            Allowance::Defence => self == Self::Defence,
            Allowance::Shedding => self == Self::Shedding,
        }
    }
}

/// The factor of the calibration that a parameter is.
pub(crate) fn calibrated_factor(parameter: Parameter) -> Option<Factor> {
    let index = PARAMETERS.iter().position(|calibrated| *calibrated == parameter)?;
    Factor::ALL.get(index).copied()
}

/// Parameters that are not calibrated, with spreads of Hovorka et al. (2002): 30 to 60 %, halved.
const STRUCTURE: [(Parameter, f64); 6] = [
    (Parameter::KA1, 0.3),
    (Parameter::KA2, 0.3),
    (Parameter::KA3, 0.3),
    (Parameter::K12, 0.3),
    (Parameter::KE, 0.2),
    (Parameter::VG, 0.15),
];
/// Fields that may differ for good: ports that no parameter stands for. What an amplitude of 1 adds, and the
/// spread of the prior. The flux is in units of nominal production.
const FIELDS: [(Field, f64, f64); 5] = [
    (Field::InsulinInput, 1.0, 0.1),
    (Field::LiverAction, 1.0, 0.2),
    (Field::Flux, 0.016, 0.0625),
    (Field::SensorGain, 1.0, 0.05),
    (Field::SensorOffset, 1.0, 5.0),
];
/// Times at which the bumps of the meal kernel are highest, min.
const MEAL_PEAKS: [f64; 5] = [15.0, 40.0, 80.0, 140.0, 240.0];
/// Times at which the bumps of the insulin kernel are highest, min.
const INSULIN_PEAKS: [f64; 5] = [25.0, 60.0, 110.0, 190.0, 320.0];
/// Least and usual carbohydrate of a meal, g, and the hours through which it is absorbed.
const LEAST_MEAL: f64 = 15.0;
const USUAL_MEAL: f64 = 45.0;
const MEAL_HOURS: usize = 5;
/// Share of a meal's glucose that an amplitude of 1 adds in a bump.
const MEAL_SHARE: f64 = 0.15;
/// Glucose below which carbohydrate is taken for a treatment, mg/dL, and its kernel, min: sugar is absorbed
/// faster than the meals that a person's gut time is calibrated to.
const TREATED_BELOW: f64 = 85.0;
const RESCUE_PEAKS: [f64; 3] = [8.0, 20.0, 50.0];
const RESCUE_SHARE: f64 = 0.3;
/// Glucose that an amplitude of 1 removes in a bump for each unit of insulin, mmol kg/kg/U: a fifth of what a
/// unit does at a correction factor of 40 mg/dL/U in 70 kg.
const INSULIN_SHARE: f64 = 0.2 * 40.0 / 18.0 * 0.16 * 70.0;
/// Harmonics of the day.
const HARMONICS: usize = 4;
/// Flux of a harmonic at amplitude 1, mmol/kg/min: 12 % of endogenous production.
const CLOCK_FLUX: f64 = 0.002;

/// A flux over glucose, mg/dL, relative.
type Shape = fn(f64) -> f64;
/// Shapes of a flux over glucose, mg/dL: effectiveness, what defends against lows, what sheds highs.
const GLUCOSE_SHAPES: [(Background, Shape); 3] = [
    (Background::Effectiveness, |g| ((130.0 - g) / 100.0).clamp(-1.5, 1.0)),
    (Background::Defence, |g| ((80.0 - g) / 20.0).clamp(0.0, 2.0)),
    (Background::Shedding, |g| -((g - 170.0) / 80.0).clamp(0.0, 2.0)),
];

/// The background of a person: directions, each with the standard deviation of its amplitude's prior.
///
/// `glucose` is the filtered plasma glucose, mg/dL.
pub(crate) fn background(
    record: &Observations,
    hours: &[f64],
    glucose: &[f64],
) -> Vec<(Background, f64, Direction)> {
    let mut all = Vec::new();
    // What is left to move once a person is calibrated.
    let left_sd = Factor::ALL.map(|factor| 0.5 * factor.prior_sd());
    for (parameter, prior_sd) in PARAMETERS.into_iter().zip(left_sd).chain(STRUCTURE) {
        all.push((Background::Parameter(parameter), prior_sd, Direction::Parameter(parameter)));
    }
    for (field, unit, prior_sd) in FIELDS {
        let direction = Direction::Course(vec![(field, vec![unit; record.len()])]);
        all.push((Background::Field(field), prior_sd, direction));
    }
    let eaten = |grams: f64| glucose_dose(Grams(grams), record.weight);
    let meals: Vec<f64> = record.inputs.iter().map(|i| MEAL_SHARE * eaten(i.carbs.0)).collect();
    all.extend(kernel(Background::MealKernel, &MEAL_PEAKS, &meals));
    let by_size = Direction::Course(vec![(Field::GutTime, by_size(record))]);
    all.push((Background::GutTimeBySize, 0.3, by_size));
    let treatments = record.inputs.iter().zip(glucose).map(|(i, g)| {
        let taken = if *g < TREATED_BELOW { i.carbs.0 } else { 0.0 };
        RESCUE_SHARE * eaten(taken)
    });
    let treatments: Vec<f64> = treatments.collect();
    all.extend(kernel(Background::RescueKernel, &RESCUE_PEAKS, &treatments));
    for (which, shape) in GLUCOSE_SHAPES {
        all.push(flux(which, glucose.iter().map(|g| CLOCK_FLUX * shape(*g)).collect()));
    }
    let insulin: Vec<f64> =
        record.inputs.iter().map(|i| i.insulin().during(STEP).0 / record.weight.0).collect();
    let mean = insulin.iter().sum::<f64>() / insulin.len().max(1) as f64;
    let insulin: Vec<f64> = insulin.iter().map(|u| -INSULIN_SHARE * (u - mean)).collect();
    all.extend(kernel(Background::InsulinKernel, &INSULIN_PEAKS, &insulin));
    for harmonic in 1..=HARMONICS {
        // Highest at midnight, and a quarter of a period after it.
        for later in [0.0, 0.25] {
            let wave = |hour: &f64| {
                let turns = harmonic as f64 * hour / 24.0 - later;
                CLOCK_FLUX * (std::f64::consts::TAU * turns).cos()
            };
            // Steps of five minutes come round every day.
            let day: Vec<f64> = hours.iter().take(STEPS_PER_DAY).map(wave).collect();
            let course = day.iter().copied().cycle().take(hours.len()).collect();
            all.push(flux(Background::Clock, course));
        }
    }
    all
}

/// A direction of the flux.
fn flux(which: Background, course: Vec<f64>) -> (Background, f64, Direction) {
    (which, 1.0, Direction::Course(vec![(Field::Flux, course)]))
}

/// The flux after doses, a direction a bump.
fn kernel(
    which: Background,
    peaks: &[f64],
    doses: &[f64],
) -> impl Iterator<Item = (Background, f64, Direction)> {
    bumps(peaks).into_iter().map(move |bump| flux(which, filtered(doses, &bump)))
}

/// Bumps in logarithmic time between neighbouring peaks, per minute, each of area 1.
fn bumps(peaks: &[f64]) -> Vec<Vec<f64>> {
    let logs: Vec<f64> = peaks.iter().map(|p| p.ln()).collect();
    let last = logs.len() - 1;
    (0..logs.len())
        .map(|k| {
            let before = if k > 0 { logs[k] - logs[k - 1] } else { logs[1] - logs[0] };
            let after = if k < last { logs[k + 1] - logs[k] } else { logs[last] - logs[last - 1] };
            let length = (peaks[k] * after.exp() / STEP.0).ceil() as usize;
            let mut bump: Vec<f64> = (0..length)
                .map(|step| {
                    let time = ((step as f64 + 0.5) * STEP.0).ln() - logs[k];
                    let x = if time < 0.0 { time / before } else { time / after };
                    if x.abs() < 1.0 { 0.5 * (1.0 + (std::f64::consts::PI * x).cos()) } else { 0.0 }
                })
                .collect();
            let area: f64 = bump.iter().sum::<f64>() * STEP.0;
            bump.iter_mut().for_each(|value| *value /= area);
            bump
        })
        .collect()
}

/// How much larger than usual the last meal was, as a share of the usual meal, while it is absorbed: large meals
/// leave the stomach more slowly in some models and bodies than in others.
fn by_size(record: &Observations) -> Vec<f64> {
    let mut sizes = vec![0.0; record.len()];
    for (step, input) in record.inputs.iter().enumerate() {
        if input.carbs.0 >= LEAST_MEAL {
            let end = (step + MEAL_HOURS * STEPS_PER_HOUR).min(sizes.len());
            sizes[step..end].fill((input.carbs.0 / USUAL_MEAL - 1.0).clamp(-1.0, 1.5));
        }
    }
    sizes
}

/// A series of doses through a kernel that starts with the dose.
fn filtered(doses: &[f64], kernel: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; doses.len()];
    for (step, dose) in doses.iter().enumerate().filter(|(_, dose)| **dose != 0.0) {
        for (value, k) in out[step..].iter_mut().zip(kernel) {
            *value += dose * k;
        }
    }
    out
}

/// Local hour at the start of each step of a record.
pub(crate) fn hours(record: &cohort::Record) -> Vec<f64> {
    use chrono::Timelike;
    let first = f64::from(record.start().time().num_seconds_from_midnight()) / 3600.0;
    (0..record.len()).map(|k| (first + k as f64 / STEPS_PER_HOUR as f64) % 24.0).collect()
}
