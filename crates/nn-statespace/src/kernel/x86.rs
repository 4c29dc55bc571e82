//! Vectors of x86-64: the only unsafe code of this crate.
//!
//! A token is made by `detect` alone, after the processor was asked for every feature that its
//! methods use; to hold one is therefore the proof that they may run. Loads and stores check the
//! length of their slice.

#![expect(unsafe_code, reason = "vector instructions; each use is covered by a token, see above")]

use std::arch::x86_64::*;

use super::lanes::{Job, Lanes};

/// A token and the features that it proves.
macro_rules! token {
    ($(#[$doc:meta])* $token:ident: $($feature:tt),+) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy)]
        pub(super) struct $token(());

        impl $token {
            /// The token, if the machine has the instructions.
            pub(super) fn detect() -> Option<Self> {
                ($(is_x86_feature_detected!($feature))&&+).then_some(Self(()))
            }

            /// Does `job` compiled for these instructions.
            pub(super) fn vectorize<T, J: Job<T>>(self, job: J) -> J::Output
            where
                Self: Lanes<T>,
            {
                #[target_feature($(enable = $feature),+)]
                fn compiled<T, J: Job<T>>(token: $token, job: J) -> J::Output
                where
                    $token: Lanes<T>,
                {
                    job.run(token)
                }
                // SAFETY: the token proves the features.
                unsafe { compiled(self, job) }
            }
        }
    };
}

token!(
    /// Proof of AVX2 and FMA.
    Avx2: "avx2", "fma"
);

token!(
    /// Proof of AVX-512 F, VL, DQ and BW, AVX2 and FMA.
    Avx512: "avx512f", "avx512vl", "avx512dq", "avx512bw", "avx2", "fma"
);

/// The operations of [`Lanes`] in terms of instructions. The last three are what the two
/// families do differently.
macro_rules! lanes {
    (
        $token:ident, $real:ident, $vector:ident, $mask:ident, $count:literal,
        $splat:ident, $load:ident, $store:ident, $add:ident, $multiply_add:ident,
        $(bits: $bits:ident,)?
        positive: |$p:ident| $positive:expr,
        add_where: |$wm:ident, $wa:ident, $wb:ident| $add_where:expr,
        multiply_add_where: |$mm:ident, $ma:ident, $mb:ident, $mc:ident| $multiply_add_where:expr $(,)?
    ) => {
        impl Lanes<$real> for $token {
            type Vector = $vector;
            type Mask = $mask;
            const COUNT: usize = $count;
            $(
                const MASKS_ARE_BITS: bool = true;

                #[inline(always)]
                fn bits(self, mask: $mask) -> $bits {
                    mask
                }

                #[inline(always)]
                fn mask(self, bits: $bits) -> $mask {
                    bits
                }
            )?

            #[inline(always)]
            fn splat(self, value: $real) -> $vector {
                // SAFETY: the token proves the features.
                unsafe { $splat(value) }
            }

            #[inline(always)]
            fn load(self, from: &[$real]) -> $vector {
                let from: &[$real; $count] = from.first_chunk().expect("a whole vector");
                // SAFETY: the token proves the features; `from` has as many values as are read.
                unsafe { $load(from.as_ptr()) }
            }

            #[inline(always)]
            fn store(self, vector: $vector, to: &mut [$real]) {
                let to: &mut [$real; $count] = to.first_chunk_mut().expect("a whole vector");
                // SAFETY: the token proves the features; `to` has as many values as are written.
                unsafe { $store(to.as_mut_ptr(), vector) }
            }

            #[inline(always)]
            fn add(self, a: $vector, b: $vector) -> $vector {
                // SAFETY: the token proves the features.
                unsafe { $add(a, b) }
            }

            #[inline(always)]
            fn multiply_add(self, a: $vector, b: $vector, c: $vector) -> $vector {
                // SAFETY: the token proves the features.
                unsafe { $multiply_add(a, b, c) }
            }

            #[inline(always)]
            fn positive(self, $p: $vector) -> $mask {
                // SAFETY: the token proves the features.
                unsafe { $positive }
            }

            #[inline(always)]
            fn add_where(self, $wm: $mask, $wa: $vector, $wb: $vector) -> $vector {
                // SAFETY: the token proves the features.
                unsafe { $add_where }
            }

            #[inline(always)]
            fn multiply_add_where(
                self,
                $mm: $mask,
                $ma: $vector,
                $mb: $vector,
                $mc: $vector,
            ) -> $vector {
                // SAFETY: the token proves the features.
                unsafe { $multiply_add_where }
            }
        }
    };
}

lanes!(
    Avx2, f32, __m256, __m256, 8,
    _mm256_set1_ps, _mm256_loadu_ps, _mm256_storeu_ps, _mm256_add_ps, _mm256_fmadd_ps,
    positive: |a| _mm256_cmp_ps::<_CMP_GT_OQ>(a, _mm256_setzero_ps()),
    add_where: |mask, a, b| _mm256_add_ps(a, _mm256_and_ps(mask, b)),
    multiply_add_where: |mask, a, b, c| _mm256_fmadd_ps(_mm256_and_ps(mask, a), b, c),
);

lanes!(
    Avx2, f64, __m256d, __m256d, 4,
    _mm256_set1_pd, _mm256_loadu_pd, _mm256_storeu_pd, _mm256_add_pd, _mm256_fmadd_pd,
    positive: |a| _mm256_cmp_pd::<_CMP_GT_OQ>(a, _mm256_setzero_pd()),
    add_where: |mask, a, b| _mm256_add_pd(a, _mm256_and_pd(mask, b)),
    multiply_add_where: |mask, a, b, c| _mm256_fmadd_pd(_mm256_and_pd(mask, a), b, c),
);

lanes!(
    Avx512, f32, __m512, __mmask16, 16,
    _mm512_set1_ps, _mm512_loadu_ps, _mm512_storeu_ps, _mm512_add_ps, _mm512_fmadd_ps,
    bits: u16,
    positive: |a| _mm512_cmp_ps_mask::<_CMP_GT_OQ>(a, _mm512_setzero_ps()),
    add_where: |mask, a, b| _mm512_mask_add_ps(a, mask, a, b),
    multiply_add_where: |mask, a, b, c| _mm512_mask3_fmadd_ps(a, b, c, mask),
);

lanes!(
    Avx512, f64, __m512d, __mmask8, 8,
    _mm512_set1_pd, _mm512_loadu_pd, _mm512_storeu_pd, _mm512_add_pd, _mm512_fmadd_pd,
    positive: |a| _mm512_cmp_pd_mask::<_CMP_GT_OQ>(a, _mm512_setzero_pd()),
    add_where: |mask, a, b| _mm512_mask_add_pd(a, mask, a, b),
    multiply_add_where: |mask, a, b, c| _mm512_mask3_fmadd_pd(a, b, c, mask),
);
