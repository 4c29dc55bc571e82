//! The vector operations that the kernel is written in.
//!
//! Lanes are samples. Every operation acts on each lane by itself, so that a wider vector gives the
//! same numbers as a narrower one. What can differ between machines is whether a product and a sum
//! are rounded once (with fused instructions) or twice.

/// Vectors of `T`, with the proof that the machine can work on them.
///
/// An implementation is a token: it exists only on machines with its instructions.
pub trait Lanes<T>: Copy {
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
pub trait Job<T> {
    /// What it returns.
    type Output;
    /// Does it. Implementations are inlined, so that they are compiled for the lanes' instructions.
    fn run<L: Lanes<T>>(self, lanes: L) -> Self::Output;
}
