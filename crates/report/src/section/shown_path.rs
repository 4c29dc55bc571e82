//! Paths without the folders of the machine on which they were read.

use serde_json::Value;

/// Last parts of an absolute path that are shown.
const SHOWN: usize = 2;

/// A path as the page shows it: of an absolute one, its end.
pub(super) fn shown_path(path: &str) -> String {
    let slashed = path.replace('\\', "/");
    let drive = slashed.as_bytes().get(1..3) == Some(b":/");
    if !slashed.starts_with('/') && !drive {
        return path.to_owned();
    }
    let parts: Vec<&str> = slashed.split('/').filter(|part| !part.is_empty()).collect();
    format!("\u{2026}/{}", parts[parts.len().saturating_sub(SHOWN)..].join("/"))
}

/// A command line with every absolute path shown by its end. Arguments with spaces stand in single quotes.
pub(super) fn shown_command(command: &str) -> String {
    let mut within = false;
    let arguments = command.split(|c: char| {
        within ^= c == '\'';
        c == ' ' && !within
    });
    let word = |argument: &str| {
        let plain = argument.trim_matches('\'');
        let shown = match plain.split_once('=') {
            Some((option, path)) if option.starts_with('-') => {
                format!("{option}={}", shown_path(path))
            }
            _ => shown_path(plain),
        };
        if plain.len() < argument.len() { format!("'{shown}'") } else { shown }
    };
    arguments.map(word).collect::<Vec<_>>().join(" ")
}

/// JSON with every string that is an absolute path shown by its end.
pub(super) fn shown_json(value: &Value) -> Value {
    match value {
        Value::String(text) => Value::String(shown_path(text)),
        Value::Array(list) => Value::Array(list.iter().map(shown_json).collect()),
        Value::Object(map) => {
            Value::Object(map.iter().map(|(key, value)| (key.clone(), shown_json(value))).collect())
        }
        other => other.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absolute_paths_lose_their_beginning() {
        for (path, shown) in [
            ("fixtures/embedded/cohort/people.csv", "fixtures/embedded/cohort/people.csv"),
            ("/home/ann/study/cohort/people.csv", "\u{2026}/cohort/people.csv"),
            ("/people.csv", "\u{2026}/people.csv"),
            ("C:\\Users\\ann\\cohort\\people.csv", "\u{2026}/cohort/people.csv"),
            ("12/31", "12/31"),
        ] {
            assert_eq!(shown_path(path), shown);
        }
        assert_eq!(
            shown_command(
                "cargo xtask diagnose --cohort /home/ann/a/b --out=/home/ann/c/d --seed 1"
            ),
            "cargo xtask diagnose --cohort \u{2026}/a/b --out=\u{2026}/c/d --seed 1"
        );
        assert_eq!(
            shown_command("p import '/home/ann my/a/b c' --map 'time=Fecha y hora' --seed 1"),
            "p import '\u{2026}/a/b c' --map 'time=Fecha y hora' --seed 1"
        );
        let config = serde_json::json!({"model": ["/home/ann/x/y/z"], "n": 3});
        assert_eq!(shown_json(&config), serde_json::json!({"model": ["\u{2026}/y/z"], "n": 3}));
    }
}
