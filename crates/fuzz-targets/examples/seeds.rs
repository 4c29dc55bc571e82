//! `cargo run -p fuzz-targets --example seeds -- CORPUS [OUTPUTS]`: writes each target's good inputs
//! to `CORPUS/TARGET/`, and the JSON files below OUTPUTS as documents.

use std::fs;
use std::path::{Path, PathBuf};

/// Largest file that is worth a fuzzer's time, bytes.
const LARGEST: u64 = 100_000;

fn main() -> std::io::Result<()> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let Some(corpus) = arguments.next() else {
        return Err(std::io::Error::other("usage: seeds CORPUS [OUTPUTS]"));
    };
    for target in fuzz_targets::TARGETS {
        let folder = corpus.join(target.name);
        fs::create_dir_all(&folder)?;
        for (i, seed) in (target.seeds)().iter().enumerate() {
            fs::write(folder.join(format!("seed-{i}")), seed)?;
        }
    }
    match arguments.next() {
        Some(outputs) => documents(&outputs, &corpus.join("documents"), &mut 0),
        None => Ok(()),
    }
}

fn documents(outputs: &Path, corpus: &Path, count: &mut usize) -> std::io::Result<()> {
    for entry in fs::read_dir(outputs)? {
        let path = entry?.path();
        if path.is_dir() {
            documents(&path, corpus, count)?;
        } else if path.extension().is_some_and(|extension| extension == "json")
            && fs::metadata(&path)?.len() <= LARGEST
        {
            let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
            let mut bytes = name.unwrap_or_default().into_bytes();
            bytes.push(b'\n');
            bytes.extend(fs::read(&path)?);
            fs::write(corpus.join(format!("output-{count}")), bytes)?;
            *count += 1;
        }
    }
    Ok(())
}
