//! The top of a function of a few coordinates, without derivatives.

/// Raises `value` along one coordinate at a time, with steps that are halved where none helps
/// (Hooke and Jeeves 1961). Coordinates stay within `limits`. Returns the value reached.
pub(crate) fn climb(
    point: &mut [f64],
    limits: (f64, f64),
    (mut step, least_step): (f64, f64),
    value: impl Fn(&[f64]) -> f64,
) -> f64 {
    let mut top = value(point);
    while step >= least_step {
        let before = top;
        for coordinate in 0..point.len() {
            for change in [step, -step] {
                let old = point[coordinate];
                point[coordinate] = (old + change).clamp(limits.0, limits.1);
                let reached = value(point);
                if reached > top {
                    top = reached;
                    break;
                }
                point[coordinate] = old;
            }
        }
        if top <= before {
            step *= 0.5;
        }
    }
    top
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_finds_a_top_inside_and_one_at_the_limit() {
        let hill = |x: &[f64]| -(x[0] - 0.3).powi(2) - (x[1] - 2.0).powi(2);
        let mut point = [0.9, 0.1];
        let top = climb(&mut point, (0.0, 1.0), (0.25, 1e-6), hill);
        assert!((point[0] - 0.3).abs() < 1e-5 && point[1] == 1.0, "{point:?}");
        assert!((top + 1.0).abs() < 1e-9, "{top}");
    }
}
