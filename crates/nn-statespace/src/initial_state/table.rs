//! The authors' table of initial states (`initSteadyStates.csv`).

use std::io::Read;

use physiology::MgPerDl;

use crate::error::ModelError;
use crate::import::FILE_ORDER;
use crate::scaler::ScaledStates;

/// The columns of the table after the glucose column: the states in [`FILE_ORDER`], scaled.
const COLUMNS: &str =
    "output_cgm,state_Q2,state_S1,state_S2,state_I,state_X1,state_X2,state_X3,state_Ug,state_Ug2";
const GLUCOSE_COLUMN: &str = "initCGM";

/// Initial states by glucose, in the scaled units of the model they were computed for.
///
/// The authors' rows are 1 mg/dL apart from 40 to 400. They are not steady states: C1 is 1.36 in
/// every row, which adds about 6 g of carbohydrate to a run. Use them only to reproduce.
#[derive(Debug, Clone, PartialEq)]
pub struct InitialStateTable {
    /// Ascending by glucose, mg/dL; at least one.
    rows: Vec<(f64, ScaledStates)>,
}

impl InitialStateTable {
    /// Reads a table with the columns `initCGM,output_cgm,state_Q2,state_S1,state_S2,state_I,
    /// state_X1,state_X2,state_X3,state_Ug,state_Ug2`, in any order.
    ///
    /// # Errors
    /// [`ModelError::InitialTable`] with the line, counted from 1, and the column at fault.
    pub fn read(mut reader: impl Read) -> Result<Self, ModelError> {
        let bad = |line: usize, column: &str, problem: String| ModelError::InitialTable {
            line,
            column: column.to_owned(),
            problem,
        };
        let mut text = String::new();
        reader.read_to_string(&mut text).map_err(|error| bad(1, "", error.to_string()))?;
        let mut lines = text.lines().enumerate();
        let header: Vec<&str> = lines
            .next()
            .map(|(_, line)| line.split(',').map(str::trim).collect())
            .unwrap_or_default();
        let place = |name: &str| {
            header
                .iter()
                .position(|column| *column == name)
                .ok_or_else(|| bad(1, name, "no such column".to_owned()))
        };
        let glucose_place = place(GLUCOSE_COLUMN)?;
        let mut places = Vec::new();
        for (name, compartment) in COLUMNS.split(',').zip(FILE_ORDER) {
            places.push((place(name)?, name, compartment));
        }
        let mut rows: Vec<(f64, ScaledStates)> = Vec::new();
        for (index, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
            let line_number = index + 1;
            let fields: Vec<&str> = line.split(',').map(str::trim).collect();
            let number = |place: usize, name: &str| -> Result<f64, ModelError> {
                let field = fields
                    .get(place)
                    .ok_or_else(|| bad(line_number, name, "the line ends early".to_owned()))?;
                match field.parse::<f64>() {
                    Ok(value) if value.is_finite() => Ok(value),
                    _ => Err(bad(line_number, name, format!("'{field}' is not a finite number"))),
                }
            };
            let glucose = number(glucose_place, GLUCOSE_COLUMN)?;
            if rows.last().is_some_and(|(previous, _)| *previous >= glucose) {
                let problem = format!("{glucose} does not follow the row before it");
                return Err(bad(line_number, GLUCOSE_COLUMN, problem));
            }
            let mut states = ScaledStates::default();
            for (place, name, compartment) in &places {
                states[*compartment] = number(*place, name)?;
            }
            rows.push((glucose, states));
        }
        if rows.is_empty() {
            return Err(bad(2, GLUCOSE_COLUMN, "no rows".to_owned()));
        }
        Ok(Self { rows })
    }

    /// The row for a glucose value: the nearest one, the lower of two equally near.
    ///
    /// # Errors
    /// [`ModelError::GlucoseOutsideTable`] if the value lies more than half a mg/dL outside the
    /// table or is not a number.
    pub fn row(&self, glucose: MgPerDl) -> Result<ScaledStates, ModelError> {
        let lowest = MgPerDl(self.rows[0].0);
        let highest = MgPerDl(self.rows[self.rows.len() - 1].0);
        if !(lowest.0 - 0.5..=highest.0 + 0.5).contains(&glucose.0) {
            return Err(ModelError::GlucoseOutsideTable { glucose, lowest, highest });
        }
        let distance = |row: &&(f64, ScaledStates)| (row.0 - glucose.0).abs();
        let nearest = self.rows.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        Ok(nearest.expect("a table without rows is refused when read").1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use physiology::Compartment;

    const HEADER: &str = "initCGM,output_cgm,state_Q2,state_S1,state_S2,state_I,state_X1,state_X2,\
                          state_X3,state_Ug,state_Ug2";

    fn table(rows: &str) -> Result<InitialStateTable, ModelError> {
        InitialStateTable::read(format!("{HEADER}\n{rows}").as_bytes())
    }

    #[test]
    fn columns_reach_their_compartments_and_the_nearest_row_is_taken() {
        let table = table("100,0,1,2,3,4,5,6,7,8,9\n101,10,11,12,13,14,15,16,17,18,19\n");
        let table = table.expect("well formed");
        let row = table.row(MgPerDl(100.4)).expect("within");
        for (compartment, expected) in FILE_ORDER.into_iter().zip(0..10) {
            assert_eq!(row[compartment], f64::from(expected), "{compartment}");
        }
        assert_eq!(table.row(MgPerDl(101.5)).expect("rounds to 101")[Compartment::Q1], 10.0);
    }

    #[test]
    fn glucose_outside_the_table_is_refused() {
        let table = table("40,0,1,2,3,4,5,6,7,8,9\n41,0,1,2,3,4,5,6,7,8,9\n").expect("well formed");
        for glucose in [39.4, 41.6, f64::NAN] {
            let error = table.row(MgPerDl(glucose)).expect_err("outside").to_string();
            assert!(error.contains("40 mg/dL to 41 mg/dL"), "{error}");
        }
    }

    #[test]
    fn faults_are_named_with_line_and_column() {
        let cases = [
            ("40,0,1,2,x,4,5,6,7,8,9\n", "line 2, column state_S2"),
            ("40,0,1,2,3,4,5,6,7,8\n", "line 2, column state_Ug2"),
            ("40,0,1,2,3,4,NaN,6,7,8,9\n", "line 2, column state_X1"),
            ("41,0,1,2,3,4,5,6,7,8,9\n40,0,1,2,3,4,5,6,7,8,9\n", "line 3, column initCGM"),
            ("", "line 2, column initCGM"),
        ];
        for (rows, place) in cases {
            let error = table(rows).expect_err(place).to_string();
            assert!(error.contains(place), "{error}");
        }
        let error = InitialStateTable::read("initCGM,state_Q2\n".as_bytes()).expect_err("columns");
        assert!(error.to_string().contains("output_cgm"), "{error}");
    }
}
