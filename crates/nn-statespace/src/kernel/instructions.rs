//! The sets of instructions that the kernel is compiled for, and which of them this machine has.

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
