//! Floating-point numbers as integers: every finite number is `m 2^e`, so that finitely many are whole multiples of one
//! power of two.

use num_bigint::BigInt;

/// The exponent of the last bit of a finite number; `None` of zero.
pub(crate) fn last_bit(value: f64) -> Option<i64> {
    let (mantissa, exponent) = parts(value);
    (mantissa != 0).then(|| exponent + i64::from(mantissa.trailing_zeros()))
}

/// `value / 2^exponent`, which has to be whole.
pub(crate) fn whole(value: f64, exponent: i64) -> BigInt {
    let (mantissa, own) = parts(value);
    if mantissa == 0 {
        return BigInt::ZERO;
    }
    let zeros = i64::from(mantissa.trailing_zeros());
    let shift = own + zeros - exponent;
    let shift = u64::try_from(shift).expect("the grid is as fine as its numbers");
    let size = BigInt::from(mantissa >> zeros) << shift;
    if value < 0.0 { -size } else { size }
}

/// `|value| = mantissa 2^exponent`.
fn parts(value: f64) -> (u64, i64) {
    let bits = value.to_bits();
    let fraction = bits & ((1 << 52) - 1);
    match (bits >> 52) & 0x7ff {
        0 => (fraction, -1074),
        biased => (fraction | 1 << 52, biased as i64 - 1075),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_become_what_they_are() {
        for value in [1.0, -0.75, 3.0e-7, 1234567.890625, f64::MIN_POSITIVE, 5e-324, -1e300] {
            let exponent = last_bit(value).expect("not zero");
            let whole = whole(value, exponent - 3);
            let text = whole.to_string();
            // Odd times eight: nothing finer is lost, nothing coarser is there.
            assert_eq!(&whole % 8, BigInt::ZERO, "{text}");
            assert_ne!(&whole % 16, BigInt::ZERO, "{text}");
            assert_eq!(text.starts_with('-'), value < 0.0);
        }
        assert_eq!(whole(-0.75, -4), BigInt::from(-12));
        assert_eq!(whole(0.0, 0), BigInt::ZERO);
        assert_eq!(last_bit(0.0), None);
        assert_eq!(last_bit(6.0), Some(1));
    }
}
