//! The largest slope of a network of two inputs by visiting every cell of its arrangement.
//!
//! The hyperplanes `a_j = 0` and the edges of the box cut the plane into cells. A cell inside the
//! box is a polygon, so it has a corner where two of the lines cross; visiting all crossings, and
//! all sectors around each, visits every cell. All decisions are exact, including where many lines
//! meet in one point or coincide, so the result is the largest slope itself. The work grows with
//! the cube of the number of neurons.
//!
//! It shares with branch and bound only the exact arithmetic, and serves as its oracle.

use std::cmp::Ordering;

use crate::error::ConformanceError;
use crate::exact::Dyadic;
use crate::network::OneHiddenLayer;
use crate::property::Property;
use crate::region::Region;

/// The largest slope against a property, enclosed by neighbouring numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Enumerated {
    /// The exact largest slope, rounded down; scaled output per minute per scaled input.
    pub m_lower: f64,
    /// The same, rounded up.
    pub m_upper: f64,
    /// Crossings of two lines inside the box, each counted once a pair.
    pub crossings: usize,
}

/// The exact largest slope against `property` over `region`, for a network of two inputs.
///
/// # Errors
/// [`ConformanceError::NotPlanar`] unless there are two inputs and both vary, and what
/// [`crate::verify()`] refuses about property and region.
pub fn largest_slope_by_enumeration(
    network: &OneHiddenLayer,
    property: &Property,
    region: &Region,
) -> Result<Enumerated, ConformanceError> {
    let (boxed, tested) = property.box_in(network, region)?;
    if !boxed.half_spaces().is_empty() {
        return Err(ConformanceError::BoxesAlone);
    }
    let varying = boxed.lower().iter().zip(boxed.upper()).filter(|(lo, hi)| lo < hi).count();
    if network.inputs().len() != 2 || varying != 2 {
        let inputs = varying.min(network.inputs().len());
        return Err(ConformanceError::NotPlanar { network: network.output().to_owned(), inputs });
    }

    let against = Dyadic::new(property.direction.against());
    let (lower, upper) = (boxed.lower(), boxed.upper());
    // The four edges first, positive inside.
    let mut lines = vec![
        Line { w: [1.0, 0.0], b: -lower[0] },
        Line { w: [-1.0, 0.0], b: upper[0] },
        Line { w: [0.0, 1.0], b: -lower[1] },
        Line { w: [0.0, -1.0], b: upper[1] },
    ];
    let mut gains = vec![Dyadic::default(); EDGES];
    for j in 0..network.hidden() {
        let row = network.input_weights(j);
        let gain = Dyadic::new(network.output_weights()[j])
            .times(&Dyadic::new(row[tested]))
            .times(&against);
        if gain.sign() != Ordering::Equal {
            lines.push(Line { w: [row[0], row[1]], b: network.hidden_biases()[j] });
            gains.push(gain);
        }
    }
    Ok(Arrangement { rough: gains.iter().map(Dyadic::round_up).collect(), lines, gains }.largest())
}

const EDGES: usize = 4;

/// `w x + b = 0`.
struct Line {
    w: [f64; 2],
    b: f64,
}

struct Arrangement {
    lines: Vec<Line>,
    gains: Vec<Dyadic>,
    /// The gains in floating point.
    rough: Vec<f64>,
}

/// The crossing of two lines in homogeneous coordinates, `(x / d, y / d)`.
struct Crossing {
    x: Dyadic,
    y: Dyadic,
    d: Dyadic,
}

impl Arrangement {
    fn largest(&self) -> Enumerated {
        let mut best: Option<Dyadic> = None;
        let mut crossings = 0;
        let mut signs = vec![Ordering::Equal; self.lines.len()];
        for i in 0..self.lines.len() {
            for j in 0..i {
                let Some(crossing) = Crossing::of(&self.lines[i], &self.lines[j]) else {
                    continue;
                };
                let inside = (0..EDGES).all(|e| {
                    signs[e] = self.sign(&crossing, i, j, e);
                    signs[e] != Ordering::Less
                });
                if !inside {
                    continue;
                }
                crossings += 1;
                for (l, sign) in signs.iter_mut().enumerate().skip(EDGES) {
                    *sign = self.sign(&crossing, i, j, l);
                }
                self.visit_sectors(&mut signs, &mut best);
            }
        }
        // The corners of the box are crossings, so there is always a cell.
        let best = best.unwrap_or_default();
        Enumerated { m_lower: best.round_down(), m_upper: best.round_up(), crossings }
    }

    /// Sign of line `l` at the crossing of lines `i` and `j`.
    fn sign(&self, crossing: &Crossing, i: usize, j: usize, l: usize) -> Ordering {
        if l == i || l == j {
            return Ordering::Equal;
        }
        let [a, b, c] = [&self.lines[i], &self.lines[j], &self.lines[l]];
        // The determinant of the three lines over that of the first two, in floating point.
        let minors = [
            (b.w[0] * a.b, a.w[0] * b.b, c.w[1]),
            (a.w[1] * b.b, b.w[1] * a.b, c.w[0]),
            (a.w[0] * b.w[1], b.w[0] * a.w[1], c.b),
        ];
        let value: f64 = minors.iter().map(|(p, q, r)| (p - q) * r).sum();
        let size: f64 = minors.iter().map(|(p, q, r)| (p.abs() + q.abs()) * r.abs()).sum();
        let d = crossing.d.sign();
        // Seven operations a term and two sums: well below 16 EPSILON of the sum of sizes.
        let rough = if value.abs() > 16.0 * f64::EPSILON * size + 1e-290 {
            value.total_cmp(&0.0)
        } else {
            let exact = Dyadic::new(c.w[0])
                .times(&crossing.x)
                .plus(&Dyadic::new(c.w[1]).times(&crossing.y))
                .plus(&Dyadic::new(c.b).times(&crossing.d));
            exact.sign()
        };
        if d == Ordering::Less { rough.reverse() } else { rough }
    }

    /// Offers the slope of every cell around a crossing, given the signs there; lines through the
    /// crossing have sign `Equal`, which is overwritten sector by sector and restored.
    fn visit_sectors(&self, signs: &mut [Ordering], best: &mut Option<Dyadic>) {
        let through: Vec<usize> =
            (0..signs.len()).filter(|&l| signs[l] == Ordering::Equal).collect();
        for (n, &p) in through.iter().enumerate() {
            for &q in &through[..n] {
                for (side_p, side_q) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                    let direction = self.between(p, q, side_p, side_q);
                    let all_off_the_lines = through.iter().all(|&l| {
                        let w = self.lines[l].w;
                        signs[l] = Dyadic::new(w[0])
                            .times(&direction[0])
                            .plus(&Dyadic::new(w[1]).times(&direction[1]))
                            .sign();
                        signs[l] != Ordering::Equal
                    });
                    if all_off_the_lines && (0..EDGES).all(|e| signs[e] == Ordering::Greater) {
                        self.offer(signs, best);
                    }
                    for &l in &through {
                        signs[l] = Ordering::Equal;
                    }
                }
            }
        }
    }

    /// `side_p t_p + side_q t_q`, t being a line's direction: between the two rays.
    fn between(&self, p: usize, q: usize, side_p: f64, side_q: f64) -> [Dyadic; 2] {
        let part = |l: usize, side: f64| {
            let w = self.lines[l].w;
            [Dyadic::new(-side * w[1]), Dyadic::new(side * w[0])]
        };
        let ([px, py], [qx, qy]) = (part(p, side_p), part(q, side_q));
        [px.plus(&qx), py.plus(&qy)]
    }

    fn offer(&self, signs: &[Ordering], best: &mut Option<Dyadic>) {
        let on = || (EDGES..signs.len()).filter(|&l| signs[l] == Ordering::Greater);
        let (rough, size) = on()
            .fold((0.0, 0.0), |(sum, size), l| (sum + self.rough[l], size + self.rough[l].abs()));
        let known = best.as_ref().map_or(f64::NEG_INFINITY, Dyadic::round_down);
        // n additions err by less than n EPSILON of the sum of sizes.
        if rough + signs.len() as f64 * f64::EPSILON * size < known {
            return;
        }
        let slope = on().fold(Dyadic::default(), |sum, l| sum.plus(&self.gains[l]));
        if best.as_ref().is_none_or(|best| slope.minus(best).sign() == Ordering::Greater) {
            *best = Some(slope);
        }
    }
}

impl Crossing {
    /// `None` for parallel lines.
    fn of(a: &Line, b: &Line) -> Option<Self> {
        let minor = |p: f64, q: f64, r: f64, s: f64| {
            Dyadic::new(p).times(&Dyadic::new(q)).minus(&Dyadic::new(r).times(&Dyadic::new(s)))
        };
        let d = minor(a.w[0], b.w[1], b.w[0], a.w[1]);
        (d.sign() != Ordering::Equal).then(|| Self {
            x: minor(a.w[1], b.b, b.w[1], a.b),
            y: minor(b.w[0], a.b, a.w[0], b.b),
            d,
        })
    }
}
