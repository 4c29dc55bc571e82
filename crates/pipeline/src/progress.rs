//! Progress on everything that takes longer than a moment.
//!
//! On a terminal a bar with count, rate and time left; otherwise plain lines now and then; nothing
//! with `-q`.

use std::io::{IsTerminal as _, Write as _};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

static QUIET: AtomicBool = AtomicBool::new(false);

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

/// Writes one line to standard error. That nobody listens is no reason to lose the work.
pub fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Progress of one stage over `total` items.
#[derive(Debug)]
pub struct Progress {
    label: String,
    bar: ProgressBar,
    plain: Option<std::sync::Mutex<Instant>>,
    total: u64,
}

impl Progress {
    /// Begins a stage.
    #[must_use]
    pub fn begin(label: &str, total: usize) -> Self {
        let total = total as u64;
        let quiet = QUIET.load(Ordering::Relaxed);
        let terminal = std::io::stderr().is_terminal();
        let bar = ProgressBar::with_draw_target(
            Some(total),
            if quiet || !terminal {
                ProgressDrawTarget::hidden()
            } else {
                ProgressDrawTarget::stderr()
            },
        );
        let style = ProgressStyle::with_template(
            "{prefix:>12} [{bar:30}] {pos}/{len} {per_sec} left {eta} {msg}",
        )
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("=> ");
        bar.set_style(style);
        bar.set_prefix(label.to_owned());
        let plain = (!quiet && !terminal).then(|| std::sync::Mutex::new(Instant::now()));
        Self { label: label.to_owned(), bar, plain, total }
    }

    /// One more item is done; `message` says what is known so far.
    pub fn advance(&self, message: &str) {
        self.bar.inc(1);
        self.bar.set_message(message.to_owned());
        let Some(plain) = &self.plain else { return };
        let Ok(mut last) = plain.lock() else { return };
        if last.elapsed() >= PLAIN_INTERVAL {
            *last = Instant::now();
            note(format!("{}: {}/{} {message}", self.label, self.bar.position(), self.total));
        }
    }

    /// The stage is over.
    pub fn finish(self, summary: &str) {
        let seconds = self.bar.elapsed().as_secs_f64();
        self.bar.finish_and_clear();
        note(format!("{}: {summary} ({seconds:.1} s)", self.label));
    }
}
