//! One malformed input: what is typed, and what the answer must say.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

/// A command on a malformed input.
pub(super) struct Case {
    /// What is wrong.
    pub(super) name: String,
    /// The words after the program's name, without `--out`.
    pub(super) arguments: Vec<String>,
    /// Expected exit status: 1, or 2 for wrong usage.
    pub(super) status: i32,
    /// What the message must hold.
    pub(super) words: Vec<String>,
    /// Folder in which nothing may be left; the output is asked for within it.
    pub(super) apart: PathBuf,
    /// Whether `--out` is added.
    pub(super) out: bool,
    /// Whether the program must not run as root, for whom nothing is closed.
    pub(super) ordinary: bool,
}

/// The cases, and a folder for their inputs.
pub(super) struct Cases {
    root: PathBuf,
    pub(super) all: Vec<Case>,
    /// Small disks, to be taken away at the end.
    pub(super) mounted: Vec<PathBuf>,
}

impl Cases {
    pub(super) fn new(root: &Path) -> Self {
        Self { root: root.to_owned(), all: Vec::new(), mounted: Vec::new() }
    }

    /// A path of its own for the input of the next case.
    pub(super) fn place(&self, name: &str) -> PathBuf {
        let folder = self.root.join("inputs").join(self.all.len().to_string());
        fs::create_dir_all(&folder).expect("a folder");
        folder.join(name)
    }

    /// A file for the next case.
    pub(super) fn file(&self, name: &str, bytes: impl AsRef<[u8]>) -> String {
        let path = self.place(name);
        fs::write(&path, bytes).expect("writable");
        text(&path)
    }

    /// Bad input: status 1 and a message with all of `words`.
    pub(super) fn refused(&mut self, name: &str, arguments: &[&str], words: &[&str]) {
        self.add(name, arguments, 1, words, true);
    }

    /// Bad input of a command that has no `--out`, or whose `--out` is the fault.
    pub(super) fn refused_as_it_is(&mut self, name: &str, arguments: &[&str], words: &[&str]) {
        self.add(name, arguments, 1, words, false);
    }

    /// The same for a user who may not do everything; `--out` is added where `out` says so.
    pub(super) fn refused_for_a_user(
        &mut self,
        name: &str,
        arguments: &[&str],
        words: &[&str],
        out: bool,
    ) {
        self.add(name, arguments, 1, words, out);
        let case = self.all.last_mut().expect("just added");
        case.ordinary = true;
        // The user is somebody else where the tests run as root.
        for folder in [&self.root, &case.apart] {
            let open = fs::Permissions::from_mode(0o777);
            fs::set_permissions(folder, open).expect("ours");
        }
    }

    /// Wrong usage: status 2.
    pub(super) fn usage(&mut self, name: &str, arguments: &[&str], words: &[&str]) {
        self.add(name, arguments, 2, words, true);
    }

    fn add(&mut self, name: &str, arguments: &[&str], status: i32, words: &[&str], out: bool) {
        let owned = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect();
        let apart = self.root.join("outputs").join(self.all.len().to_string());
        fs::create_dir_all(&apart).expect("a folder");
        self.all.push(Case {
            name: name.to_owned(),
            arguments: owned(arguments),
            status,
            words: owned(words),
            apart,
            out,
            ordinary: false,
        });
    }
}

impl Drop for Cases {
    fn drop(&mut self) {
        for folder in &self.mounted {
            let _ = std::process::Command::new("umount").arg(folder).status();
        }
    }
}

/// A path as an argument.
pub(super) fn text(path: &Path) -> String {
    path.to_str().expect("temporary paths are UTF-8").to_owned()
}

/// A path of the repository.
pub(super) fn repository(path: &str) -> String {
    text(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path))
}
