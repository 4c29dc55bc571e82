//! The vector operations that the kernel is written in, and which instructions carry them out.
//!
//! Lanes are samples. Every operation acts on each lane by itself, so that a wider vector gives the
//! same numbers as a narrower one. What can differ between machines is whether a product and a sum
//! are rounded once (with fused instructions) or twice.

use super::real::Real;

/// Vectors of `T`, with the proof that the machine can work on them.
///
/// An implementation is a token: it exists only on machines with its instructions.
pub trait Lanes<T: Real>: Copy {
    /// A vector; its lanes are side by side in memory.
    type Vector: Copy;
    /// A truth value a lane.
    type Mask: Copy;
    /// Lanes of a vector; a power of two, at most [`super::block::WIDE`].
    const COUNT: usize;
    /// Whether a mask is a handful of bits, so that it is cheaper to keep one than to compute it
    /// again.
    const MASKS_ARE_BITS: bool = false;

    /// The mask as bits; asked for only where masks are bits.
    fn bits(self, _mask: Self::Mask) -> u16 {
        unreachable!("masks of these lanes are not bits")
    }
    /// The mask of these bits; asked for only where masks are bits.
    fn mask(self, _bits: u16) -> Self::Mask {
        unreachable!("masks of these lanes are not bits")
    }
    /// `value` in every lane.
    fn splat(self, value: T) -> Self::Vector;
    /// The first values of `from`.
    fn load(self, from: &[T]) -> Self::Vector;
    /// Writes the lanes to the front of `to`.
    fn store(self, vector: Self::Vector, to: &mut [T]);
    /// `a + b`.
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a b + c`, rounded once where the machine can do so quickly.
    fn multiply_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;
    /// Where `a > 0`; not where it is not a number.
    fn positive(self, a: Self::Vector) -> Self::Mask;
    /// `a + b` where the mask holds, else `a`.
    fn add_where(self, mask: Self::Mask, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a b + c` where the mask holds, else `c`; rounded as by [`Self::multiply_add`].
    fn multiply_add_where(
        self,
        mask: Self::Mask,
        a: Self::Vector,
        b: Self::Vector,
        c: Self::Vector,
    ) -> Self::Vector;
}

/// Something to be compiled for each set of instructions.
pub trait Job<T: Real> {
    /// What it returns.
    type Output;
    /// Does it. Implementations are inlined, so that they are compiled for the lanes' instructions.
    fn run<L: Lanes<T>>(self, lanes: L) -> Self::Output;
}

/// A set of instructions that the kernel is compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Instructions {
    /// Those that every machine of the target has.
    Portable,
    /// AVX2 with fused multiplication and addition (x86-64).
    Avx2,
    /// AVX-512 (x86-64).
    Avx512,
}

impl Instructions {
    /// Those that this machine has, the fastest last.
    ///
    /// ```
    /// use nn_statespace::kernel::Instructions;
    ///
    /// assert_eq!(Instructions::available()[0], Instructions::Portable);
    /// ```
    #[must_use]
    pub fn available() -> Vec<Self> {
        let mut found = vec![Self::Portable];
        #[cfg(target_arch = "x86_64")]
        {
            found.extend(super::x86::Avx2::detect().map(|_| Self::Avx2));
            found.extend(super::x86::Avx512::detect().map(|_| Self::Avx512));
        }
        found
    }

    /// The fastest that this machine has.
    #[must_use]
    pub fn best() -> Self {
        Self::available().into_iter().max().expect("the portable ones are always there")
    }
}

/// Four lanes that the compiler maps to whatever the target has.
#[derive(Debug, Clone, Copy)]
pub(super) struct Portable;

/// Lanes of a portable vector: 16 bytes of single precision, which every 64-bit machine has.
const FOUR: usize = 4;

impl<T: Real> Lanes<T> for Portable {
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
fn masked<T: Real>(mask: [T::Bits; FOUR], mut a: [T; FOUR]) -> [T; FOUR] {
    for lane in 0..FOUR {
        a[lane] = a[lane].masked(mask[lane]);
    }
    a
}
