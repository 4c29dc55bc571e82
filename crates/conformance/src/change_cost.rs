//! What a change of a network's output weights costs, and the cheapest change that some linear pieces ask for.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver as _, NonnegativeConeT, SolverStatus, ZeroConeT,
};
use faer::{Mat, Side};

use crate::error::{ConformanceError, require};
use crate::network::{OneHiddenLayer, check_arrays, check_point};

/// Share of the mean curvature that is added to every direction of the output weights: what the cost does not see
/// must not change without need either.
const RIDGE: f64 = 1e-6;
/// Tolerance of the search for the cheapest change: below half of any margin that survives rounding.
const TOLERANCE: f64 = 1e-9;

/// The cost of changing the output weights of a network, about the weights it has: `value + gradient . d + d . curvature d / 2`,
/// with d the change of the output weights and, in the last place, of the output bias.
#[derive(Clone, Debug)]
pub struct ChangeCost {
    value: f64,
    gradient: Vec<f64>,
    /// Shape (hidden + 1, hidden + 1), symmetric, positive semi-definite.
    curvature: Mat<f64>,
}

impl ChangeCost {
    /// A cost from its parts, the curvature row by row.
    ///
    /// # Errors
    /// [`ConformanceError::Shape`] if they do not fit together, [`ConformanceError::NonFiniteWeight`] if one is not a
    /// finite number.
    pub fn new(
        network: &OneHiddenLayer,
        value: f64,
        gradient: Vec<f64>,
        curvature: &[f64],
    ) -> Result<Self, ConformanceError> {
        let n = network.hidden() + 1;
        check_arrays(
            network.output(),
            &[("value", &[value], 1), ("gradient", &gradient, n), ("curvature", curvature, n * n)],
        )?;
        let curvature = Mat::from_fn(n, n, |row, column| curvature[row * n + column]);
        Ok(Self { value, gradient, curvature })
    }

    /// The mean squared difference of the outputs of `network` and `original` over `points`, scaled as the network
    /// sees them; both have the same hidden layer.
    ///
    /// # Errors
    /// [`ConformanceError::Point`]; [`ConformanceError::Limit`] without points.
    pub fn of_output(
        original: &OneHiddenLayer,
        network: &OneHiddenLayer,
        points: &[Vec<f64>],
    ) -> Result<Self, ConformanceError> {
        require(!points.is_empty(), "points", 0.0, "at least one point is needed")?;
        for (index, point) in points.iter().enumerate() {
            check_point(network.output(), network.inputs().len(), point, index)?;
        }
        let n = network.hidden() + 1;
        let activity = Mat::from_fn(n, points.len(), |unit, index| {
            if unit + 1 == n { 1.0 } else { network.activation(unit, &points[index]).max(0.0) }
        });
        let share = 2.0 / points.len() as f64;
        let product = &activity * activity.transpose();
        let curvature = Mat::from_fn(n, n, |row, column| share * product[(row, column)]);
        let difference = Mat::from_fn(n, 1, |unit, _| {
            if unit + 1 == n {
                network.output_bias() - original.output_bias()
            } else {
                network.output_weights()[unit] - original.output_weights()[unit]
            }
        });
        let gradient = &curvature * &difference;
        let value = 0.5 * (difference.transpose() * &gradient)[(0, 0)].max(0.0);
        Ok(Self { value, gradient: (0..n).map(|unit| gradient[(unit, 0)]).collect(), curvature })
    }

    /// What the network costs as it is.
    #[must_use]
    pub fn value(&self) -> f64 {
        self.value
    }

    /// The curvature, row by row.
    #[must_use]
    pub fn curvature(&self) -> Vec<f64> {
        let n = self.gradient.len();
        (0..n * n).map(|index| self.curvature[(index / n, index % n)]).collect()
    }

    /// The output weights and bias of least cost, of single precision, whose slope on every piece is `margin` in the right
    /// direction; `None` if there are none. `pieces` are derivatives of slopes against a property by the output weights.
    pub(crate) fn least(
        &self,
        network: &OneHiddenLayer,
        pieces: &[Vec<f64>],
        margin: f64,
    ) -> Option<(Vec<f64>, f64)> {
        let bounds = pieces.iter().map(|piece| (piece.clone(), -margin)).collect();
        self.solve(network, 0, bounds)
    }

    /// The output weights and bias of least cost, of single precision, that have the signs named.
    pub(crate) fn least_with_signs(
        &self,
        network: &OneHiddenLayer,
        signs: &[Sign],
    ) -> Option<(Vec<f64>, f64)> {
        // For each weight of a sign, the row that is `factor` times this weight.
        let rows_of = |sign: Sign, factor: f64| {
            (0..signs.len()).filter(move |place| signs[*place] == sign).map(move |place| {
                let mut row = vec![0.0; signs.len()];
                row[place] = factor;
                (row, 0.0)
            })
        };
        let zeros = signs.iter().filter(|sign| **sign == Sign::Zero).count();
        let asked = rows_of(Sign::Zero, 1.0)
            .chain(rows_of(Sign::NotAbove, 1.0))
            .chain(rows_of(Sign::NotBelow, -1.0));
        let (mut weights, bias) = self.solve(network, zeros, asked.collect())?;
        // What the search leaves within its tolerance.
        for (weight, sign) in weights.iter_mut().zip(signs) {
            *weight = match sign {
                Sign::Free => *weight,
                Sign::NotAbove => weight.min(0.0),
                Sign::NotBelow => weight.max(0.0),
                Sign::Zero => 0.0,
            };
        }
        Some((weights, bias))
    }

    /// The output weights v and bias of least cost; of each `(row, most)` asked, `row . v = most`
    /// for the first `equal` and `row . v <= most` for the others. A quadratic programme, in
    /// coordinates in which the curvature is the identity.
    fn solve(
        &self,
        network: &OneHiddenLayer,
        equal: usize,
        asked: Vec<(Vec<f64>, f64)>,
    ) -> Option<(Vec<f64>, f64)> {
        let n = network.hidden() + 1;
        let mean = (0..n).map(|unit| self.curvature[(unit, unit)]).sum::<f64>() / n as f64;
        let ridged = Mat::from_fn(n, n, |row, column| {
            let ridge = if row == column { RIDGE * mean.max(1e-12) } else { 0.0 };
            self.curvature[(row, column)] + ridge
        });
        let factor = ridged.llt(Side::Lower).ok()?;
        let mut whitening = Mat::<f64>::identity(n, n);
        factor.L().solve_lower_triangular_in_place(whitening.as_mut());

        let original = network.output_weights();
        let count = asked.len();
        let cones = [ZeroConeT(equal), NonnegativeConeT(count - equal)];
        let rows =
            Mat::from_fn(count, n, |row, unit| asked[row].0.get(unit).copied().unwrap_or(0.0));
        let whitened = &rows * whitening.transpose();
        // Each row in units of its own length, so that the tolerance means the same for all.
        let lengths: Vec<f64> =
            (0..count).map(|row| whitened.row(row).norm_l2().max(f64::MIN_POSITIVE)).collect();
        let left = CscMatrix::new(
            count,
            n,
            (0..=n).map(|column| column * count).collect(),
            (0..n).flat_map(|_| 0..count).collect(),
            (0..n * count)
                .map(|index| (index % count, index / count))
                .map(|(row, column)| whitened[(row, column)] / lengths[row])
                .collect(),
        );
        let right: Vec<f64> = asked
            .iter()
            .zip(&lengths)
            .map(|((row, most), length)| {
                let now: f64 = row.iter().zip(original).map(|(by, weight)| by * weight).sum();
                (most - now) / length
            })
            .collect();
        let linear: Vec<f64> = (0..n)
            .map(|row| (0..n).map(|unit| whitening[(row, unit)] * self.gradient[unit]).sum())
            .collect();
        let settings = DefaultSettings {
            verbose: false,
            max_threads: 1,
            tol_feas: TOLERANCE,
            tol_gap_abs: TOLERANCE,
            tol_gap_rel: TOLERANCE,
            ..DefaultSettings::default()
        };
        let distance = CscMatrix::identity(n);
        let mut solver =
            DefaultSolver::new(&distance, &linear, &left, &right, &cones, settings).ok()?;
        solver.solve();
        let found =
            matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved);
        let change = |unit: usize| -> f64 {
            (0..n).map(|row| whitening[(row, unit)] * solver.solution.x[row]).sum()
        };
        let single = |value: f64| f64::from(value as f32);
        let weights = original.iter().enumerate().map(|(unit, w)| single(w + change(unit)));
        found.then(|| (weights.collect(), single(network.output_bias() + change(n - 1))))
    }
}

/// What sign an output weight may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sign {
    Free,
    NotAbove,
    NotBelow,
    Zero,
}
