//! Exact arithmetic on dyadic rationals, `m 2^e` with an integer `m` of any length.
//!
//! Sums and products of finite floating-point numbers are dyadic, so the slopes, the signs of the
//! pre-activations and the values of a network at a point can all be had without rounding.

use std::cmp::Ordering;

/// `(-1)^negative * limbs * 2^exponent`, limbs little-endian; zero has no limbs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Dyadic {
    negative: bool,
    limbs: Vec<u64>,
    exponent: i64,
}

impl Dyadic {
    /// The exact value of a finite number. Inputs are checked to be finite where they enter the
    /// crate; anything else is a defect of the crate.
    pub(crate) fn new(value: f64) -> Self {
        debug_assert!(value.is_finite(), "only finite numbers are dyadic");
        let bits = value.to_bits();
        let fraction = bits & ((1 << 52) - 1);
        let biased = ((bits >> 52) & 0x7ff) as i64;
        let (mantissa, exponent) =
            if biased == 0 { (fraction, -1074) } else { (fraction | 1 << 52, biased - 1075) };
        let limbs = if mantissa == 0 { Vec::new() } else { vec![mantissa] };
        Self { negative: value < 0.0, limbs, exponent }
    }

    /// Sign as an ordering against zero.
    pub(crate) fn sign(&self) -> Ordering {
        match (self.limbs.is_empty(), self.negative) {
            (true, _) => Ordering::Equal,
            (false, true) => Ordering::Less,
            (false, false) => Ordering::Greater,
        }
    }

    /// `bias + weights . point`.
    pub(crate) fn affine(bias: f64, weights: &[f64], point: &[f64]) -> Self {
        weights
            .iter()
            .zip(point)
            .fold(Self::new(bias), |sum, (&w, &x)| sum.plus(&Self::new(w).times(&Self::new(x))))
    }

    pub(crate) fn negated(&self) -> Self {
        Self { negative: !self.negative, ..self.clone() }
    }

    pub(crate) fn absolute(&self) -> Self {
        Self { negative: false, ..self.clone() }
    }

    pub(crate) fn plus(&self, other: &Self) -> Self {
        if self.limbs.is_empty() {
            return other.clone();
        }
        if other.limbs.is_empty() {
            return self.clone();
        }
        let exponent = self.exponent.min(other.exponent);
        let a = shifted(&self.limbs, self.exponent - exponent);
        let b = shifted(&other.limbs, other.exponent - exponent);
        let (negative, limbs) = if self.negative == other.negative {
            (self.negative, limb_by_limb(a, &b, u64::overflowing_add))
        } else {
            let order = a.len().cmp(&b.len()).then_with(|| a.iter().rev().cmp(b.iter().rev()));
            match order {
                Ordering::Equal => (false, Vec::new()),
                Ordering::Greater => (self.negative, limb_by_limb(a, &b, u64::overflowing_sub)),
                Ordering::Less => (other.negative, limb_by_limb(b, &a, u64::overflowing_sub)),
            }
        };
        Self { negative, limbs, exponent }
    }

    pub(crate) fn minus(&self, other: &Self) -> Self {
        self.plus(&other.negated())
    }

    pub(crate) fn times(&self, other: &Self) -> Self {
        let mut limbs = vec![0_u64; self.limbs.len() + other.limbs.len()];
        for (i, &a) in self.limbs.iter().enumerate() {
            let mut carry = 0_u128;
            for (j, &b) in other.limbs.iter().enumerate() {
                let t = u128::from(a) * u128::from(b) + u128::from(limbs[i + j]) + carry;
                limbs[i + j] = t as u64;
                carry = t >> 64;
            }
            limbs[i + other.limbs.len()] = carry as u64;
        }
        trim(&mut limbs);
        Self {
            negative: self.negative != other.negative,
            limbs,
            exponent: self.exponent + other.exponent,
        }
    }

    /// Largest floating-point number that is not above the value (minus infinity if none is).
    pub(crate) fn round_down(&self) -> f64 {
        let (below, above) = self.magnitude();
        if self.negative { -above } else { below }
    }

    /// Smallest floating-point number that is not below the value (infinity if none is).
    pub(crate) fn round_up(&self) -> f64 {
        let (below, above) = self.magnitude();
        if self.negative { -below } else { above }
    }

    /// The floating-point neighbours of the absolute value, below and above, equal if it is one.
    fn magnitude(&self) -> (f64, f64) {
        let Some(&top) = self.limbs.last() else {
            return (0.0, 0.0);
        };
        let length = self.limbs.len() as i64 * 64 - i64::from(top.leading_zeros());
        let drop = (length - 53).max(-1074 - self.exponent);
        if drop <= 0 {
            // At most 53 bits above an exponent of at least -1074.
            return single(self.limbs[0], self.exponent);
        }
        let exact = lowest_set_bit(&self.limbs) >= drop;
        let (below, rounded_below) = single(bits_from(&self.limbs, drop), self.exponent + drop);
        if exact {
            return (below, rounded_below);
        }
        (below, if below == f64::MAX { f64::INFINITY } else { below.next_up() })
    }
}

/// `mantissa * 2^exponent` for a mantissa of at most 53 bits that is representable unless it
/// overflows; then the neighbours are the largest number and infinity.
fn single(mantissa: u64, exponent: i64) -> (f64, f64) {
    if mantissa == 0 {
        return (0.0, 0.0);
    }
    let mut value = mantissa as f64;
    let mut exponent = exponent;
    while exponent != 0 && value.is_finite() {
        // Down, two steps at most: the result is representable, so no step loses bits.
        let step = exponent.clamp(-1000, 1000);
        value *= 2_f64.powi(step as i32);
        exponent -= step;
    }
    if value.is_finite() { (value, value) } else { (f64::MAX, f64::INFINITY) }
}

fn trim(limbs: &mut Vec<u64>) {
    while limbs.last() == Some(&0) {
        limbs.pop();
    }
}

fn shifted(limbs: &[u64], bits: i64) -> Vec<u64> {
    let (whole, part) = ((bits / 64) as usize, (bits % 64) as u32);
    let mut out = vec![0; whole];
    let mut carry = 0;
    for &limb in limbs {
        out.push(if part == 0 { limb } else { limb << part | carry });
        carry = if part == 0 { 0 } else { limb >> (64 - part) };
    }
    out.push(carry);
    trim(&mut out);
    out
}

/// Adds `b`, or subtracts a `b` that is not above `a`, with what is carried or borrowed from limb to limb; the last of `a`
/// overflows no more.
fn limb_by_limb(mut a: Vec<u64>, b: &[u64], step: impl Fn(u64, u64) -> (u64, bool)) -> Vec<u64> {
    a.resize(a.len().max(b.len()) + 1, 0);
    let mut carry = false;
    for (i, limb) in a.iter_mut().enumerate() {
        let (t, first) = step(*limb, b.get(i).copied().unwrap_or(0));
        let (t, second) = step(t, u64::from(carry));
        *limb = t;
        carry = first || second;
    }
    trim(&mut a);
    a
}

/// The bits above position `drop` (at most 53 of them, by the caller's choice of `drop`).
fn bits_from(limbs: &[u64], drop: i64) -> u64 {
    let (whole, part) = ((drop / 64) as usize, (drop % 64) as u32);
    let low = limbs.get(whole).copied().unwrap_or(0) >> part;
    let high = limbs.get(whole + 1).copied().unwrap_or(0);
    if part == 0 { low } else { low | high << (64 - part) }
}

fn lowest_set_bit(limbs: &[u64]) -> i64 {
    let zeros = limbs.iter().take_while(|&&limb| limb == 0).count();
    zeros as i64 * 64 + limbs.get(zeros).map_or(0, |limb| i64::from(limb.trailing_zeros()))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn exact(value: f64) -> Dyadic {
        Dyadic::new(value)
    }

    #[test]
    fn rounds_to_both_neighbours() {
        let one = exact(1.0);
        let tiny = exact(f64::from_bits(1));
        let above = one.plus(&tiny);
        assert_eq!(above.round_down(), 1.0);
        assert_eq!(above.round_up(), 1.0 + f64::EPSILON);
        let below = one.minus(&tiny).negated();
        assert_eq!(below.round_down(), -1.0);
        assert_eq!(below.round_up(), -1.0 + f64::EPSILON / 2.0);
        // A product far below the smallest number, and one above the largest.
        let product = tiny.times(&tiny);
        assert_eq!((product.round_down(), product.round_up()), (0.0, f64::from_bits(1)));
        let huge = exact(f64::MAX).times(&exact(2.0));
        assert_eq!((huge.round_down(), huge.round_up()), (f64::MAX, f64::INFINITY));
        let huge = huge.negated();
        assert_eq!((huge.round_down(), huge.round_up()), (f64::NEG_INFINITY, -f64::MAX));
        let zero = one.minus(&one);
        assert_eq!((zero.sign(), zero.round_up()), (Ordering::Equal, 0.0));
    }

    fn number() -> impl Strategy<Value = f64> {
        prop_oneof![
            any::<f64>().prop_filter("finite", |v| v.is_finite()),
            -10.0..10.0_f64,
            (-40_i32..40).prop_map(f64::from),
            Just(0.0),
            Just(-0.0),
        ]
    }

    proptest! {
        #[test]
        fn agrees_with_rounded_arithmetic(a in number(), b in number()) {
            for (value, rounded) in [
                (exact(a).plus(&exact(b)), a + b),
                (exact(a).minus(&exact(b)), a - b),
                (exact(a).times(&exact(b)), a * b),
            ] {
                // Rounding to nearest gives one of the two neighbours.
                let (down, up) = (value.round_down(), value.round_up());
                prop_assert!(down <= up);
                prop_assert!(rounded == down || rounded == up, "{rounded} {down} {up}");
                prop_assert!(down == up || up == down.next_up());
            }
            prop_assert_eq!(exact(a).round_up(), a);
            prop_assert_eq!(exact(a).round_down(), a);
        }

        #[test]
        fn is_a_ring(a in number(), b in number(), c in number()) {
            let (a, b, c) = (exact(a), exact(b), exact(c));
            let left = a.plus(&b).times(&c);
            let right = a.times(&c).plus(&b.times(&c));
            prop_assert_eq!(left.minus(&right).sign(), Ordering::Equal);
            prop_assert_eq!(a.plus(&b).minus(&b).minus(&a).sign(), Ordering::Equal);
            let integers = exact(7.0).times(&exact(-6.0)).plus(&exact(42.0));
            prop_assert_eq!(integers.sign(), Ordering::Equal);
        }
    }
}
