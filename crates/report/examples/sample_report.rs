//! Writes a report from made-up JSON: `cargo run -p report --example sample_report -- report.html`
//!
//! A second argument chooses what a folder holds: `diagnose`, `none`, `unknown` or `blind-check`.

#![expect(clippy::print_stdout, reason = "an example says what it wrote")]

mod made_up;

use std::error::Error;

use report::{Inputs, render};

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("give the path of the report to write")?;
    let of = std::env::args().nth(2).unwrap_or_default();
    let mut inputs = Inputs::default();
    for (part, value) in made_up::folder(&of) {
        let value = made_up::completed(part, value);
        inputs.read(part, value.to_string().as_bytes())?;
    }
    std::fs::write(&path, render(&inputs)?)?;
    println!("wrote {path}");
    Ok(())
}
