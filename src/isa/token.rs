//! The tokens, one row for each instruction set.

#[cfg(all(simdop_x86, not(feature = "std")))]
use super::cpuid;

/// Plain Rust, on every machine. The reference implementation.
#[derive(Copy, Clone, PartialEq, Eq, Debug, Default)]
pub struct Scalar(());

impl Scalar {
    /// Always available.
    #[must_use]
    pub const fn new() -> Self {
        Self(())
    }
}

/// Whether this machine supports a feature, by its name in `target_feature`.
#[cfg(all(simdop_x86, feature = "std"))]
macro_rules! detected {
    ($feature:tt) => {
        std::arch::is_x86_feature_detected!($feature)
    };
}

#[cfg(all(simdop_x86, not(feature = "std")))]
macro_rules! detected {
    ($feature:tt) => {
        const { cpuid::Feature::named($feature) }.detected()
    };
}

#[cfg(simdop_neon)]
macro_rules! detected {
    ($feature:tt) => {
        cfg!(target_feature = $feature)
    };
}

/// Defines an instruction set: token, detection, gate, and `$attribute!`, which compiles an item for it. `$d` is a
/// dollar sign.
#[cfg(any(simdop_x86, simdop_neon))]
macro_rules! instruction_set {
    ($d:tt $(#[$doc:meta])* $token:ident, $attribute:ident, [$($feature:tt)+]) => {
        $(#[$doc])*
        #[derive(Copy, Clone, PartialEq, Eq, Debug)]
        pub struct $token(());

        impl $token {
            /// The token, if this machine supports the instruction set.
            #[must_use]
            pub fn detect() -> Option<Self> {
                if !($(detected!($feature))&&+) {
                    return None;
                }
                // SAFETY: each feature that the constructor is compiled for was just detected.
                Some(unsafe { Self::assume_supported() })
            }

            /// The token, if the crate is compiled for the instruction set.
            #[must_use]
            pub const fn baseline() -> Option<Self> {
                if !($(cfg!(target_feature = $feature))&&+) {
                    return None;
                }
                // SAFETY: each feature that the constructor is compiled for is enabled for the whole crate.
                Some(unsafe { Self::assume_supported() })
            }

            /// The token, without a check. Safe to call from a function compiled for the same features.
            ///
            /// # Safety
            /// In other functions: the machine must have every feature that this function is compiled for, and the
            /// operating system must save their registers.
            #[inline]
            #[must_use]
            $(#[target_feature(enable = $feature)])+
            pub const fn assume_supported() -> Self {
                Self(())
            }

            /// Runs `f`, compiled for the instruction set as far as it is inlined.
            #[inline(always)]
            pub fn run<R>(self, f: impl FnOnce() -> R) -> R {
                #[inline]
                $(#[target_feature(enable = $feature)])+
                fn compiled_for<R>(f: impl FnOnce() -> R) -> R {
                    f()
                }
                // SAFETY: the token proves every feature of `compiled_for`: it has the list of `assume_supported`.
                unsafe { compiled_for(f) }
            }
        }

        /// Compiles a function for the instruction set of the same name.
        macro_rules! $attribute {
            ($d($d item:tt)*) => {
                $(#[target_feature(enable = $feature)])+
                $d($d item)*
            };
        }
        pub(crate) use $attribute;
    };
}

#[cfg(simdop_x86)]
instruction_set! { $
    /// x86-64 with AVX2 and F16C: Intel since Haswell, AMD since Zen.
    Avx2, compiled_for_avx2, ["avx2" "bmi1" "bmi2" "f16c" "lzcnt" "popcnt"]
}

#[cfg(simdop_x86)]
instruction_set! { $
    /// x86-64 with AVX-512F, BW and VL: Intel servers since Skylake, AMD since Zen 4.
    Avx512, compiled_for_avx512,
    ["avx2" "avx512bw" "avx512f" "avx512vl" "bmi1" "bmi2" "f16c" "lzcnt" "popcnt"]
}

#[cfg(simdop_neon)]
instruction_set! { $
    /// aarch64 with NEON (Advanced SIMD).
    Neon, compiled_for_neon, ["neon"]
}

#[cfg(simdop_x86)]
impl Avx512 {
    /// AVX-512 includes AVX2.
    #[must_use]
    pub const fn as_avx2(self) -> Avx2 {
        // SAFETY: the list of features of `Avx512` includes that of `Avx2`, and `self` proves it.
        unsafe { Avx2::assume_supported() }
    }
}
