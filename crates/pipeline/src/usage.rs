//! Processor time and memory of this process.

use std::fs;

/// Processor time of this process so far, where the system tells it (Linux).
#[must_use]
pub fn processor_seconds() -> Option<f64> {
    let stat = fs::read_to_string("/proc/self/stat").ok()?;
    // The name of the program stands in brackets and may hold anything.
    let (_, rest) = stat.rsplit_once(')')?;
    let ticks = |place: usize| rest.split_whitespace().nth(place)?.parse::<f64>().ok();
    // Fields 14 and 15 of proc(5), of which two stand before; Linux counts 100 ticks a second.
    Some((ticks(11)? + ticks(12)?) / 100.0)
}

/// Largest resident memory so far, where the system tells it (Linux).
#[must_use]
pub fn peak_mib() -> Option<f64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: f64 = line.split_whitespace().next()?.parse().ok()?;
    Some(kibibytes / 1024.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Instant;

    #[test]
    fn memory_and_processor_time_are_told_where_the_system_tells_them() {
        if std::path::Path::new("/proc/self/status").exists() {
            assert!(peak_mib().is_some_and(|peak| peak > 1.0));
            let before = processor_seconds().expect("as the status");
            let clock = Instant::now();
            while clock.elapsed().as_secs_f64() < 0.1 {
                std::hint::black_box(processor_seconds());
            }
            assert!(processor_seconds().expect("as before") > before);
        }
    }
}
