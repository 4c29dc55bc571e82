//! The two precisions of the kernel.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::instructions::Instructions;
use super::lanes::Job;
use super::portable::{Portable, Scalar};

/// Single precision, in which networks are trained, and double precision, in which gradients are
/// checked.
///
/// Sealed: `f32` and `f64`.
pub trait Real:
    sealed::Sealed
    + Copy
    + Default
    + Debug
    + PartialEq
    + PartialOrd
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + std::iter::Sum
    + 'static
{
    /// Zero.
    const ZERO: Self;
    /// The nearest number of this precision.
    fn of(value: f64) -> Self;
    /// The same number in double precision.
    fn to_f64(self) -> f64;
    /// Whether it is neither infinite nor not a number.
    fn is_finite(self) -> bool;
}

/// What the kernel itself needs of a precision; out of reach from outside.
pub(super) mod sealed {
    use super::{Instructions, Job, Scalar};

    pub trait Sealed: Scalar {
        /// Does `job` with these instructions.
        fn dispatch<J: Job<Self>>(instructions: Instructions, job: J) -> J::Output;
    }
}

macro_rules! real {
    ($real:ident) => {
        impl Real for $real {
            const ZERO: Self = 0.0;

            #[inline(always)]
            fn of(value: f64) -> Self {
                value as $real
            }

            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }

            #[inline(always)]
            fn is_finite(self) -> bool {
                $real::is_finite(self)
            }
        }

        impl sealed::Sealed for $real {
            fn dispatch<J: Job<Self>>(instructions: Instructions, job: J) -> J::Output {
                #[cfg(target_arch = "x86_64")]
                {
                    use super::x86::{Avx2, Avx512};
                    if instructions == Instructions::Avx512
                        && let Some(token) = Avx512::detect()
                    {
                        return token.vectorize(job);
                    }
                    if instructions == Instructions::Avx2
                        && let Some(token) = Avx2::detect()
                    {
                        return token.vectorize(job);
                    }
                }
                let _ = instructions;
                job.run(Portable)
            }
        }
    };
}

real!(f32);
real!(f64);
