//! `data_in_use.json`: the people, days and channels that are used, and what each check of the data said.

/// `data_in_use.json`: the people, days and channels that are used, the same for every stage.
#[apply(strict!)]
pub struct DataInUse {
    /// `data-in-use/1`.
    pub schema: String,
    /// One entry a person, in the order of the cohort.
    pub people: Vec<PersonInUse>,
}

/// What is used of one person.
#[apply(strict!)]
pub struct PersonInUse {
    /// The person.
    pub person_id: String,
    /// Why the person is left out of every stage; null for one who is used.
    pub left_out: Option<String>,
    /// One entry a check, in the order in which they are made.
    pub checks: Vec<CheckResult>,
    /// Calendar days that the record touches.
    pub days: usize,
    /// Days of which nothing is used, in order; all others are used. Empty for a person who is left out.
    pub days_left_out: Vec<DayLeftOut>,
    /// Channels of which nothing, or not everything that is recorded, is used.
    pub channels_left_out: Vec<ChannelLeftOut>,
}

/// What a check said of a person.
#[apply(strict!)]
pub struct CheckResult {
    /// The check's name, e.g. `flat_cgm`.
    pub check: String,
    /// What follows from it.
    pub result: CheckOutcome,
    /// What was found, a sentence a finding; empty for `pass`.
    pub findings: Vec<String>,
}

named::named_in_json! {
    /// What follows from a check.
    #[derive(serde::Serialize, serde::Deserialize)]
    #[cfg_attr(test, derive(schemars::JsonSchema))]
    CheckOutcome {
        /// Nothing was found.
        Pass: "pass",
        /// Something was found that leaves the person in use: it is said, or a channel or some values are not used.
        Warn: "warn",
        /// The person is left out.
        Fail: "fail",
    }
}

/// A day of which nothing is used.
#[apply(strict!)]
#[derive(Eq)]
pub struct DayLeftOut {
    /// The date, `YYYY-MM-DD`.
    pub date: String,
    /// The check that left it out, or what its record lacks.
    pub reason: String,
}

/// A channel of which not everything that is recorded is used.
#[apply(strict!)]
pub struct ChannelLeftOut {
    /// Column of `records.csv`.
    pub channel: String,
    /// Share of its recorded values that are not used, 0 to 1.
    pub share: f64,
    /// The check that left them out.
    pub reason: String,
}
