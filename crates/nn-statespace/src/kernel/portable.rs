//! Lanes without instructions of any one processor.

use std::ops::Add;

use super::lanes::Lanes;

/// Four lanes that the compiler maps to whatever the target has.
#[derive(Debug, Clone, Copy)]
pub(super) struct Portable;

/// Lanes of a portable vector: 16 bytes of single precision, which every 64-bit machine has.
const FOUR: usize = 4;

impl<T: Scalar> Lanes<T> for Portable {
    type Vector = [T; FOUR];
    type Mask = [T::Bits; FOUR];
    const COUNT: usize = FOUR;

    #[inline(always)]
    fn splat(self, value: T) -> [T; FOUR] {
        [value; FOUR]
    }

    #[inline(always)]
    fn load(self, from: &[T]) -> [T; FOUR] {
        [from[0], from[1], from[2], from[3]]
    }

    #[inline(always)]
    fn store(self, vector: [T; FOUR], to: &mut [T]) {
        to[..FOUR].copy_from_slice(&vector);
    }

    #[inline(always)]
    fn add(self, mut a: [T; FOUR], b: [T; FOUR]) -> [T; FOUR] {
        for lane in 0..FOUR {
            a[lane] = a[lane] + b[lane];
        }
        a
    }

    #[inline(always)]
    fn multiply_add(self, a: [T; FOUR], b: [T; FOUR], mut c: [T; FOUR]) -> [T; FOUR] {
        for lane in 0..FOUR {
            c[lane] = a[lane].multiply_add(b[lane], c[lane]);
        }
        c
    }

    #[inline(always)]
    fn positive(self, a: [T; FOUR]) -> [T::Bits; FOUR] {
        a.map(T::ones_where_positive)
    }

    #[inline(always)]
    fn add_where(self, mask: [T::Bits; FOUR], a: [T; FOUR], b: [T; FOUR]) -> [T; FOUR] {
        // a + 0 is a, but for a = -0, of which no sum here depends on the sign.
        Lanes::<T>::add(self, a, masked(mask, b))
    }

    #[inline(always)]
    fn multiply_add_where(
        self,
        mask: [T::Bits; FOUR],
        a: [T; FOUR],
        b: [T; FOUR],
        c: [T; FOUR],
    ) -> [T; FOUR] {
        Lanes::<T>::multiply_add(self, masked(mask, a), b, c)
    }
}

/// `a` where the mask holds, else 0.
#[inline(always)]
fn masked<T: Scalar>(mask: [T::Bits; FOUR], mut a: [T; FOUR]) -> [T; FOUR] {
    for lane in 0..FOUR {
        a[lane] = a[lane].masked(mask[lane]);
    }
    a
}

/// What the portable lanes need of a number.
pub trait Scalar: Copy + Add<Output = Self> {
    /// An unsigned integer of the same size.
    type Bits: Copy;
    /// `self b + c`; rounded once if the target fuses the two without being asked.
    fn multiply_add(self, b: Self, c: Self) -> Self;
    /// All bits if `self > 0`, else none.
    fn ones_where_positive(self) -> Self::Bits;
    /// `self` with the bits of `mask` alone.
    fn masked(self, mask: Self::Bits) -> Self;
}

macro_rules! scalar {
    ($real:ident, $bits:ident) => {
        impl Scalar for $real {
            type Bits = $bits;

            #[inline(always)]
            fn multiply_add(self, b: Self, c: Self) -> Self {
                // Without the instruction, mul_add is a slow call.
                if cfg!(target_arch = "aarch64") { self.mul_add(b, c) } else { self * b + c }
            }

            #[inline(always)]
            fn ones_where_positive(self) -> $bits {
                if self > 0.0 { $bits::MAX } else { 0 }
            }

            #[inline(always)]
            fn masked(self, mask: $bits) -> Self {
                Self::from_bits(self.to_bits() & mask)
            }
        }
    };
}

scalar!(f32, u32);
scalar!(f64, u64);
