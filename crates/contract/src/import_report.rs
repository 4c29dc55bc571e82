//! `import_report.json`: what was found and done on import.

use std::fmt;

/// Everything a reader must know to trust a cohort. What only an importer knows is absent where a cohort folder is
/// read as it is.
#[apply(strict!)]
pub struct ImportReport {
    /// Name of the format.
    pub format: String,
    /// What "per day" means in `people`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub days_are: Option<String>,
    /// One entry a person, in the order of the cohort.
    pub people: Vec<PersonImport>,
    /// Units and meanings that were inferred, with the evidence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inferences: Option<Vec<Inference>>,
    /// What was changed, merged, left out or looks odd.
    pub notes: Vec<Note>,
}

/// One person's part of an import.
#[apply(strict!)]
pub struct PersonImport {
    /// Daily figures.
    pub balance: MassBalance,
    /// The same in one line.
    pub line: String,
    /// Therapy as stated or inferred: `open_loop_pump`, `aid`, `mdi` or `unknown`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub therapy: Option<String>,
    /// Amounts in the source, in the record, and left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub totals: Option<Vec<Totals>>,
    /// Implausible figures; nothing was changed because of them.
    pub findings: Vec<ImplausibleFigure>,
}

/// Daily figures of one person. Shares are of the record's steps; amounts a day are over the steps in which that
/// channel is recorded; null for a channel that is missing.
#[apply(strict!)]
pub struct MassBalance {
    /// The person's identifier.
    pub person: String,
    /// Steps of the record / 288.
    pub days: f64,
    /// Basal insulin, U/day.
    pub basal_u_day: Option<f64>,
    /// Bolus insulin, U/day.
    pub bolus_u_day: Option<f64>,
    /// Carbohydrate, g/day.
    pub carbs_g_day: Option<f64>,
    /// Mean sensor glucose, mg/dL.
    pub mean_glucose_mg_dl: Option<f64>,
    /// Share of steps with a sensor reading, 0 to 1.
    pub cgm_share: f64,
    /// Share of steps with a heart rate, 0 to 1.
    pub heart_rate_share: f64,
}

/// An implausible figure.
#[apply(strict!)]
pub struct ImplausibleFigure {
    /// The person's identifier.
    pub person: String,
    /// Column of `records.csv`.
    pub column: String,
    /// The calendar day, if the figure is about one.
    pub date: Option<String>,
    /// The step within the record, if the figure is about one.
    pub step: Option<usize>,
    /// Start of that step, local wall clock.
    pub time: Option<String>,
    /// What was judged.
    pub what: String,
    /// Its value, in `unit`.
    pub value: f64,
    /// Its unit.
    pub unit: String,
    /// Smallest and largest plausible value, in `unit`.
    pub plausible: (f64, f64),
}

/// The account of one amount: `source = record + left_out`.
#[apply(strict!)]
pub struct Totals {
    /// Column of `records.csv`.
    pub column: String,
    /// Unit of the three amounts.
    pub unit: String,
    /// Sum over the source.
    pub source: f64,
    /// Sum over the record.
    pub record: f64,
    /// Sum over what the notes list as left out.
    pub left_out: f64,
}

/// A unit or meaning that the source does not state.
#[apply(strict!)]
pub struct Inference {
    /// The person's identifier.
    pub person: String,
    /// The file.
    pub file: String,
    /// The line of a text file (the header is line 1), or the data row of a Parquet file (from 1).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub row: Option<usize>,
    /// The column.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// What was concluded.
    pub conclusion: String,
    /// The figures it rests on.
    pub evidence: String,
}

/// Something that was changed, merged, left out or looks odd.
#[apply(strict!)]
pub struct Note {
    /// The person, if it concerns one.
    pub person: Option<String>,
    /// The file; the first if there are several.
    pub file: String,
    /// The line of a text file (the header is line 1), or the data row of a Parquet file (from 1).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub row: Option<usize>,
    /// The column.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// What.
    pub what: String,
    /// How many times.
    pub count: usize,
}

impl ImportReport {
    /// The daily figures, one line a person.
    pub fn lines(&self) -> impl Iterator<Item = &str> {
        self.people.iter().map(|person| person.line.as_str())
    }
}

impl Totals {
    /// Whether the account closes, within rounding: 1e-9 of the source's amount.
    #[must_use]
    pub fn closes(&self) -> bool {
        (self.source - self.record - self.left_out).abs() <= 1e-9 * self.source.abs().max(1.0)
    }
}

impl fmt::Display for MassBalance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown = |value: Option<f64>, digits: usize| {
            value.map_or_else(|| "?".to_owned(), |value| format!("{value:.digits$}"))
        };
        write!(
            f,
            "{}: {:.0} days, {} + {} U/day, {} g/day, mean {} mg/dL, CGM {:.0} %, heart rate {:.0} %",
            self.person,
            self.days,
            shown(self.basal_u_day, 1),
            shown(self.bolus_u_day, 1),
            shown(self.carbs_g_day, 0),
            shown(self.mean_glucose_mg_dl, 0),
            100.0 * self.cgm_share,
            100.0 * self.heart_rate_share,
        )
    }
}

impl fmt::Display for ImplausibleFigure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "person '{}'", self.person)?;
        for when in self.date.iter().chain(&self.time) {
            write!(f, ", {when}")?;
        }
        let (low, high) = self.plausible;
        write!(
            f,
            ", column {}: {} of {:.3} {} is outside {low} to {high}; check the unit",
            self.column, self.what, self.value, self.unit
        )
    }
}

impl fmt::Display for Inference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.person, self.file)?;
        write_cell(f, self.row, self.column.as_deref())?;
        write!(f, ": {}; {}", self.conclusion, self.evidence)
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(person) = &self.person {
            write!(f, "{person}: ")?;
        }
        f.write_str(&self.file)?;
        write_cell(f, self.row, self.column.as_deref())?;
        write!(f, ": {} ({}x)", self.what, self.count)
    }
}

/// Where in a file, if the place is not the whole file.
fn write_cell(f: &mut fmt::Formatter<'_>, row: Option<usize>, column: Option<&str>) -> fmt::Result {
    if let Some(row) = row {
        write!(f, ", row {row}")?;
    }
    column.map_or(Ok(()), |column| write!(f, ", column {column}"))
}
