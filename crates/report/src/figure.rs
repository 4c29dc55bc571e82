//! Figures of the report, drawn by the SVG backend of `plotters`: what they are made of, and those that
//! several sections show or that need much room.

mod agp;
mod canvas;
mod equivalence;
mod error_pairs;
mod forest;
pub(crate) mod palette;
mod panel;
mod schematic;

pub(crate) use agp::agp;
pub(crate) use canvas::{Canvas, Drawn, WIDTH, draw};
pub(crate) use equivalence::equivalence;
pub(crate) use error_pairs::{ErrorPair, error_pairs};
pub(crate) use forest::{ForestFrame, ForestRow, forest, shortened};
pub(crate) use palette::Key;
pub(crate) use panel::{Axis, Panel};
pub(crate) use schematic::{PortShade, schematic};
