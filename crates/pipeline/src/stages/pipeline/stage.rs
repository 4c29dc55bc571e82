//! The stages of a pipeline.

/// The stages, in order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
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
    /// Every stage, in order.
    pub const ALL: [Self; 9] = [
        Self::Cohort,
        Self::Train,
        Self::Verify,
        Self::HeldOut,
        Self::Twin,
        Self::Baselines,
        Self::Evaluate,
        Self::Diagnose,
        Self::Report,
    ];

    /// Its folder in the output of a pipeline.
    #[must_use]
    pub const fn folder(self) -> &'static str {
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

    /// Its name: the folder's without the number.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.folder().trim_start_matches(|c: char| c.is_ascii_digit() || c == '-')
    }
}
