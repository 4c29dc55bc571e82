//! The CSV that LibreView exports, and the one of FreeStyle Libre's older program.
//!
//! One line about the export stands above the header. Times are the device's own clock, day or
//! month first as the account's country has it; glucose is in mg/dL or mmol/L as the column's name
//! says. The record takes the historic readings (record type 0); scans (type 1) are the same
//! sensor's readings before smoothing, and finger-sticks (type 2) are none of a sensor. Both are
//! counted and left out. The person is named after the file.
//!
//! The header is in the language of the account. The names are those that public readers and writers
//! of these files know (German: `Glukosewert-Verlauf`; Spanish: HUPA-UCM and `cgmpy`; French, Dutch,
//! Italian). In a language that is not among them, `--from table` with a map reads the file.

use std::path::PathBuf;

use super::table::plan::Plan;
use super::table::{Role, TableOptions, read};
use crate::error::CohortError;

const FORMAT: &str = "libre";
const TIME: &str = "Device Timestamp";
const MG_PER_DL: &str = "Historic Glucose mg/dL";
const MMOL_PER_L: &str = "Historic Glucose mmol/L";
const RAPID: &str = "Rapid-Acting Insulin (units)";
const LONG: &str = "Long-Acting Insulin (units)";
const GRAMS: &str = "Carbohydrates (grams)";
const SERVINGS: &str = "Carbohydrates (servings)";
const MEAL: &str = "Meal Insulin (units)";
const CORRECTION: &str = "Correction Insulin (units)";
const CHANGE: &str = "User Change Insulin (units)";
const SCAN: &str = "Scan Glucose mg/dL";
const SCAN_MMOL: &str = "Scan Glucose mmol/L";
const STRIP: &str = "Strip Glucose mg/dL";
const STRIP_MMOL: &str = "Strip Glucose mmol/L";
const SOME_RAPID: &str = "Non-numeric Rapid-Acting Insulin";
const SOME_LONG: &str = "Non-numeric Long-Acting Insulin";
const SOME_FOOD: &str = "Non-numeric Food";

const COLUMNS: [(Role, &str); 6] = [
    (Role::Time, TIME),
    (Role::Glucose, MG_PER_DL),
    (Role::Glucose, MMOL_PER_L),
    (Role::Bolus, RAPID),
    (Role::LongActing, LONG),
    (Role::Carbs, GRAMS),
];
/// What the calculator proposed and the user changed: the dose where no other is written.
const CALCULATED: [&str; 3] = [MEAL, CORRECTION, CHANGE];
/// Names in other languages and of older exports, as the file writes them; case and marks do not
/// count.
const NAMES: [(&str, &str); 68] = [
    ("Meter Timestamp", TIME),
    ("Time", TIME),
    // German.
    ("Gerätezeitstempel", TIME),
    ("Glukosewert-Verlauf mg/dL", MG_PER_DL),
    ("Glukosewert-Verlauf mmol/L", MMOL_PER_L),
    ("Schnellwirkendes Insulin (Einheiten)", RAPID),
    ("Depotinsulin (Einheiten)", LONG),
    ("Kohlenhydrate (Gramm)", GRAMS),
    ("Kohlenhydrate (Portionen)", SERVINGS),
    ("Mahlzeiteninsulin (Einheiten)", MEAL),
    ("Korrekturinsulin (Einheiten)", CORRECTION),
    ("Insulin-Änderung durch Anwender (Einheiten)", CHANGE),
    ("Glukose-Scan mg/dL", SCAN),
    ("Glukose-Scan mmol/L", SCAN_MMOL),
    ("Glukose-Teststreifen mg/dL", STRIP),
    ("Glukose-Teststreifen mmol/L", STRIP_MMOL),
    ("Nicht numerisches schnellwirkendes Insulin", SOME_RAPID),
    ("Nicht numerisches Depotinsulin", SOME_LONG),
    ("Nicht numerische Nahrungsdaten", SOME_FOOD),
    // Spanish.
    ("Sello de tiempo del dispositivo", TIME),
    ("Marca de hora del dispositivo", TIME),
    ("Hora", TIME),
    ("Historial de glucosa mg/dL", MG_PER_DL),
    ("Historial de glucosa mmol/L", MMOL_PER_L),
    ("Insulina de acción rápida (unidades)", RAPID),
    ("Insulina de acción larga (unidades)", LONG),
    ("Carbohidratos (gramos)", GRAMS),
    ("Carbohidratos (raciones)", SERVINGS),
    ("Escaneo de glucosa mg/dL", SCAN),
    ("Escanear glucosa mg/dL", SCAN),
    ("Tira reactiva para glucosa mg/dL", STRIP),
    ("Insulina de acción rápida no numérica", SOME_RAPID),
    ("Insulina de acción rápida sin valor numérico", SOME_RAPID),
    ("Alimentos sin valor numérico", SOME_FOOD),
    // French.
    ("Horodatage de l'appareil", TIME),
    ("Historique de la glycémie mg/dL", MG_PER_DL),
    ("Historique de la glycémie mmol/L", MMOL_PER_L),
    ("Insuline à action rapide (unités)", RAPID),
    ("Insuline à action longue (unités)", LONG),
    ("Insuline à action lente (unités)", LONG),
    ("Glucides (grammes)", GRAMS),
    ("Glucides (portions)", SERVINGS),
    ("Insuline repas (unités)", MEAL),
    ("Correction insuline (unités)", CORRECTION),
    ("Insuline modifiée par l'utilisateur (unités)", CHANGE),
    ("Numérisation de la glycémie mg/dL", SCAN),
    ("Numérisation de la glycémie mmol/L", SCAN_MMOL),
    ("Glycémie par bandelette mg/dL", STRIP),
    ("Alimentation sans valeur numérique", SOME_FOOD),
    // Dutch.
    ("Tijdstempel apparaat", TIME),
    ("Tijdstempel meter", TIME),
    ("Historische glucose mg/dL", MG_PER_DL),
    ("Historische glucose mmol/L", MMOL_PER_L),
    ("Snelwerkende insuline (eenheden)", RAPID),
    ("Langwerkende insuline (eenheden)", LONG),
    ("Koolhydraten (gram)", GRAMS),
    ("Koolhydraten (porties)", SERVINGS),
    ("Maaltijdinsuline (eenheden)", MEAL),
    ("Correctie insuline (eenheden)", CORRECTION),
    ("Wijzigen insuline gebruiker (eenheden)", CHANGE),
    ("Niet-numerieke snelwerkende insuline", SOME_RAPID),
    ("Niet-numerieke langwerkende insuline", SOME_LONG),
    ("Niet-numeriek voedsel", SOME_FOOD),
    // Italian.
    ("Timestamp del dispositivo", TIME),
    ("Storico del glucosio mg/dL", MG_PER_DL),
    ("Insulina ad azione rapida (unità)", RAPID),
    ("Insulina ad effetto prolungato (unità)", LONG),
    ("Carboidrati (grammi)", GRAMS),
];
const COUNTED: [(&str, &str); 8] = [
    (SCAN, "scans: left out, the historic readings are the sensor's record"),
    (SCAN_MMOL, "scans: left out, the historic readings are the sensor's record"),
    (STRIP, "finger-stick readings: left out, they are none of the sensor"),
    (STRIP_MMOL, "finger-stick readings: left out, they are none of the sensor"),
    (SOME_RAPID, "fast-acting insulin without an amount: left out"),
    (SOME_LONG, "long-acting insulin without an amount: left out"),
    (SOME_FOOD, "meals without an amount: left out"),
    (SERVINGS, "carbohydrate in servings: counts where --unit says what one holds (carbs=10 g)"),
];

/// Reads exports, one or more a person.
pub(super) fn import(
    sources: &[PathBuf],
    options: &TableOptions,
) -> Result<super::Import, CohortError> {
    let mut options = options.clone();
    options.refuse_columns(FORMAT)?;
    options.columns = COLUMNS.map(|(role, column)| (role, column.to_owned())).to_vec();
    if options.unit(Role::Carbs).is_some_and(|unit| unit.trim() != "g") {
        // Servings are then what is logged; the column of grams would be multiplied too.
        options.columns.retain(|(role, _)| *role != Role::Carbs);
        options.columns.push((Role::Carbs, SERVINGS.into()));
    }
    let plan = Plan {
        format: FORMAT,
        options,
        bolus_parts: &CALCULATED,
        names: &NAMES,
        counted: &COUNTED,
        ..Plan::default()
    };
    read(sources, &plan)
}
