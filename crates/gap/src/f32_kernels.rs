//! Sums of products in single precision, compiled for the instructions of the machine they run on.
//!
//! Products and sums are rounded one by one on all machines, and sums have the same order, so that results agree bit
//! for bit. Closures are not compiled along with the function that dispatches them, so that all is written as loops.

use pulp::{Arch, NullaryFnOnce, Simd, WithSimd};

/// Numbers that are worked on side by side.
pub(crate) const WIDTH: usize = 8;
/// Registers of sums that are filled at a time: one alone would wait for itself.
const AT_ONCE: usize = 4;

/// Adds a multiple of one list to another, as far as both go.
pub(crate) fn add_scaled(to: &mut [f32], factor: f32, of: &[f32]) {
    struct AddScaled<'a>(&'a mut [f32], f32, &'a [f32]);
    impl NullaryFnOnce for AddScaled<'_> {
        type Output = ();
        #[inline(always)]
        fn call(self) {
            let Self(to, factor, of) = self;
            let n = to.len().min(of.len());
            let (to, of) = (&mut to[..n], &of[..n]);
            for k in 0..n {
                to[k] += factor * of[k];
            }
        }
    }
    Arch::new().dispatch(AddScaled(to, factor, of));
}

/// Adds the products of two lists, entry by entry, to a third, as far as all go.
pub(crate) fn add_products(to: &mut [f32], a: &[f32], b: &[f32]) {
    struct AddProducts<'a>(&'a mut [f32], &'a [f32], &'a [f32]);
    impl NullaryFnOnce for AddProducts<'_> {
        type Output = ();
        #[inline(always)]
        fn call(self) {
            let Self(to, a, b) = self;
            let n = to.len().min(a.len()).min(b.len());
            let (to, a, b) = (&mut to[..n], &a[..n], &b[..n]);
            for k in 0..n {
                to[k] += a[k] * b[k];
            }
        }
    }
    Arch::new().dispatch(AddProducts(to, a, b));
}

/// Replaces `sum` by the sum of rows times their factors. A row is as long as the sum, a multiple of [`WIDTH`]; as many
/// rows count as there are factors and whole rows.
pub(crate) fn combined(factors: &[f32], rows: &[f32], sum: &mut [f32]) {
    struct Combine<'a>(&'a [f32], &'a [f32], &'a mut [f32]);
    impl WithSimd for Combine<'_> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let Self(factors, rows, sum) = self;
            let (rows, _) = S::as_simd_f32s(rows);
            let (sum, _) = S::as_mut_simd_f32s(sum);
            let width = sum.len();
            let mut first = 0;
            while first + AT_ONCE <= width {
                registers::<S, AT_ONCE>(simd, factors, rows, first, sum);
                first += AT_ONCE;
            }
            for first in first..width {
                registers::<S, 1>(simd, factors, rows, first, sum);
            }
        }
    }
    /// `N` registers of the sum from `first` on.
    #[inline(always)]
    fn registers<S: Simd, const N: usize>(
        simd: S,
        factors: &[f32],
        rows: &[S::f32s],
        first: usize,
        sum: &mut [S::f32s],
    ) {
        let mut sums = [simd.splat_f32s(0.0); N];
        for (factor, row) in factors.iter().zip(rows.chunks_exact(sum.len())) {
            let Some(row) = row[first..].first_chunk::<N>() else { return };
            let factor = simd.splat_f32s(*factor);
            for k in 0..N {
                sums[k] = simd.add_f32s(sums[k], simd.mul_f32s(factor, row[k]));
            }
        }
        sum[first..first + N].copy_from_slice(&sums);
    }
    if !sum.is_empty() {
        Arch::new().dispatch(Combine(factors, rows, sum));
    }
}

/// The product of two lists, as far as both go; [`WIDTH`] sums side by side on every machine.
pub(crate) fn product(a: &[f32], b: &[f32]) -> f32 {
    struct Product<'a>(&'a [f32], &'a [f32]);
    impl WithSimd for Product<'_> {
        type Output = f32;
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> f32 {
            let Self(a, b) = self;
            let n = a.len().min(b.len());
            let ((a, a_rest), (b, b_rest)) =
                (a[..n].as_chunks::<WIDTH>(), b[..n].as_chunks::<WIDTH>());
            let mut sums = [0.0_f32; WIDTH];
            {
                let (registers, rest) = S::as_mut_simd_f32s(&mut sums);
                assert!(rest.is_empty(), "registers are no wider than the sums");
                for (index, register) in registers.iter_mut().enumerate() {
                    let mut sum = simd.splat_f32s(0.0);
                    for (x, y) in a.iter().zip(b) {
                        let (x, y) = (S::as_simd_f32s(x).0[index], S::as_simd_f32s(y).0[index]);
                        sum = simd.add_f32s(sum, simd.mul_f32s(x, y));
                    }
                    *register = sum;
                }
            }
            // Too few to be worked on side by side.
            let rest: f32 = a_rest.iter().zip(b_rest).map(|(x, y)| x * y).sum();
            sums.iter().sum::<f32>() + rest
        }
    }
    Arch::new().dispatch(Product(a, b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(n: usize, turn: f32) -> Vec<f32> {
        (0..n).map(|k| (turn * k as f32).sin()).collect()
    }

    #[test]
    fn sums_are_those_written_out() {
        // Lengths around multiples of what is worked on side by side.
        for n in [0, 1, 7, 8, 9, 24, 31] {
            let (a, b) = (wave(n, 0.7), wave(n + 3, 1.3));
            let expected: f64 = a.iter().zip(&b).map(|(x, y)| f64::from(x * y)).sum();
            assert!((f64::from(product(&a, &b)) - expected).abs() < 1e-5, "{n}"); // single precision
            let mut scaled = a.clone();
            add_scaled(&mut scaled, 0.5, &b);
            let mut products = a.clone();
            add_products(&mut products, &a, &b);
            for k in 0..n {
                assert_eq!(scaled[k], a[k] + 0.5 * b[k]);
                assert_eq!(products[k], a[k] + a[k] * b[k]);
            }
        }
    }

    #[test]
    fn rows_are_combined_as_far_as_there_are_both_rows_and_factors() {
        let rows = wave(3 * 16, 0.3);
        for factors in [&[2.0, -1.0][..], &[2.0, -1.0, 0.5, 9.0]] {
            let mut sum = [7.0; 16];
            combined(factors, &rows, &mut sum);
            for lane in 0..16 {
                let mut expected = 0.0;
                for (row, factor) in factors.iter().take(3).enumerate() {
                    expected += factor * rows[16 * row + lane];
                }
                assert_eq!(sum[lane], expected);
            }
        }
        combined(&[1.0], &[], &mut []);
    }
}
