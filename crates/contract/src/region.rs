//! `region.json`: the region over which properties are asked.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::{Deserializer, Error as _, MapAccess, Visitor};

/// One interval a signal, and half-spaces that cut pieces off.
#[apply(strict!)]
pub struct RegionFile {
    /// Least and greatest value of each signal, in `unit`. No signal stands twice.
    #[serde(deserialize_with = "once")]
    pub bounds: BTreeMap<String, [f64; 2]>,
    /// Half-spaces that cut pieces off the bounds, in `unit`; absent where there is none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub half_spaces: Vec<HalfSpace>,
    /// The unit of all numbers.
    pub unit: Unit,
}

/// In what unit a region is given.
#[apply(word!)]
pub enum Unit {
    /// As the network sees the signals.
    Scaled,
    /// Each signal in its physical unit.
    Physical,
}

/// The points at which a weighted sum of signals is at most a number.
#[apply(strict!)]
pub struct HalfSpace {
    /// The largest value of the sum.
    pub at_most: f64,
    /// Weight of each signal; those that are not named have none.
    pub weights: BTreeMap<String, f64>,
}

/// Reads a map and refuses a name that stands in it twice.
fn once<'de, D: Deserializer<'de>>(source: D) -> Result<BTreeMap<String, [f64; 2]>, D::Error> {
    struct Entries;
    impl<'de> Visitor<'de> for Entries {
        type Value = BTreeMap<String, [f64; 2]>;

        fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
            formatter.write_str("an object of [lower, upper] pairs")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
            let mut entries = BTreeMap::new();
            while let Some((name, interval)) = map.next_entry::<String, _>()? {
                if entries.contains_key(&name) {
                    return Err(A::Error::custom(format!("'{name}' is bounded twice; keep one")));
                }
                entries.insert(name, interval);
            }
            Ok(entries)
        }
    }
    source.deserialize_map(Entries)
}
