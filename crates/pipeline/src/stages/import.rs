//! `import`: a study's files as a cohort folder, with an account of what was done.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail, ensure};
pub use cohort::{DateOrder, ImportFormat};
use cohort::{RecordsFormat, TableOptions, guess_table, import_with, write_folder};
use contract::{Document as _, ImportReport};

use crate::progress::json_is_asked_for;
use crate::{Manifest, OutputFolder, note, table};
use ::report::count;

/// Largest file of a map, bytes.
const LARGEST_MAP: u64 = 1 << 20;

/// Settings of `import`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Format of the source.
    pub from: ImportFormat,
    /// The study's folder or file, or several tables.
    pub source: Vec<PathBuf>,
    /// Output folder.
    pub out: PathBuf,
    /// Write `records.parquet` in place of `records.csv`.
    pub parquet: bool,
    /// Columns by role, or TOML files of them.
    pub map: Vec<String>,
    /// Units by role.
    pub unit: Vec<String>,
    /// Time zone of the people.
    pub zone: Option<String>,
    /// Times without an offset are UTC.
    pub utc: bool,
    /// Order of day and month.
    pub dates: Option<DateOrder>,
    /// The decimal mark.
    pub decimal: Option<char>,
    /// The sheet of an Excel workbook.
    pub sheet: Option<String>,
    /// Propose a map and write nothing.
    pub guess: bool,
}

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    for source in &args.source {
        if !source.exists() {
            bail!("there is nothing at '{}'", source.display());
        }
    }
    let format = args.from;
    if args.guess {
        return guess(args);
    }
    let (options, map_files) = options(args)?;
    let sources: Vec<String> = args.source.iter().map(|s| s.display().to_string()).collect();
    let imported = import_with(format, &args.source, &options)
        .with_context(|| format!("importing '{}' as {}", sources.join("', '"), format.name()))?;
    let records = if args.parquet { RecordsFormat::Parquet } else { RecordsFormat::Csv };
    let mut config = serde_json::json!({ "from": format.name(), "parquet": args.parquet });
    if !options.is_default() {
        config["options"] = serde_json::to_value(&options).context("writing the options")?;
    }
    let manifest =
        Manifest::new("import", config, None).with_inputs(args.source.iter().chain(&map_files))?;

    let output = OutputFolder::begin(&args.out, manifest)?;
    write_folder(&imported.cohort, output.path(), records).context("writing the cohort")?;
    output.write_document(&imported.report)?;
    let place = output.finish()?;
    imported.report.lines().for_each(note);
    for inference in imported.report.inferences.iter().flatten() {
        note(format!("inferred: {inference}"));
    }
    let findings: usize = imported.report.people.iter().map(|p| p.findings.len()).sum();
    note(format!(
        "import: {}, {} and {} in {}",
        count(imported.cohort.people.len(), "person", "people"),
        count(imported.report.notes.len(), "note", "notes"),
        count(findings, "finding", "findings"),
        place.join(ImportReport::FILE).display()
    ));
    Ok(())
}

/// What was said about the tables, and the files that say it.
fn options(args: &Settings) -> Result<(TableOptions, Vec<PathBuf>)> {
    let mut options = TableOptions::default();
    let mut files = Vec::new();
    for map in &args.map {
        let path = Path::new(map);
        if map.contains('=') && !path.exists() {
            options.add_map(map)?;
            continue;
        }
        if !path.is_file() {
            bail!("--map {map}: neither COLUMN=NAME nor a file; give a map or a TOML file of it");
        }
        let size = fs::metadata(path).with_context(|| format!("--map {map}"))?.len();
        if size > LARGEST_MAP {
            bail!("--map {map}: {size} bytes are no map");
        }
        let text = fs::read_to_string(path).with_context(|| format!("--map {map}"))?;
        let of_file = TableOptions::from_toml(&text, map)?;
        files.push(path.to_owned());
        options.columns.extend(of_file.columns);
        options.units.extend(of_file.units);
        options.only.extend(of_file.only);
        options.zone = of_file.zone.or(options.zone);
        options.utc |= of_file.utc;
        options.dates = of_file.dates.or(options.dates);
        options.decimal = of_file.decimal.or(options.decimal);
        options.sheet = of_file.sheet.or(options.sheet);
    }
    for unit in &args.unit {
        options.add_unit(unit)?;
    }
    options.zone = args.zone.clone().or(options.zone);
    options.utc |= args.utc;
    options.dates = args.dates.or(options.dates);
    options.decimal = args.decimal.or(options.decimal);
    options.sheet = args.sheet.clone().or(options.sheet);
    Ok((options, files))
}

/// Says what the columns seem to hold, and the command that would read them so.
fn guess(args: &Settings) -> Result<()> {
    if args.from != ImportFormat::Table {
        bail!("--guess: the columns of {} are known; use it with --from table", args.from.name());
    }
    ensure!(!json_is_asked_for(), "--json: a proposal is no JSON; leave it out with --guess");
    let guess =
        guess_table(&args.source, args.sheet.as_deref()).context("looking at the tables")?;
    for line in &guess.lines {
        table(line);
    }
    if !guess.missing.is_empty() {
        let missing: Vec<&str> = guess.missing.iter().map(|role| role.name()).collect();
        bail!("no column looks like {}; map it by hand with --map", missing.join(" or "));
    }
    let units = match guess.units.as_str() {
        "" => String::new(),
        units => format!(" --unit {units}"),
    };
    note("a proposal, to be judged by you; several people in one file need person=COL:");
    table(format!("  --map \"{}\"{units}", guess.map));
    Ok(())
}
