//! Certificates by the prover are accepted; what was changed in them, or in the model, is not.

use std::collections::{BTreeMap, HashMap};
use std::time::Duration;

use certificate::{Rejection, check};
use conformance::{
    Direction, Limits, OneHiddenLayer, Property, PropertyKind, Region, Verdict, certify, verify,
};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use safetensors::tensor::{Dtype, TensorView};
use serde_json::{Value, json};
use sha2::{Digest as _, Sha256};

const NAMES: [&str; 5] = ["a", "b", "c", "d", "e"];

/// Weights of a network "N" over the first few of [`NAMES`].
#[derive(Clone)]
struct Weights {
    inputs: usize,
    w1: Vec<f64>,
    b1: Vec<f64>,
    w2: Vec<f64>,
}

impl Weights {
    /// Random, of single precision; the slope by "a" is negative on the whole and not much of it is by itself.
    fn random(inputs: usize, hidden: usize, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut draw = |count: usize| -> Vec<f64> {
            (0..count).map(|_| f64::from(rng.random_range(-1.0_f32..1.0))).collect()
        };
        let (mut w1, mut b1, mut w2) = (draw(inputs * hidden), draw(hidden), draw(hidden));
        for unit in 0..hidden {
            if unit % 3 != 0 {
                let a = &mut w1[unit * inputs];
                *a = -a.abs().copysign(w2[unit]);
            }
        }
        // Two neurons on one hyperplane, seen from both sides.
        for input in 0..inputs {
            w1[inputs + input] = -2.0 * w1[input];
        }
        b1[1] = -2.0 * b1[0];
        w2[1] = -w2[1].abs().copysign(w1[inputs]);
        Self { inputs, w1, b1, w2 }
    }

    fn network(&self) -> OneHiddenLayer {
        let inputs = NAMES[..self.inputs].iter().map(|name| (*name).to_owned()).collect();
        let (w1, b1, w2) = (self.w1.clone(), self.b1.clone(), self.w2.clone());
        OneHiddenLayer::new("N", inputs, w1, b1, w2, 0.5).expect("shapes fit")
    }

    fn file(&self) -> Vec<u8> {
        self.file_wired(&NAMES[..self.inputs])
    }

    fn file_wired(&self, names: &[&str]) -> Vec<u8> {
        let bytes = |values: &[f64]| -> Vec<u8> {
            values.iter().flat_map(|value| (*value as f32).to_le_bytes()).collect()
        };
        let hidden = self.b1.len();
        let parts = [
            ("N.hidden.weight", vec![hidden, self.inputs], bytes(&self.w1)),
            ("N.hidden.bias", vec![hidden], bytes(&self.b1)),
            ("N.output.weight", vec![hidden], bytes(&self.w2)),
        ];
        let views = parts.iter().map(|(name, shape, data)| {
            let view = TensorView::new(Dtype::F32, shape.clone(), data).expect("lengths fit");
            ((*name).to_owned(), view)
        });
        let header = json!({ "wiring": { "N": names } }).to_string();
        let metadata = HashMap::from([("population".to_owned(), header)]);
        safetensors::serialize(views.collect::<BTreeMap<_, _>>(), Some(metadata))
            .expect("plain tensors")
    }
}

fn property() -> Property {
    Property {
        network: "N".to_owned(),
        input: "a".to_owned(),
        direction: Direction::Decreasing,
        kind: PropertyKind::Physical,
    }
}

fn region(inputs: usize) -> Region {
    Region::scaled(NAMES[..inputs].iter().map(|name| (*name, [-1.0, 1.5]))).expect("a box")
}

/// The certificate that the prover writes, sealed; whether the property holds, and the largest slope against it.
fn proved(weights: &Weights) -> (Value, Verdict, f64) {
    proved_over(weights, &region(weights.inputs))
}

fn proved_over(weights: &Weights, region: &Region) -> (Value, Verdict, f64) {
    let network = weights.network();
    let limits = Limits {
        relative_gap: 0.0,
        nodes: 1_000_000,
        time: Duration::from_secs(60),
        cross_check: None,
    };
    let row = verify(&network, &property(), region, &limits, &|| Duration::ZERO).expect("bounded");
    let found = certify(&network, &property(), region, row.m_upper, 1_000_000)
        .expect("bounded")
        .expect("the search came to this bound");
    let file = json!({
        "schema": "certificate/2",
        "half_spaces": region.half_spaces(),
        "bounds": region.iter().collect::<BTreeMap<_, _>>(),
        "certificates": [found],
    });
    (sealed(file, &weights.file()), row.verdict, row.m_upper)
}

fn hash(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The file with the seals that it should have.
fn sealed(mut file: Value, model: &[u8]) -> Value {
    file["model_sha256"] = hash(model).into();
    file.as_object_mut().expect("an object").remove("sha256");
    file["sha256"] = hash(&serde_json::to_vec(&file).expect("plain")).into();
    file
}

fn checked(file: &Value, model: &[u8]) -> Result<f64, Rejection> {
    let accepted = check(&serde_json::to_vec(file).expect("plain"), model)?;
    assert_eq!(accepted.len(), 1);
    let over: BTreeMap<_, _> = accepted[0].over.iter().cloned().collect();
    assert_eq!(json!(over), file["bounds"]);
    Ok(accepted[0].claim)
}

fn tree(file: &mut Value) -> &mut Vec<Value> {
    file["certificates"][0]["tree"].as_array_mut().expect("a tree")
}

/// A certificate with a tree of some size, its weights and its claim.
fn grown() -> (Weights, Value, f64) {
    let mut seeds = (0..100).map(|seed| Weights::random(3, 14, seed));
    seeds
        .find_map(|weights| {
            let (mut file, _, claim) = proved(&weights);
            (tree(&mut file).len() > 20).then_some((weights, file, claim))
        })
        .expect("one of a hundred networks needs splits")
}

/// What a changed file is rejected for: the seal as it is, the proof once it is sealed anew.
fn rejected(changed: Value, model: &[u8], because: &str) {
    let as_it_is = checked(&changed, model);
    assert!(matches!(as_it_is, Err(Rejection::Seal { .. })), "{as_it_is:?}");
    let again = checked(&sealed(changed, model), model);
    let Err(Rejection::Unproved { reason, .. }) = again else { panic!("{again:?}") };
    assert!(reason.contains(because), "{reason}");
}

#[test]
fn accepts_what_the_prover_shows_and_it_is_true() {
    let (mut proofs, mut pairs) = (0, 0);
    for seed in 0..60 {
        let inputs = 2 + seed as usize % 4;
        let weights = Weights::random(inputs, 6 + seed as usize % 12, seed);
        let (file, verdict, claim) = proved(&weights);
        assert_eq!(checked(&file, &weights.file()).expect("a proof"), claim);
        assert_eq!(verdict == Verdict::Proved, claim <= 0.0);
        proofs += usize::from(claim <= 0.0);
        pairs += file.to_string().matches("\"apart\":[[").count();
        // Slopes at random points, by differences too short for a kink to be likely.
        let (network, mut rng) = (weights.network(), ChaCha8Rng::seed_from_u64(seed));
        for _ in 0..200 {
            let mut point: Vec<f64> =
                (0..inputs).map(|_| rng.random_range(-1.0..1.5 - 1e-3)).collect();
            let before = network.evaluate(&point).expect("in the box");
            point[0] += 1e-3;
            let slope = (network.evaluate(&point).expect("in the box") - before) / 1e-3;
            assert!(slope <= claim + 1e-9, "{slope} above {claim}");
        }
    }
    assert!(proofs > 5 && proofs < 55, "{proofs} of 60 properties hold");
    assert!(pairs > 5, "{pairs} leaves need pairs");
}

#[test]
fn rejects_an_edited_weight() {
    let (weights, file, _) = grown();
    let mut edited = weights.clone();
    for unit in 0..edited.b1.len() {
        // Steeper against the property wherever it is active.
        if edited.w2[unit] * edited.w1[unit * edited.inputs] > 0.0 {
            edited.w2[unit] *= 1.5;
        }
    }
    let other = checked(&file, &edited.file());
    assert!(matches!(other, Err(Rejection::OtherModel { .. })), "{other:?}");
    let mut changed = file;
    changed["model_sha256"] = hash(&edited.file()).into();
    rejected(changed, &edited.file(), "above the claim");
}

#[test]
fn rejects_a_dropped_leaf() {
    let (weights, file, _) = grown();
    let leaves: Vec<usize> = (0..tree(&mut file.clone()).len())
        .filter(|place| tree(&mut file.clone())[*place].get("apart").is_some())
        .collect();
    for place in leaves {
        let mut changed = file.clone();
        tree(&mut changed).remove(place);
        let again = checked(&sealed(changed, &weights.file()), &weights.file());
        assert!(matches!(again, Err(Rejection::Unproved { .. })), "{again:?}");
    }
    let mut changed = file.clone();
    tree(&mut changed).pop();
    rejected(changed, &weights.file(), "have no leaf");
    let mut changed = file;
    tree(&mut changed).push(json!({ "apart": [] }));
    rejected(changed, &weights.file(), "belong to no box");
}

#[test]
fn rejects_a_moved_split() {
    let (weights, file, _) = grown();
    let mut unproved = 0;
    let splits: Vec<usize> = (0..tree(&mut file.clone()).len())
        .filter(|place| tree(&mut file.clone())[*place].get("at").is_some())
        .collect();
    for place in &splits {
        for by in [-0.4, 0.4] {
            let mut changed = file.clone();
            let at = tree(&mut changed)[*place]["at"].as_f64().expect("a number");
            tree(&mut changed)[*place]["at"] = (at + by).into();
            let as_it_is = checked(&changed, &weights.file());
            assert!(matches!(as_it_is, Err(Rejection::Seal { .. })), "{as_it_is:?}");
            // Sealed anew it may still be a proof, of the same claim: then what it claims is true.
            let again = checked(&sealed(changed, &weights.file()), &weights.file());
            unproved += usize::from(matches!(again, Err(Rejection::Unproved { .. })));
        }
    }
    assert!(unproved > splits.len(), "{unproved} of {} moves", 2 * splits.len());
    let mut changed = file;
    tree(&mut changed)[0]["at"] = 1.5.into();
    rejected(changed, &weights.file(), "outside of its box");
}

#[test]
fn rejects_a_lowered_bound() {
    let (weights, file, claim) = grown();
    let mut changed = file;
    // The next number below: the bound of the prover is attained.
    changed["certificates"][0]["claim"] = claim.next_down().into();
    rejected(changed, &weights.file(), "above the claim");
}

#[test]
fn rejects_what_else_does_not_hold() {
    let (weights, file, _) = grown();
    let model = weights.file();
    let with = |change: &dyn Fn(&mut Value)| {
        let mut changed = file.clone();
        change(&mut changed);
        changed
    };
    let single = |change: &dyn Fn(&mut Value)| with(&|file| change(&mut file["certificates"][0]));
    rejected(with(&|file| file["bounds"]["a"] = json!([-40.0, 40.0])), &model, "node ");
    rejected(with(&|file| file["bounds"]["a"] = json!([1.0, 1.0])), &model, "no room to move");
    rejected(with(&|file| file["bounds"]["b"] = json!([2.0, 1.0])), &model, "no interval");
    rejected(single(&|one| one["property"] = "increasing".into()), &model, "node ");
    rejected(single(&|one| one["property"] = "flat".into()), &model, "no property");
    rejected(single(&|one| one["input"] = "z".into()), &model, "no input");
    rejected(single(&|one| one["together"] = json!([[0, 3]])), &model, "share a hyperplane");
    rejected(single(&|one| one["together"] = json!([[0, 1], [1, 2]])), &model, "two groups");
    rejected(single(&|one| one["together"] = json!([[0, 99]])), &model, "no neuron 99");
    // The whole box as a leaf, with pairs that are not apart, or counted twice.
    let leaf = |apart: Value| single(&|one| one["tree"] = json!([{ "apart": apart }]));
    rejected(leaf(json!([])), &model, "above the claim");
    rejected(leaf(json!([[2, 3, "b"]])), &model, "apart");
    rejected(leaf(json!([[2, 2, "b"]])), &model, "counted twice");
    rejected(leaf(json!([[1, 2, "b"]])), &model, "leads no undecided group");
    let other = checked(&sealed(with(&|file| file["schema"] = "x/1".into()), &model), &model);
    assert!(matches!(other, Err(Rejection::Schema(_))), "{other:?}");
    let more = checked(&sealed(with(&|file| file["more"] = 1.into()), &model), &model);
    assert!(matches!(more, Err(Rejection::Form(_))), "{more:?}");
    assert!(matches!(check(b"[", &model), Err(Rejection::Form(_))));
    assert!(matches!(checked(&sealed(file.clone(), b"x"), b"x"), Err(Rejection::Model(_))));
}

#[test]
fn half_spaces_are_part_of_the_claim() {
    let (mut needed, mut accepted) = (0, 0);
    for seed in 0..40 {
        let weights = Weights::random(2, 8, seed);
        let cut = region(2).within([("a", 1.0), ("b", -0.5)], 0.2).expect("a half-space");
        let (file, _, claim) = proved_over(&weights, &cut);
        assert_eq!(checked(&file, &weights.file()).expect("a proof"), claim);
        accepted += 1;
        let (_, _, of_box) = proved(&weights);
        if claim < of_box {
            // The claim is not true of the whole box.
            for half_spaces in [
                json!([]),
                json!([{ "weights": { "a": 1.0, "b": -0.5 }, "at_most": 20.0 }]),
                json!([{ "weights": { "a": -1.0, "b": 0.5 }, "at_most": 20.0 }]),
                json!([{ "weights": { "a": 1.0, "z": -0.5 }, "at_most": 0.2 }]),
            ] {
                let mut changed = file.clone();
                changed["half_spaces"] = half_spaces;
                rejected(changed, &weights.file(), "node ");
            }
            needed += 1;
        }
    }
    assert_eq!(accepted, 40);
    assert!(needed > 5, "{needed}");
}

#[test]
fn half_spaces_need_a_point_strictly_inside() {
    let weights = Weights::random(2, 8, 1);
    let model = weights.file();
    let cut = region(2).within([("a", 1.0), ("b", -0.5)], 0.2).expect("a half-space");
    let (file, _, claim) = proved_over(&weights, &cut);
    let with = |inside: Value| {
        let mut changed = file.clone();
        changed["certificates"][0]["inside"] = inside;
        changed
    };
    // Any other point inside serves as well.
    for point in [json!({ "a": 0.0, "b": 0.0 }), json!({ "a": 0.1999999, "b": 0.0 })] {
        let accepted = checked(&sealed(with(point), &model), &model);
        assert_eq!(accepted.expect("a proof"), claim);
    }
    let mut removed = file.clone();
    removed["certificates"][0].as_object_mut().expect("an object").remove("inside");
    rejected(removed, &model, "no point inside them is named");
    for (point, because) in [
        (Value::Null, "no point inside them is named"),
        (json!({ "a": 0.2, "b": 0.0 }), "not strictly inside half-space 0"),
        (json!({ "a": 1.0, "b": 0.0 }), "not strictly inside half-space 0"),
        (json!({ "a": -1.5, "b": 0.0 }), "outside of the box by 'a'"),
        (json!({ "a": 0.0, "b": 1.75 }), "outside of the box by 'b'"),
        (json!({ "a": 0.0 }), "no value of 'b'"),
        (json!({ "a": 0.0, "b": 0.0, "z": 0.0 }), "names 'z'"),
    ] {
        rejected(with(point), &model, because);
    }
}

/// `max(0, a - 0.5)` rises. Two half-spaces that leave `b = 0.5` alone put each half of the box outside of one of them.
#[test]
fn a_region_without_an_inside_proves_nothing() {
    let weights = Weights { inputs: 2, w1: vec![1.0, 0.0], b1: vec![-0.5], w2: vec![1.0] };
    let of = |inside: Value| {
        let file = json!({
            "schema": "certificate/2",
            "bounds": { "a": [-1.0, 1.0], "b": [0.0, 1.0] },
            "half_spaces": [
                { "weights": { "b": 1.0 }, "at_most": 0.5 },
                { "weights": { "b": -1.0 }, "at_most": -0.5 },
            ],
            "certificates": [{
                "network": "N", "input": "a", "property": "decreasing", "claim": 0.0,
                "inside": inside, "together": [],
                "tree": [{ "split": "b", "at": 0.5 }, { "apart": [] }, { "apart": [] }],
            }],
        });
        let refused = checked(&sealed(file, &weights.file()), &weights.file());
        refused.expect_err("nothing is proved").to_string()
    };
    assert!(of(Value::Null).contains("no point inside them is named"));
    assert!(of(json!({ "a": 0.0, "b": 0.5 })).contains("not strictly inside half-space 0"));
    assert!(of(json!({ "a": 0.0, "b": 0.25 })).contains("not strictly inside half-space 1"));
}

/// `max(0, -a + 2 a)` rises with a; by its first column alone it would fall.
#[test]
fn refuses_an_input_that_is_wired_twice() {
    let weights = Weights { inputs: 2, w1: vec![-1.0, 2.0], b1: vec![0.0], w2: vec![1.0] };
    let model = weights.file_wired(&["a", "a"]);
    let file = json!({
        "schema": "certificate/2",
        "bounds": { "a": [-1.0, 1.0] },
        "certificates": [{
            "network": "N", "input": "a", "property": "decreasing", "claim": 0.0,
            "together": [], "tree": [{ "apart": [] }],
        }],
    });
    let Err(Rejection::Model(reason)) = checked(&sealed(file, &model), &model) else {
        panic!("a proof by half of the weights");
    };
    assert!(reason.contains("'a' is wired to 'N' twice"), "{reason}");
}

/// `max(0, a)` never falls: one leaf, by hand and not by the prover.
#[test]
fn accepts_a_proof_by_hand() {
    let weights = Weights { inputs: 1, w1: vec![1.0], b1: vec![0.0], w2: vec![1.0] };
    let of = |property: &str, claim: f64| {
        let file = json!({
            "schema": "certificate/2",
            "bounds": { "a": [-1.0, 1.0] },
            "certificates": [{
                "network": "N", "input": "a", "property": property, "claim": claim,
                "together": [], "tree": [{ "apart": [] }],
            }],
        });
        checked(&sealed(file, &weights.file()), &weights.file())
    };
    assert_eq!(of("increasing", 0.0).expect("it never falls"), 0.0);
    assert_eq!(of("decreasing", 1.0).expect("it rises by one at most"), 1.0);
    assert!(of("decreasing", 0.5).is_err());
    assert!(of("increasing", -0.5).is_err());
}
