//! What a person's record says about each port, two hours at a time.
//!
//! The signature of a constant change at a port, cut into bins, stands for a change within a bin: the filter
//! forgets within a few hours. What is constant and what differs from day to day in everybody is integrated
//! out, so that only the course within and beyond days is left to judge.

use std::ops::Range;

use effects::{EffectId, Field, Port};
use faer::linalg::solvers::Llt;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, MatRef, Par, Side};
use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};

use crate::design::{Background, Column, Design};
use crate::which::held_out::Allowed;
use crate::which::statistics::{RANDOM, Sums, add_gram};

/// Steps of a bin: two hours.
const BIN: usize = 2 * STEPS_PER_HOUR;
/// Bins of a day.
pub(super) const BINS_PER_DAY: usize = STEPS_PER_DAY / BIN;
/// Directions whose course is asked for: those that differ from day to day, and action on the liver.
const DIRECTIONS: usize = RANDOM.len() + 1;
const LIVER: Background = Background::Field(Field::LiverAction);

/// The direction of a port; `None` where none stands for it.
fn direction(port: Port) -> Option<usize> {
    match port {
        Port::InsulinActionLiver => Some(RANDOM.len()),
        _ => RANDOM.iter().position(|random| random.port == port),
    }
}

/// Sums over one bin.
#[derive(Debug, Clone)]
struct Bin {
    /// Gram matrix of the directions.
    gram: [[f64; DIRECTIONS]; DIRECTIONS],
    /// Products of each direction with what is allowed for, as [`Bins::kept`].
    cross: Vec<[f32; DIRECTIONS]>,
    /// Scores of the directions.
    score: [f64; DIRECTIONS],
}

/// A person's record in bins.
#[derive(Debug, Clone)]
pub(in crate::which) struct Bins {
    bins: Vec<Bin>,
    /// Columns of the design that may be allowed for.
    kept: Vec<usize>,
}

impl Bins {
    /// Sums up a design; `is_guard` tells effects that are always allowed for.
    pub(in crate::which) fn of(design: &Design, is_guard: impl Fn(EffectId) -> bool) -> Self {
        let kept: Vec<usize> = (0..design.columns.len())
            .filter(|column| match design.columns[*column] {
                Column::Background { .. } => true,
                Column::Effect { effect, .. } => is_guard(effect),
            })
            .collect();
        let column_of = |wanted: Background| {
            let found = design.columns.iter().position(|column| column.is(wanted));
            found.expect("the background has every direction")
        };
        let directions: [usize; DIRECTIONS] = std::array::from_fn(|k| {
            column_of(RANDOM.get(k).map_or(LIVER, |random| random.background))
        });
        let steps = design.residuals.len();
        let bins = (0..steps.div_ceil(BIN))
            .map(|bin| bin_of(design, &kept, &directions, bin * BIN..((bin + 1) * BIN).min(steps)))
            .collect();
        Self { bins, kept }
    }
}

fn bin_of(
    design: &Design,
    kept: &[usize],
    directions: &[usize; DIRECTIONS],
    steps: Range<usize>,
) -> Bin {
    let mut bin = Bin {
        gram: [[0.0; DIRECTIONS]; DIRECTIONS],
        cross: Vec::with_capacity(kept.len()),
        score: [0.0; DIRECTIONS],
    };
    let weighted: Vec<[f64; DIRECTIONS]> = steps
        .clone()
        .map(|step| {
            directions.map(|k| design.weights[step] * f64::from(design.signatures[k][step]))
        })
        .collect();
    let product = |values: &mut dyn Iterator<Item = f64>| {
        let mut sum = [0.0; DIRECTIONS];
        for (value, weighted) in values.zip(&weighted) {
            for (sum, weighted) in sum.iter_mut().zip(weighted) {
                *sum += weighted * value;
            }
        }
        sum
    };
    let column = |k: usize| design.signatures[k][steps.clone()].iter().map(|s| f64::from(*s));
    for (row, k) in bin.gram.iter_mut().zip(directions) {
        *row = product(&mut column(*k));
    }
    bin.cross.extend(kept.iter().map(|k| product(&mut column(*k)).map(|x| x as f32)));
    bin.score = product(&mut design.residuals[steps.clone()].iter().map(|r| -r));
    bin
}

/// Information about a course at one port, bin by bin, with all else integrated out: the log likelihood of a
/// course u over none is score'u - u'Gu/2. G is diagonal, less what the days' own differences and what is
/// constant would explain of u.
pub(super) struct Left {
    /// Scores.
    pub(super) score: Vec<f64>,
    /// The diagonal of G before anything is taken out, summed up: entry k is the sum over the bins before k.
    own: Vec<f64>,
    /// By how much the differences of a day answer to its bins, summed up from the start of each day.
    daily: Vec<Vec<Vec<f64>>>,
    /// By how much what is constant answers to the bins, summed up from the start of the record.
    constant: Vec<Vec<f64>>,
}

impl Left {
    /// Information about the courses at `ports`, none for a port without a direction. `sums` hold A and b of the
    /// person as they are; `spreads` are those from day to day.
    pub(super) fn of(
        person: &Bins,
        sums: &[Sums],
        allowed: &[Allowed],
        spreads: &[f64; RANDOM.len()],
        ports: &[Port],
    ) -> Vec<Option<Self>> {
        let kept: Vec<usize> = allowed
            .iter()
            .map(|a| person.kept.iter().position(|k| *k == a.column))
            .map(|place| place.expect("what is allowed for is background or guard"))
            .collect();
        let total = |i: usize, j: usize| -> f64 {
            sums.iter().map(|s| s.a[(allowed[i].column, allowed[j].column)]).sum()
        };
        let mut system = Mat::from_fn(allowed.len(), allowed.len(), total);
        let mut right = Mat::from_fn(allowed.len(), 1, |i, _| {
            sums.iter().map(|s| s.b[allowed[i].column]).sum::<f64>()
        });
        for (i, a) in allowed.iter().enumerate() {
            system[(i, i)] += a.sd.powi(-2);
            right[(i, 0)] += a.mean * a.sd.powi(-2);
        }
        let active: Vec<(usize, f64)> =
            spreads.iter().copied().enumerate().filter(|(_, spread)| *spread > 0.0).collect();
        let days: Vec<Differing> = person
            .bins
            .chunks(BINS_PER_DAY)
            .map(|bins| Differing::of(bins, &active, &kept))
            .collect();
        for day in &days {
            add_gram(&mut system, day.constant.as_ref(), -1.0);
            right -= day.constant.transpose() * &day.score;
        }
        let factor = system
            .llt(Side::Lower)
            .expect("a Gram matrix, less a part of it, plus the precision of a proper prior");
        solve_lower_triangular_in_place(factor.L(), right.as_mut(), Par::Seq);
        let of_port = |port: &Port| {
            let direction = direction(*port)?;
            Some(Self::of_direction(person, direction, &kept, &days, (factor.L(), right.as_ref())))
        };
        ports.iter().map(of_port).collect()
    }

    /// `background` holds the factor of the system of what is constant, and its solved right side.
    fn of_direction(
        person: &Bins,
        direction: usize,
        kept: &[usize],
        days: &[Differing],
        background: (MatRef<'_, f64>, MatRef<'_, f64>),
    ) -> Self {
        let bins = &person.bins;
        let mut score: Vec<f64> = bins.iter().map(|bin| bin.score[direction]).collect();
        let mut constant = Mat::from_fn(kept.len(), bins.len(), |i, k| {
            f64::from(bins[k].cross[kept[i]][direction])
        });
        let mut daily = Vec::with_capacity(days.len());
        for (place, (day, of_day)) in days.iter().zip(bins.chunks(BINS_PER_DAY)).enumerate() {
            let answers = day.answers(of_day, direction);
            let first = place * BINS_PER_DAY;
            let mut these = constant.as_mut().subcols_mut(first, of_day.len());
            these -= day.constant.transpose() * &answers;
            let taken = day.score.transpose() * &answers;
            for (k, score) in score[first..first + of_day.len()].iter_mut().enumerate() {
                *score -= taken[(0, k)];
            }
            daily.push(summed_up(answers.as_ref()));
        }
        solve_lower_triangular_in_place(background.0, constant.as_mut(), Par::Seq);
        let taken = background.1.transpose() * &constant;
        for (k, score) in score.iter_mut().enumerate() {
            *score -= taken[(0, k)];
        }
        let mut own = vec![0.0];
        for bin in bins {
            own.push(own[own.len() - 1] + bin.gram[direction][direction]);
        }
        Self { score, own, daily, constant: summed_up(constant.as_ref()) }
    }

    /// Number of bins.
    pub(super) fn len(&self) -> usize {
        self.score.len()
    }

    /// u'Gu of a course that is 1 in some bins and 0 elsewhere.
    pub(super) fn information(&self, bins: Range<usize>) -> f64 {
        let mut left = self.own[bins.end] - self.own[bins.start];
        left -= square(&self.constant[bins.start], &self.constant[bins.end]);
        for day in bins.start / BINS_PER_DAY..bins.end.div_ceil(BINS_PER_DAY) {
            let first = day * BINS_PER_DAY;
            let answers = &self.daily[day];
            let from = bins.start.max(first) - first;
            let to = bins.end.min(first + BINS_PER_DAY) - first;
            left -= square(&answers[from], &answers[to]);
        }
        left.max(0.0)
    }

    /// The bins of a day with their part of G, what is constant left in.
    pub(super) fn day(&self, day: usize) -> (Range<usize>, Mat<f64>) {
        let first = day * BINS_PER_DAY;
        let bins = first..(first + BINS_PER_DAY).min(self.len());
        let answers = &self.daily[day];
        let gram = Mat::from_fn(bins.len(), bins.len(), |i, j| {
            let product: f64 = (0..answers[0].len())
                .map(|f| (answers[i + 1][f] - answers[i][f]) * (answers[j + 1][f] - answers[j][f]))
                .sum();
            let own = if i == j { self.own[first + i + 1] - self.own[first + i] } else { 0.0 };
            own - product
        });
        (bins, gram)
    }

    /// Number of days.
    pub(super) fn days(&self) -> usize {
        self.daily.len()
    }
}

/// The factors in which a day differs from others, integrated out by Woodbury's identity as in
/// [`variance`](crate::which::variance).
struct Differing {
    active: Vec<(usize, f64)>,
    /// L with LL' = I + D Z'WZ D.
    factor: Llt<f64>,
    /// L^-1 D Z'WX: (factors, allowed).
    constant: Mat<f64>,
    /// L^-1 D times the scores: (factors, 1).
    score: Mat<f64>,
}

impl Differing {
    fn of(bins: &[Bin], active: &[(usize, f64)], kept: &[usize]) -> Self {
        let n = active.len();
        let factor = Mat::from_fn(n, n, |i, j| {
            let ((a, s), (b, t)) = (active[i], active[j]);
            let product: f64 = bins.iter().map(|bin| bin.gram[a][b]).sum();
            s * t * product + f64::from(u8::from(i == j))
        })
        .llt(Side::Lower)
        .expect("the identity plus a product of a matrix with itself");
        let mut constant = Mat::from_fn(n, kept.len(), |i, k| {
            let (a, s) = active[i];
            s * bins.iter().map(|bin| f64::from(bin.cross[kept[k]][a])).sum::<f64>()
        });
        let mut score = Mat::from_fn(n, 1, |i, _| {
            let (a, s) = active[i];
            s * bins.iter().map(|bin| bin.score[a]).sum::<f64>()
        });
        solve_lower_triangular_in_place(factor.L(), constant.as_mut(), Par::Seq);
        solve_lower_triangular_in_place(factor.L(), score.as_mut(), Par::Seq);
        Self { active: active.to_vec(), factor, constant, score }
    }

    /// L^-1 D Z'WZ of a direction by bin: (factors, bins).
    fn answers(&self, bins: &[Bin], direction: usize) -> Mat<f64> {
        let mut answers = Mat::from_fn(self.active.len(), bins.len(), |i, k| {
            let (a, s) = self.active[i];
            s * bins[k].gram[direction][a]
        });
        solve_lower_triangular_in_place(self.factor.L(), answers.as_mut(), Par::Seq);
        answers
    }
}

/// Sums of the columns before each, one more than there are columns.
fn summed_up(columns: MatRef<'_, f64>) -> Vec<Vec<f64>> {
    let mut sums = vec![vec![0.0; columns.nrows()]];
    for column in columns.col_iter() {
        let last = &sums[sums.len() - 1];
        sums.push(last.iter().zip(column.iter()).map(|(sum, value)| sum + value).collect());
    }
    sums
}

/// The square of a difference.
fn square(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

#[cfg(test)]
pub(super) mod tests {
    use faer::linalg::solvers::Solve;

    use super::*;

    /// A port at which bins carry the same information each and nothing else differs.
    pub(in super::super) fn alone(information: f64, score: Vec<f64>) -> Left {
        let bins = score.len();
        Left {
            own: (0..=bins).map(|k| k as f64 * information).collect(),
            daily: vec![vec![Vec::new(); BINS_PER_DAY + 1]; bins.div_ceil(BINS_PER_DAY)],
            constant: vec![Vec::new(); bins + 1],
            score,
        }
    }

    /// Rows of a bin in the tests.
    const ROWS: usize = 5;

    fn value(row: usize, column: usize) -> f64 {
        ((row * (2 * column + 3)) as f64 * 0.37 + (row * row) as f64 * 0.11 + column as f64).sin()
    }

    /// Two and a half days, three constant directions and the others.
    fn person() -> (Bins, Sums, Mat<f64>, Mat<f64>, Mat<f64>) {
        let bins = 5 * BINS_PER_DAY / 2;
        let rows = bins * ROWS;
        let x = Mat::from_fn(rows, 3, value);
        let z = Mat::from_fn(rows, DIRECTIONS, |row, k| value(row, k + 3));
        let y = Mat::from_fn(rows, 1, |row, _| value(row, 20) + 0.5 * z[(row, 2)]);
        let of_bin = |bin: usize| {
            let sum = |f: &dyn Fn(usize) -> f64| (bin * ROWS..(bin + 1) * ROWS).map(f).sum::<f64>();
            Bin {
                gram: std::array::from_fn(|a| {
                    std::array::from_fn(|b| sum(&|row| z[(row, a)] * z[(row, b)]))
                }),
                cross: (0..3)
                    .map(|k| std::array::from_fn(|a| sum(&|row| z[(row, a)] * x[(row, k)]) as f32))
                    .collect(),
                score: std::array::from_fn(|a| sum(&|row| z[(row, a)] * y[(row, 0)])),
            }
        };
        let b = x.transpose() * &y;
        let sums = Sums { a: x.transpose() * &x, b: (0..3).map(|k| b[(k, 0)]).collect() };
        let bins = Bins { bins: (0..bins).map(of_bin).collect(), kept: vec![0, 1, 2] };
        (bins, sums, x, z, y)
    }

    #[test]
    fn information_is_that_of_a_dense_covariance() {
        let (bins, sums, x, z, y) = person();
        let sds = [0.5, 1.0, 0.2];
        let allowed: Vec<Allowed> =
            (0..3).map(|column| Allowed { column, mean: 0.0, sd: sds[column] }).collect();
        let spreads = [0.2, 0.0, 0.3, 0.0, 0.0, 0.1, 0.0];
        let (rows, a_day) = (x.nrows(), BINS_PER_DAY * ROWS);
        let covariance = Mat::from_fn(rows, rows, |i, j| {
            let constant: f64 = (0..3).map(|k| sds[k] * sds[k] * x[(i, k)] * x[(j, k)]).sum();
            let daily: f64 =
                (0..spreads.len()).map(|f| spreads[f] * spreads[f] * z[(i, f)] * z[(j, f)]).sum();
            let same = if i / a_day == j / a_day { daily } else { 0.0 };
            constant + same + f64::from(u8::from(i == j))
        });
        let inverse = covariance.llt(Side::Lower).expect("a covariance");
        let left = Left::of(
            &bins,
            &[sums],
            &allowed,
            &spreads,
            &[Port::GutAbsorption, Port::InsulinInput],
        );
        assert!(left[1].is_none());
        let left = left[0].as_ref().expect("a direction of its own");
        for range in [0..3, 5..17, 0..left.len(), 24..30] {
            let course = Mat::from_fn(rows, 1, |row, _| {
                if range.contains(&(row / ROWS)) { z[(row, 2)] } else { 0.0 }
            });
            let solved = inverse.solve(&course);
            let expected = (course.transpose() * &solved)[(0, 0)];
            let found = left.information(range.clone());
            // Products with constant directions are kept in single precision.
            assert!((found - expected).abs() < 1e-4 * expected, "{range:?} {found} {expected}");
            let expected = (solved.transpose() * &y)[(0, 0)];
            let found: f64 = left.score[range.clone()].iter().sum();
            assert!((found - expected).abs() < 1e-4 * expected.abs().max(1.0), "{range:?} {found}");
        }
    }
}
