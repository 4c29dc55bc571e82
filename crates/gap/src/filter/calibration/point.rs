//! The record under some factors: innovations, their derivatives, and what days say of the factors.

use physiology::STEPS_PER_DAY;

use super::information::{DayInformation, Information};
use super::{Factors, PersonalFactors, Setting, directions};
use crate::error::GapError;
use crate::filter::augmented::AugmentedModel;
use crate::filter::kalman::{Filtered, Innovation, filter, replayed};
use crate::filter::scored::{Whitening, cautious_scale, normalised};
use crate::filter::tangent::{Along, Fork, Lanes, few_at_a_time, filtered_along};
use crate::filter::whitening::huber_loss;

/// What is held while the factors are searched: gains and variances of the filter with some parameters, and the
/// whitening of its innovations.
pub(super) struct FixedGains {
    pub(super) filtered: Filtered,
    pub(super) whitening: Whitening,
}

impl FixedGains {
    pub(super) fn of(setting: &Setting<'_>, factors: &PersonalFactors) -> Result<Self, GapError> {
        Ok(Self::by(setting, filter(&setting.model(factors), setting.record)?))
    }

    fn by(setting: &Setting<'_>, filtered: Filtered) -> Self {
        let z = normalised(&filtered.innovations, &setting.scored);
        let (whitening, _) = Whitening::fitted(&z, cautious_scale);
        Self { filtered, whitening }
    }
}

/// The record under some factors.
pub(super) struct Point {
    pub(super) factors: PersonalFactors,
    /// Innovations in their standard deviations, and their derivatives.
    pub(super) z: Vec<Option<f64>>,
    pub(super) signatures: Vec<Factors>,
    whitened: Vec<Option<f64>>,
    pub(super) information: Information,
}

impl Point {
    pub(super) fn at(
        setting: &Setting<'_>,
        held: &FixedGains,
        factors: PersonalFactors,
    ) -> Result<Self, GapError> {
        let model = setting.model(&factors);
        let run = replayed(&model, setting.record, &held.filtered)?;
        let directions = directions();
        let mut signatures: Vec<Factors> = Vec::new();
        few_at_a_time(&model, setting.record, &run, &directions, |_, rows| {
            signatures = scaled(&run.innovations, rows).collect();
        })?;
        Ok(Self::of(setting, held, factors, &run.innovations, signatures))
    }

    fn of(
        setting: &Setting<'_>,
        held: &FixedGains,
        factors: PersonalFactors,
        innovations: &[Option<Innovation>],
        signatures: Vec<Factors>,
    ) -> Self {
        let z = normalised(innovations, &setting.scored);
        let whitened = held.whitening.autoregression.whitened(&z);
        let information = Information::of((0..z.len().div_ceil(STEPS_PER_DAY)).map(|index| {
            let mut day = DayInformation { index, ..DayInformation::default() };
            let first = index * STEPS_PER_DAY;
            let steps = first..z.len().min(first + STEPS_PER_DAY);
            day.add(&held.whitening, &z, &signatures, steps, 1.0);
            day
        }));
        Self { factors, z, signatures, whitened, information }
    }

    /// Negative log posterior, the data's part divided by `dependence`, nats.
    pub(super) fn loss(&self, held: &FixedGains, dependence: f64) -> f64 {
        let of = |w: &f64| huber_loss(w / held.whitening.scale, 1.0);
        self.whitened.iter().flatten().map(of).sum::<f64>() / dependence + self.factors.prior_loss()
    }
}

/// Derivatives in standard deviations of the innovations, the factors beside each other.
pub(super) fn scaled(
    innovations: &[Option<Innovation>],
    rows: &[Lanes],
) -> impl Iterator<Item = Factors> {
    innovations.iter().zip(rows).map(|(innovation, row)| {
        let inverse = innovation.map_or(0.0, |i| i.variance.sqrt().recip());
        std::array::from_fn(|k| inverse * f64::from(row[k]))
    })
}

/// A person's own gains, and the record under them.
pub(super) struct OwnGains {
    pub(super) model: AugmentedModel,
    pub(super) held: FixedGains,
    pub(super) point: Point,
    /// Where logged meals can be left out.
    pub(super) forks: Vec<Fork>,
}

impl OwnGains {
    /// `struck`: the steps of the meals that can be left out.
    pub(super) fn of(
        setting: &Setting<'_>,
        factors: PersonalFactors,
        struck: &[usize],
    ) -> Result<Self, GapError> {
        let model = setting.model(&factors);
        let Along { filtered, blocks, forks } =
            filtered_along(&model, setting.record, &directions(), struck)?;
        let held = FixedGains::by(setting, filtered);
        let innovations = &held.filtered.innovations;
        // All factors are in one block.
        let signatures = blocks.iter().flat_map(|(_, rows)| scaled(innovations, rows)).collect();
        let point = Point::of(setting, &held, factors, innovations, signatures);
        Ok(Self { model, held, point, forks })
    }
}
