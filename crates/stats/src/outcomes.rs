//! Glucose outcomes of one trace: time in ranges, risk indices, mean and variability.

use std::fmt;

use physiology::MgPerDl;

use crate::StatsError;
use crate::error::at_least;
use crate::moments::{mean, mean_and_sd};

/// Lower edge of the target range, mg/dL, inclusive (Battelino et al. 2019).
const TARGET_LOW: f64 = 70.0;
/// Upper edge of the target range, mg/dL, inclusive (Battelino et al. 2019).
const TARGET_HIGH: f64 = 180.0;
/// Level-2 hypoglycaemia lies below, mg/dL (Battelino et al. 2019).
const LEVEL_2_LOW: f64 = 54.0;
/// Level-2 hyperglycaemia lies above, mg/dL (Battelino et al. 2019).
const LEVEL_2_HIGH: f64 = 250.0;
/// Below this, mg/dL, `ln G` is negative and the risk function is undefined.
const LEAST_GLUCOSE: f64 = 1.0;

/// The six outcomes on which the paper tests equivalence.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Outcome {
    /// Time in range, 70-180 mg/dL inclusive, % of samples.
    Tir,
    /// Time above range, > 180 mg/dL, % of samples.
    Tar,
    /// Time below range, < 70 mg/dL, % of samples.
    Tbr,
    /// Low blood glucose index, dimensionless.
    Lbgi,
    /// High blood glucose index, dimensionless.
    Hbgi,
    /// Mean glucose, mg/dL.
    Mg,
}

/// Key, abbreviation, unit and equivalence margin of each outcome, in the order of
/// [`Outcome::ALL`].
const FACTS: [(&str, &str, &str, f64); 6] = [
    ("tir", "TIR", "%", 5.0),
    ("tar", "TAR", "%", 5.0),
    ("tbr", "TBR", "%", 1.0),
    ("lbgi", "LBGI", "", 0.5),
    ("hbgi", "HBGI", "", 1.0),
    ("mg", "MG", MgPerDl::UNIT, 10.0),
];

impl Outcome {
    /// All six, in the paper's order.
    pub const ALL: [Self; 6] = [Self::Tir, Self::Tar, Self::Tbr, Self::Lbgi, Self::Hbgi, Self::Mg];

    /// Lower-case key, as it stands in JSON outputs.
    #[must_use]
    pub const fn key(self) -> &'static str {
        FACTS[self as usize].0
    }

    /// The field's abbreviation.
    #[must_use]
    pub const fn name(self) -> &'static str {
        FACTS[self as usize].1
    }

    /// Unit; empty for the dimensionless risk indices.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        FACTS[self as usize].2
    }

    /// Equivalence margin of the paper, in the outcome's own unit (percentage points for times).
    #[must_use]
    pub const fn margin(self) -> f64 {
        FACTS[self as usize].3
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Outcomes of one glucose trace, or their average over several.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcomes {
    /// Time in 70-180 mg/dL inclusive, %.
    pub tir: f64,
    /// Time above 180 mg/dL, %.
    pub tar: f64,
    /// Time below 70 mg/dL, %.
    pub tbr: f64,
    /// Low blood glucose index, dimensionless.
    pub lbgi: f64,
    /// High blood glucose index, dimensionless.
    pub hbgi: f64,
    /// Mean glucose, mg/dL.
    pub mg: f64,
    /// Sample standard deviation of glucose, mg/dL.
    pub sd: f64,
    /// Coefficient of variation, 100 SD / mean, %.
    pub cv: f64,
    /// Glucose management indicator, 3.31 + 0.02392 MG, % (Bergenstal et al. 2018).
    pub gmi: f64,
    /// Time below 54 mg/dL, %.
    pub tbr54: f64,
    /// Time above 250 mg/dL, %.
    pub tar250: f64,
}

impl Outcomes {
    /// Outcomes of the samples that are present; the caller leaves missing ones out.
    ///
    /// The risk indices are means over *all* samples, `LBGI = mean(10 min(f, 0)^2)` and
    /// `HBGI = mean(10 max(f, 0)^2)`, with `f = 1.509 ((ln G)^1.084 - 5.381)` (Kovatchev et al.
    /// 1997, G in mg/dL).
    ///
    /// # Errors
    ///
    /// [`StatsError::TooFew`] below two samples (a spread needs two),
    /// [`StatsError::NotAGlucose`] for a value that is not finite or below 1 mg/dL.
    pub fn of(glucose: impl IntoIterator<Item = MgPerDl>) -> Result<Self, StatsError> {
        let glucose: Vec<f64> = glucose.into_iter().map(MgPerDl::value).collect();
        at_least(2, "glucose samples", glucose.len())?;
        if let Some(index) = glucose.iter().position(|g| !g.is_finite() || *g < LEAST_GLUCOSE) {
            return Err(StatsError::NotAGlucose { index, value: glucose[index] });
        }

        let n = glucose.len() as f64;
        let percent = |inside: &dyn Fn(f64) -> bool| {
            100.0 * glucose.iter().filter(|g| inside(**g)).count() as f64 / n
        };
        let (mg, sd) = mean_and_sd(&glucose);
        let (mut low, mut high) = (0.0, 0.0);
        for g in &glucose {
            let f = risk(*g);
            low += 10.0 * f.min(0.0).powi(2);
            high += 10.0 * f.max(0.0).powi(2);
        }

        Ok(Self {
            tir: percent(&|g| (TARGET_LOW..=TARGET_HIGH).contains(&g)),
            tar: percent(&|g| g > TARGET_HIGH),
            tbr: percent(&|g| g < TARGET_LOW),
            lbgi: low / n,
            hbgi: high / n,
            mg,
            sd,
            cv: 100.0 * sd / mg,
            gmi: 3.31 + 0.02392 * mg,
            tbr54: percent(&|g| g < LEVEL_2_LOW),
            tar250: percent(&|g| g > LEVEL_2_HIGH),
        })
    }

    /// Mean of each outcome over the windows of one person, as the paper evaluates (5-h windows).
    ///
    /// # Errors
    ///
    /// [`StatsError::TooFew`] where there is no window.
    pub fn average(windows: &[Self]) -> Result<Self, StatsError> {
        at_least(1, "windows", windows.len())?;
        let over = |field: fn(&Self) -> f64| mean(&windows.iter().map(field).collect::<Vec<_>>());
        Ok(Self {
            tir: over(|o| o.tir),
            tar: over(|o| o.tar),
            tbr: over(|o| o.tbr),
            lbgi: over(|o| o.lbgi),
            hbgi: over(|o| o.hbgi),
            mg: over(|o| o.mg),
            sd: over(|o| o.sd),
            cv: over(|o| o.cv),
            gmi: over(|o| o.gmi),
            tbr54: over(|o| o.tbr54),
            tar250: over(|o| o.tar250),
        })
    }

    /// The value of one of the six tested outcomes, in its unit.
    #[must_use]
    pub const fn get(&self, outcome: Outcome) -> f64 {
        match outcome {
            Outcome::Tir => self.tir,
            Outcome::Tar => self.tar,
            Outcome::Tbr => self.tbr,
            Outcome::Lbgi => self.lbgi,
            Outcome::Hbgi => self.hbgi,
            Outcome::Mg => self.mg,
        }
    }
}

/// Symmetrised glucose `f = 1.509 ((ln G)^1.084 - 5.381)`, `glucose` in mg/dL, at least 1.
///
/// Kovatchev et al. 1997: negative below 112.5 mg/dL, positive above.
fn risk(glucose: f64) -> f64 {
    1.509 * (glucose.ln().powf(1.084) - 5.381)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(values: &[f64]) -> Result<Outcomes, StatsError> {
        Outcomes::of(values.iter().copied().map(MgPerDl))
    }

    /// Both edges of the target range, and samples on either side of every threshold.
    const TRACE: [f64; 10] = [45.0, 62.0, 69.0, 70.0, 95.0, 120.0, 180.0, 181.0, 251.0, 330.0];

    #[test]
    fn matches_an_independent_computation() {
        let o = of(&TRACE).expect("a valid trace");
        assert_eq!((o.tir, o.tar, o.tbr, o.tbr54, o.tar250), (40.0, 30.0, 30.0, 10.0, 20.0));
        // numpy: f = 1.509*(np.log(g)**1.084-5.381); (10*np.minimum(f,0)**2).mean(), the same
        // with maximum; g.mean(); g.std(ddof=1); 100*sd/mean; 3.31+0.02392*mean.
        // 1e-12 relative leaves room for the last digits of ln and pow.
        for (ours, numpy) in [
            (o.lbgi, 5.784157987974403),
            (o.hbgi, 7.938241558740138),
            (o.mg, 140.3),
            (o.sd, 93.7941599698214),
            (o.cv, 66.85257303622338),
            (o.gmi, 6.665976),
        ] {
            assert!((ours - numpy).abs() < 1e-12 * numpy, "{ours} against {numpy}");
        }
    }

    #[test]
    fn risk_vanishes_at_its_published_centre() {
        // Kovatchev et al. give 112.5 mg/dL to one decimal; the slope of f there is 0.0163.
        assert!(risk(112.5).abs() < 0.05 * 0.02);
        // The scale is chosen so that 10 f^2 reaches 100 at 600 and (nearly) at 20 mg/dL.
        assert!((10.0 * risk(600.0).powi(2) - 100.0).abs() < 0.1);
        assert!((10.0 * risk(20.0).powi(2) - 100.0).abs() < 0.1);
    }

    #[test]
    fn what_is_not_a_glucose_is_named() {
        for bad in [f64::NAN, f64::INFINITY, 0.0, -3.0, 0.99] {
            match of(&[100.0, bad]) {
                Err(StatsError::NotAGlucose { index: 1, .. }) => {}
                other => panic!("{bad} gave {other:?}"),
            }
        }
        assert!(matches!(of(&[100.0]), Err(StatsError::TooFew { n: 1, needed: 2, .. })));
    }

    #[test]
    fn the_average_is_over_windows_not_samples() {
        let short = of(&[60.0, 60.0]).expect("valid");
        let long = of(&[100.0; 8]).expect("valid");
        let average = Outcomes::average(&[short, long]).expect("two windows");
        assert_eq!((average.tbr, average.tir, average.mg), (50.0, 50.0, 80.0));
        assert!(Outcomes::average(&[]).is_err());
    }

    #[test]
    fn keys_are_those_of_the_json() {
        let keys: Vec<&str> = Outcome::ALL.iter().map(|o| o.key()).collect();
        assert_eq!(keys, ["tir", "tar", "tbr", "lbgi", "hbgi", "mg"]);
        let margins: Vec<f64> = Outcome::ALL.iter().map(|o| o.margin()).collect();
        assert_eq!(margins, [5.0, 5.0, 1.0, 0.5, 1.0, 10.0]);
    }
}
