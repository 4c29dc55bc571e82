//! `realism.json`: made people beside real ones.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Where a person comes from.
#[apply(word!)]
#[derive(Hash, PartialOrd, Ord)]
pub enum Group {
    /// A world in which nothing is missing.
    Null,
    /// A world in which an effect acts.
    Effect,
    /// A record of a real person.
    Real,
}

/// The statistics of one person.
#[apply(strict!)]
pub struct PersonStatistics {
    /// Where the person comes from.
    pub group: Group,
    /// The hand that made the person; the study, for a real one.
    pub hand: String,
    /// The person's identifier.
    pub person_id: String,
    /// Statistics by name; what cannot be computed of this record is absent.
    pub values: BTreeMap<String, f64>,
}

/// The statistics of everybody, real people first.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct People(pub Vec<PersonStatistics>);

/// Quantiles of one statistic in one group.
#[apply(strict!)]
#[derive(Copy)]
pub struct Quantiles {
    /// People.
    pub people: usize,
    /// 2.5 % quantile.
    pub lower: f64,
    /// Median.
    pub median: f64,
    /// 97.5 % quantile.
    pub upper: f64,
}

/// One statistic.
#[apply(strict!)]
pub struct StatisticRow {
    /// Its name.
    pub statistic: String,
    /// In worlds without an effect; `None` where nobody there has it.
    pub nulls: Option<Quantiles>,
    /// In worlds with effects.
    pub effects: Option<Quantiles>,
    /// In real people.
    pub real: Quantiles,
    /// Real people outside the central 95 % of both kinds of worlds, with their values.
    pub outside: BTreeMap<String, f64>,
    /// How many could lie outside by chance: more do in less than 5 % of draws of so many people.
    pub allowed_outside: usize,
    /// Whether no more lie outside than could by chance.
    pub inside: bool,
}

/// The table: `realism.json`.
#[apply(strict!)]
pub struct Realism {
    /// Always `realism/1`.
    pub schema: String,
    /// A row a statistic, by name.
    pub statistics: Vec<StatisticRow>,
    /// Statistics in which real people lie inside.
    pub inside: usize,
    /// Statistics in which every real person lies within the central 95 %.
    pub all_inside: usize,
    /// Values of real people within the central 95 %, of all of them.
    pub values_inside: usize,
    /// Values of real people that were compared.
    pub values: usize,
}
