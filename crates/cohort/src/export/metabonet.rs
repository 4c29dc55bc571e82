//! `metabonet.parquet` with the columns of MetaboNet: a row has the reading at its time and what
//! was given in the five minutes before, insulin in U, weight in lb.

use std::fs::File;
use std::path::Path;

use physiology::STEPS_PER_HOUR;
use polars::prelude::{
    Column, DataFrame, DataType, IntoColumn, NamedFrom, PolarsError, Series, TimeUnit,
};

use crate::error::CohortError;
use crate::parquet_sink::write_parts;
use crate::person::{Cohort, KG_PER_LB, Person, Therapy};

const FILE: &str = "metabonet.parquet";
const SOURCE: &str = "cohort";

pub(super) fn write(cohort: &Cohort, folder: &Path) -> Result<(), CohortError> {
    if cohort.people.is_empty() {
        return Err(CohortError::empty(FILE));
    }
    let file = File::create(folder.join(FILE)).map_err(CohortError::io(FILE, "written"))?;
    write_parts(file, &cohort.people, frame).map_err(|error| CohortError::not_written(FILE, &error))
}

fn frame(person: &Person) -> Result<DataFrame, PolarsError> {
    let record = &person.record;
    // One row more than steps: the last one has what the last step was given.
    let rows = record.len() + 1;
    let times: Vec<i64> = (0..rows).map(|k| record.time(k).and_utc().timestamp_millis()).collect();
    let number = |name: &str, at: &dyn Fn(usize) -> Option<f64>| -> Column {
        Series::new(name.into(), (0..rows).map(at).collect::<Vec<Option<f64>>>()).into_column()
    };
    let text = |name: &str, text: Option<&str>| -> Column {
        Series::new(name.into(), vec![text; rows]).into_column()
    };
    let before = |channel: &[Option<f64>], k: usize| channel[k.checked_sub(1)?];
    let basal = |k: usize| before(record.basal(), k).map(|u_h| u_h / STEPS_PER_HOUR as f64);
    let bolus = |k: usize| before(record.bolus(), k);
    let differences = person.heart_rate_baseline.is_some_and(|rate| rate.0 == 0.0);
    let modality = match person.therapy {
        Therapy::Mdi => Some("MDI"),
        Therapy::Aid => Some("AID"),
        Therapy::OpenLoopPump => Some("SAP"),
        Therapy::Unknown => None,
    };
    let columns = vec![
        text("id", Some(&person.id)),
        text("source_file", Some(SOURCE)),
        Series::new("date".into(), times)
            .cast(&DataType::Datetime(TimeUnit::Milliseconds, None))?
            .into_column(),
        number("CGM", &|k| record.cgm().get(k).copied().flatten()),
        number("basal", &basal),
        number("bolus", &bolus),
        number("insulin", &|k| Some(basal(k)? + bolus(k)?)),
        number("carbs", &|k| before(record.carbs(), k)),
        number("weight", &|_| person.weight.map(|weight| weight.0 / KG_PER_LB)),
        number("heartrate", &|k| if differences { None } else { before(record.heart_rate(), k) }),
        number("steps", &|k| before(record.steps(), k)),
        text("insulin_delivery_modality", modality),
    ];
    DataFrame::new(rows, columns)
}
