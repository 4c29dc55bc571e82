//! Lets bodies live the recorded days of a cohort. Writes `OUT_DIR/cohort` and, apart from it,
//! `OUT_DIR/info.json` with the truth and the people who could not be replayed.
//!
//!     cargo run -p world --example replay_cohort -- COHORT OUT_DIR [hovorka|padova|minimal|saturating] [SEED]
#![expect(clippy::print_stdout, reason = "an example tells what it wrote")]

use std::error::Error;
use std::fs;
use std::path::PathBuf;

use cohort::{RecordsFormat, read_folder, write_folder};
use serde_json::json;
use world::replayed::Replayed;
use world::{Amplitudes, Generator};

const USAGE: &str =
    "usage: replay_cohort COHORT OUT_DIR [hovorka|padova|minimal|saturating] [SEED]";

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [source, out, rest @ ..] = arguments.as_slice() else { return Err(USAGE.into()) };
    let generator = match rest.first() {
        Some(name) => Generator::from_name(name).ok_or(USAGE)?,
        None => Generator::Hovorka,
    };
    let seed = rest.get(1).map_or(Ok(1), |seed| seed.parse())?;

    let cohort = read_folder(&PathBuf::from(source))?;
    let replayed = Replayed::fit(generator, seed, &cohort, Amplitudes::NONE);
    let out = PathBuf::from(out);
    fs::create_dir_all(&out)?;
    write_folder(&replayed.cohort()?, &out.join("cohort"), RecordsFormat::Csv)?;
    let people: Vec<_> = replayed.people.iter().map(|person| person.info()).collect();
    let skipped: Vec<_> = replayed
        .skipped
        .iter()
        .map(|(id, reason)| json!({ "person_id": id, "reason": reason.to_string() }))
        .collect();
    let info = json!({ "seed": seed, "people": people, "skipped": skipped });
    fs::write(out.join("info.json"), format!("{info:#}\n"))?;
    for (id, reason) in &replayed.skipped {
        println!("{id} is left out: {reason}");
    }
    println!("{} people: {}", people.len(), out.display());
    Ok(())
}
