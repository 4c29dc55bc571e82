//! Truncated, edited and exchanged files of the published kind: plain errors, never a panic.

use std::path::Path;

use nn_statespace::import;
use rand::{RngExt, SeedableRng};

fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).expect("the reference folder is complete")
}

/// Reads some bytes; an error must say something, and an answer must satisfy the reader itself.
type Reader<'a> = &'a dyn Fn(&[u8]) -> Result<(), nn_statespace::ModelError>;

/// Cuts `whole` at many lengths, which must give errors, and edits up to three random bytes, which
/// may give either.
fn check(name: &str, whole: &[u8], read: Reader<'_>, edits: u32) {
    read(whole).expect(name);
    let stride = (whole.len() / 400).max(1);
    for length in (0..whole.len()).step_by(stride) {
        let error = read(&whole[..length]).expect_err("a file that ends early");
        assert!(!error.to_string().is_empty());
    }
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(11);
    let mut refused = 0;
    for _ in 0..edits {
        let mut edited = whole.to_vec();
        for _ in 0..rng.random_range(1..4) {
            let position = rng.random_range(0..edited.len());
            edited[position] = rng.random();
        }
        refused += u32::from(read(&edited).is_err());
    }
    assert!(refused > edits / 2, "{name}: {refused} of {edits}");
}

#[test]
fn damaged_scalers_give_errors() {
    let Some(folder) = reference_data::find("t1dsim_ai", "damaged_scalers") else { return };
    let whole = bytes(&folder, "Model0826/scaler_robust.pkl");
    let read = |bytes: &[u8]| import::heart_rate_scaler(bytes).map(drop);
    check("heart rate", &whole, &read, 20_000);
    let inputs = bytes(&folder, "scaler_inputs.pkl");
    let states = bytes(&folder, "scaler_states.pkl");
    check("states", &states, &|bytes| import::scaler(bytes, &inputs).map(drop), 20_000);
}

#[test]
fn damaged_weights_give_errors() {
    let Some(folder) = reference_data::find("t1dsim_ai", "damaged_weights") else { return };
    let (states, inputs) =
        (bytes(&folder, "scaler_states.pkl"), bytes(&folder, "scaler_inputs.pkl"));
    let whole = bytes(&folder, "population_model_05022024_epoch_15.pt");
    let original = import::population(&whole, &states, &inputs).expect("undamaged");
    let read = |bytes: &[u8]| {
        // Whatever is accepted, with edits in padding and dates, has the same weights: each entry
        // has a checksum.
        let model = import::population(bytes, &states, &inputs)?;
        assert!(model == original, "an edit changed the weights unnoticed");
        Ok(())
    };
    check("population", &whole, &read, 1_000);
    let read = |bytes: &[u8]| import::population(bytes, &states, &inputs).map(drop);
    // Edits of the pickle itself are caught by the checksum; make that fit again, so that they
    // reach the reader of pickles.
    let start = whole.windows(2).position(|pair| pair == b"\x80\x02").expect("a pickle");
    let length = 4642;
    let crc_of = |bytes: &[u8]| -> u32 {
        !bytes.iter().fold(u32::MAX, |crc, byte| {
            (0..8).fold(crc ^ u32::from(*byte), |c, _| {
                (c >> 1) ^ (0xEDB8_8320 & (c & 1).wrapping_neg())
            })
        })
    };
    let stored = crc_of(&whole[start..start + length]).to_le_bytes();
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(12);
    let mut refused = 0;
    for _ in 0..1_000 {
        let mut edited = whole.clone();
        let position = start + rng.random_range(0..length);
        edited[position] = rng.random();
        let crc = crc_of(&edited[start..start + length]).to_le_bytes();
        let places: Vec<usize> =
            (0..whole.len() - 4).filter(|at| whole[*at..at + 4] == stored).collect();
        for place in places {
            edited[place..place + 4].copy_from_slice(&crc);
        }
        refused += u32::from(read(&edited).is_err());
    }
    // Some edits hit what has no meaning to a reader (memory places, module attributes).
    assert!(refused > 500, "{refused} of 1000");
}

#[test]
fn exchanged_files_are_told_apart() {
    let Some(folder) = reference_data::find("t1dsim_ai", "exchanged_files") else { return };
    let population = bytes(&folder, "population_model_05022024_epoch_15.pt");
    let individual = bytes(&folder, "Model0826/individual_model.pt");
    let states = bytes(&folder, "scaler_states.pkl");
    let inputs = bytes(&folder, "scaler_inputs.pkl");
    let cases: [(Result<(), nn_statespace::ModelError>, &str); 5] = [
        (
            import::population(&individual, &states, &inputs).map(drop),
            "tensor net_dS1.0.bias: not in the file; is this the right kind of model?",
        ),
        (
            import::individual_network(&population).map(drop),
            "tensor net_model.0.bias: not in the file; is this the right kind of model?",
        ),
        (
            import::population(&population, &inputs, &states).map(drop),
            "tensor center_: expected shape [10], found [2]; is this the right file?",
        ),
        (
            import::heart_rate_scaler(&states).map(drop),
            "tensor center_: expected shape [1], found [10]; is this the right file?",
        ),
        (
            import::population(&states, &states, &inputs).map(drop),
            "archive, offset 547: the end record of a ZIP archive is not there; is the file \
             complete?",
        ),
    ];
    for (result, expected) in cases {
        assert_eq!(result.expect_err(expected).to_string(), expected);
    }
}
