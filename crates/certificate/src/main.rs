//! `check-certificates MODEL CERTIFICATES`: says which properties are proved, or why the certificates are rejected.
#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a program speaks on its standard streams"
)]

use std::error::Error as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

const USAGE: &str = "usage: check-certificates MODEL.safetensors CERTIFICATES.json";

fn main() -> ExitCode {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let [model, certificates] = arguments.as_slice() else {
        eprintln!("{USAGE}");
        return ExitCode::from(2);
    };
    match run(model, certificates) {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("rejected: {reason}");
            ExitCode::FAILURE
        }
    }
}

fn run(model: &Path, certificates: &Path) -> Result<(), String> {
    let read = |path: &Path| {
        std::fs::read(path).map_err(|error| format!("cannot read '{}': {error}", path.display()))
    };
    let began = Instant::now();
    let accepted =
        certificate::check(&read(certificates)?, &read(model)?).map_err(|rejection| {
            let cause = rejection.source().map(|cause| format!(": {cause}")).unwrap_or_default();
            format!("{rejection}{cause}")
        })?;
    for row in &accepted {
        let verdict = if row.claim <= 0.0 { "proved" } else { "bounded" };
        let over =
            row.over.iter().map(|(input, [lower, upper])| format!("{input} {lower} to {upper}"));
        let cut = match row.half_spaces {
            0 => String::new(),
            number => format!(", cut by {number} half-spaces"),
        };
        println!(
            "{verdict}: {} {} in {}, slope against it at most {:e} over {}{cut} (scaled; {} boxes)",
            row.network,
            row.property,
            row.input,
            row.claim,
            over.collect::<Vec<_>>().join(", "),
            row.leaves
        );
    }
    println!(
        "{} of {} certificates accepted in {:.1} s",
        accepted.len(),
        accepted.len(),
        began.elapsed().as_secs_f64()
    );
    Ok(())
}
