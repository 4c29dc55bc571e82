//! Writes a report from made-up JSON: `cargo run -p report --example sample_report -- report.html`

#![expect(clippy::print_stdout, reason = "an example says what it wrote")]

mod made_up;

use std::error::Error;

use report::{Inputs, render};

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("give the path of the report to write")?;
    let mut inputs = Inputs::default();
    for (part, value) in made_up::parts() {
        inputs.read(part, value.to_string().as_bytes())?;
    }
    std::fs::write(&path, render(&inputs)?)?;
    println!("wrote {path}");
    Ok(())
}
