//! Regions over which a property is asked: one interval a signal, in scaled units.
//!
//! The paper uses a training region and a generalisation region (its appendix "Conformance
//! verification results"); any box will do. A region is read from `region.json`, whose bounds are
//! in scaled or in physical units.

use std::collections::BTreeMap;
use std::fmt;
use std::io::Read;

use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer};

use crate::error::ConformanceError;
use crate::network::OneHiddenLayer;

/// How a signal is scaled: `scaled = (physical - centre) / scale` (paper, robust scaler).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scaling {
    /// Physical value that is scaled to zero.
    pub centre: f64,
    /// Physical length that is scaled to one, above zero.
    pub scale: f64,
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
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    bounds: BTreeMap<String, [f64; 2]>,
}

/// The part of a [`Region`] that one network sees: bounds in the order of its inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct BoxRegion {
    lower: Vec<f64>,
    upper: Vec<f64>,
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
        let mut region = Self { bounds: BTreeMap::new() };
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
        let mut text = String::new();
        source.read_to_string(&mut text).map_err(ConformanceError::RegionRead)?;
        let file: RegionFile = serde_json::from_str(&text).map_err(ConformanceError::RegionForm)?;
        let mut region = Self { bounds: BTreeMap::new() };
        for (name, interval) in file.bounds.0 {
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
        Ok(region)
    }

    /// Every interval longer by a share of its length at both ends.
    ///
    /// # Errors
    /// [`ConformanceError::Limit`] for a share below 0, [`ConformanceError::RegionNonFinite`] where an end leaves the
    /// numbers.
    pub fn widened(&self, share: f64) -> Result<Self, ConformanceError> {
        if !(share.is_finite() && share >= 0.0) {
            let range = "0 or more";
            return Err(ConformanceError::Limit { limit: "widen", value: share, range });
        }
        Self::scaled(self.bounds.iter().map(|(name, [lower, upper])| {
            let more = share * (upper - lower);
            (name.clone(), [lower - more, upper + more])
        }))
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
        let mut lower = Vec::with_capacity(network.inputs().len());
        let mut upper = Vec::with_capacity(network.inputs().len());
        for input in network.inputs() {
            let [lo, hi] = self.bounds(input).ok_or_else(|| ConformanceError::RegionMissing {
                signal: input.clone(),
                network: network.output().to_owned(),
            })?;
            lower.push(lo);
            upper.push(hi);
        }
        Ok(BoxRegion { lower, upper })
    }

    fn insert(&mut self, signal: String, interval: [f64; 2]) -> Result<(), ConformanceError> {
        check_interval(&signal, interval)?;
        if self.bounds.contains_key(&signal) {
            return Err(ConformanceError::RegionDuplicate { signal });
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

    /// Whether `point` lies in the box.
    #[must_use]
    pub fn contains(&self, point: &[f64]) -> bool {
        point.len() == self.lower.len()
            && point
                .iter()
                .zip(&self.lower)
                .zip(&self.upper)
                .all(|((x, lower), upper)| lower <= x && x <= upper)
    }

    /// Refuses a box that leaves the tested input a single value.
    pub(crate) fn check_free(
        &self,
        network: &OneHiddenLayer,
        tested: usize,
    ) -> Result<(), ConformanceError> {
        if self.lower[tested] < self.upper[tested] {
            return Ok(());
        }
        Err(ConformanceError::FixedInput {
            network: network.output().to_owned(),
            input: network.inputs()[tested].clone(),
            value: self.lower[tested],
        })
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
    let name = signal.name.clone();
    let Scaling { centre, scale } =
        signal.scaling.ok_or_else(|| ConformanceError::RegionNoScaling { signal: name.clone() })?;
    if !centre.is_finite() || !scale.is_finite() || scale <= 0.0 {
        return Err(ConformanceError::Scaling { signal: name, centre, scale });
    }
    let down = ((lower - centre).next_down() / scale).next_down();
    let up = ((upper - centre).next_up() / scale).next_up();
    check_interval(&signal.name, [down, up])?;
    Ok([down, up])
}

#[derive(Deserialize)]
struct RegionFile {
    unit: Unit,
    bounds: Bounds,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Unit {
    Scaled,
    Physical,
}

/// The entries of `bounds` as written, so that a repeated name can be refused.
struct Bounds(Vec<(String, [f64; 2])>);

impl<'de> Deserialize<'de> for Bounds {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Entries;
        impl<'de> Visitor<'de> for Entries {
            type Value = Bounds;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("an object of [lower, upper] pairs")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Bounds, A::Error> {
                let mut entries = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    entries.push(entry);
                }
                Ok(Bounds(entries))
            }
        }
        deserializer.deserialize_map(Entries)
    }
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
