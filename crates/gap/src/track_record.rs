//! How much an answer deserves to be believed: what the blind check measured of this diagnosis.

use serde::{Deserialize, Serialize};

/// The figures of the full blind checks of today's posterior, by hands that nothing of the diagnosis they judge has seen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrackRecord {
    /// The commands that print the figures.
    pub source: Vec<String>,
    /// Cohorts in which nothing is missing, with any alarm.
    pub nulls_with_alarm: Counted,
    /// The same with a name.
    pub nulls_with_name: Counted,
    /// Single effects that move glucose by 5 mg/dL or more, named and no other.
    pub named_from_5: Counted,
    /// Cohorts with one effect in which another is named.
    pub another_named: Counted,
    /// Effects planted into real people's records that are named and were not named in the record as it is.
    pub planted_named: Counted,
    /// Planted cohorts in which another name appears that the record as it is does not get.
    pub planted_another: Counted,
}

/// So many of so many.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counted {
    /// So many.
    pub count: usize,
    /// Of so many.
    pub of: usize,
}

impl TrackRecord {
    /// That of this version.
    ///
    /// # Panics
    /// Never: the file is part of the crate and tested.
    #[must_use]
    pub fn measured() -> Self {
        serde_json::from_str(include_str!("track_record.json"))
            .expect("the crate's own file, tested")
    }

    /// The record in one sentence, for the reader of a diagnosis.
    #[must_use]
    pub fn sentence(&self) -> String {
        let of = |counted: Counted| format!("{} of {}", counted.count, counted.of);
        format!(
            "How much to believe: on made cohorts by hands that its posterior never saw this diagnosis raised an \
             alarm in {} in which nothing was missing (a name in {}), named {} effects of 5 mg/dL or more (and no other), and named \
             another effect in {}; of effects planted into real people's records it newly named {}, with another name in {}.",
            of(self.nulls_with_alarm),
            self.nulls_with_name.count,
            of(self.named_from_5),
            of(self.another_named),
            of(self.planted_named),
            of(self.planted_another),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_record_is_whole_and_counts_no_more_than_there_are() {
        let record = TrackRecord::measured();
        assert!(!record.source.is_empty());
        for counted in [
            record.nulls_with_alarm,
            record.nulls_with_name,
            record.named_from_5,
            record.another_named,
            record.planted_named,
            record.planted_another,
        ] {
            assert!(counted.of > 0 && counted.count <= counted.of, "{counted:?}");
        }
        assert!(record.nulls_with_name.count <= record.nulls_with_alarm.count);
        let alarms = format!("{} of {}", record.nulls_with_alarm.count, record.nulls_with_alarm.of);
        assert!(record.sentence().contains(&alarms));
    }

    #[test]
    fn the_readme_has_the_same_figures() {
        let words: Vec<&str> = include_str!("../../../README.md").split_whitespace().collect();
        let readme = words.join(" ");
        let record = TrackRecord::measured();
        let of = |counted: Counted| format!("{} of {}", counted.count, counted.of);
        for said in [
            format!("a false alarm in {} cohorts", of(record.nulls_with_alarm)),
            format!("names an effect in {};", record.nulls_with_name.count),
            format!("names {} effects that move", of(record.named_from_5)),
            format!("another effect in {} cohorts", of(record.another_named)),
            format!("newly names {} effects", of(record.planted_named)),
            format!("and another in {} changed records", of(record.planted_another)),
        ] {
            assert!(readme.contains(&said), "the README does not say `{said}`");
        }
    }
}
