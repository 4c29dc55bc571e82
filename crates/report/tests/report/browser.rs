//! The page in a browser: nothing in the console, every figure wide enough with text that can be read and lies
//! within it, no scrolling sideways, enough contrast, in light, dark and print. Runs where `chromium` is on the
//! path.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::made_up;
use crate::reading::page;

const BROWSER: &str = "chromium";
/// Longer than any browser needs to start.
const PATIENCE: Duration = Duration::from_secs(60);
/// Least contrast of text (WCAG 2.2, level AA).
const CONTRAST: f64 = 4.5;
/// Least height of letters in figures, CSS pixels.
const LETTERS: f64 = 11.0;

/// Width from which on no table has to be scrolled, CSS pixels.
const ROOMY: u32 = 1000;

/// How the page is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Look {
    Light,
    Dark,
    Print,
}

impl Look {
    /// The page as this look shows it whatever the browser prefers: the rules of the others are taken out
    /// of effect, its own hold.
    fn of(self, html: &str) -> String {
        const DARK: &str = "@media screen and (prefers-color-scheme: dark)";
        const PRINT: &str = "@media print";
        assert_eq!((html.matches(DARK).count(), html.matches(PRINT).count()), (1, 1));
        let (dark, print) = match self {
            Self::Light => ("@media not all", "@media not all"),
            Self::Dark => ("@media all", "@media not all"),
            Self::Print => ("@media not all", "@media all"),
        };
        html.replace(DARK, dark).replace(PRINT, print)
    }
}

/// What the browser measures on a page, in the words of `measure.html`.
fn measured(folder: &Path, width: u32, html: &str) -> Value {
    fs::create_dir_all(folder).expect("cargo's folder for tests");
    let write = |name: &str, text: &str| fs::write(folder.join(name), text).expect("a folder");
    write("report.html", html);
    write("frame.html", &include_str!("measure.html").replace("WIDTH", &width.to_string()));
    let file = |name: &str| fs::File::create(folder.join(name)).expect("a folder");
    let mut browser = Command::new(BROWSER)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr"])
        .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
        .args(["--no-first-run", "--allow-file-access-from-files"])
        .args(["--virtual-time-budget=10000", "--dump-dom"])
        .arg(format!("--user-data-dir={}", folder.join("profile").display()))
        .arg(format!("file://{}", folder.join("frame.html").display()))
        .stdout(Stdio::from(file("seen.html")))
        .stderr(Stdio::from(file("log")))
        .spawn()
        .expect("the browser starts");
    let begun = Instant::now();
    while browser.try_wait().expect("a process of ours").is_none() {
        if begun.elapsed() > PATIENCE {
            browser.kill().expect("a process of ours");
            panic!("the browser does not end");
        }
        sleep(Duration::from_millis(50));
    }
    let log = fs::read_to_string(folder.join("log")).expect("a log");
    let console: Vec<&str> = log.lines().filter(|line| line.contains(":CONSOLE")).collect();
    assert!(console.is_empty(), "{console:?}");
    let seen = fs::read_to_string(folder.join("seen.html")).expect("what was seen");
    let (_, found) = seen.split_once("id=\"found\">").expect("the measurements");
    let (found, _) = found.split_once("</p>").expect("their end");
    let found = found.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    serde_json::from_str(&found).unwrap_or_else(|error| panic!("{error}: {found}"))
}

/// Whether the browser is there; says so where it is not.
fn is_installed() -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let there = std::env::split_paths(&path).any(|folder| folder.join(BROWSER).is_file());
    if !there {
        #[expect(clippy::print_stderr, reason = "a skipped test must say that it was skipped")]
        {
            eprintln!("skipped: {BROWSER} is not on the path");
        }
    }
    there
}

/// What is wrong with the page at a width, a line each.
fn faults(html: &str, width: u32, look: Look) -> Vec<String> {
    let name = format!("browser-{width}-{look:?}");
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let found = measured(&folder, width, &look.of(html));
    let number = |key: &str| found[key].as_f64().unwrap_or_else(|| panic!("{key}: {found}"));
    let mut faults = Vec::new();
    let mut fault = |wrong: bool, words: String| {
        if wrong {
            faults.push(format!("at {width} px, {look:?}: {words}"));
        }
    };
    fault(number("sideways") > 0.0, format!("scrolls sideways by {} px", found["sideways"]));
    let figures = html.matches("<figure>").count() as f64;
    fault(number("figures") != figures, format!("{} figures of {figures}", found["figures"]));
    for list in ["narrow", "out", "clipped"] {
        fault(found[list] != serde_json::json!([]), format!("{list}: {}", found[list]));
    }
    if width >= ROOMY {
        let scrolled = &found["scrolled"];
        fault(*scrolled != serde_json::json!([]), format!("tables scroll: {scrolled}"));
    }
    fault(number("letters") < LETTERS, format!("letters of {} px", found["letters"]));
    let ratio = found["contrast"]["ratio"].as_f64().expect("a ratio");
    fault(ratio < CONTRAST, format!("contrast: {}", found["contrast"]));
    faults
}

#[test]
fn a_page_fits_its_window_and_can_be_read() {
    if !is_installed() {
        return;
    }
    let html = page(&made_up::parts());
    let screens = [400, 800, 1000, 1200]
        .into_iter()
        .flat_map(|width| [(width, Look::Light), (width, Look::Dark)]);
    // The width of A4 between its margins.
    let shown = screens.chain([(720, Look::Print)]);
    let faults: Vec<String> = shown.flat_map(|(width, look)| faults(&html, width, look)).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn faults_are_seen() {
    if !is_installed() {
        return;
    }
    // What the measurements are for, each fault once.
    let fault = "<section id=\"verdict\"><p style=\"color:#999;width:900px\">pale and wide</p><figure><svg \
        viewBox=\"0 0 1000 100\"><text x=\"950\" y=\"50\" font-size=\"9\">far beyond the edge of it</text></svg>\
        </figure>";
    let html = page(&made_up::parts()).replacen("<section id=\"verdict\">", fault, 1);
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("browser-faults");
    let found = measured(&folder, 400, &Look::Light.of(&html));
    assert!(found["sideways"].as_f64().is_some_and(|beyond| beyond > 100.0), "{found}");
    assert!(found["letters"].as_f64().is_some_and(|letters| letters < LETTERS), "{found}");
    assert!(found["contrast"]["ratio"].as_f64().is_some_and(|ratio| ratio < CONTRAST), "{found}");
    assert_eq!(found["contrast"]["text"], "pale and wide");
    assert!(found["clipped"].to_string().contains("far beyond"), "{found}");
}
