//! The page in a browser: nothing in the console, figures as wide as the page, no scrolling
//! sideways on a phone. Runs where `chromium` is on the path.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::made_up;
use crate::reading::page;

const BROWSER: &str = "chromium";
/// Longer than any browser needs to start.
const PATIENCE: Duration = Duration::from_secs(60);

/// What the browser found on a page, in the words of `FRAME`.
fn seen(folder: &Path, width: u32, html: &str) -> String {
    let write = |name: &str, text: &str| fs::write(folder.join(name), text).expect("a folder");
    write("report.html", html);
    write("frame.html", &FRAME.replace("WIDTH", &width.to_string()));
    let file = |name: &str| fs::File::create(folder.join(name)).expect("a folder");
    let mut browser = Command::new(BROWSER)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr"])
        .args(["--allow-file-access-from-files", "--virtual-time-budget=10000", "--dump-dom"])
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
    fs::read_to_string(folder.join("seen.html")).expect("what was seen")
}

/// A page that shows the report in a frame of a given width and prints its measurements.
const FRAME: &str = "<!DOCTYPE html><body><iframe id=\"frame\" src=\"report.html\" \
    style=\"width:WIDTHpx;height:800px;border:0\"></iframe><p id=\"found\"></p><script>
document.getElementById('frame').onload = () => {
  const page = document.getElementById('frame').contentDocument;
  page.querySelectorAll('details').forEach(d => d.open = true);
  const root = page.documentElement;
  const figures = [...page.querySelectorAll('figure > svg')];
  const narrow = figures.filter(f => f.getBoundingClientRect().width < 0.8 * Math.min(WIDTH, 640));
  const boxes = [...page.querySelectorAll('.scroll')];
  const out = boxes.filter(b => b.getBoundingClientRect().right > root.clientWidth + 1);
  document.getElementById('found').textContent = 'sideways ' + (root.scrollWidth - root.clientWidth)
    + ', figures ' + figures.length + ', narrow ' + narrow.length + ', boxes out ' + out.length;
};
</script></body>";

#[test]
fn a_page_fits_its_window() {
    let path = std::env::var_os("PATH").unwrap_or_default();
    if !std::env::split_paths(&path).any(|folder| folder.join(BROWSER).is_file()) {
        #[expect(clippy::print_stderr, reason = "a skipped test must say that it was skipped")]
        {
            eprintln!("skipped: {BROWSER} is not on the path");
        }
        return;
    }
    let html = page(&made_up::parts());
    let figures = html.matches("<figure>").count();
    for width in [360, 400, 1200] {
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("browser-{width}"));
        fs::create_dir_all(&folder).expect("cargo's folder for tests");
        let seen = seen(&folder, width, &html);
        let expected = format!("sideways 0, figures {figures}, narrow 0, boxes out 0");
        let found = seen.split_once("id=\"found\">").map_or("", |(_, found)| found);
        assert!(found.starts_with(&expected), "at {width} px: {found:.80}, expected {expected}");
    }
}
