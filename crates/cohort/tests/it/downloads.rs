//! The exports that people download, as `fixtures/downloads/make.py` makes them up.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use cohort::{
    Channel, CohortError, DateOrder, Import, ImportFormat, RecordsFormat, Role, TableOptions,
    Therapy, guess_table, import_with, read_folder, write_folder,
};

fn exports() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/downloads")
}

fn spreadsheet_options() -> TableOptions {
    let mut options = TableOptions::default();
    let map =
        "person=Código,time=Fecha y hora,glucose=Glucosa,basal=Basal (U),bolus=Bolo,carbs=Hidratos";
    options.add_map(map).expect("a map");
    options.add_unit("glucose=mmol/L,basal=U/5min").expect("units");
    options
}

fn channel_options() -> TableOptions {
    let toml = fs::read_to_string(exports().join("channels/map.toml")).expect("a fixture");
    TableOptions::from_toml(&toml, "map.toml").expect("a map")
}

/// Reads an export; what is read can be written, read again, and its sums close.
fn read(format: ImportFormat, name: &str, options: &TableOptions) -> Import {
    let path = exports().join(name);
    let import = import_with(format, &[path], options).unwrap_or_else(|e| panic!("{name}: {e}"));
    for totals in import.report.people.iter().flat_map(|person| person.totals.iter().flatten()) {
        assert!(totals.closes(), "{name}: {totals:?}");
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    for format in [RecordsFormat::Csv, RecordsFormat::Parquet] {
        let folder = folder.path().join(format!("{format:?}"));
        write_folder(&import.cohort, &folder, format).expect("writable");
        assert!(read_folder(&folder).expect("readable") == import.cohort, "{name}");
    }
    import
}

fn notes(import: &Import) -> Vec<String> {
    import.report.notes.iter().map(ToString::to_string).collect()
}

fn has(lines: &[String], says: &str) {
    assert!(lines.iter().any(|line| line.contains(says)), "{says}\nis not in {lines:#?}");
}

#[test]
fn each_export_gives_the_figures_of_the_events_that_it_was_made_of() {
    let text = fs::read_to_string(exports().join("expected.json")).expect("a fixture");
    let expected: BTreeMap<String, Vec<String>> = serde_json::from_str(&text).expect("JSON");
    assert_eq!(expected.len(), 6);
    for (name, lines) in expected {
        let none = TableOptions::default();
        let import = match name.split('/').next().expect("a name") {
            "dexcom" => read(ImportFormat::Dexcom, &name, &none),
            "libre" => read(ImportFormat::Libre, &name, &none),
            "channels" => read(ImportFormat::Table, &name, &channel_options()),
            _ => read(ImportFormat::Table, &name, &spreadsheet_options()),
        };
        let found: Vec<&str> = import.report.lines().collect();
        assert_eq!(found, lines, "{name}");
    }
}

#[test]
fn dexcom_leaves_out_what_is_no_reading_and_says_so() {
    let import = read(ImportFormat::Dexcom, "dexcom/clarity_mg_dl.csv", &TableOptions::default());
    let person = &import.cohort.people[0];
    assert_eq!(person.therapy, Therapy::Mdi);
    assert!(person.record.basal().iter().all(Option::is_none));
    // Floored: the sensor reads at 00:02:41.
    assert_eq!(person.record.start().to_string(), "2024-03-01 00:00:00");
    assert_eq!((person.record.cgm()[300], person.record.cgm()[301]), (Some(40.0), Some(400.0)));
    // The alert's threshold of 250 is no reading.
    assert!(person.record.cgm().iter().flatten().filter(|value| **value == 250.0).count() == 0);
    let basal = &import.report.people[0].totals.iter().flatten().find(|t| t.column == "basal_u_h");
    assert_eq!(basal.map(|t| (t.source, t.record, t.left_out)), Some((54.0, 0.0, 54.0)));
    has(&notes(&import), "beyond the sensor's range: kept as 40 and 400 mg/dL (2x)");
    has(&notes(&import), "long-acting injections, which no basal rate describes: left out (3x)");
    let json = serde_json::to_string(&import.report).expect("JSON");
    assert!(!json.contains("Nobody"), "no name is carried over");
}

#[test]
fn libre_takes_historic_readings_and_the_parts_of_a_calculated_dose() {
    let import = read(ImportFormat::Libre, "libre/libreview_mmol_l.csv", &TableOptions::default());
    let record = &import.cohort.people[0].record;
    assert_eq!(record.start().to_string(), "2024-05-30 00:05:00");
    // 20:47 of the first day: 6.0 U for the meal and 0.5 U of correction.
    let step = record.step_at("2024-05-30T20:45:00".parse().expect("a time")).expect("inside");
    assert_eq!(record.bolus()[step], Some(6.5));
    let notes = notes(&import);
    has(&notes, "scans: left out");
    has(&notes, "finger-stick readings: left out");
    has(&notes, "meals without an amount: left out (1x)");
    let inferences: Vec<String> =
        import.report.inferences.iter().flatten().map(ToString::to_string).collect();
    has(&inferences, "dates are day-first");
    has(&inferences, "header in line 2");
    has(&inferences, "glucose in mmol/L; median 7.");
    let american = read(ImportFormat::Libre, "libre/libreview_mg_dl.csv", &TableOptions::default());
    assert_eq!(american.cohort.people[0].record.start(), record.start());
    assert!(!serde_json::to_string(&import.report).expect("JSON").contains("Nobody"));
}

/// The first reading, bolus and carbohydrate of a text, and what is noted.
fn first_values(
    format: ImportFormat,
    text: &str,
) -> (Option<f64>, Option<f64>, Option<f64>, Vec<String>) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("p1.csv");
    fs::write(&path, text).expect("writable");
    let options = TableOptions { dates: Some(DateOrder::DayFirst), ..Default::default() };
    let import = import_with(format, &[path], &options).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let record = &import.cohort.people[0].record;
    (record.cgm()[0], record.bolus()[0], record.carbs()[0], notes(&import))
}

#[test]
fn libre_is_read_in_the_languages_of_its_accounts() {
    // As public readers and writers of these files have them.
    let german = "Glukose-Werte,Erstellt am,25-02-2021 17:28 UTC,Erstellt von,x\n\nGerät,Seriennummer,\
        Gerätezeitstempel,Aufzeichnungstyp,Glukosewert-Verlauf mg/dL,Glukose-Scan mg/dL,\
        Schnellwirkendes Insulin (Einheiten),Kohlenhydrate (Gramm),Depotinsulin (Einheiten)\n";
    let dutch = "Glucosegegevens,Gegenereerd op,x UTC,Gegenereerd door,x\nApparaat,Serienummer,\
        Tijdstempel apparaat,Gegevenstype,Historische glucose mmol/l,Scan Glucose mmol/l,\
        Snelwerkende insuline (eenheden),Koolhydraten (gram),Langwerkende insuline (eenheden)\n";
    let french = "Glucose,Généré le,x UTC,Généré par,x\nAppareil,Numéro de série,\
        Horodatage de l'appareil,Type d'enregistrement,Historique de la glycémie mg/dL,\
        Numérisation de la glycémie mg/dL,Insuline à action rapide (unités),Glucides (grammes),\
        Insuline à action longue (unités)\n";
    let spanish = "Informe,Generado el,x UTC,Generado por,x\nDispositivo,Número de serie,\
        Sello de tiempo del dispositivo,Tipo de registro,Historial de glucosa mg/dL,\
        Escaneo de glucosa mg/dL,Insulina de acción rápida (unidades),Carbohidratos (gramos),\
        Insulina de acción larga (unidades)\n";
    let italian = "Dati,Generato il,x UTC,Generato da,x\nDispositivo,Numero di serie,\
        Timestamp del dispositivo,Tipo,Storico del glucosio mg/dL,Scan,\
        Insulina ad azione rapida (unità),Carboidrati (grammi),\
        Insulina ad effetto prolungato (unità)\n";
    let older = "x\nID,Serial,Time,Record Type,Historic Glucose(mg/dL),Scan Glucose(mg/dL),\
        Rapid-Acting Insulin (units),Carbohydrates (grams),Long-Acting Insulin (units)\n";
    for header in [german, dutch, french, spanish, italian, older] {
        let (reading, scan) = if header == dutch { ("5.0", "6.0") } else { ("90", "108") };
        let row = |kind, cells: String| format!("Libre,1,18-02-2021 10:55,{kind},{cells}\n");
        let text = [
            header.to_owned(),
            row(0, format!("{reading},,,,")),
            row(1, format!(",{scan},,,")),
            row(4, ",,4.5,,".into()),
            row(5, ",,,30,".into()),
            row(4, ",,,,12".into()),
        ]
        .concat();
        let (glucose, bolus, carbs, notes) = first_values(ImportFormat::Libre, &text);
        assert_eq!((glucose, bolus, carbs), (Some(90.0), Some(4.5), Some(30.0)), "{text}");
        has(&notes, "long-acting injections");
        if header != italian {
            has(&notes, "scans: left out");
        }
    }
}

#[test]
fn dexcom_is_read_in_the_languages_of_its_accounts() {
    let german = "Index;Zeitstempel (JJJJ-MM-TTThh:mm:ss);Ereignistyp;Ereignisuntertyp;\
        Glukosewert (mmol/l);Insulinwert (IE);Kohlenhydratwert (Gramm)\n\
        1;;Vorname;;;;\n\
        2;2026-06-02T00:00:00;EGW;;5,0;;\n3;2026-06-02T00:05:00;EGW;;Niedrig;;\n\
        4;2026-06-02T00:10:00;EGW;;Hoch;;\n5;2026-06-02T00:00:00;Kohlenhydrate;;;;30\n\
        6;2026-06-02T00:00:00;Insulin;Fast-Acting;;4,5;\n\
        7;2026-06-02T00:00:00;Insulin;unbekannt;;3,5;\n";
    let spanish = "Índice;Marca temporal (AAAA-MM-DDThh:mm:ss);Tipo de evento;Subtipo de evento;\
        Nivel de glucosa (mg/dl);Nivel de insulina (u);Nivel de carbohidratos (gramos)\n\
        1;;Nombre;;;;\n\
        2;2020-06-02T00:00:00;Niveles estimados de glucosa;;90;;\n\
        3;2020-06-02T00:05:00;Niveles estimados de glucosa;;Bajo;;\n\
        4;2020-06-02T00:10:00;Niveles estimados de glucosa;;Alto;;\n\
        5;2020-06-02T00:00:00;Carbohidratos;;;;30\n\
        6;2020-06-02T00:00:00;Insulina;Fast-Acting;;4.5;\n\
        7;2020-06-02T00:00:00;Insulina;desconocida;;3.5;\n\
        8;2020-06-02T00:00:00;Alerta;;55;;\n";
    for text in [german, spanish] {
        let (glucose, bolus, carbs, notes) = first_values(ImportFormat::Dexcom, text);
        assert_eq!((glucose, bolus, carbs), (Some(90.0), Some(4.5), Some(30.0)), "{text}");
        has(&notes, "beyond the sensor's range: kept as 40 and 400 mg/dL (2x)");
        has(&notes, "doses of a kind that is not known: left out (1x)");
    }
}

#[test]
fn a_spreadsheet_is_found_out_and_the_guess_maps_it() {
    let path = exports().join("spreadsheet.csv");
    let import = read(ImportFormat::Table, "spreadsheet.csv", &spreadsheet_options());
    let inferences: Vec<String> =
        import.report.inferences.iter().flatten().map(ToString::to_string).collect();
    has(&inferences, "Windows-1252 (not UTF-8), columns between semicolons, header in line 3");
    has(&inferences, "numbers with a decimal comma");
    has(&inferences, "dates are day-first");
    let (_, second) = import.cohort.find("P-02").expect("there");
    assert_eq!(second.record.start().to_string(), "2024-02-11 00:00:00");
    let guess = guess_table(&[path], None).expect("a table");
    assert_eq!(
        guess.map,
        "person=Código,time=Fecha y hora,glucose=Glucosa,basal=Basal (U),bolus=Bolo,carbs=Hidratos"
    );
    assert_eq!((guess.units.as_str(), guess.missing.len()), ("glucose=mmol/L", 0));
    let channels = guess_table(&[exports().join("channels")], None).expect("tables");
    assert_eq!(channels.missing, [Role::Glucose], "no name says what 'value' is");
}

#[test]
fn a_workbook_is_read_as_the_table_that_it_was_made_of() {
    let told = read(ImportFormat::Table, "spreadsheet.csv", &spreadsheet_options());
    let first = read(ImportFormat::Table, "spreadsheet.xlsx", &spreadsheet_options());
    assert_eq!(first.cohort, told.cohort);
    let inferences: Vec<String> =
        first.report.inferences.iter().flatten().map(ToString::to_string).collect();
    has(&inferences, "Excel workbook, sheet 'Datos', of 2 sheets, header in line 3");
    let mut options = TableOptions { sheet: Some("Fecha aparte".into()), ..Default::default() };
    let map = "person=Código,date=Día,clock=Hora,glucose=Glucosa,basal=Basal (U),bolus=Bolo,carbs=Hidratos";
    options.add_map(map).expect("a map");
    options.add_unit("glucose=mmol/L,basal=U/5min").expect("units");
    let second = read(ImportFormat::Table, "spreadsheet.xlsx", &options);
    assert_eq!(second.cohort, told.cohort);

    let path = exports().join("spreadsheet.xlsx");
    let guess = guess_table(std::slice::from_ref(&path), None).expect("a table");
    assert_eq!((guess.units.as_str(), guess.missing.len()), ("glucose=mmol/L", 0));
    let refused = |sheet: &str, path: PathBuf, options: TableOptions| {
        let options = TableOptions { sheet: Some(sheet.into()), ..options };
        import_with(ImportFormat::Table, &[path], &options).map(|_| ()).expect_err("refused")
    };
    let message = refused("Otra", path, spreadsheet_options()).to_string();
    assert_eq!(message, "--sheet: spreadsheet.xlsx has the sheets Datos, Fecha aparte");
    let message = refused("Datos", exports().join("spreadsheet.csv"), spreadsheet_options());
    assert!(message.to_string().contains("spreadsheet.csv is no Excel workbook"), "{message}");
    // A cell that is no number is named by its row in the sheet.
    let mut options = spreadsheet_options();
    options.columns.retain(|(role, _)| *role != Role::Carbs);
    options.add_map("carbs=Código").expect("a map");
    options.columns.retain(|(role, _)| *role != Role::Person);
    let path = exports().join("spreadsheet.xlsx");
    let error = import_with(ImportFormat::Table, &[path], &options).expect_err("text").to_string();
    assert!(error.contains("spreadsheet.xlsx, row 4, column Código: 'P-01' is not"), "{error}");
}

#[test]
fn channels_in_utc_land_on_the_wall_clock_across_the_change() {
    let import = read(ImportFormat::Table, "channels", &channel_options());
    let record = &import.cohort.people[0].record;
    assert_eq!(record.start().to_string(), "2024-10-26 02:00:00");
    // 48 hours of UTC are 47 on a clock that is set back.
    assert_eq!(record.len(), 47 * 12);
    let lunch = record.step_at("2024-10-26T15:30:00".parse().expect("a time")).expect("inside");
    assert_eq!(record.bolus()[lunch], Some(7.0));
    let winter = record.step_at("2024-10-27T14:30:00".parse().expect("a time")).expect("inside");
    assert_eq!(record.bolus()[winter], Some(7.0));
    let notes = notes(&import);
    has(&notes, "readings in the hour that came again: left out (12x)");
    has(&notes, "bolus in a row that stands twice: the second one is left out (1x)");
    let bolus = import.report.people[0].totals.iter().flatten().find(|t| t.column == "bolus_u");
    assert_eq!(bolus.map(|t| (t.source, t.left_out)), Some((43.0, 7.0)));
    // Without a zone the person's clock is not known.
    let mut nowhere = channel_options();
    nowhere.zone = None;
    let error = import_with(ImportFormat::Table, &[exports().join("channels")], &nowhere)
        .expect_err("no wall clock");
    assert!(matches!(error, CohortError::Undecided { .. }), "{error}");
    assert!(error.to_string().contains("--zone Europe/Madrid"), "{error}");
}

#[test]
fn a_record_written_as_a_table_is_read_back() {
    let cohort = read_folder(&exports().join("../embedded/cohort")).expect("a fixture");
    let folder = tempfile::tempdir().expect("a temporary folder");
    // Each person in a file, mmol/L with a decimal comma, month first with AM and PM.
    for person in cohort.people.iter().take(2) {
        let record = &person.record;
        let comma = |value: f64| format!("{value:?}").replace('.', ",");
        let mut text = String::from("When|Sugar|Rate|Dose|Food|Pulse|Walked\n");
        for k in 0..record.len() {
            let mut cells = vec![record.time(k).format("%m/%d/%Y %I:%M %p").to_string()];
            cells.push(record.cgm()[k].map_or_else(String::new, |v| comma(v / 18.0)));
            for channel in
                [Channel::Basal, Channel::Bolus, Channel::Carbs, Channel::HeartRate, Channel::Steps]
            {
                cells.push(record.channel(channel)[k].map_or_else(String::new, comma));
            }
            text += &(cells.join("|") + "\n");
        }
        fs::write(folder.path().join(format!("{}.csv", person.id)), text).expect("writable");
    }
    let mut options = TableOptions::default();
    options
        .add_map("time=When,glucose=Sugar,basal=Rate,bolus=Dose,carbs=Food,heart_rate=Pulse,steps=Walked")
        .expect("a map");
    options.add_unit("glucose=mmol/L").expect("a unit");
    let import =
        import_with(ImportFormat::Table, &[folder.path().to_owned()], &options).expect("readable");
    for (found, person) in import.cohort.people.iter().zip(&cohort.people) {
        assert_eq!(found.id, person.id);
        let start = found.record.start();
        let first = person.record.step_at(start).expect("on the grid");
        for channel in [Channel::Cgm, Channel::Bolus, Channel::Carbs, Channel::HeartRate] {
            for k in 0..found.record.len() {
                let (a, b) =
                    (found.record.channel(channel)[k], person.record.channel(channel)[first + k]);
                let near = match (a, b) {
                    // Rounding of a division and a product.
                    (Some(a), Some(b)) => (a - b).abs() < 1e-9,
                    // A pump that is recorded gave no bolus.
                    (Some(a), None) => a == 0.0 && channel == Channel::Bolus,
                    (None, None) => true,
                    (None, Some(_)) => channel == Channel::HeartRate && b == Some(0.0),
                };
                assert!(near, "{}, {channel:?}, step {k}: {a:?} and {b:?}", person.id);
            }
        }
    }
}
