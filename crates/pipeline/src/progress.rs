//! Progress on everything that takes longer than a moment.
//!
//! On a terminal a bar with count, rate and time left; otherwise plain lines now and then; nothing
//! with `-q`.

use std::io::{IsTerminal as _, Write as _};
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use anyhow::Result;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

static QUIET: AtomicBool = AtomicBool::new(false);
/// How results are printed: [`TABLES`], [`JSON`] or [`NOTHING`].
static RESULTS: AtomicU8 = AtomicU8::new(TABLES);
const TABLES: u8 = 0;
const JSON: u8 = 1;
const NOTHING: u8 = 2;

/// How often a plain line is written when the output is not a terminal.
const PLAIN_INTERVAL: Duration = Duration::from_secs(10);

/// Silences progress and notes.
pub fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

/// Writes one line for the person at the terminal.
pub fn note(text: impl AsRef<str>) {
    if !QUIET.load(Ordering::Relaxed) {
        say(text.as_ref());
    }
}

/// Makes the JSON of a result take the place of its tables on the standard output.
pub fn ask_for_json() {
    RESULTS.store(JSON, Ordering::Relaxed);
}

/// Whether the JSON of a result was asked for.
pub(crate) fn json_is_asked_for() -> bool {
    RESULTS.load(Ordering::Relaxed) == JSON
}

/// Prints neither tables nor JSON, until [`ask_for_json`].
pub(crate) fn print_no_results() {
    RESULTS.store(NOTHING, Ordering::Relaxed);
}

/// Writes a result's table to the standard output, unless its JSON was asked for.
pub fn table(text: impl AsRef<str>) {
    if RESULTS.load(Ordering::Relaxed) == TABLES {
        print(text.as_ref().trim_end_matches('\n').as_bytes());
    }
}

/// Writes to the standard output. That nobody reads on is no reason to lose the work.
pub(crate) fn print(bytes: &[u8]) {
    let mut out = std::io::stdout().lock();
    let _ = out.write_all(bytes).and_then(|()| out.write_all(b"\n")).and_then(|()| out.flush());
}

/// Writes one line to standard error. That nobody listens is no reason to lose the work.
pub fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{}", plain(line));
}

/// An error with its causes, each said once.
#[must_use]
pub fn in_words(error: &anyhow::Error) -> String {
    let mut said: Vec<String> = Vec::new();
    for cause in error.chain() {
        let cause = plain(&cause.to_string());
        if !said.iter().any(|before| before.contains(&cause)) {
            said.push(cause);
        }
    }
    said.join(": ")
}

/// Without the numbers of the operating system's errors, which say nothing to a reader.
fn plain(text: &str) -> String {
    const NUMBER: &str = " (os error ";
    let mut parts = text.split(NUMBER);
    let mut plain = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let rest = part.trim_start_matches(|c: char| c.is_ascii_digit());
        match rest.strip_prefix(')') {
            // The hidden folder in which a temporary file could not be made.
            Some(rest) => plain += rest.split(" at path \"").next().unwrap_or_default(),
            None => plain = plain + NUMBER + part,
        }
    }
    plain
}

/// Progress of one stage over `total` items.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    plain: Option<std::sync::Mutex<Instant>>,
}

impl Progress {
    /// Begins a stage.
    #[must_use]
    pub fn begin(label: &str, total: usize) -> Self {
        let quiet = QUIET.load(Ordering::Relaxed);
        let terminal = std::io::stderr().is_terminal();
        let bar = ProgressBar::new(total as u64);
        if quiet || !terminal {
            bar.set_draw_target(ProgressDrawTarget::hidden());
        }
        let style = ProgressStyle::with_template(
            "{prefix:>12} [{bar:30}] {pos}/{len} {per_sec} left {eta} {msg}",
        )
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("=> ");
        bar.set_style(style);
        bar.set_prefix(label.to_owned());
        let plain = (!quiet && !terminal).then(|| std::sync::Mutex::new(Instant::now()));
        Self { bar, plain }
    }

    /// One more item is done; `message` says what is known so far.
    pub fn advance(&self, message: &str) {
        self.bar.inc(1);
        self.bar.set_message(message.to_owned());
        let Some(plain) = &self.plain else { return };
        let Ok(mut last) = plain.lock() else { return };
        if last.elapsed() >= PLAIN_INTERVAL {
            *last = Instant::now();
            let (done, all) = (self.bar.position(), self.bar.length().unwrap_or_default());
            note(format!("{}: {done}/{all} {message}", self.bar.prefix()));
        }
    }

    /// [`in_threads`], and each item that is done is one more.
    pub(crate) fn each<T: Send>(
        &self,
        count: usize,
        work: impl Fn(usize) -> Result<T> + Sync,
    ) -> Result<Vec<T>> {
        in_threads(count, |index| work(index).inspect(|_| self.advance("")))
    }

    /// The stage is over.
    pub fn finish(self, summary: &str) {
        let seconds = self.bar.elapsed().as_secs_f64();
        self.bar.finish_and_clear();
        note(format!("{}: {summary} ({seconds:.1} s)", self.bar.prefix()));
    }
}

/// Does `count` items on all threads and returns what they give, in their order; the error is that of the first
/// item that has one.
///
/// The threads are its own. A thread of rayon that waits for another pool, such as that of polars, meanwhile begins
/// the next item on the same stack, and the one after that (decision 0061).
pub(crate) fn in_threads<T: Send>(
    count: usize,
    work: impl Fn(usize) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let (next, failed) = (AtomicUsize::new(0), AtomicBool::new(false));
    let some = || {
        let mut done = Vec::new();
        while !failed.load(Ordering::Relaxed) {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= count {
                break;
            }
            let result = work(index);
            failed.fetch_or(result.is_err(), Ordering::Relaxed);
            done.push((index, result));
        }
        done
    };
    let mut done = std::thread::scope(|scope| {
        let threads = rayon::current_num_threads().min(count);
        let threads: Vec<_> = (0..threads).map(|_| scope.spawn(some)).collect();
        let ended = threads.into_iter().map(|thread| thread.join());
        ended.flat_map(|done| done.unwrap_or_else(|panic| resume_unwind(panic))).collect::<Vec<_>>()
    });
    done.sort_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use anyhow::Context as _;

    use super::*;

    #[test]
    fn items_come_in_their_order_and_none_begins_on_the_stack_of_another() {
        thread_local!(static BUSY: std::cell::Cell<bool> = const { std::cell::Cell::new(false) });
        let other = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool");
        let waited = in_threads(40, |index| {
            anyhow::ensure!(!BUSY.replace(true), "item {index} on the stack of another");
            other.install(|| std::thread::sleep(Duration::from_millis(1)));
            BUSY.set(false);
            Ok(index)
        });
        assert_eq!(waited.expect("all done"), Vec::from_iter(0..40));
        assert!(in_threads(0, Ok).expect("nothing to do").is_empty());
    }

    #[test]
    fn the_error_is_that_of_the_first_item_that_has_one() {
        for _ in 0..20 {
            let said = in_threads(40, |index| {
                if index < 7 {
                    return Ok(());
                }
                // The first to fail is the last to say so.
                std::thread::sleep(Duration::from_millis(if index == 7 { 3 } else { 0 }));
                anyhow::bail!("item {index}")
            });
            assert_eq!(said.expect_err("items fail").to_string(), "item 7");
        }
    }

    #[test]
    fn numbers_of_the_system_are_left_out_and_causes_said_once() {
        let source = std::io::Error::from_raw_os_error(2);
        let inner = anyhow::Error::new(source).context("x.csv: No such file or directory");
        let error = Err::<(), _>(inner).context("the cohort").expect_err("an error");
        assert_eq!(in_words(&error), "the cohort: x.csv: No such file or directory");
        let place = "cannot write: Denied (os error 13) at path \"/a/.building-1\"";
        assert_eq!(plain(place), "cannot write: Denied");
        assert_eq!(plain("a (os error b) c"), "a (os error b) c");
    }
}
