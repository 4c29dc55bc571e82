//! Figures of the report, drawn by the SVG backend of `plotters`.

mod agp;
mod before_after;
mod canvas;
mod equivalence;
mod error_pairs;
mod example_day;
mod forest;
mod palette;
mod panel;
mod port_course;
mod power;
mod reliability;
mod schematic;
mod slices;
mod targets;
mod training;
mod what_if;

pub(crate) use agp::agp;
pub(crate) use before_after::{Bars, before_after};
pub(crate) use equivalence::equivalence;
pub(crate) use error_pairs::{ErrorPair, error_pairs};
pub(crate) use example_day::example_day;
pub(crate) use forest::{ForestFrame, ForestRow, forest};
pub(crate) use palette::{Key, Stroke};
pub(crate) use port_course::port_course;
pub(crate) use power::power;
pub(crate) use reliability::reliability;
pub(crate) use schematic::{PortShade, schematic};
pub(crate) use slices::slices;
pub(crate) use targets::targets;
pub(crate) use training::training;
pub(crate) use what_if::what_if;

use canvas::Svg;

/// A figure with the key to its lines.
pub(crate) type Drawn = (Svg, Vec<Key>);
