//! Runs a case in a process of its own and judges how it ended.

use std::fs::{self, File};
use std::os::unix::fs::MetadataExt as _;
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use super::case::{Case, text};

/// Longest time of a case.
const LONGEST: Duration = Duration::from_secs(10);
/// Largest peak of memory, MiB.
const LARGEST_MIB: u64 = 1024;
/// The user and group without rights.
const NOBODY: u32 = 65_534;
/// How often a process is looked after: often enough to see a gibibyte being filled.
const PAUSE: Duration = Duration::from_millis(2);
/// What no message for a user holds.
const NEVER: [&str; 8] = [
    "panicked",
    "RUST_BACKTRACE",
    "unwrap",
    "Os {",
    "memory allocation",
    "stack overflow",
    "polars",
    "(os error",
];

/// How a case ended.
pub(super) struct Ended {
    pub(super) message: String,
    pub(super) seconds: f64,
    pub(super) peak_mib: u64,
    pub(super) faults: Vec<String>,
}

/// Runs the case.
pub(super) fn run(case: &Case, scratch: &Path) -> Ended {
    let (said, printed) = (scratch.join("stderr"), scratch.join("stdout"));
    let mut command = if case.ordinary {
        as_ordinary_user(scratch)
    } else {
        Command::new(env!("CARGO_BIN_EXE_t1d-twins"))
    };
    command.args(&case.arguments);
    if case.out {
        command.args(["--out", &text(&case.apart.join("out"))]);
    }
    let child = command
        .arg("-q")
        .current_dir(scratch)
        .stdin(Stdio::null())
        .stdout(File::create(&printed).expect("writable"))
        .stderr(File::create(&said).expect("writable"))
        .spawn()
        .expect("the program starts");
    let (status, seconds, peak_mib) = wait(child);
    let message = String::from_utf8_lossy(&fs::read(&said).expect("written")).into_owned();
    let mut faults = Vec::new();
    match status {
        None => faults.push(format!("stopped after {seconds:.1} s with {peak_mib} MiB")),
        Some(status) if status != Some(case.status) => {
            faults.push(format!("status {status:?} in place of {}", case.status));
        }
        Some(_) => {}
    }
    if !message.lines().any(|line| line.starts_with("error: ")) {
        faults.push("no line begins with 'error: '".to_owned());
    }
    for never in NEVER.iter().filter(|never| message.contains(**never)) {
        faults.push(format!("the message holds '{never}'"));
    }
    for word in case.words.iter().filter(|word| !message.contains(word.as_str())) {
        faults.push(format!("the message lacks '{word}'"));
    }
    if message.len() > 4000 {
        faults.push(format!("the message has {} bytes", message.len()));
    }
    for path in entries(&case.apart) {
        faults.push(format!("left behind: '{}'", path.display()));
    }
    Ended { message: message.trim().to_owned(), seconds, peak_mib, faults }
}

/// The program, run by nobody in particular where the tests run as root.
fn as_ordinary_user(scratch: &Path) -> Command {
    let mut program = PathBuf::from(env!("CARGO_BIN_EXE_t1d-twins"));
    let is_root = fs::metadata("/proc/self").is_ok_and(|this| this.uid() == 0);
    if !is_root {
        return Command::new(program);
    }
    let of_nobody = |program: &Path| {
        let mut command = Command::new(program);
        command.uid(NOBODY).gid(NOBODY);
        command
    };
    let starts = of_nobody(&program).arg("--version").output();
    if !starts.is_ok_and(|output| output.status.success()) {
        // The build lies where only root can go.
        let copy = scratch.join("t1d-twins");
        fs::copy(&program, &copy).expect("writable");
        program = copy;
    }
    of_nobody(&program)
}

/// Exit status, seconds and largest peak of memory in MiB; no status if the process had to be stopped.
fn wait(mut child: Child) -> (Option<Option<i32>>, f64, u64) {
    let begun = Instant::now();
    let proc = PathBuf::from(format!("/proc/{}/status", child.id()));
    let mut peak = 0;
    loop {
        let ended = child.try_wait().expect("a child").map(|status| status.code());
        peak = peak.max(peak_mib(&proc).unwrap_or(0));
        let too_much = begun.elapsed() > LONGEST || peak > LARGEST_MIB;
        if ended.is_none() && too_much {
            child.kill().expect("a child");
            child.wait().expect("a child");
        }
        if ended.is_some() || too_much {
            return (ended, begun.elapsed().as_secs_f64(), peak);
        }
        std::thread::sleep(PAUSE);
    }
}

/// Peak of the resident memory so far, MiB.
fn peak_mib(status: &Path) -> Option<u64> {
    let status = fs::read_to_string(status).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.split_whitespace().next()?.parse::<u64>().ok().map(|kib| kib / 1024)
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    fs::read_dir(folder)
        .map(|entries| entries.flatten().map(|entry| entry.path()).collect())
        .unwrap_or_default()
}
