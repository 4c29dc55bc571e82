//! Figures of the report, drawn by the SVG backend of `plotters`.

mod agp;
mod canvas;
mod equivalence;
mod example_day;
mod forest;
mod palette;
mod panel;
mod training;
mod twins;

pub(crate) use agp::agp;
pub(crate) use canvas::Svg;
pub(crate) use equivalence::equivalence;
pub(crate) use example_day::example_day;
pub(crate) use forest::{ForestRow, forest};
pub(crate) use palette::{Key, Stroke};
pub(crate) use training::training;
pub(crate) use twins::twins;

/// A figure with the key to its lines.
pub(crate) type Drawn = (Svg, Vec<Key>);
