//! Digital twins for type 1 diabetes on the command line.

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::run(&cli::commands("t1d-twins").get_matches())
}
