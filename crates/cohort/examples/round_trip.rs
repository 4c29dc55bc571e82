//! Writes a small made-up cohort as a folder, reads it back and prints its mass balance:
//! `cargo run -p cohort --example round_trip`.

use cohort::{
    Channel, Cohort, MissingDoses, Person, Record, RecordsFormat, Therapy, WindowRule, findings,
    mass_balance, read_folder, split_by_time, windows, write_folder,
};
use physiology::Kilograms;

#[expect(clippy::print_stdout, reason = "an example shows its result")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut record = Record::new("2024-03-04T00:00:00".parse()?, 16 * 288)?;
    for k in 0..record.len() {
        let meal = matches!(k % 288, 96 | 150 | 228);
        record.channel_mut(Channel::Cgm)[k] = Some(140.0 + 30.0 * (k as f64 / 40.0).sin().round());
        record.channel_mut(Channel::Basal)[k] = Some(0.8);
        record.channel_mut(Channel::Bolus)[k] = Some(if meal { 5.5 } else { 0.0 });
        record.channel_mut(Channel::Carbs)[k] = Some(if meal { 55.0 } else { 0.0 });
    }
    let person = Person {
        id: "made-up-1".into(),
        weight: Some(Kilograms(70.0)),
        therapy: Therapy::OpenLoopPump,
        heart_rate_baseline: None,
        record,
    };
    let folder = std::env::temp_dir().join(format!("cohort-example-{}", std::process::id()));
    write_folder(&Cohort { people: vec![person] }, &folder, RecordsFormat::Csv)?;
    let cohort = read_folder(&folder)?;
    std::fs::remove_dir_all(&folder)?;

    let person = &cohort.people[0];
    println!("{}", mass_balance(person));
    println!("{} implausible figures", findings(person).len());
    let split = split_by_time(&person.record, cohort::TRAINING_DAYS);
    let train = windows(0, &person.record, split.train, &WindowRule::TRAINING)?;
    let test = windows(0, &person.record, split.test, &WindowRule::EVALUATION)?;
    println!("{} training windows of 5 h, {} to judge by", train.len(), test.len());
    let inputs = person.inputs(test[0].range(), MissingDoses::Error)?;
    println!("first held-out insulin rate: {:.1}", inputs[0].insulin());
    Ok(())
}
