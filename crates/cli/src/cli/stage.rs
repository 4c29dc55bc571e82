//! The stages of a pipeline.

use clap::ValueEnum;

/// The stages, in order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub(crate) enum Stage {
    /// Read and judge the cohort's records.
    Cohort,
    /// Simulate days and train the population network.
    Train,
    /// Prove or refute the network's monotonicity.
    Verify,
    /// Compare the network with the ODE on simulated days that trained neither.
    HeldOut,
    /// Train a twin a person, and its variants.
    Twin,
    /// Fit what twins are compared with.
    Baselines,
    /// Compare with held-out days.
    Evaluate,
    /// Say where the ODE plant misses.
    Diagnose,
    /// Write the report.
    Report,
}

impl Stage {
    /// Its folder in the output of a pipeline.
    pub(crate) fn folder(self) -> &'static str {
        match self {
            Self::Cohort => "1-cohort",
            Self::Train => "2-train",
            Self::Verify => "3-verify",
            Self::HeldOut => "4-held-out",
            Self::Twin => "5-twin",
            Self::Baselines => "6-baselines",
            Self::Evaluate => "7-evaluate",
            Self::Diagnose => "8-diagnose",
            Self::Report => "report",
        }
    }

    /// As it is typed.
    pub(crate) fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }
}
