//! Files of a crate that know each other in a circle. A parent and its children are not looked at: a module may use
//! what it is made of. Also what the filter of `gap` must not know.
//!
//! What a file names is read from its text: every path that begins with `crate`, `super` or `self`, up to the longest part
//! that is a file. Tests are left out.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use anyhow::{Context as _, Result, bail};

/// A module of a crate by its path, as `["which", "round"]`.
type Module = Vec<String>;

/// Modules of `gap` that its filter may know. The filter answers; the questions that are put to it are elsewhere.
const FILTER_MAY_KNOW: [&str; 3] = ["error", "filter", "quality"];

/// Reports every circle, and what the filter must not know.
pub(super) fn check(root: &Path) -> Result<()> {
    let mut crates: Vec<_> = fs::read_dir(root.join("crates"))
        .context("the folder of crates")?
        .collect::<Result<Vec<_>, _>>()?
        .into_iter()
        .map(|entry| entry.path())
        .collect();
    crates.push(root.join("xtask"));
    crates.sort();
    let mut wrong = Vec::new();
    for folder in crates {
        let name =
            folder.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        let arrows = arrows(&folder.join("src"))?;
        let found = circles(&arrows);
        wrong.extend(found.iter().map(|circle| format!("{name}: {}", circle.join(" - "))));
        let beyond = if name == "gap" { beyond_the_filter(&arrows) } else { BTreeSet::new() };
        if !beyond.is_empty() {
            bail!(
                "the filter of gap names modules that it must not know (docs/architecture.md): {}",
                beyond.into_iter().collect::<Vec<_>>().join(", ")
            );
        }
    }
    if !wrong.is_empty() {
        bail!("files know each other in circles:\n  {}", wrong.join("\n  "));
    }
    Ok(())
}

/// The modules that the filter and its parts name and must not know.
fn beyond_the_filter(arrows: &BTreeMap<Module, BTreeSet<Module>>) -> BTreeSet<&str> {
    let of_filter = arrows.iter().filter(|(module, _)| module[0] == "filter");
    let named = of_filter.flat_map(|(_, named)| named).map(|path| path[0].as_str());
    named.filter(|name| !FILTER_MAY_KNOW.contains(name)).collect()
}

/// What each file of a crate names, parents and children aside.
fn arrows(src: &Path) -> Result<BTreeMap<Module, BTreeSet<Module>>> {
    let mut texts = BTreeMap::new();
    read(src, &mut Vec::new(), &mut texts)?;
    let known: BTreeSet<Module> = texts.keys().cloned().collect();
    let related = |one: &Module, other: &Module| one.starts_with(other) || other.starts_with(one);
    Ok(texts
        .iter()
        .map(|(module, text)| {
            let named = named(text, module)
                .into_iter()
                .filter_map(|mut path| {
                    while !path.is_empty() && !known.contains(&path) {
                        path.pop();
                    }
                    (!path.is_empty()).then_some(path)
                })
                .filter(|path| !related(path, module))
                .collect();
            (module.clone(), named)
        })
        .collect())
}

fn read(folder: &Path, at: &mut Module, texts: &mut BTreeMap<Module, String>) -> Result<()> {
    for entry in fs::read_dir(folder).with_context(|| format!("'{}'", folder.display()))? {
        let path = entry?.path();
        let stem = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        if path.is_dir() {
            at.push(stem);
            read(&path, at, texts)?;
            at.pop();
        } else if path.extension().is_some_and(|e| e == "rs") && !["lib", "main"].contains(&&*stem)
        {
            let text =
                fs::read_to_string(&path).with_context(|| format!("'{}'", path.display()))?;
            let mut module = at.clone();
            if stem != "mod" {
                module.push(stem);
            }
            texts.insert(module, text);
        }
    }
    Ok(())
}

/// Every path of a text that begins within its crate, groups in braces opened.
fn named(text: &str, module: &Module) -> Vec<Module> {
    let code: String = text
        .split("#[cfg(test)]\nmod tests {")
        .next()
        .unwrap_or_default()
        .lines()
        .map(|line| line.split("//").next().unwrap_or_default())
        .collect::<Vec<_>>()
        .join("\n");
    let mut found = Vec::new();
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    for root in ["crate", "super", "self"] {
        for (index, _) in code.match_indices(&format!("{root}::")) {
            if code[..index].chars().next_back().is_some_and(|c| is_word(c) || c == ':') {
                continue;
            }
            let parent = module[..module.len().saturating_sub(1)].to_vec();
            let base = match root {
                "crate" => Vec::new(),
                "super" => parent,
                _ => module.clone(),
            };
            follow(&code[index + root.len() + 2..], base, &mut found);
        }
    }
    found
}

/// Adds the paths at the beginning of `rest`, which continue `base`; returns how far they reach.
fn follow(rest: &str, mut base: Module, found: &mut Vec<Module>) -> usize {
    let mut at = 0;
    loop {
        if rest[at..].starts_with('{') {
            at += 1;
            while at < rest.len() && !rest[at..].starts_with('}') {
                let c = rest[at..].chars().next().unwrap_or(' ');
                if c.is_alphanumeric() || c == '_' || c == '{' {
                    at += follow(&rest[at..], base.clone(), found).max(1);
                } else {
                    at += c.len_utf8();
                }
            }
            return at + 1;
        }
        let word: String =
            rest[at..].chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        at += word.len();
        match word.as_str() {
            "super" => drop(base.pop()),
            "" => {}
            _ => base.push(word),
        }
        if !rest[at..].starts_with("::") {
            found.push(base);
            return at;
        }
        at += 2;
    }
}

/// Groups of files of which each reaches every other.
fn circles(arrows: &BTreeMap<Module, BTreeSet<Module>>) -> Vec<Vec<String>> {
    let reached = |from: &Module| {
        let mut seen: BTreeSet<&Module> = BTreeSet::new();
        let mut open: Vec<&Module> = arrows.get(from).into_iter().flatten().collect();
        while let Some(next) = open.pop() {
            if seen.insert(next) {
                open.extend(arrows.get(next).into_iter().flatten());
            }
        }
        seen
    };
    let reach: BTreeMap<&Module, BTreeSet<&Module>> =
        arrows.keys().map(|module| (module, reached(module))).collect();
    let mut done: BTreeSet<&Module> = BTreeSet::new();
    let mut found = Vec::new();
    for (module, to) in &reach {
        if done.contains(module) || !to.contains(module) {
            continue;
        }
        let together: Vec<&Module> =
            to.iter().copied().filter(|other| reach[other].contains(module)).collect();
        found.push(together.iter().map(|module| module.join("/")).collect());
        done.extend(together);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn module(path: &str) -> Module {
        path.split('/').map(str::to_owned).collect()
    }

    #[test]
    fn paths_are_read_with_their_groups() {
        let text = "use crate::a::{B, c::{D, e}};\nuse super::f::G;\n// use crate::no::N;\n\
                    #[cfg(test)]\nmod sample;\nuse crate::j::K;\n\
                    fn x() { super::super::h::i() }\n#[cfg(test)]\nmod tests { use crate::t::T; }";
        let found = named(text, &module("m/n"));
        for path in ["a/B", "a/c/D", "a/c/e", "m/f/G", "h/i", "j/K"] {
            assert!(found.contains(&module(path)), "{path}: {found:?}");
        }
        assert!(found.iter().all(|path| path[0] != "no" && path[0] != "t"), "{found:?}");
    }

    fn arrows<const N: usize>(named: [(&str, &[&str]); N]) -> BTreeMap<Module, BTreeSet<Module>> {
        let arrow =
            |(from, to): (&str, &[&str])| (module(from), to.iter().map(|to| module(to)).collect());
        named.into_iter().map(arrow).collect()
    }

    #[test]
    fn a_circle_is_found_and_a_line_is_not() {
        let arrows =
            arrows([("a", &["b"]), ("b", &["c"]), ("c", &["a"]), ("d", &["a"]), ("e", &[])]);
        assert_eq!(circles(&arrows), [["a", "b", "c"]]);
    }

    #[test]
    fn what_the_filter_must_not_know_is_named() {
        let arrows = arrows([
            ("filter", &["which/round"]),
            ("filter/kalman", &["filter/state", "error"]),
            ("which", &["filter"]),
        ]);
        assert_eq!(beyond_the_filter(&arrows), BTreeSet::from(["which"]));
    }
}
