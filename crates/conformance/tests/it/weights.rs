//! Reads the published `.pt` file far enough for these tests: a ZIP archive of uncompressed
//! entries `.../data/N`, each a little-endian f32 array. Their order and shapes are those of the
//! state dictionary: for each network in turn, w1 (hidden x inputs), b1, w2 (1 x hidden), b2 (1).

use std::collections::HashMap;

use conformance::OneHiddenLayer;

/// Networks in the order of the state dictionary, each with its inputs in the order of its columns.
const NETWORKS: [(&str, &[&str]); 10] = [
    ("S1", &["S1", "u_insulin"]),
    ("S2", &["S1", "S2"]),
    ("I", &["S2", "I"]),
    ("X1", &["I", "X1"]),
    ("X2", &["I", "X2"]),
    ("X3", &["I", "X3"]),
    ("Q1", &["X1", "X3", "Q1", "Q2", "C2"]),
    ("Q2", &["X1", "X2", "Q1", "Q2"]),
    ("C2", &["C1", "C2"]),
    ("C1", &["C1", "u_carbs"]),
];

/// The ten published networks, or `None` (after a message) without the reference material.
pub(crate) fn published(test: &str) -> Option<Vec<OneHiddenLayer>> {
    let path = reference_data::find("t1dsim_ai/population_model_05022024_epoch_15.pt", test)?;
    let bytes = std::fs::read(path).expect("reference file is readable");
    let arrays = stored_arrays(&bytes);
    let array = |index: usize| arrays[&index].clone();
    let networks = NETWORKS.iter().enumerate().map(|(n, (output, inputs))| {
        let inputs: Vec<String> = inputs.iter().map(|&name| name.to_owned()).collect();
        let [w1, b1, w2] = [0, 1, 2].map(|part| array(4 * n + part));
        let b2 = array(4 * n + 3)[0];
        OneHiddenLayer::new(*output, inputs, w1, b1, w2, b2).expect("published shapes")
    });
    Some(networks.collect())
}

/// The arrays of all entries `.../data/N` by N, found through the archive's central directory.
fn stored_arrays(zip: &[u8]) -> HashMap<usize, Vec<f64>> {
    let u16_at = |at: usize| usize::from(u16::from_le_bytes([zip[at], zip[at + 1]]));
    let u32_at = |at: usize| u16_at(at) | u16_at(at + 2) << 16;
    let end = (0..zip.len() - 21)
        .rev()
        .find(|&at| zip[at..].starts_with(b"PK\x05\x06"))
        .expect("end of central directory");
    let mut at = u32_at(end + 16);
    let mut arrays = HashMap::new();
    for _ in 0..u16_at(end + 10) {
        assert!(zip[at..].starts_with(b"PK\x01\x02"), "central directory entry");
        let (method, size) = (u16_at(at + 10), u32_at(at + 24));
        let (name_length, local) = (u16_at(at + 28), u32_at(at + 42));
        let name = String::from_utf8_lossy(&zip[at + 46..at + 46 + name_length]).into_owned();
        let start = local + 30 + u16_at(local + 26) + u16_at(local + 28);
        if let Some(index) = name.split("/data/").nth(1).and_then(|index| index.parse().ok()) {
            assert_eq!(method, 0, "{name} is stored, not compressed");
            let floats = zip[start..start + size].chunks_exact(4);
            let values = floats.map(|b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])));
            arrays.insert(index, values.collect());
        }
        at += 46 + name_length + u16_at(at + 30) + u16_at(at + 32);
    }
    arrays
}
