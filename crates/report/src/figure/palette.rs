//! Colours, line styles and markers.
//!
//! The colours are Okabe and Ito's (2008), which people with the three common kinds of colour
//! blindness can distinguish. Every line also has its own dash pattern and every marker its own
//! shape, so nothing is lost in greyscale.

use plotters::style::RGBColor;

/// Black.
pub(crate) const BLACK: RGBColor = RGBColor(0, 0, 0);
/// Okabe-Ito blue.
pub(crate) const BLUE: RGBColor = RGBColor(0, 114, 178);
/// Okabe-Ito vermillion.
pub(crate) const VERMILLION: RGBColor = RGBColor(213, 94, 0);
/// Okabe-Ito bluish green.
pub(crate) const GREEN: RGBColor = RGBColor(0, 158, 115);
/// Okabe-Ito reddish purple.
pub(crate) const PURPLE: RGBColor = RGBColor(204, 121, 167);
/// Okabe-Ito sky blue.
pub(crate) const SKY: RGBColor = RGBColor(86, 180, 233);
/// Okabe-Ito orange.
pub(crate) const ORANGE: RGBColor = RGBColor(230, 159, 0);
/// Grid lines.
pub(crate) const GRID: RGBColor = RGBColor(221, 221, 221);
/// Shaded ranges.
pub(crate) const SHADE: RGBColor = RGBColor(236, 236, 236);
/// Axes and weak marks.
pub(crate) const GREY: RGBColor = RGBColor(110, 110, 110);

/// How a line looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stroke {
    /// Colour.
    pub(crate) colour: RGBColor,
    /// Width in canvas units.
    pub(crate) width: u32,
    /// Dash and gap in canvas units; `None` for an unbroken line.
    pub(crate) dash: Option<(i32, i32)>,
}

/// An unbroken line.
pub(crate) const fn solid(colour: RGBColor, width: u32) -> Stroke {
    Stroke { colour, width, dash: None }
}

/// A broken line.
pub(crate) const fn dashed(colour: RGBColor, width: u32, on: i32, off: i32) -> Stroke {
    Stroke { colour, width, dash: Some((on, off)) }
}

/// What was measured.
pub(crate) const MEASURED: Stroke = solid(BLACK, 4);
/// The twin.
pub(crate) const TWIN: Stroke = dashed(BLUE, 5, 22, 8);
/// The population network.
pub(crate) const POPULATION: Stroke = dashed(VERMILLION, 4, 5, 9);
/// The ODE model.
pub(crate) const ODE: Stroke = dashed(GREEN, 3, 36, 18);
/// The closest virtual patient.
pub(crate) const CLOSEST: Stroke = dashed(PURPLE, 4, 14, 6);

/// Shape of a marker.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Marker {
    /// Filled disc.
    Disc,
    /// Open circle.
    Ring,
    /// Filled square.
    Square,
    /// Filled triangle.
    Triangle,
    /// Filled diamond.
    Diamond,
    /// Two crossed lines.
    Cross,
}

impl Marker {
    /// Markers in the order in which methods get them.
    pub(crate) const CYCLE: [Self; 6] =
        [Self::Disc, Self::Triangle, Self::Square, Self::Diamond, Self::Ring, Self::Cross];

    /// The marker in the middle of a 44 x 14 swatch; `COLOUR` stands for the colour.
    pub(crate) const fn swatch(self) -> &'static str {
        match self {
            Self::Disc => "<circle cx=\"22\" cy=\"7\" r=\"5.5\" fill=\"COLOUR\"/>",
            Self::Ring => {
                "<circle cx=\"22\" cy=\"7\" r=\"5\" fill=\"#fff\" stroke=\"COLOUR\" stroke-width=\"2\"/>"
            }
            Self::Square => "<path d=\"M17 2h10v10h-10z\" fill=\"COLOUR\"/>",
            Self::Triangle => "<path d=\"M22 1l6 11h-12z\" fill=\"COLOUR\"/>",
            Self::Diamond => "<path d=\"M22 0l7 7-7 7-7-7z\" fill=\"COLOUR\"/>",
            Self::Cross => {
                "<path d=\"M17 2l10 10M27 2l-10 10\" stroke=\"COLOUR\" stroke-width=\"2.5\"/>"
            }
        }
    }
}

/// Colours in the order in which methods get them.
pub(crate) const COLOURS: [RGBColor; 6] = [BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY];

/// One entry of a figure's key, written as HTML so that it wraps on a phone.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Key {
    /// What it stands for.
    pub(crate) label: String,
    /// Colour and dash.
    pub(crate) stroke: Stroke,
    /// Opacity of a filled area; `None` for a line.
    pub(crate) area: Option<f64>,
    /// Marker on the line.
    pub(crate) marker: Option<Marker>,
}

impl Key {
    /// A line.
    pub(crate) fn line(label: &str, stroke: Stroke) -> Self {
        Self { label: label.to_owned(), stroke, area: None, marker: None }
    }

    /// A filled area.
    pub(crate) fn area(label: &str, colour: RGBColor, opacity: f64) -> Self {
        Self { area: Some(opacity), ..Self::line(label, solid(colour, 1)) }
    }

    /// A marker with its interval line.
    pub(crate) fn marker(label: &str, stroke: Stroke, marker: Marker) -> Self {
        Self { marker: Some(marker), ..Self::line(label, stroke) }
    }
}
