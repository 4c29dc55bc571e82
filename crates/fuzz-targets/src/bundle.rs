//! Several files as one run of bytes.

/// What stands before the name of a file; the name ends at the end of its line.
const MARK: &[u8] = b"\n\x01file ";

/// Packs files: name and content.
#[must_use]
pub fn pack(files: &[(String, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (name, content) in files {
        bytes.extend_from_slice(MARK);
        bytes.extend_from_slice(name.as_bytes());
        bytes.push(b'\n');
        bytes.extend_from_slice(content);
    }
    bytes
}

/// The files of packed bytes. What stands before the first name, and files whose name leads out of
/// their folder, are left out.
#[must_use]
pub fn unpack(bytes: &[u8]) -> Vec<(String, &[u8])> {
    let starts: Vec<usize> = (0..bytes.len()).filter(|at| bytes[*at..].starts_with(MARK)).collect();
    let ends = starts.iter().skip(1).copied().chain([bytes.len()]);
    let files = starts.iter().zip(ends).filter_map(|(start, end)| {
        let file = &bytes[start + MARK.len()..end];
        let line = file.iter().position(|byte| *byte == b'\n')?;
        let name = std::str::from_utf8(&file[..line]).ok()?;
        let inside = !name.is_empty()
            && name.split('/').all(|part| !matches!(part, "" | "." | ".."))
            && !name.contains('\0');
        inside.then(|| (name.to_owned(), &file[line + 1..]))
    });
    files.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_come_back_and_names_stay_inside() {
        let files = [("a.csv".to_owned(), b"x,y\n".to_vec()), ("b/c".to_owned(), Vec::new())];
        let packed = pack(&files);
        let back: Vec<_> = unpack(&packed).into_iter().map(|(n, b)| (n, b.to_vec())).collect();
        assert_eq!(back, files);
        for name in ["../a", "/a", "a/../b", ""] {
            assert!(unpack(&pack(&[(name.to_owned(), Vec::new())])).is_empty(), "{name}");
        }
    }
}
