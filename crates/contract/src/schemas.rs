//! JSON Schemas of every document, and the page that lists their keys: made from the types, compared with what
//! lies in `docs/`. `UPDATE_DOCS=1 cargo test -p contract` writes them.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value};

use crate::document_kinds;

/// What follows this line in `docs/outputs.md` is made from the types.
const MARK: &str =
    "<!-- From here on made from the types: UPDATE_DOCS=1 cargo test -p contract -->\n";

/// Every document: its file, its schema name and its JSON Schema.
fn all() -> impl Iterator<Item = (&'static str, &'static str, Value)> {
    document_kinds().into_iter().map(|kind| (kind.file, kind.schema.0, (kind.schema.1)()))
}

/// The name of a schema's file: the schema name, or the type's for a file that has none.
fn stem(name: &str, schema: &Value) -> String {
    if !name.is_empty() {
        return name.replace('/', "-");
    }
    let title = schema["title"].as_str().unwrap_or_default();
    let dashed: String = title
        .char_indices()
        .map(|(place, letter)| match letter {
            capital if capital.is_uppercase() && place > 0 => format!("-{capital}"),
            other => other.to_string(),
        })
        .collect();
    dashed.to_lowercase()
}

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs")
}

/// Compares a file with what it should hold, or writes it where `UPDATE_DOCS` is set.
fn agrees(path: &Path, expected: &str) {
    if std::env::var_os("UPDATE_DOCS").is_some() {
        let folder = path.parent().expect("a folder");
        std::fs::create_dir_all(folder).expect("docs can be written");
        std::fs::write(path, expected).expect("docs can be written");
    }
    let found = std::fs::read_to_string(path).unwrap_or_default();
    assert!(
        found == expected,
        "'{}' is not what the types say; UPDATE_DOCS=1 cargo test -p contract writes it",
        path.display()
    );
}

#[test]
fn schemas_are_those_of_the_types() {
    for (_, name, schema) in all() {
        let file = format!("{}.schema.json", stem(name, &schema));
        let text = serde_json::to_string_pretty(&schema).expect("JSON") + "\n";
        agrees(&docs().join("schemas").join(file), &text);
    }
}

#[test]
fn the_page_of_outputs_lists_every_key() {
    let path = docs().join("outputs.md");
    let page = std::fs::read_to_string(&path).expect("docs/outputs.md");
    let (written, _) = page.split_once(MARK).expect("the mark of docs/outputs.md");
    let mut text = format!("{written}{MARK}");
    for (file, name, schema) in all() {
        let (what, stem) = (sentence(&schema), stem(name, &schema));
        let called = match name {
            "" => "Schema".to_owned(),
            name => format!("Schema `{name}`"),
        };
        let _ = write!(
            text,
            "\n## `{file}`\n\n{what} {called}: `docs/schemas/{stem}.schema.json`.\n\n| key | type | meaning |\n|---|---|---|\n",
        );
        text += &table(&schema);
    }
    agrees(&path, &text);
}

#[test]
fn every_key_is_described() {
    for (file, _, schema) in all() {
        for line in table(&schema).lines() {
            assert!(!line.ends_with("|  |"), "{file}: no meaning: {line}");
        }
    }
}

/// The rows of a document: its keys, or those of what it lists.
fn table(schema: &Value) -> String {
    let mut text = String::new();
    let (words, within) = kind(schema, schema);
    match within {
        Some((object, path)) => {
            let path = path.trim_start_matches('.');
            rows(&mut text, schema, object, path, &mut BTreeMap::new());
        }
        None => text = format!("| `[]` | {words} | {} |\n", sentence(schema)),
    }
    text
}

/// A row for each key of an object, and for those of the objects within; an object that was listed before is
/// named by its first place in `known`.
fn rows<'a>(
    text: &mut String,
    root: &'a Value,
    schema: &'a Value,
    path: &str,
    known: &mut BTreeMap<*const Value, String>,
) {
    let empty = Map::new();
    let properties = schema["properties"].as_object().unwrap_or(&empty);
    for (key, value) in properties {
        let place = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        let (kind, within) = kind(root, value);
        let meaning = sentence(value).replace('|', "\\|");
        let within = within.map(|(object, list)| (object, format!("{place}{list}")));
        let first = within.as_ref().and_then(|(object, _)| known.get(&std::ptr::from_ref(*object)));
        let as_there = first.map_or_else(String::new, |first| format!(", as `{first}`"));
        let _ = writeln!(text, "| `{place}` | {kind}{as_there} | {meaning} |");
        if let (Some((object, inner)), true) = (within, as_there.is_empty()) {
            known.insert(std::ptr::from_ref(object), inner.clone());
            rows(text, root, object, &inner, known);
        }
    }
}

/// The type in words, and the object within, if there is one, with what its path adds.
fn kind<'a>(root: &'a Value, schema: &'a Value) -> (String, Option<(&'a Value, &'static str)>) {
    if let Some(target) = schema["$ref"].as_str() {
        let definition = root.pointer(target.trim_start_matches('#'));
        return kind(root, definition.expect("a definition of this schema"));
    }
    if let Some(variants) = schema["anyOf"].as_array() {
        let (null, some): (Vec<_>, Vec<_>) = variants.iter().partition(|v| v["type"] == "null");
        let null = if null.is_empty() { "" } else { " or null" };
        if let [one] = some[..] {
            let (words, within) = kind(root, one);
            return (format!("{words}{null}"), within);
        }
        let words: Vec<String> = some.iter().map(|one| one_of_several(root, one)).collect();
        return (format!("{}{null}", words.join(" or ")), None);
    }
    if let Some(variants) = schema["oneOf"].as_array() {
        let words = variants.iter().flat_map(words_of).collect::<Vec<_>>();
        return (words.join(", "), None);
    }
    if schema["enum"].is_array() {
        return (words_of(schema).join(", "), None);
    }
    let types: Vec<&str> = match &schema["type"] {
        Value::String(one) => vec![one],
        Value::Array(several) => several.iter().filter_map(Value::as_str).collect(),
        _ => return ("any".to_owned(), None),
    };
    let null = if types.contains(&"null") { " or null" } else { "" };
    match types.first().copied().unwrap_or_default() {
        "array" => {
            let items = schema.get("items").filter(|items| items.is_object());
            let (words, within) = kind(root, items.unwrap_or(&schema["prefixItems"][0]));
            (format!("list of {words}{null}"), within.map(|(object, _)| (object, "[]")))
        }
        "object" if schema["properties"].is_object() => {
            (format!("object{null}"), Some((schema, "")))
        }
        "object" => {
            let (words, within) = kind(root, &schema["additionalProperties"]);
            (format!("map of {words}{null}"), within.map(|(object, _)| (object, ".*")))
        }
        other => (format!("{other}{null}"), None),
    }
}

/// One of several forms: an object by its keys.
fn one_of_several(root: &Value, schema: &Value) -> String {
    let Some(properties) = schema["properties"].as_object() else { return kind(root, schema).0 };
    let keys: Vec<String> = properties
        .iter()
        .map(|(key, value)| format!("`{key}`, {}: {}", kind(root, value).0, sentence(value)))
        .collect();
    format!("object with {}", keys.join(" and "))
}

fn words_of(variant: &Value) -> Vec<String> {
    let one = variant["const"].as_str().into_iter();
    let several = variant["enum"].as_array().into_iter().flatten().filter_map(Value::as_str);
    one.chain(several).map(|word| format!("`{word}`")).collect()
}

/// The description in one line, without links of Rust.
fn sentence(schema: &Value) -> String {
    let text = schema["description"].as_str().unwrap_or_default();
    let mut line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    // [`Name`](path) and [`Name`] are the name alone.
    while let (Some(from), Some(to)) = (line.find("[`"), line.find("`]")) {
        let name = line[from + 2..to].to_owned();
        let rest = &line[to + 2..];
        let after = if rest.starts_with('(') { rest.find(')').map_or(0, |end| end + 1) } else { 0 };
        line = format!("{}`{name}`{}", &line[..from], &rest[after..]);
    }
    line
}
