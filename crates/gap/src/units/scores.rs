//! Scores of fields, step by step, of a person's innovations and of innovations in which nothing is missing.

use std::ops::Range;

use effects::{EffectId, Field};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use physiology::STEPS_PER_DAY;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::tally::{DATA, Total};
use crate::background::Allowed;
use crate::calibrated_person::CalibratedPerson;
use crate::design::{Column, Design, Whitener};
use crate::error::GapError;
use crate::filter::tangent::{LANES, Lanes, course_scores};

/// Fields whose scores are taken.
pub(super) const FIELDS: [Field; 13] = [
    Field::InsulinInput,
    Field::InsulinTime,
    Field::Action,
    Field::LiverAction,
    Field::Production,
    Field::GutTime,
    Field::CarbAmount,
    Field::ExtraCarbs,
    Field::Flux,
    Field::SensorLag,
    Field::SensorGain,
    Field::SensorOffset,
    Field::RenalRate,
];

/// Scores with the background taken out.
pub(super) struct Scores {
    /// Sums from the start of the record, by field: an entry a step, and one before the first.
    sums: Vec<Vec<[f64; LANES]>>,
    /// Driven effects, each with its variant; days of 24 h from the start of the record as units.
    pub(super) effects: Vec<(EffectId, usize, Total)>,
}

impl Scores {
    /// Of a person with each of some backgrounds profiled out. `information` is A of the design, all days together.
    ///
    /// # Errors
    /// As [`course_scores`].
    pub(super) fn profiled<const N: usize>(
        person: &CalibratedPerson<'_>,
        design: &Design,
        information: &Mat<f64>,
        backgrounds: [&[Allowed]; N],
    ) -> Result<[Self; N], GapError> {
        let whitener = Whitener::of(person.calibration);
        let mut effects = Vec::with_capacity(N);
        let factors: [Vec<Lanes>; N] = backgrounds.map(|nuisances| {
            let mut lanes = drawn(design, nuisances);
            take_out(design, information, nuisances, &mut lanes);
            // Weighted, and with the sign of a score: what the model lacks is positive.
            for (row, weight) in lanes.iter_mut().zip(&design.weights) {
                *row = row.map(|value| -(*weight as f32) * value);
            }
            effects.push(of_effects(design, &lanes));
            whitener.back(&lanes)
        });
        let (model, filtered) = (&person.calibration.model, &person.calibration.filtered);
        let by_field = course_scores(model, person.observations, filtered, &FIELDS, &factors)?;
        let mut all = by_field.into_iter().zip(effects);
        Ok(std::array::from_fn(|_| {
            let (by_field, effects) = all.next().unwrap_or_default();
            Self { sums: by_field.iter().map(|rows| summed(rows)).collect(), effects }
        }))
    }

    /// The scores of a factor on a field over some steps; `field` is an index in [`FIELDS`].
    pub(super) fn over(&self, field: usize, steps: &Range<usize>) -> [f64; LANES] {
        let (start, end) = (&self.sums[field][steps.start], &self.sums[field][steps.end]);
        std::array::from_fn(|lane| end[lane] - start[lane])
    }
}

/// Sums up to each row, and of all.
fn summed(rows: &[Lanes]) -> Vec<[f64; LANES]> {
    let mut sum = [0.0; LANES];
    let mut sums = vec![sum];
    for row in rows {
        sum = std::array::from_fn(|lane| sum[lane] + f64::from(row[lane]));
        sums.push(sum);
    }
    sums
}

/// The innovations, and beside them draws of what they are where nothing is missing: noise, and a background from
/// its prior.
fn drawn(design: &Design, nuisances: &[Allowed]) -> Vec<Lanes> {
    // Each person's own, so that a cohort's information is as sure as all draws together; of the record alone, so
    // that the answer depends on no seed, name or order.
    let of_record = design.residuals.iter().fold(0_u64, |sum, r| sum.rotate_left(1) ^ r.to_bits());
    let mut rng = ChaCha8Rng::seed_from_u64(of_record);
    let mut sign = || if rng.random_bool(0.5) { 1.0f32 } else { -1.0 };
    let mut side_by_side = |data: f64, sd: f32| -> Lanes {
        std::array::from_fn(|lane| if lane == DATA { data as f32 } else { sd * sign() })
    };
    let mut lanes: Vec<Lanes> = Vec::with_capacity(design.residuals.len());
    for (weight, residual) in design.weights.iter().zip(&design.residuals) {
        let sd = if *weight > 0.0 { weight.sqrt().recip() as f32 } else { 0.0 };
        lanes.push(side_by_side(*residual, sd));
    }
    for direction in nuisances {
        let sizes = side_by_side(0.0, direction.sd as f32);
        add(&mut lanes, &design.signatures[direction.column], &sizes);
    }
    lanes
}

/// Takes out the background that is most probable.
fn take_out(design: &Design, information: &Mat<f64>, nuisances: &[Allowed], lanes: &mut [Lanes]) {
    let system = Mat::from_fn(nuisances.len(), nuisances.len(), |row, column| {
        let prior = if row == column { nuisances[row].sd.powi(-2) } else { 0.0 };
        prior + information[(nuisances[row].column, nuisances[column].column)]
    });
    let of_direction = |direction: &Allowed| {
        let steps = design.signatures[direction.column].iter().zip(&design.weights);
        let mut sum = [0.0; LANES];
        for ((signature, weight), row) in steps.zip(&*lanes) {
            let factor = weight * f64::from(*signature);
            sum = std::array::from_fn(|lane| sum[lane] - factor * f64::from(row[lane]));
        }
        sum[DATA] += direction.mean * direction.sd.powi(-2);
        sum
    };
    let scores: Vec<[f64; LANES]> = nuisances.iter().map(of_direction).collect();
    let scores = Mat::from_fn(scores.len(), LANES, |index, lane| scores[index][lane]);
    // A Gram matrix plus the precision of a proper prior.
    let Ok(factor) = system.llt(Side::Lower) else { return };
    let found = factor.solve(&scores);
    for (index, direction) in nuisances.iter().enumerate() {
        let sizes: Lanes = std::array::from_fn(|lane| found[(index, lane)] as f32);
        add(lanes, &design.signatures[direction.column], &sizes);
    }
}

fn add(lanes: &mut [Lanes], signature: &[f32], sizes: &Lanes) {
    for (row, value) in lanes.iter_mut().zip(signature) {
        *row = std::array::from_fn(|lane| row[lane] + value * sizes[lane]);
    }
}

/// Scores of the driven effects.
fn of_effects(design: &Design, weighted: &[Lanes]) -> Vec<(EffectId, usize, Total)> {
    let columns = design.columns.iter().zip(&design.signatures);
    columns
        .filter_map(|(column, signature)| {
            let Column::Effect { effect, variant } = *column else { return None };
            let days = signature.chunks(STEPS_PER_DAY).zip(weighted.chunks(STEPS_PER_DAY));
            let of_day = |(signature, rows): (&[f32], &[Lanes])| {
                let mut sum = [0.0; LANES];
                for (value, row) in signature.iter().zip(rows) {
                    sum = std::array::from_fn(|lane| sum[lane] + f64::from(value * row[lane]));
                }
                sum
            };
            let days: Vec<[f64; LANES]> = days.map(of_day).collect();
            Some((effect, variant, Total::of(days.iter().map(|day| (day, 1.0)))))
        })
        .collect()
}
