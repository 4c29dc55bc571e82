//! A blank SVG and the few marks that the figures need, in canvas units.
//!
//! The canvas is 1,000 units wide for any page. Letters are 33 units high, which is 11 pixels in a
//! card on a 400-pixel phone.

use std::cell::RefCell;

use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::{
    Circle, DrawingArea, IntoDrawingArea, PathElement, Polygon, Rectangle, SVGBackend, Text,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontFamily, RGBColor, TextStyle, WHITE};

use super::palette::{Key, Marker, Stroke, solid};
use crate::html::escape_into;

/// Width of every figure, canvas units.
pub(crate) const WIDTH: i32 = 1000;
/// Height of letters in the drawing library's measure (it divides by 1.24).
const LETTER: f64 = 41.0;
/// Half the size of a marker.
const MARK: i32 = 11;

/// A point on the canvas.
pub(crate) type At = (i32, i32);

/// A finished figure: an `svg` element, which only [`draw`] makes, and the key to its lines.
pub(crate) struct Drawn {
    svg: String,
    /// The key to its lines.
    pub(crate) keys: Vec<Key>,
}

impl Drawn {
    /// The markup of the `svg` element.
    pub(crate) fn markup(&self) -> &str {
        &self.svg
    }
}

/// The canvas for the marks.
pub(crate) struct Canvas<'a> {
    area: DrawingArea<SVGBackend<'a>, Shift>,
    /// Places with words that show when a pointer rests there.
    hovers: RefCell<String>,
}

/// Draws a figure of `height` canvas units; `label` describes it for a screen reader.
pub(crate) fn draw(
    label: &str,
    height: i32,
    keys: Vec<Key>,
    marks: impl FnOnce(&Canvas<'_>),
) -> Drawn {
    let mut drawn = String::new();
    let hovers = {
        let size = (WIDTH as u32, height.unsigned_abs());
        let area = SVGBackend::with_string(&mut drawn, size).into_drawing_area();
        let canvas = Canvas { area, hovers: RefCell::default() };
        accept(canvas.area.fill(&WHITE));
        marks(&canvas);
        accept(canvas.area.present());
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
    svg += &format!("\">{body}{hovers}</svg>\n");
    Drawn { svg, keys }
}

/// Takes a mark as drawn: the backend writes into a string, where nothing fails.
fn accept<E: std::fmt::Debug>(mark: Result<(), E>) {
    mark.expect("a string takes every mark");
}

impl Canvas<'_> {
    /// Words that show when a pointer rests within a box.
    pub(crate) fn hover(&self, (x, y): At, (right, bottom): At, words: &str) {
        let (left, top) = (x.min(right), y.min(bottom));
        let (width, height) = ((right - x).abs().max(1), (bottom - y).abs().max(1));
        let mut hovers = self.hovers.borrow_mut();
        hovers.push_str(&format!(
            "<rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" fill=\"transparent\"><title>"
        ));
        escape_into(&mut hovers, words);
        hovers.push_str("</title></rect>\n");
    }

    /// A line through points.
    pub(crate) fn path(&self, points: impl Into<Vec<At>>, stroke: Stroke) {
        let style = stroke.colour.stroke_width(stroke.width);
        let points: Vec<At> = points.into();
        accept(match stroke.dash {
            None => self.area.draw(&PathElement::new(points, style)),
            Some((on, off)) => self.area.draw(&DashedPathElement::new(points, on, off, style)),
        });
    }

    /// A filled shape.
    pub(crate) fn fill(&self, outline: impl Into<Vec<At>>, colour: RGBColor, opacity: f64) {
        let style = colour.mix(opacity).filled();
        accept(self.area.draw(&Polygon::<At>::new(outline, style)));
    }

    /// A filled box.
    pub(crate) fn rectangle(&self, corner: At, opposite: At, colour: RGBColor, opacity: f64) {
        let style = colour.mix(opacity).filled();
        accept(self.area.draw(&Rectangle::new([corner, opposite], style)));
    }

    /// A marker centred on a point.
    pub(crate) fn marker(&self, (x, y): At, marker: Marker, colour: RGBColor) {
        let (left, right, top, bottom) = (x - MARK, x + MARK, y - MARK, y + MARK);
        match marker {
            Marker::Disc => accept(self.area.draw(&Circle::new((x, y), MARK, colour.filled()))),
            Marker::Ring => {
                accept(self.area.draw(&Circle::new((x, y), MARK - 1, WHITE.filled())));
                accept(self.area.draw(&Circle::new((x, y), MARK - 2, colour.stroke_width(4))));
            }
            Marker::Square => self.rectangle((left, top), (right, bottom), colour, 1.0),
            Marker::Triangle => {
                self.fill([(x, top - 2), (right + 1, bottom), (left - 1, bottom)], colour, 1.0);
            }
            Marker::Diamond => {
                let r = MARK + 3;
                self.fill([(x, y - r), (x + r, y), (x, y + r), (x - r, y)], colour, 1.0);
            }
            Marker::Cross => {
                self.path([(left, top), (right, bottom)], solid(colour, 4));
                self.path([(right, top), (left, bottom)], solid(colour, 4));
            }
        }
    }

    /// Black text; `anchor` says which point of the text is at the given point.
    pub(crate) fn text(&self, text: &str, at: At, anchor: (HPos, VPos)) {
        let style = TextStyle::from((FontFamily::SansSerif, LETTER));
        let style = style.pos(Pos::new(anchor.0, anchor.1));
        accept(self.area.draw(&Text::new(text.to_owned(), at, style)));
    }
}
