//! The paper's table: six outcomes of one method against the real ones, over people.

use contract::{Equivalence, WithInterval};

use crate::{Outcome, Outcomes, StatsError, summary, tost};

/// Tests the six outcomes with the paper's margins; one entry a person, the same order in both. The rows
/// are in the order of [`Outcome::ALL`].
///
/// # Errors
///
/// As [`tost::paired`].
pub fn compare_outcomes(
    actual: &[Outcomes],
    simulated: &[Outcomes],
    alpha: f64,
) -> Result<Vec<Equivalence>, StatsError> {
    Outcome::ALL
        .into_iter()
        .map(|metric| {
            let column = |people: &[Outcomes]| -> Vec<f64> {
                people.iter().map(|person| person.get(metric)).collect()
            };
            let (real, model) = (column(actual), column(simulated));
            let test = tost::paired(&real, &model, metric.margin(), alpha)?;
            Ok(Equivalence {
                metric: metric.key().to_owned(),
                unit: metric.unit().to_owned(),
                margin: metric.margin(),
                actual: summary(&real)?,
                simulated: summary(&model)?,
                difference: WithInterval {
                    value: test.difference,
                    lower: test.interval.lower,
                    upper: test.interval.upper,
                },
                p: test.p,
                equivalent: test.equivalent,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use physiology::MgPerDl;

    use super::*;

    #[test]
    fn rows_follow_the_papers_order_and_margins() {
        let person = |base: f64| {
            let trace = (0..60).map(|k| MgPerDl(base + f64::from(k)));
            Outcomes::of(trace).expect("a valid trace")
        };
        let actual = [person(80.0), person(120.0), person(140.0)];
        let shifted = [person(83.0), person(122.0), person(144.0)];
        let rows = compare_outcomes(&actual, &shifted, 0.05).expect("three people");
        let metrics: Vec<&str> = rows.iter().map(|row| row.metric.as_str()).collect();
        assert_eq!(metrics, Outcome::ALL.map(Outcome::key));
        let mg = &rows[5];
        // Shifts 3, 2 and 4 mg/dL: the mean is 3 up to rounding of sums of 60 values.
        assert!((mg.difference.value - 3.0).abs() < 1e-12);
        assert!(mg.equivalent && mg.difference.upper < mg.margin);
        assert!(compare_outcomes(&actual, &shifted[..2], 0.05).is_err());
    }
}
