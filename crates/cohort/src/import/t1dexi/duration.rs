//! Durations of ISO 8601, like `PT5M` or `P0DT0H30M15.5S`.

/// Whole seconds; `None` for anything else, also for years and months, and above 10 days.
pub(super) fn seconds(text: &str) -> Option<i64> {
    let mut rest = text.strip_prefix('P')?;
    let mut in_time = false;
    let mut seconds = 0.0;
    let mut parts = 0;
    while !rest.is_empty() {
        if !in_time && let Some(time) = rest.strip_prefix('T') {
            (in_time, rest) = (true, time);
            continue;
        }
        let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.')?;
        let value: f64 = rest[..end].parse().ok()?;
        let unit = match (in_time, rest.as_bytes()[end]) {
            (false, b'W') => 604_800.0,
            (false, b'D') => 86_400.0,
            (true, b'H') => 3600.0,
            (true, b'M') => 60.0,
            (true, b'S') => 1.0,
            _ => return None,
        };
        seconds += value * unit;
        parts += 1;
        rest = &rest[end + 1..];
    }
    (parts > 0 && seconds <= 864_000.0).then_some(seconds.round() as i64)
}

#[cfg(test)]
mod tests {
    use super::seconds;

    #[test]
    fn durations_are_read_and_others_refused() {
        for (text, value) in [
            ("PT5M", Some(300)),
            ("P0DT1H30M0S", Some(5400)),
            ("PT299.6S", Some(300)),
            ("P1D", Some(86_400)),
            ("PT0S", Some(0)),
            ("P1Y", None),
            ("P1M", None),
            ("PT", None),
            ("5M", None),
            ("PT-5M", None),
            ("PT1é", None),
            ("P99999D", None),
        ] {
            assert_eq!(seconds(text), value, "{text}");
        }
    }
}
