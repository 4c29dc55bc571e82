//! `docs/tutorial.md`: every command in it works, and prints what the page says.

use std::path::Path;
use std::process::Command;

/// A command of the page, and the lines that it is said to print.
struct Step {
    words: Vec<String>,
    prints: Vec<String>,
}

/// The words of a command line; double quotes hold words together.
fn words(line: &str) -> Vec<String> {
    let (mut words, mut word, mut quoted) = (Vec::new(), String::new(), false);
    for letter in line.chars() {
        match letter {
            '"' => quoted = !quoted,
            ' ' if !quoted => words.push(std::mem::take(&mut word)),
            letter => word.push(letter),
        }
    }
    words.push(word);
    words.retain(|word| !word.is_empty());
    words
}

/// The indented lines of a page: a command, and what follows it until the next one.
fn steps(page: &str) -> Vec<Step> {
    let mut steps: Vec<Step> = Vec::new();
    for line in page.lines().filter_map(|line| line.strip_prefix("    ")) {
        match (line.strip_prefix("cargo xtask "), steps.last_mut()) {
            (Some(command), _) => steps.push(Step { words: words(command), prints: Vec::new() }),
            (None, Some(step)) => step.prints.push(line.trim().to_owned()),
            (None, None) => panic!("'{line}' follows no command"),
        }
    }
    steps
}

#[test]
fn every_command_of_the_tutorial_works_as_printed() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let page = std::fs::read_to_string(root.join("docs/tutorial.md")).expect("the page");
    let folder = tempfile::tempdir().expect("a folder");
    let out = format!("{}/", folder.path().display());
    let steps = steps(&page);
    assert!(steps.len() >= 5, "{} commands", steps.len());
    for step in steps {
        let arguments = step.words.iter().map(|word| match word.strip_prefix("out/") {
            Some(name) => format!("{out}{name}"),
            None => word.clone(),
        });
        let run = Command::new(env!("CARGO_BIN_EXE_t1d-twins"))
            .args(arguments)
            .current_dir(&root)
            .output()
            .expect("the program starts");
        let both = [run.stdout, run.stderr].concat();
        let said = String::from_utf8_lossy(&both).replace(&out, "out/");
        let fails = step.prints.iter().any(|line| line.starts_with("error: "));
        assert_eq!(run.status.code(), Some(i32::from(fails)), "{:?}: {said}", step.words);
        for line in &step.prints {
            for part in line.split("...").map(str::trim).filter(|part| !part.is_empty()) {
                assert!(
                    said.contains(part),
                    "{:?} does not print '{part}' but: {said}",
                    step.words
                );
            }
        }
    }
}
