//! The model in a sketch, with the ports where an effect can enter shaded by their probability.

use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::At;
use super::palette::{BLACK, BLUE, GREY, Key, SHADE, Stroke, VERMILLION, solid};
use super::{Canvas, Drawn, WIDTH, draw};

/// One port and the probability that something is missing there.
pub(crate) struct PortShade<'a> {
    /// Its key in the files.
    pub(crate) port: &'a str,
    /// Probability; `None` where it was not assessed.
    pub(crate) probability: Option<f64>,
    /// The text below its name in the sketch.
    pub(crate) says: String,
    /// Whether it has a frame.
    pub(crate) framed: bool,
}

/// A column of the sketch: its left and right edge.
type Lane = (i32, i32);
const LEFT: Lane = (10, 300);
const CENTRE: Lane = (355, 645);
const RIGHT: Lane = (700, WIDTH - 10);

/// Parts of the body and of the record: name, column, top.
const PARTS: [(&str, Lane, i32); 8] = [
    ("Insulin doses", LEFT, 20),
    ("Liver", CENTRE, 20),
    ("Logged meals", RIGHT, 20),
    ("Skin depot", LEFT, 224),
    ("Gut", RIGHT, 224),
    ("Plasma insulin", LEFT, 428),
    ("Blood glucose", CENTRE, 530),
    ("Sensor reading", CENTRE, 768),
];
/// Height of a part.
const PART: i32 = 56;

/// Ports: key, name in the sketch, column, top.
const PORTS: [(&str, &str, Lane, i32); 9] = [
    ("insulin_input", "insulin available", LEFT, 106),
    ("insulin_absorption", "absorption", LEFT, 310),
    ("insulin_action", "action on uptake", LEFT, 514),
    ("insulin_action_liver", "action on liver", CENTRE, 262),
    ("egp", "production", CENTRE, 106),
    ("carb_amount", "carbs eaten", RIGHT, 106),
    ("gut_absorption", "gut absorption", RIGHT, 310),
    ("glucose_flux", "other flux", RIGHT, 514),
    ("sensor", "sensor", CENTRE, 650),
];
/// Height of a port.
const PORT: i32 = 88;

/// The flows; the last point of each has an arrowhead.
const FLOWS: [&[At]; 17] = [
    &[(155, 76), (155, 106)],
    &[(155, 194), (155, 224)],
    &[(155, 280), (155, 310)],
    &[(155, 398), (155, 428)],
    &[(155, 484), (155, 514)],
    &[(300, 558), (355, 558)],
    &[(300, 456), (328, 456), (328, 306), (355, 306)],
    &[(500, 262), (500, 194)],
    &[(500, 76), (500, 106)],
    &[(645, 150), (672, 150), (672, 440), (500, 440), (500, 530)],
    &[(845, 76), (845, 106)],
    &[(845, 194), (845, 224)],
    &[(845, 280), (845, 310)],
    &[(845, 398), (845, 480), (580, 480), (580, 530)],
    &[(700, 558), (645, 558)],
    &[(500, 586), (500, 650)],
    &[(500, 738), (500, 768)],
];

/// Frame of the most probable ports.
const FRAME: Stroke = solid(VERMILLION, 7);

/// Draws the model with its ports; `frame` says what the frame of a port means.
pub(crate) fn schematic(shades: &[PortShade<'_>], frame: Option<&str>) -> Drawn {
    let mut keys = vec![
        Key::area("Part of the model", SHADE, 1.0),
        Key::area("Place where an effect can enter: probability 1", BLUE, opacity(1.0)),
        Key::area("Probability 0.3", BLUE, opacity(0.3)),
    ];
    keys.extend(frame.map(|meaning| Key::line(meaning, FRAME)));
    draw("Where in the model something is missing", 844, keys, |canvas| {
        for flow in FLOWS {
            arrow(canvas, flow);
        }
        for (name, (left, right), top) in PARTS {
            canvas.rectangle((left, top), (right, top + PART), SHADE, 1.0);
            let centre = ((left + right) / 2, top + PART / 2);
            canvas.text(name, centre, (HPos::Center, VPos::Center));
        }
        for (key, name, (left, right), top) in PORTS {
            let bottom = top + PORT;
            let shade = shades.iter().find(|shade| shade.port == key);
            if let Some(probability) = shade.and_then(|shade| shade.probability) {
                canvas.rectangle((left, top), (right, bottom), BLUE, opacity(probability));
            }
            let outline = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
            let framed = shade.is_some_and(|shade| shade.framed);
            canvas.path(outline, if framed { FRAME } else { solid(GREY, 2) });
            let middle = (left + right) / 2;
            let says = shade.map_or("not assessed", |shade| &shade.says);
            canvas.text(name, (middle, top + 27), (HPos::Center, VPos::Center));
            canvas.text(says, (middle, top + 63), (HPos::Center, VPos::Center));
        }
    })
}

/// Opacity of a shade; black letters stay legible on the darkest.
fn opacity(probability: f64) -> f64 {
    0.6 * probability.clamp(0.0, 1.0)
}

/// A line with a head at its end.
fn arrow(canvas: &Canvas<'_>, points: &[At]) {
    canvas.path(points, solid(BLACK, 3));
    let [.., (x0, y0), (x, y)] = points else { return };
    let (dx, dy) = ((x - x0).signum(), (y - y0).signum());
    let (back, half) = (16, 9);
    let foot = (x - back * dx, y - back * dy);
    let head = [
        (*x, *y),
        (foot.0 + half * dy, foot.1 + half * dx),
        (foot.0 - half * dy, foot.1 - half * dx),
    ];
    canvas.fill(head, BLACK, 1.0);
}
