//! What a run was: written beside every output, and what resumption compares.

use std::collections::HashSet;
use std::fs;
use std::io::Read as _;
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use anyhow::{Context as _, Result, bail};
use contract::{Document as _, FileHash};
use serde::Serialize;
use sha2::{Digest as _, Sha256};

use crate::files::{check_size, entries};

/// The report's file name in an output folder.
pub(crate) const REPORT: &str = "report.html";
/// The manifest's file name in an output folder.
pub(crate) const FILE: &str = contract::Manifest::FILE;

/// What the program is called, for manifests.
static PROGRAM: OnceLock<&'static str> = OnceLock::new();

/// Says what manifests call the program, unless it was said before; returns what they do.
pub fn call_program(name: &'static str) -> &'static str {
    PROGRAM.get_or_init(|| name)
}

/// What the program is called.
pub(crate) fn program() -> &'static str {
    PROGRAM.get().copied().unwrap_or("cargo xtask")
}

/// The manifest of a folder that is written or was.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Manifest {
    written: contract::Manifest,
    /// Folders that are inputs, the cohort first of a command that reads one; in the file their files stand.
    #[serde(skip)]
    pub(crate) folders: Vec<PathBuf>,
}

impl Deref for Manifest {
    type Target = contract::Manifest;

    fn deref(&self) -> &Self::Target {
        &self.written
    }
}

impl Manifest {
    /// Adds a model's file, whose size is looked at first.
    pub(crate) fn with_model(self, path: &Path) -> Result<Self> {
        check_size(path)?;
        self.with_input(path)
    }

    /// A manifest without inputs.
    #[must_use]
    pub fn new(stage: &str, config: serde_json::Value, seed: Option<u64>) -> Self {
        let written = contract::Manifest {
            schema: contract::Manifest::SCHEMA.to_owned(),
            stage: stage.to_owned(),
            command: command_line(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            config,
            seed,
            inputs: Vec::new(),
            outputs: Vec::new(),
        };
        Self { written, folders: Vec::new() }
    }

    /// Adds a file, or every file of a folder in the order of their names.
    pub fn with_input(mut self, path: &Path) -> Result<Self> {
        let files = files_in(path)?;
        if path.is_dir() {
            self.folders.push(path.to_path_buf());
        }
        for file in files {
            let sha256 = hash_file(&file)?;
            self.written.inputs.push(FileHash { path: slashed(&file), sha256 });
        }
        Ok(self)
    }

    /// Adds each of these, of which there may be none.
    pub(crate) fn with_inputs(
        self,
        paths: impl IntoIterator<Item = impl AsRef<Path>>,
    ) -> Result<Self> {
        paths.into_iter().try_fold(self, |manifest, path| manifest.with_input(path.as_ref()))
    }

    /// The manifest with the hashes of every file in `folder`, which is about to be finished.
    pub(crate) fn with_outputs_in(mut self, folder: &Path) -> Result<Self> {
        let files = files_in(folder)?;
        self.written.outputs = files
            .iter()
            .map(|file| {
                let path = slashed(file.strip_prefix(folder).unwrap_or(file));
                Ok(FileHash { path, sha256: hash_file(file)? })
            })
            .collect::<Result<_>>()?;
        Ok(self)
    }

    /// Files in `folder` that this manifest does not name, the manifest itself left out.
    pub(crate) fn strangers_in(&self, folder: &Path) -> Result<Vec<String>> {
        let files = files_in(folder)?;
        let names = files.iter().map(|file| slashed(file.strip_prefix(folder).unwrap_or(file)));
        Ok(names.filter(|name| !self.outputs.iter().any(|known| known.path == *name)).collect())
    }

    /// Whether every output is there with the bytes that were written.
    pub(crate) fn outputs_intact_in(&self, folder: &Path) -> bool {
        // The command `report` may have drawn the report anew.
        self.outputs.iter().filter(|output| output.path != REPORT).all(|output| {
            hash_file(&folder.join(&output.path)).is_ok_and(|found| found == output.sha256)
        })
    }

    /// The input folder in which a path lies, which need not exist.
    pub(crate) fn folder_around(&self, path: &Path) -> Option<&Path> {
        let path = std::path::absolute(path).ok()?;
        // The path itself may be an input's folder; that is told of otherwise.
        let there = path.ancestors().skip(1).find_map(|ancestor| ancestor.canonicalize().ok())?;
        let around =
            |folder: &&PathBuf| folder.canonicalize().is_ok_and(|folder| there.starts_with(folder));
        self.folders.iter().find(around).map(PathBuf::as_path)
    }

    /// The first input that lies within `folder`, if any.
    pub(crate) fn input_within(&self, folder: &Path) -> Option<&str> {
        let folder = folder.canonicalize().ok()?;
        let inside =
            |path: &str| Path::new(path).canonicalize().is_ok_and(|path| path.starts_with(&folder));
        self.inputs.iter().map(|input| input.path.as_str()).find(|path| inside(path))
    }

    /// Whether a folder written with `self` would hold what one written with `other` holds.
    ///
    /// Paths and the command line may differ; what was computed and from which bytes may not.
    pub(crate) fn same_work(&self, other: &Self) -> bool {
        let hashes = |m: &Self| m.inputs.iter().map(|i| i.sha256.clone()).collect::<Vec<_>>();
        self.schema == other.schema
            && self.stage == other.stage
            && self.version == other.version
            && self.config == other.config
            && self.seed == other.seed
            && hashes(self) == hashes(other)
    }

    /// The manifest in `folder`, or `None` if there is none that can be read.
    #[must_use]
    pub fn read(folder: &Path) -> Option<Self> {
        let written = contract::read(&fs::read(folder.join(FILE)).ok()?).ok()?;
        Some(Self { written, folders: Vec::new() })
    }
}

/// A file, or every file of a folder in the order of their names. Links are followed; a folder that
/// they lead to again is refused.
fn files_in(path: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    collect(path, &mut files, &mut HashSet::new())?;
    Ok(files)
}

fn collect(path: &Path, files: &mut Vec<PathBuf>, folders: &mut HashSet<PathBuf>) -> Result<()> {
    if path.is_dir() {
        let place = path
            .canonicalize()
            .with_context(|| format!("cannot read the folder '{}'", path.display()))?;
        if !folders.insert(place) {
            bail!("'{}' leads to a folder that was read already; remove the link", path.display());
        }
        for entry in entries(path)? {
            // A manifest names the command line as typed, which is not part of the work.
            if entry.file_name().is_none_or(|name| name != FILE) {
                collect(&entry, files, folders)?;
            }
        }
    } else if path.is_file() {
        files.push(path.to_path_buf());
    } else if path.exists() {
        bail!("'{}' is not a file; give a file or a folder of files", path.display());
    } else {
        bail!("there is no '{}'", path.display());
    }
    Ok(())
}

/// SHA-256 of a file's bytes, hexadecimal.
pub(crate) fn hash_file(path: &Path) -> Result<String> {
    let mut file =
        fs::File::open(path).with_context(|| format!("cannot open '{}'", path.display()))?;
    let mut hasher = Sha256::new();
    let mut buffer = vec![0; 1 << 16];
    loop {
        let read =
            file.read(&mut buffer).with_context(|| format!("cannot read '{}'", path.display()))?;
        if read == 0 {
            break;
        }
        hasher.update(&buffer[..read]);
    }
    Ok(hexadecimal(&hasher.finalize()))
}

/// Bytes as lower-case hexadecimal digits.
pub(crate) fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn slashed(path: &Path) -> String {
    path.to_string_lossy().replace('\\', "/")
}

/// A path, or another argument, as it can be pasted into a shell.
pub(crate) fn shown(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = |c: char| c.is_alphanumeric() || "/._-+@:,=".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        text
    } else {
        format!("'{}'", text.replace('\'', "'\\''"))
    }
}

fn command_line() -> String {
    let arguments = std::env::args_os().skip(1).map(|argument| shown(Path::new(&argument)));
    std::iter::once(program().to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hash_of_a_known_text() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let file = folder.path().join("abc");
        fs::write(&file, "abc").expect("writable");
        // FIPS 180-4, example of SHA-256.
        assert_eq!(
            hash_file(&file).expect("readable"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
    }

    #[cfg(unix)]
    #[test]
    fn a_shell_reads_the_argument_that_was_given() {
        for argument in
            ["out/a b", "it's", "", "$HOME", "a\"b", "*", "~", "a;b", "--worlds=3", "é\n"]
        {
            let script = format!("printf %s {}", shown(Path::new(argument)));
            let output = std::process::Command::new("sh").args(["-c", &script]).output();
            assert_eq!(output.expect("a shell").stdout, argument.as_bytes(), "{script}");
        }
        assert_eq!(shown(Path::new("out/a-1.csv")), "out/a-1.csv");
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_once() {
        use std::os::unix::fs::symlink;

        let place = tempfile::tempdir().expect("temporary folder");
        let (study, elsewhere) = (place.path().join("study"), place.path().join("elsewhere"));
        for folder in [&study, &elsewhere] {
            fs::create_dir(folder).expect("writable");
            fs::write(folder.join("a.csv"), "a").expect("writable");
        }
        let hashed = |folder: &Path| {
            let manifest = Manifest::new("x", serde_json::Value::Null, None).with_input(folder);
            manifest.map(|manifest| manifest.inputs.len()).map_err(|error| error.to_string())
        };
        symlink(&elsewhere, study.join("linked")).expect("a link");
        symlink(&study, place.path().join("link")).expect("a link");
        assert_eq!(hashed(&place.path().join("link")), Ok(2));
        symlink(&elsewhere, study.join("twice")).expect("a link");
        let refused = hashed(&study).expect_err("counted twice");
        assert!(refused.contains("twice' leads to a folder that was read already"), "{refused}");
        fs::remove_file(study.join("twice")).expect("ours");
        symlink("..", study.join("up")).expect("a link");
        symlink(".", study.join("itself")).expect("a link");
        let refused = hashed(&study).expect_err("a loop");
        assert!(refused.contains("itself' leads to a folder that was read already"), "{refused}");
    }

    #[test]
    fn changed_bytes_are_other_work_and_a_moved_folder_is_not() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let make = |name: &str, text: &str| {
            let file = folder.path().join(name);
            fs::write(&file, text).expect("writable");
            Manifest::new("x", serde_json::json!({"a": 1}), Some(1))
                .with_input(&file)
                .expect("readable")
        };
        assert!(make("one", "text").same_work(&make("two", "text")));
        assert!(!make("one", "text").same_work(&make("one", "other")));
    }
}
