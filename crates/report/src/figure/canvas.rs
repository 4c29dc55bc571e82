//! A blank SVG and the few marks that the figures need, in canvas units.
//!
//! The canvas is 1,000 units wide for any page. Letters are 33 units high, which is 11 pixels in a
//! card on a 400-pixel phone.

use std::cell::RefCell;
use std::fmt::Write as _;

use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::{
    Circle, DrawingArea, IntoDrawingArea, PathElement, Polygon, Rectangle, SVGBackend, Text,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontFamily, RGBColor, TextStyle, WHITE};

use super::palette::{BLACK, Marker, Stroke};
use crate::ReportError;
use crate::html::escape_into;

/// Width of every figure, canvas units.
pub(super) const WIDTH: i32 = 1000;
/// Height of letters in the drawing library's measure (it divides by 1.24).
const LETTER: f64 = 41.0;
/// Half the size of a marker.
const MARK: i32 = 11;

/// A point on the canvas.
pub(super) type At = (i32, i32);

/// A finished figure: an `svg` element.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Svg(String);

impl Svg {
    /// The markup.
    pub(crate) fn markup(&self) -> &str {
        &self.0
    }
}

/// The canvas for the marks.
pub(super) struct Canvas<'a> {
    area: DrawingArea<SVGBackend<'a>, Shift>,
    name: &'a str,
    /// Places with words that show when a pointer rests there.
    hovers: RefCell<String>,
}

/// Draws a figure of `height` canvas units; `label` describes it for a screen reader.
pub(super) fn draw(
    label: &str,
    height: i32,
    marks: impl FnOnce(&Canvas<'_>) -> Result<(), ReportError>,
) -> Result<Svg, ReportError> {
    let mut drawn = String::new();
    let hovers = {
        let size = (WIDTH as u32, height.unsigned_abs());
        let area = SVGBackend::with_string(&mut drawn, size).into_drawing_area();
        let canvas = Canvas { area, name: label, hovers: RefCell::default() };
        canvas.accept(canvas.area.fill(&WHITE))?;
        marks(&canvas)?;
        canvas.accept(canvas.area.present())?;
        canvas.hovers.take()
    };
    // The backend fixes width and height in pixels; a page that must fit a phone must not.
    let body = drawn.split_once('>').map_or("", |(_, body)| body);
    let body = body.trim_end().trim_end_matches("</svg>");
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" role=\"img\" \
         aria-label=\""
    );
    escape_into(&mut svg, label);
    svg.push_str("\">");
    svg.push_str(body);
    svg.push_str(&hovers);
    svg.push_str("</svg>\n");
    Ok(Svg(svg))
}

impl Canvas<'_> {
    fn accept<E: std::fmt::Display>(&self, result: Result<(), E>) -> Result<(), ReportError> {
        result.map_err(|error| ReportError::Figure {
            figure: self.name.to_owned(),
            message: error.to_string(),
        })
    }

    /// Words that show when a pointer rests within a box.
    pub(super) fn hover(&self, (x, y): At, (right, bottom): At, words: &str) {
        let (left, top) = (x.min(right), y.min(bottom));
        let (width, height) = ((right - x).abs().max(1), (bottom - y).abs().max(1));
        let mut hovers = self.hovers.borrow_mut();
        let _ = write!(
            hovers,
            "<rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" fill=\"transparent\"><title>"
        );
        escape_into(&mut hovers, words);
        hovers.push_str("</title></rect>\n");
    }

    /// A line through points.
    pub(super) fn path(&self, points: Vec<At>, stroke: Stroke) -> Result<(), ReportError> {
        let style = stroke.colour.stroke_width(stroke.width);
        match stroke.dash {
            None => self.accept(self.area.draw(&PathElement::new(points, style))),
            Some((on, off)) => {
                self.accept(self.area.draw(&DashedPathElement::new(points, on, off, style)))
            }
        }
    }

    /// A filled shape.
    pub(super) fn fill(
        &self,
        outline: Vec<At>,
        colour: RGBColor,
        opacity: f64,
    ) -> Result<(), ReportError> {
        self.accept(self.area.draw(&Polygon::new(outline, colour.mix(opacity).filled())))
    }

    /// A filled box.
    pub(super) fn rectangle(
        &self,
        corner: At,
        opposite: At,
        colour: RGBColor,
        opacity: f64,
    ) -> Result<(), ReportError> {
        let style = colour.mix(opacity).filled();
        self.accept(self.area.draw(&Rectangle::new([corner, opposite], style)))
    }

    /// A marker centred on a point.
    pub(super) fn marker(
        &self,
        (x, y): At,
        marker: Marker,
        colour: RGBColor,
    ) -> Result<(), ReportError> {
        let line = |from: At, to: At| self.path(vec![from, to], super::palette::solid(colour, 4));
        match marker {
            Marker::Disc => {
                self.accept(self.area.draw(&Circle::new((x, y), MARK, colour.filled())))
            }
            Marker::Ring => {
                self.accept(self.area.draw(&Circle::new((x, y), MARK - 1, WHITE.filled())))?;
                self.accept(self.area.draw(&Circle::new((x, y), MARK - 2, colour.stroke_width(4))))
            }
            Marker::Square => {
                self.rectangle((x - MARK, y - MARK), (x + MARK, y + MARK), colour, 1.0)
            }
            Marker::Triangle => {
                let points =
                    vec![(x, y - MARK - 2), (x + MARK + 1, y + MARK), (x - MARK - 1, y + MARK)];
                self.fill(points, colour, 1.0)
            }
            Marker::Diamond => {
                let r = MARK + 3;
                self.fill(vec![(x, y - r), (x + r, y), (x, y + r), (x - r, y)], colour, 1.0)
            }
            Marker::Cross => {
                line((x - MARK, y - MARK), (x + MARK, y + MARK))?;
                line((x + MARK, y - MARK), (x - MARK, y + MARK))
            }
        }
    }

    /// Black text; `anchor` says which point of the text is at the given point.
    pub(super) fn text(&self, text: &str, at: At, anchor: (HPos, VPos)) -> Result<(), ReportError> {
        let style = TextStyle::from((FontFamily::SansSerif, LETTER))
            .color(&BLACK)
            .pos(Pos::new(anchor.0, anchor.1));
        self.accept(self.area.draw(&Text::new(text.to_owned(), at, style)))
    }
}
