use gap::{Diagnoser, DiagnosisConfig};
fn main() {
    let folder = std::env::args_os().nth(1).expect("folder");
    let cohort = cohort::read_folder(folder.as_ref()).expect("cohort");
    let d = Diagnoser::new(&effects::library(), &DiagnosisConfig::working())
        .run(&cohort, 1)
        .expect("run");
    println!("{d:#?}");
}
