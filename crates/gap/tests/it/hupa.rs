//! Open data: the eight people of HUPA-UCM.

use cohort::{ImportFormat, import};
use gap::{Diagnoser, DiagnosisConfig, LocalisationRule};

#[test]
fn the_diagnosis_of_eight_real_people_is_finite_and_complete() {
    let Some(folder) = reference_data::find("hupa_ucm", "diagnosis of HUPA-UCM") else { return };
    let cohort = import(ImportFormat::HupaUcm, &folder).expect("imports").cohort;
    let working = DiagnosisConfig::working();
    let config = DiagnosisConfig {
        localisation: LocalisationRule { replicates: 1000, ..working.localisation },
        ..working
    };
    let diagnosis =
        Diagnoser::new(&effects::library(), &config).run(&cohort, 1).expect("diagnosed");
    assert_eq!(diagnosis.people.len(), cohort.people.len());
    let included = diagnosis.people.iter().filter(|p| p.excluded.is_none()).count();
    // Of the eight, one logs no carbohydrate and one has CGM that is almost all drawn lines.
    assert!(included >= 5, "most people have insulin, carbohydrate and CGM: {included}");
    for person in &diagnosis.people {
        assert_eq!(person.excluded.is_some(), person.calibration.is_none(), "{}", person.person_id);
    }
    assert_eq!(diagnosis.baseline.len(), 3);
    for horizon in &diagnosis.baseline {
        for number in [horizon.mae, horizon.rmse, horizon.bias] {
            assert!(number.value.is_finite() && number.lower <= number.upper, "{horizon:?}");
        }
        // Worse than a broken clock it must not be: CGM readings have an SD of about 60 mg/dL.
        assert!((3.0..90.0).contains(&horizon.mae.value), "{horizon:?}");
    }
    for cell in &diagnosis.cells {
        for number in [cell.mean_error_mg_dl, cell.lower, cell.upper, cell.share_of_gap] {
            assert!(number.is_finite(), "{cell:?}");
        }
        assert!((0.0..=1.0).contains(&cell.p_adjusted), "{cell:?}");
        assert!(cell.lower <= cell.mean_error_mg_dl && cell.mean_error_mg_dl <= cell.upper);
    }
    // Heart rate, steps and meals are on record, sleep and set changes are not.
    let has = |level: &str| diagnosis.cells.iter().any(|c| c.level == level);
    for level in ["03-06", "after_meal", "exercise", "after_exercise", ">180", "weekend", "1440"] {
        assert!(has(level), "{level}");
    }
    assert!(!has("sleep") && !has("set_day_3_plus"));
}
