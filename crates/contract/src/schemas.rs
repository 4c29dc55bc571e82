//! JSON Schemas of every document, and the page that lists their keys: made from the types, compared with what
//! lies in `docs/`. `UPDATE_DOCS=1 cargo test -p contract` writes them.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use schemars::{JsonSchema, schema_for};
use serde_json::{Map, Value};

use crate::bench::{DiagnosisBench, MealsBench, TrainingStepBench, TwinsBench};
use crate::blind_check::{
    Answer, BlindCheck, CalibrationTable, Label, Labels, OpenedLabels, People, PlantedCheck,
    Realism, Seal,
};
use crate::development_set::{DevelopmentSetSummary, ScalerSummary};
use crate::posterior::{PosteriorCard, StatisticNames};
use crate::{
    Baselines, Certificates, Conformance, DataInUse, Diagnosis, Document, EffectTwins, ExampleDay,
    Exclusions, GlucoseByPerson, GlucoseProfile, HeldOut, ImportReport, Manifest, Meals,
    OutcomesTable, RegionFile, Repair, RunErrors, StatedTruth, SteadyStates, Thresholds, Training,
    Trajectories, TwinsTable, WhatIf, WidthSearch,
};

/// What follows this line in `docs/outputs.md` is made from the types.
const MARK: &str =
    "<!-- From here on made from the types: UPDATE_DOCS=1 cargo test -p contract -->\n";

/// A document: its file, its schema name and its JSON Schema.
struct Described {
    file: &'static str,
    name: &'static str,
    schema: Value,
}

impl Described {
    /// The name of its schema's file: the schema name, or the type's for a file that has none.
    fn stem(&self) -> String {
        if !self.name.is_empty() {
            return self.name.replace('/', "-");
        }
        let title = self.schema["title"].as_str().unwrap_or_default();
        let dashed: String = title
            .char_indices()
            .map(|(place, letter)| match letter {
                capital if capital.is_uppercase() && place > 0 => format!("-{capital}"),
                other => other.to_string(),
            })
            .collect();
        dashed.to_lowercase()
    }
}

fn described<T: Document + JsonSchema>() -> Described {
    Described { file: T::FILE, name: T::SCHEMA, schema: schema_for!(T).to_value() }
}

fn all() -> Vec<Described> {
    vec![
        described::<Manifest>(),
        described::<ImportReport>(),
        described::<DevelopmentSetSummary>(),
        described::<ScalerSummary>(),
        described::<WidthSearch>(),
        described::<Training>(),
        described::<RegionFile>(),
        described::<Conformance>(),
        described::<Certificates>(),
        described::<Repair>(),
        described::<HeldOut>(),
        described::<SteadyStates>(),
        described::<Trajectories>(),
        described::<TwinsTable>(),
        described::<RunErrors>(),
        described::<Baselines>(),
        described::<OutcomesTable>(),
        described::<Exclusions>(),
        described::<GlucoseProfile>(),
        described::<WhatIf>(),
        described::<ExampleDay>(),
        described::<Diagnosis>(),
        described::<DataInUse>(),
        described::<GlucoseByPerson>(),
        described::<StatedTruth>(),
        described::<EffectTwins>(),
        described::<Meals>(),
        described::<BlindCheck>(),
        described::<Seal>(),
        described::<Answer>(),
        described::<OpenedLabels>(),
        described::<Label>(),
        described::<Labels>(),
        described::<CalibrationTable>(),
        described::<Thresholds>(),
        described::<PlantedCheck>(),
        described::<Realism>(),
        described::<People>(),
        described::<StatisticNames>(),
        described::<PosteriorCard>(),
        described::<DiagnosisBench>(),
        described::<MealsBench>(),
        described::<TrainingStepBench>(),
        described::<TwinsBench>(),
    ]
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
    for document in all() {
        let name = document.stem();
        let text = serde_json::to_string_pretty(&document.schema).expect("JSON") + "\n";
        agrees(&docs().join("schemas").join(format!("{name}.schema.json")), &text);
    }
}

#[test]
fn the_page_of_outputs_lists_every_key() {
    let path = docs().join("outputs.md");
    let page = std::fs::read_to_string(&path).expect("docs/outputs.md");
    let (written, _) = page.split_once(MARK).expect("the mark of docs/outputs.md");
    let mut text = format!("{written}{MARK}");
    for document in all() {
        let what = sentence(&document.schema);
        let schema = match document.name {
            "" => "Schema".to_owned(),
            name => format!("Schema `{name}`"),
        };
        let _ = write!(
            text,
            "\n## `{}`\n\n{what} {schema}: `docs/schemas/{}.schema.json`.\n\n| key | type | meaning |\n|---|---|---|\n",
            document.file,
            document.stem()
        );
        text += &table(&document.schema);
    }
    agrees(&path, &text);
}

#[test]
fn every_key_is_described() {
    for document in all() {
        for line in table(&document.schema).lines() {
            assert!(!line.ends_with("|  |"), "{}: no meaning: {line}", document.file);
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
        return kind(root, definition(root, target));
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
            let items = if schema["items"].is_object() {
                &schema["items"]
            } else {
                &schema["prefixItems"][0]
            };
            let (words, within) = kind(root, items);
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

fn definition<'a>(root: &'a Value, target: &str) -> &'a Value {
    root.pointer(target.trim_start_matches('#')).expect("a definition of this schema")
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
