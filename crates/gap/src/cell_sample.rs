//! One cell over people: its mean, and the error of that mean at two levels.

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use crate::localisation::day_cells::{DayCells, LocalisationRule};
use crate::moderation::VariancePrior;

/// What a block of days adds to the error of a cell's mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Residual {
    /// Owner (the person) and block of days.
    pub(crate) block: (usize, usize),
    pub(crate) value: f64,
}

/// A cell over people.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sample {
    pub(crate) mean: f64,
    pub(crate) people: usize,
    pub(crate) errors: f64,
    /// Variance of people's means among each other; 0 for one person.
    pub(crate) between: f64,
    /// Mean variance of a person's mean from the blocks of days.
    pub(crate) within: f64,
    /// Degrees of freedom of `within`.
    pub(crate) within_degrees: f64,
    pub(crate) residuals: Vec<Residual>,
}

impl Sample {
    /// `None` where nobody has enough errors or where blocks do not vary.
    pub(crate) fn of(
        people: &[Vec<DayCells>],
        cell: usize,
        rule: &LocalisationRule,
    ) -> Option<Self> {
        let mut means = Vec::new();
        let mut residuals = Vec::new();
        let (mut errors, mut within, mut degrees) = (0.0, 0.0, 0.0);
        for (person, days) in people.iter().enumerate() {
            let count: f64 = days.iter().map(|day| day.counts[cell]).sum();
            let present = days.iter().filter(|day| day.counts[cell] > 0.0).count();
            if count < rule.fewest_errors as f64 || present < rule.fewest_days {
                continue;
            }
            let mean = days.iter().map(|day| day.sums[cell]).sum::<f64>() / count;
            // A ratio of totals over blocks, linearised.
            let blocks: Vec<(usize, f64)> = days
                .chunks(rule.block_days)
                .enumerate()
                .filter(|(_, block)| block.iter().any(|day| day.counts[cell] > 0.0))
                .map(|(index, block)| {
                    let sum = |of: fn(&DayCells) -> &[f64]| -> f64 {
                        block.iter().map(|day| of(day)[cell]).sum()
                    };
                    (index, (sum(|d| &d.sums) - mean * sum(|d| &d.counts)) / count)
                })
                .collect();
            let b = blocks.len() as f64;
            if b < 2.0 {
                continue;
            }
            let correction = (b / (b - 1.0)).sqrt();
            for (index, value) in blocks {
                residuals.push(Residual { block: (person, index), value: correction * value });
            }
            degrees += b - 1.0;
            errors += count;
            means.push(mean);
        }
        let n = means.len() as f64;
        let mean = means.iter().sum::<f64>() / n;
        for residual in &mut residuals {
            residual.value /= n;
            within += residual.value * residual.value;
        }
        let squares: f64 = means.iter().map(|m| (m - mean).powi(2)).sum();
        let between = squares / (n - 1.0).max(1.0);
        // `within` was summed for the mean over people; a person's own is n times that.
        (within > 0.0).then_some(Self {
            mean,
            people: means.len(),
            errors,
            between,
            within: n * within,
            within_degrees: degrees,
            residuals,
        })
    }

    /// Spread between people over what days alone would give.
    pub(crate) fn ratio(&self) -> f64 {
        self.between / self.within
    }

    pub(crate) fn between_degrees(&self) -> f64 {
        self.people as f64 - 1.0
    }

    /// `cells` is how many cells made the prior; half of them, being correlated, count.
    pub(crate) fn tested(self, prior: Option<VariancePrior>, cells: usize) -> Tested {
        let own = self.between_degrees();
        let (ratio, degrees) = match prior {
            _ if self.people == 1 => (1.0, self.within_degrees),
            Some(prior) => prior.moderated(self.ratio(), own, 0.5 * cells as f64 * own),
            None => (self.ratio().max(1.0), own),
        };
        Tested {
            error: (ratio * self.within / self.people as f64).sqrt(),
            degrees: degrees.min(self.within_degrees),
            sample: self,
        }
    }
}

/// A cell with the error of its mean.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tested {
    pub(crate) sample: Sample,
    pub(crate) error: f64,
    degrees: f64,
}

impl Tested {
    /// Gives the residuals weights of their own, which no other `owner` shares.
    pub(crate) fn owned_by(&mut self, owner: usize) {
        for residual in &mut self.sample.residuals {
            residual.block.0 = owner;
        }
    }

    /// The standard normal quantile with the tail of the cell's |t|; infinite where that vanishes.
    pub(crate) fn normal_size(&self) -> f64 {
        let t = (self.sample.mean / self.error).abs();
        let student = StudentsT::new(0.0, 1.0, self.degrees);
        student.map_or(t, |student| -Normal::standard().inverse_cdf(student.sf(t)))
    }

    /// The |t| with the tail of a standard normal `z`, at least 0.
    pub(crate) fn own_size(&self, z: f64) -> f64 {
        let student = StudentsT::new(0.0, 1.0, self.degrees);
        student.map_or(z, |student| -student.inverse_cdf(Normal::standard().sf(z)))
    }
}
