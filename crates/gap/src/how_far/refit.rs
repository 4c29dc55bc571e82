//! One Gauss-Newton iteration of a person's calibration and amplitudes on training days.

use std::borrow::Cow;
use std::ops::Range;

use effects::{Course, Field, Modulation};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use ode_sim::OdeParameters;
use physiology::Plant as _;

use super::drivers::{self, Driver};
use super::hierarchy::AmplitudeEvidence;
use crate::error::GapError;
use crate::filter::augmented::AugmentedModel;
use crate::filter::calibration::{self, CalibrationRule, FACTORS, Factor, PersonalFactors};
use crate::filter::observations::Observations;
use crate::filter::scored::{Whitening, cautious_scale, normalised};
use crate::filter::tangent::{Along, Direction, filtered_along};
use crate::filter::whitening::huber_weight;

/// Longest move of a log factor in one iteration.
const LONGEST_MOVE: f64 = 0.3;

/// A person's parameters and how her innovations are whitened.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    pub(super) factors: PersonalFactors,
    /// One entry an effect.
    pub(super) amplitudes: Vec<f64>,
    /// Its scale is at least 1.
    pub(super) whitening: Whitening,
}

/// The training days of a person in one fold.
#[derive(Debug, Clone)]
pub(super) struct Training<'a> {
    pub(super) observations: &'a Observations,
    /// The person's model, with whatever factors.
    pub(super) model: &'a AugmentedModel,
    /// Stretches of training steps; the filter restarts in each.
    pub(super) stretches: Vec<Range<usize>>,
    pub(super) drivers: Vec<Driver<'a>>,
    /// What drivers look at, but for glucose.
    pub(super) whole: &'a Course,
    /// Glucose by the latest filter, mg/dL; meaningless outside of the stretches.
    pub(super) glucose: Vec<f64>,
}

/// Least squares at one point: what the training days say about factors and amplitudes.
#[derive(Debug, Clone)]
pub(super) struct Equations {
    /// Covariance of the factors given the amplitudes, priors included.
    factors: Mat<f64>,
    /// Gradient along the factors, priors included.
    gradient: Vec<f64>,
    /// Mixed curvature, `(factors, effects)`.
    mixed: Mat<f64>,
    /// Information on the amplitudes with the factors profiled out.
    pub(super) information: Mat<f64>,
    /// Information times the estimates.
    pub(super) weighted: Vec<f64>,
    /// Sum over days of the squared score of each amplitude: what its information would be if days, not
    /// steps, were independent.
    pub(super) by_day: Vec<f64>,
}

/// The model of a person with some factors; `person` is it with any.
pub(super) fn model(person: &AugmentedModel, factors: &PersonalFactors) -> AugmentedModel {
    let parameters = factors.applied_to(&OdeParameters::nominal());
    person.with_parameters(|_| parameters)
}

/// A stretch of a record under modulations of the whole record.
pub(super) fn stretch(
    observations: &Observations,
    range: &Range<usize>,
    modulations: &[Modulation],
) -> Observations {
    Observations {
        person: observations.person.clone(),
        weight: observations.weight,
        readings: observations.readings[range.clone()].to_vec(),
        inputs: observations.inputs[range.clone()].to_vec(),
        doses_recorded: observations.doses_recorded[range.clone()].to_vec(),
        modulations: modulations.get(range.clone()).map(<[Modulation]>::to_vec).unwrap_or_default(),
        interpolated_share: observations.interpolated_share,
    }
}

impl Training<'_> {
    /// What drivers may look at.
    pub(super) fn course(&self) -> Course {
        Course { glucose: self.glucose.clone(), ..self.whole.clone() }
    }

    /// What these drivers look at: where none of them reads glucose, it is that of the whole record.
    pub(super) fn driving(&self) -> Cow<'_, Course> {
        if self.drivers.iter().any(|driver| driver.reads_glucose) {
            Cow::Owned(self.course())
        } else {
            Cow::Borrowed(self.whole)
        }
    }

    /// The equations at a fit; whitening and glucose are brought up to date.
    ///
    /// # Errors
    /// As [`filter`](crate::filter::kalman::filter); [`GapError::Singular`].
    pub(super) fn equations(
        &mut self,
        fit: &mut Fit,
        rule: &CalibrationRule,
    ) -> Result<Equations, GapError> {
        let steps = self.observations.len();
        let columns = FACTORS + fit.amplitudes.len();
        let model = model(self.model, &fit.factors);
        let course = self.driving();
        let modulations = drivers::modulations(&self.drivers, &fit.amplitudes, &course, |_| true);
        let slopes = drivers::slopes(&self.drivers, &fit.amplitudes, &course);
        let mut innovations = vec![None; steps];
        // A row a step, in standard deviations of its innovation.
        let mut derivatives = vec![0.0; steps * columns];
        for range in &self.stretches {
            let record = stretch(self.observations, range, &modulations);
            let within = |(field, all): &(Field, Vec<f64>)| (*field, all[range.clone()].to_vec());
            let part = |slope: &Vec<_>| Direction::Course(slope.iter().map(within).collect());
            let mut directions = calibration::directions().to_vec();
            directions.extend(slopes.iter().map(part));
            let Along { filtered: run, blocks, .. } =
                filtered_along(&model, &record, &directions, &[])?;
            for (glucose, state) in self.glucose[range.clone()].iter_mut().zip(&run.states) {
                *glucose = model.person().glucose(&state.body).0;
            }
            let scored = rule.scored(self.observations, range);
            innovations[range.clone()].copy_from_slice(&normalised(&run.innovations, &scored));
            for (offset, innovation) in run.innovations.iter().enumerate() {
                let Some(innovation) = innovation else { continue };
                let sd = innovation.variance.sqrt();
                let first = (range.start + offset) * columns;
                for (members, rows) in &blocks {
                    for (member, value) in members.iter().zip(&rows[offset]) {
                        derivatives[first + member] = f64::from(*value) / sd;
                    }
                }
            }
        }
        let (whitening, residuals) = Whitening::fitted(&innovations, cautious_scale);
        fit.whitening = whitening;
        let Whitening { autoregression, scale } = whitening;
        let row = |(step, residual): (usize, &Option<f64>)| {
            let residual = (*residual)?;
            // What is whitened has both of the entries before it.
            let at = |entries: usize| {
                &derivatives[(step - entries * autoregression.spacing) * columns..][..columns]
            };
            let entries = at(0).iter().zip(at(1)).zip(at(2));
            let left = entries.map(|((now, before), earlier)| {
                autoregression.left(*now, *before, *earlier) / scale
            });
            Some(EquationRow {
                residual: residual / scale,
                weight: huber_weight(residual, scale),
                day: self.whole.day[step],
                derivatives: left.collect(),
            })
        };
        let rows: Vec<EquationRow> = residuals.iter().enumerate().filter_map(row).collect();
        Equations::of(&rows, fit)
            .ok_or_else(|| GapError::Singular { person: self.observations.person.clone() })
    }
}

/// A whitened row in units of the scale.
struct EquationRow {
    residual: f64,
    weight: f64,
    day: usize,
    derivatives: Vec<f64>,
}

/// Sum over days of the squared distance of the day's score from the mean day's, along an amplitude
/// that the factors answer to.
fn by_day(rows: &[EquationRow], effect: usize, answer: &Mat<f64>) -> f64 {
    let score = |row: &EquationRow| {
        let carried: f64 = (0..FACTORS).map(|k| answer[(k, effect)] * row.derivatives[k]).sum();
        row.weight * (row.derivatives[FACTORS + effect] - carried) * row.residual
    };
    let days = rows.chunk_by(|one, next| one.day == next.day);
    let scores: Vec<f64> = days.map(|day| day.iter().map(score).sum()).collect();
    let n = scores.len() as f64;
    if n < 2.0 {
        return 0.0;
    }
    let mean = scores.iter().sum::<f64>() / n;
    n / (n - 1.0) * scores.iter().map(|score| (score - mean).powi(2)).sum::<f64>()
}

impl Equations {
    /// `None` where the factors' curvature is not positive definite.
    fn of(rows: &[EquationRow], fit: &Fit) -> Option<Self> {
        let effects = fit.amplitudes.len();
        let columns = FACTORS + effects;
        // The lower triangle, row by row.
        let mut curvature = vec![0.0; columns * columns];
        let mut gradient = vec![0.0; columns];
        for EquationRow { residual, weight, derivatives, .. } in rows {
            let sums = gradient.iter_mut().zip(curvature.chunks_exact_mut(columns));
            for (a, (gradient, curvature)) in sums.enumerate() {
                let weighted = weight * derivatives[a];
                *gradient += weighted * residual;
                for (sum, value) in curvature[..=a].iter_mut().zip(derivatives) {
                    *sum += weighted * value;
                }
            }
        }
        let symmetric = |a: usize, b: usize| curvature[a.max(b) * columns + a.min(b)];
        let mut of_factors = Mat::from_fn(FACTORS, FACTORS, symmetric);
        for (index, factor) in Factor::ALL.into_iter().enumerate() {
            let precision = factor.prior_sd().powi(-2);
            of_factors[(index, index)] += precision;
            gradient[index] += precision * fit.factors.0[index];
        }
        let factors =
            of_factors.llt(Side::Lower).ok()?.solve(&Mat::<f64>::identity(FACTORS, FACTORS));
        let mixed = Mat::from_fn(FACTORS, effects, |a, b| symmetric(a, FACTORS + b));
        // How the factors answer to each amplitude.
        let answer = &factors * &mixed;
        let explained = mixed.transpose() * &answer;
        let information = Mat::from_fn(effects, effects, |a, b| {
            symmetric(FACTORS + a, FACTORS + b) - explained[(a, b)]
        });
        let weighted = (0..effects)
            .map(|a| {
                let carried: f64 = (0..FACTORS).map(|k| answer[(k, a)] * gradient[k]).sum();
                let here: f64 = (0..effects).map(|b| information[(a, b)] * fit.amplitudes[b]).sum();
                here - gradient[FACTORS + a] + carried
            })
            .collect();
        let by_day = (0..effects).map(|effect| by_day(rows, effect, &answer)).collect();
        gradient.truncate(FACTORS);
        Some(Self { factors, gradient, mixed, information, weighted, by_day })
    }

    /// Those of some of the amplitudes, where the others stay at zero.
    pub(super) fn restricted(&self, kept: &[usize]) -> Self {
        let n = kept.len();
        Self {
            factors: self.factors.clone(),
            gradient: self.gradient.clone(),
            mixed: Mat::from_fn(FACTORS, n, |row, column| self.mixed[(row, kept[column])]),
            information: Mat::from_fn(n, n, |row, column| {
                self.information[(kept[row], kept[column])]
            }),
            weighted: kept.iter().map(|column| self.weighted[*column]).collect(),
            by_day: kept.iter().map(|column| self.by_day[*column]).collect(),
        }
    }

    /// What the person says about the amplitudes, when the information on each has to be divided by
    /// `inflation`.
    pub(super) fn evidence(&self, inflation: &[f64]) -> AmplitudeEvidence {
        let Self { information, weighted, .. } = self;
        if inflation.iter().all(|factor| *factor == 1.0) {
            let (information, weighted) = (information.clone(), weighted.clone());
            return AmplitudeEvidence { information, weighted };
        }
        let n = weighted.len();
        let shrunk =
            Mat::from_fn(n, n, |a, b| information[(a, b)] / (inflation[a] * inflation[b]).sqrt());
        // The estimate stays where it is: weighted = shrunk information x (information^-1 weighted).
        let right = Mat::from_fn(n, 1, |row, _| weighted[row]);
        let ridge =
            Mat::from_fn(n, n, |a, b| information[(a, b)] + if a == b { RIDGE } else { 0.0 });
        let weighted = match ridge.llt(Side::Lower) {
            Ok(factor) => {
                let estimate = factor.solve(&right);
                let of = |a: usize| (0..n).map(|b| shrunk[(a, b)] * estimate[(b, 0)]).sum();
                (0..n).map(of).collect()
            }
            Err(_) => weighted.iter().zip(inflation).map(|(weighted, by)| weighted / by).collect(),
        };
        AmplitudeEvidence { information: shrunk, weighted }
    }

    /// Moves the factors, and the amplitudes to `amplitudes`; returns the length of the move in posterior
    /// standard deviations.
    pub(super) fn step(&self, fit: &mut Fit, amplitudes: Vec<f64>, bound: f64) -> f64 {
        let change: Vec<f64> =
            amplitudes.iter().zip(&fit.amplitudes).map(|(new, old)| new - old).collect();
        let force: [f64; FACTORS] = std::array::from_fn(|k| {
            let pushed = change.iter().enumerate().map(|(e, by)| self.mixed[(k, e)] * by);
            self.gradient[k] + pushed.sum::<f64>()
        });
        let mut square = 0.0;
        for row in 0..FACTORS {
            let step: f64 = (0..FACTORS).map(|k| -self.factors[(row, k)] * force[k]).sum();
            square -= step * force[row];
            let step = step.clamp(-LONGEST_MOVE, LONGEST_MOVE);
            fit.factors.0[row] = (fit.factors.0[row] + step).clamp(-bound, bound);
        }
        for (row, by) in change.iter().enumerate() {
            for (column, other) in change.iter().enumerate() {
                square += by * self.information[(row, column)] * other;
            }
        }
        fit.amplitudes = amplitudes;
        square.max(0.0).sqrt()
    }
}

/// Information added so that an effect nobody's record shows has an estimate.
const RIDGE: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use cohort::Channel;

    use super::super::sample;
    use super::*;
    use crate::course::course;

    #[test]
    fn training_does_not_know_the_readings_held_out() {
        let person = sample::person(6);
        let mut other = person.clone();
        for reading in &mut other.record.channel_mut(Channel::Cgm)[576..1152] {
            *reading = reading.map(|value| 400.0 - value);
        }
        let exercise = effects::find("exercise").expect("in the library");
        let weighted = |person: &cohort::Person| {
            let observations = Observations::from_person(person).expect("a good record");
            let course = course(person, vec![120.0; person.record.len()]);
            let drivers = vec![Driver::new(exercise.as_ref(), 0, &course)];
            let stretches = vec![0..576, 1152..1728];
            let model = &sample::model(observations.weight);
            let (observations, whole) = (&observations, &course);
            let glucose = course.glucose.clone();
            let mut training = Training { observations, model, stretches, drivers, whole, glucose };
            let mut fit = Fit {
                factors: PersonalFactors::default(),
                amplitudes: vec![0.5],
                whitening: sample::UNWHITENED,
            };
            let rule = CalibrationRule::working();
            let mut found = Vec::new();
            for _ in 0..2 {
                let equations = training.equations(&mut fit, &rule).expect("solves");
                found.push((equations.weighted.clone(), equations.information[(0, 0)]));
                equations.step(&mut fit, vec![0.7], 0.9);
            }
            (found, fit.factors)
        };
        let trained = weighted(&person);
        assert_eq!(trained, weighted(&other));
        let mut changed = person.clone();
        changed.record.channel_mut(Channel::Cgm)[300] = Some(150.0);
        assert_ne!(trained, weighted(&changed), "a training reading counts");
    }

    #[test]
    fn a_variant_among_others_at_zero_has_the_equations_it_has_alone() {
        let person = sample::person(4);
        let observations = Observations::from_person(&person).expect("a good record");
        let whole = course(&person, vec![120.0; person.record.len()]);
        let (exercise, dawn) = (effects::find("exercise"), effects::find("dawn"));
        let (exercise, dawn) = (exercise.expect("known"), dawn.expect("known"));
        let model = &sample::model(observations.weight);
        let taken = |variants: &[usize]| {
            let mut drivers: Vec<Driver<'_>> =
                variants.iter().map(|v| Driver::new(exercise.as_ref(), *v, &whole)).collect();
            drivers.push(Driver::new(dawn.as_ref(), 0, &whole));
            let mut amplitudes = vec![0.0; variants.len()];
            amplitudes.push(0.3);
            let (observations, whole) = (&observations, &whole);
            let (stretches, glucose) = (vec![0..576, 700..864], whole.glucose.clone());
            let mut training = Training { observations, model, stretches, drivers, whole, glucose };
            let mut fit = Fit {
                factors: PersonalFactors::default(),
                amplitudes,
                whitening: sample::UNWHITENED,
            };
            let rule = CalibrationRule::working();
            training.equations(&mut fit, &rule).expect("solves")
        };
        let among = taken(&[0, 1, 2]).restricted(&[1, 3]);
        let alone = taken(&[1]);
        let near = |a: f64, b: f64| {
            // Single precision of the signatures.
            assert!((a - b).abs() < 1e-5 * a.abs().max(1.0), "{a} against {b}");
        };
        for row in 0..2 {
            near(among.weighted[row], alone.weighted[row]);
            near(among.by_day[row], alone.by_day[row]);
            for column in 0..2 {
                near(among.information[(row, column)], alone.information[(row, column)]);
            }
            for factor in 0..FACTORS {
                near(among.mixed[(factor, row)], alone.mixed[(factor, row)]);
            }
        }
        assert!(alone.information[(0, 0)] > 1.0 && alone.information[(0, 1)] != 0.0);
    }
}
