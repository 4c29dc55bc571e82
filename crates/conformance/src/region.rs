//! Regions over which a property is asked: one interval a signal, in scaled units.
//!
//! The paper uses a training region and a generalisation region (its appendix "Conformance
//! verification results"); any box will do. A region is read from `region.json`, whose bounds are
//! in scaled or in physical units.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::io::Read;

use contract::region::{HalfSpace, RegionFile, Unit};
use rand::{Rng, RngExt as _};

use crate::error::{ConformanceError, require};
use crate::exact::Dyadic;
use crate::network::OneHiddenLayer;

/// How a signal is scaled: `scaled = (physical - centre) / scale` (paper, robust scaler).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scaling {
    /// Physical value that is scaled to zero.
    pub centre: f64,
    /// Physical length that is scaled to one, above zero.
    pub scale: f64,
}

impl Scaling {
    /// Refuses a scaling of `signal` that is not finite or whose scale is not above 0.
    pub(crate) fn checked(self, signal: &str) -> Result<Self, ConformanceError> {
        let Self { centre, scale } = self;
        if !centre.is_finite() || !scale.is_finite() || scale <= 0.0 {
            return Err(ConformanceError::Scaling { signal: signal.to_owned(), centre, scale });
        }
        Ok(self)
    }
}

/// A signal that a region may bound.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// Its name: a state (`Q1`, ...) or an input (`u_insulin`, `u_carbs`).
    pub name: String,
    /// Its scaling, needed where a region is given in physical units.
    pub scaling: Option<Scaling>,
}

impl Signal {
    /// A signal known by name only; regions that bound it must be scaled.
    #[must_use]
    pub fn scaled(name: &str) -> Self {
        Self { name: name.to_owned(), scaling: None }
    }
}

/// One closed interval a signal, scaled units, finite, lower bound not above upper bound.
///
/// Half-spaces may cut pieces off: the region is then a polytope. A network sees those of them that speak of its inputs alone;
/// what is proved for it holds on the rest all the more.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    bounds: BTreeMap<String, [f64; 2]>,
    half_spaces: Vec<HalfSpace>,
}

/// The part of a [`Region`] that one network sees: bounds in the order of its inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct BoxRegion {
    lower: Vec<f64>,
    upper: Vec<f64>,
    /// Weights of the inputs and the largest value of their sum.
    half_spaces: Vec<(Vec<f64>, f64)>,
}

impl Region {
    /// A region from `(name, [lower, upper])` pairs in scaled units.
    ///
    /// # Errors
    /// [`ConformanceError::RegionDuplicate`], [`ConformanceError::RegionNonFinite`],
    /// [`ConformanceError::RegionOrder`].
    pub fn scaled<N: Into<String>>(
        bounds: impl IntoIterator<Item = (N, [f64; 2])>,
    ) -> Result<Self, ConformanceError> {
        let mut region = Self { bounds: BTreeMap::new(), half_spaces: Vec::new() };
        for (signal, interval) in bounds {
            region.insert(signal.into(), interval)?;
        }
        Ok(region)
    }

    /// A region from the text of a `region.json`.
    ///
    /// `signals` are the names that may be bounded. Physical bounds are converted by each signal's
    /// scaling and rounded outwards, so that the scaled box contains the physical one.
    ///
    /// # Errors
    /// The `Region...` variants of [`ConformanceError`], and [`ConformanceError::Scaling`].
    pub fn from_json(mut source: impl Read, signals: &[Signal]) -> Result<Self, ConformanceError> {
        let mut bytes = Vec::new();
        source.read_to_end(&mut bytes).map_err(ConformanceError::RegionRead)?;
        let file: RegionFile = contract::read(&bytes).map_err(ConformanceError::RegionForm)?;
        let mut region = Self { bounds: BTreeMap::new(), half_spaces: Vec::new() };
        for (name, interval) in file.bounds {
            let signal = signals.iter().find(|signal| signal.name == name).ok_or_else(|| {
                ConformanceError::RegionUnknown {
                    signal: name.clone(),
                    known: signals.iter().map(|signal| signal.name.clone()).collect(),
                }
            })?;
            check_interval(&name, interval)?;
            let interval = match file.unit {
                Unit::Scaled => interval,
                Unit::Physical => to_scaled(signal, interval)?,
            };
            region.insert(name, interval)?;
        }
        for half_space in file.half_spaces {
            let half_space = match file.unit {
                Unit::Scaled => half_space,
                Unit::Physical => half_space_to_scaled(&half_space, signals, &region)?,
            };
            region = region.within(half_space.weights, half_space.at_most)?;
        }
        Ok(region)
    }

    /// The part of the region in which a weighted sum of signals is at most a number (scaled units).
    ///
    /// # Errors
    /// [`ConformanceError::HalfSpace`] for weights or a number that are not finite, for no weight but 0, or for a signal
    /// that the region does not bound.
    pub fn within<N: Into<String>>(
        mut self,
        weights: impl IntoIterator<Item = (N, f64)>,
        at_most: f64,
    ) -> Result<Self, ConformanceError> {
        let weights: BTreeMap<String, f64> =
            weights.into_iter().map(|(name, weight)| (name.into(), weight)).collect();
        let reason = if weights.values().chain([&at_most]).any(|value| !value.is_finite()) {
            Some("a weight or the bound is not a finite number".to_owned())
        } else if weights.values().all(|weight| *weight == 0.0) {
            Some("no weight differs from 0".to_owned())
        } else {
            let unknown = weights.keys().find(|name| !self.bounds.contains_key(*name));
            unknown.map(|name| format!("the region has no bounds for '{name}'"))
        };
        if let Some(reason) = reason {
            return Err(ConformanceError::HalfSpace { number: self.half_spaces.len(), reason });
        }
        self.half_spaces.push(HalfSpace { weights, at_most });
        Ok(self)
    }

    /// The region as `region.json`, scaled units.
    #[must_use]
    pub fn file(&self) -> RegionFile {
        RegionFile {
            bounds: self.bounds.clone(),
            half_spaces: self.half_spaces.clone(),
            unit: Unit::Scaled,
        }
    }

    /// The half-spaces, in the order in which they were named.
    #[must_use]
    pub fn half_spaces(&self) -> &[HalfSpace] {
        &self.half_spaces
    }

    /// Every interval longer by a share of its length at both ends.
    ///
    /// # Errors
    /// [`ConformanceError::Limit`] for a share below 0, [`ConformanceError::RegionNonFinite`] where an end leaves the
    /// numbers.
    pub fn widened(&self, share: f64) -> Result<Self, ConformanceError> {
        require(share.is_finite() && share >= 0.0, "widen", share, "0 or more")?;
        let wider = Self::scaled(self.bounds.iter().map(|(name, [lower, upper])| {
            let more = share * (upper - lower);
            (name.clone(), [lower - more, upper + more])
        }))?;
        Ok(Self { half_spaces: self.half_spaces.clone(), ..wider })
    }

    /// Every signal with its bounds, scaled units, by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, [f64; 2])> {
        self.bounds.iter().map(|(name, bounds)| (name.as_str(), *bounds))
    }

    /// The bounds of a signal, scaled units.
    #[must_use]
    pub fn bounds(&self, signal: &str) -> Option<[f64; 2]> {
        self.bounds.get(signal).copied()
    }

    /// The bounds of the inputs of `network`, in its order.
    ///
    /// # Errors
    /// [`ConformanceError::RegionMissing`].
    pub fn box_of(&self, network: &OneHiddenLayer) -> Result<BoxRegion, ConformanceError> {
        let ends = network.inputs().iter().map(|input| {
            self.bounds(input).ok_or_else(|| ConformanceError::RegionMissing {
                signal: input.clone(),
                network: network.output().to_owned(),
            })
        });
        let ends: Vec<[f64; 2]> = ends.collect::<Result<_, _>>()?;
        let (lower, upper) = ends.into_iter().map(|[lower, upper]| (lower, upper)).unzip();
        let half_spaces = self
            .half_spaces
            .iter()
            .filter_map(|half_space| {
                let weighted = half_space.weights.iter().filter(|(_, weight)| **weight != 0.0);
                let mut weights = vec![0.0; network.inputs().len()];
                for (name, weight) in weighted {
                    let index = network.inputs().iter().position(|input| input == name)?;
                    weights[index] = *weight;
                }
                Some((weights, half_space.at_most))
            })
            .collect();
        Ok(BoxRegion { lower, upper, half_spaces })
    }

    fn insert(&mut self, signal: String, interval: [f64; 2]) -> Result<(), ConformanceError> {
        check_interval(&signal, interval)?;
        if self.bounds.contains_key(&signal) {
            return Err(ConformanceError::RegionDuplicate(signal));
        }
        self.bounds.insert(signal, interval);
        Ok(())
    }
}

impl BoxRegion {
    /// Lower bounds, one per input of the network.
    #[must_use]
    pub fn lower(&self) -> &[f64] {
        &self.lower
    }

    /// Upper bounds, one per input of the network.
    #[must_use]
    pub fn upper(&self) -> &[f64] {
        &self.upper
    }

    /// Lower and upper bound of each input of the network.
    pub(crate) fn ends(&self) -> impl Iterator<Item = (f64, f64)> + Clone {
        self.lower.iter().copied().zip(self.upper.iter().copied())
    }

    /// Weights of the inputs and the largest value of their sum, of each half-space that speaks of these inputs alone.
    #[must_use]
    pub fn half_spaces(&self) -> &[(Vec<f64>, f64)] {
        &self.half_spaces
    }

    /// How far the tested input of a point may grow at most without leaving the region, rounded towards the point.
    pub(crate) fn reach(&self, point: &[f64], tested: usize) -> f64 {
        let mut limit = self.upper[tested];
        for (weights, at_most) in &self.half_spaces {
            if weights[tested] > 0.0 {
                let sum: f64 = weights.iter().zip(point).map(|(w, x)| w * x).sum();
                limit = limit.min(point[tested] + (at_most - sum) / weights[tested]);
            }
        }
        let mut moved = point.to_vec();
        moved[tested] = limit;
        while limit > point[tested] && !self.contains(&moved) {
            limit = point[tested] + (limit - point[tested]) * 0.999;
            moved[tested] = limit;
            if limit - point[tested] < 1e-12 * (1.0 + limit.abs()) {
                return point[tested];
            }
        }
        limit
    }

    /// Whether `point` lies in the region, decided exactly.
    #[must_use]
    pub fn contains(&self, point: &[f64]) -> bool {
        point.len() == self.lower.len()
            && point.iter().zip(self.ends()).all(|(x, (lower, upper))| lower <= *x && *x <= upper)
            && self.half_spaces.iter().all(|(weights, at_most)| {
                Dyadic::affine(-at_most, weights, point).sign() != Ordering::Greater
            })
    }

    /// A point of the box, half-spaces aside, each coordinate uniform between its bounds.
    pub(crate) fn drawn(&self, rng: &mut impl Rng) -> Vec<f64> {
        self.ends().map(|(lower, upper)| lower + (upper - lower) * rng.random::<f64>()).collect()
    }
}

fn check_interval(signal: &str, [lower, upper]: [f64; 2]) -> Result<(), ConformanceError> {
    let signal = signal.to_owned();
    if !lower.is_finite() || !upper.is_finite() {
        return Err(ConformanceError::RegionNonFinite { signal, lower, upper });
    }
    if lower > upper {
        return Err(ConformanceError::RegionOrder { signal, lower, upper });
    }
    Ok(())
}

/// `(physical - centre) / scale`, rounded outwards by two units in the last place per operation.
fn to_scaled(signal: &Signal, [lower, upper]: [f64; 2]) -> Result<[f64; 2], ConformanceError> {
    let name = &signal.name;
    let scaling = signal.scaling.ok_or_else(|| ConformanceError::RegionNoScaling(name.clone()))?;
    let Scaling { centre, scale } = scaling.checked(name)?;
    let down = ((lower - centre).next_down() / scale).next_down();
    let up = ((upper - centre).next_up() / scale).next_up();
    Ok([down, up])
}

/// From physical units: `sum of w (centre + scale x)`, the bound rounded outwards.
fn half_space_to_scaled(
    from: &HalfSpace,
    signals: &[Signal],
    region: &Region,
) -> Result<HalfSpace, ConformanceError> {
    let (mut at_most, mut size) = (from.at_most, from.at_most.abs());
    let mut weights = BTreeMap::new();
    for (name, weight) in &from.weights {
        let scaling = signals.iter().find(|signal| signal.name == *name).and_then(|s| s.scaling);
        let Some(Scaling { centre, scale }) = scaling else {
            return Err(ConformanceError::RegionNoScaling(name.clone()));
        };
        let reach = region.bounds(name).map_or(0.0, |[l, u]| l.abs().max(u.abs()));
        at_most -= weight * centre;
        size += (weight * centre).abs() + (weight * scale).abs() * reach;
        weights.insert(name.clone(), weight * scale);
    }
    let slack = 4.0 * (from.weights.len() as f64 + 2.0) * f64::EPSILON * size;
    Ok(HalfSpace { weights, at_most: at_most + slack })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signals() -> Vec<Signal> {
        let scaling = Some(Scaling { centre: 118.0, scale: 80.0 });
        vec![Signal { name: "Q1".to_owned(), scaling }, Signal::scaled("X1")]
    }

    fn parse(text: &str) -> Result<Region, String> {
        Region::from_json(text.as_bytes(), &signals()).map_err(|error| error.to_string())
    }

    #[test]
    fn reads_scaled_and_physical_bounds() {
        let region = parse(r#"{"unit": "scaled", "bounds": {"Q1": [-1, 2.5], "X1": [0, 0]}}"#)
            .expect("valid region");
        assert_eq!(region.bounds("Q1"), Some([-1.0, 2.5]));
        assert_eq!(region.bounds("X1"), Some([0.0, 0.0]));
        assert_eq!(region.bounds("X2"), None);

        let region =
            parse(r#"{"unit": "physical", "bounds": {"Q1": [38, 398]}}"#).expect("valid region");
        let [lower, upper] = region.bounds("Q1").expect("bounded");
        // (38 - 118)/80 = -1 and (398 - 118)/80 = 3.5; outward rounding moves each by a few units
        // in the last place and never inwards.
        assert!(lower < -1.0 && -1.0 - lower < 4.0 * f64::EPSILON, "{lower}");
        assert!(upper > 3.5 && upper - 3.5 < 16.0 * f64::EPSILON, "{upper}");
    }

    #[test]
    fn refuses_bad_regions() {
        let cases = [
            (r#"{"unit": "scaled", "bounds": {"Q9": [0, 1]}}"#, "unknown signal 'Q9'"),
            (r#"{"unit": "scaled", "bounds": {"Q1": [2, 1]}}"#, "above its upper bound"),
            (r#"{"unit": "scaled", "bounds": {"Q1": [0, 1], "Q1": [0, 2]}}"#, "bounded twice"),
            (r#"{"unit": "scaled", "bounds": {}, "bound": {}}"#, "unknown field `bound`"),
            (r#"{"unit": "physical", "bounds": {"X1": [0, 1]}}"#, "scaling is unknown"),
            (r#"{"unit": "mg", "bounds": {}}"#, "not of the form"),
            (r#"{"unit": "scaled", "bounds": {"Q1": [0]}}"#, "not of the form"),
            (r#"{"unit": "scaled", "bounds": {"Q1": [0, 1e999]}}"#, "not of the form"),
            (r#"{"bounds": {}}"#, "not of the form"),
        ];
        for (text, message) in cases {
            let error = parse(text).expect_err(text);
            assert!(error.contains(message), "{text}: {error}");
        }
        let nan = Region::scaled([("Q1", [f64::NAN, 1.0])]).expect_err("NaN bound");
        assert!(nan.to_string().contains("both must be finite"), "{nan}");
        let no_scale =
            Signal { name: "Q1".to_owned(), scaling: Some(Scaling { centre: 0.0, scale: 0.0 }) };
        let text = r#"{"unit": "physical", "bounds": {"Q1": [0, 1]}}"#;
        assert!(Region::from_json(text.as_bytes(), &[no_scale]).is_err());
    }
}
