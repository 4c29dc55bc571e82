//! Prints the library as a document: `cargo run -p effects --example table > docs/effects.md`.

#![expect(clippy::print_stdout, reason = "what it prints is the document")]

fn main() {
    print!("{}", effects::overview(&effects::library()));
}
