//! `reconcile` from the command line: a cohort that can be read again, and an account that closes.

use std::path::Path;
use std::process::{Command, Output};

use cohort::read_folder;

fn reconcile(cohort: &Path, out: &Path, more: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_t1d-twins"))
        .args(["reconcile", "-q", "--cohort"])
        .arg(cohort)
        .arg("--out")
        .arg(out)
        .args(more)
        .output()
        .expect("the program starts")
}

#[test]
fn the_account_closes_and_only_carbohydrate_changes() {
    let embedded = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/embedded/cohort");
    let before = read_folder(&embedded).expect("the embedded cohort");
    let parent = tempfile::tempdir().expect("temporary folder");
    for (detector, rule) in [("plant", "published"), ("grid", "published"), ("plant", "additive")] {
        let out = parent.path().join(format!("{detector}-{rule}"));
        let done = reconcile(&embedded, &out, &["--detector", detector, "--rule", rule]);
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        let mut after = read_folder(&out).expect("a cohort folder");
        assert_eq!(crate::outputs::checked(&out), 2, "meals, manifest");
        let text = std::fs::read(out.join("meals.json")).expect("an account");
        let account: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
        assert_eq!(account["schema"], "meals/1");
        assert_eq!((&account["detector"], &account["rule"]), (&detector.into(), &rule.into()));
        let events = account["events"].as_array().expect("a list");
        let counted: u64 = account["fates"]
            .as_object()
            .expect("counts by fate")
            .values()
            .filter_map(serde_json::Value::as_u64)
            .sum();
        assert_eq!(counted, events.len() as u64);
        for (index, (old, new)) in before.people.iter().zip(&mut after.people).enumerate() {
            let sum =
                |person: &cohort::Person| -> f64 { person.record.carbs().iter().flatten().sum() };
            let row = &account["people"][index];
            assert_eq!(row["person_id"], old.id);
            assert_eq!(row["carbs_before_g"].as_f64(), Some(sum(old)));
            let told = row["carbs_after_g"].as_f64().expect("a number");
            assert!((told - sum(new)).abs() < 1e-6, "{told}"); // rounding of a sum
            assert_ne!(old.record.carbs(), new.record.carbs(), "{detector} {rule}");
            let column = new.record.channel_mut(cohort::Channel::Carbs);
            column.copy_from_slice(old.record.carbs());
            assert_eq!(old, new);
        }
    }
}

#[test]
fn a_cohort_is_not_replaced_by_its_reconciled_self() {
    let parent = tempfile::tempdir().expect("temporary folder");
    let cohort = parent.path().join("cohort");
    std::fs::create_dir(&cohort).expect("a folder");
    let people = "person_id,weight_kg,therapy,heart_rate_baseline_bpm\nA,70,aid,60\n";
    std::fs::write(cohort.join("people.csv"), people).expect("writable");
    let records = "person_id,time,cgm_mg_dl,basal_u_h,bolus_u,carbs_g,heart_rate_bpm,steps,\
                   sleep_efficiency\nA,2024-03-08T00:00:00,120,1,0,0,60,0,1\n";
    std::fs::write(cohort.join("records.csv"), records).expect("writable");
    let refused = reconcile(&cohort, &cohort, &[]);
    assert_eq!(refused.status.code(), Some(1));
    let message = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(message.contains("an input of this run"), "{message}");
    // One step is too short for a meal, and no error.
    let done = reconcile(&cohort, &parent.path().join("out"), &[]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}
