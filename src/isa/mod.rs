//! Instruction sets as values.
//!
//! A *token* ([`Scalar`], `Avx2`, `Avx512`, `Neon`) is a zero-sized proof that this machine has an instruction set. Safe code gets one
//! only by detection, or inside a function that is itself compiled for those features, so a kernel that takes a token needs no
//! check of its own. [`Isa`] is one of the tokens, chosen at run time: a plain value that the caller holds and hands to queries.
//!
//! Each list of features is written once, in the rows below. A row makes the token, its detection, its gate
//! (`run`), and the attribute macro that the token's kernels are compiled with.
//!
//! Without `std`: x86-64 asks CPUID and XCR0; aarch64 believes what the crate was compiled for, which on every aarch64 target
//! but a few includes NEON; targets with a soft-float ABI (`x86_64-unknown-none`) have no vector registers to pass, and so [`Scalar`]
//! only. On bare metal that knows more, `unsafe { Avx2::assume_supported() }` makes a token.

#![cfg_attr(
    any(
        all(target_arch = "x86_64", target_feature = "sse2"),
        all(target_arch = "aarch64", target_feature = "neon")
    ),
    expect(
        unsafe_code,
        reason = "entering a function compiled for detected features is the point of this module"
    )
)]

#[cfg(all(target_arch = "x86_64", target_feature = "sse2", any(test, not(feature = "std"))))]
mod cpuid;

use core::fmt;
use core::str::FromStr;

/// Plain Rust, on every machine: the specification.
#[derive(Copy, Clone, PartialEq, Eq, Debug, Default)]
pub struct Scalar(());

impl Scalar {
    /// Always available.
    #[must_use]
    pub const fn new() -> Self {
        Self(())
    }
}

/// Whether this machine has a feature, by its name in `target_feature`.
#[cfg(all(target_arch = "x86_64", target_feature = "sse2", feature = "std"))]
macro_rules! detected {
    ($feature:tt) => {
        std::arch::is_x86_feature_detected!($feature)
    };
}

#[cfg(all(target_arch = "x86_64", target_feature = "sse2", not(feature = "std")))]
macro_rules! detected {
    ($feature:tt) => {
        const { cpuid::Feature::named($feature) }.detected()
    };
}

#[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
macro_rules! detected {
    ($feature:tt) => {
        cfg!(target_feature = $feature)
    };
}

/// One instruction set: token, detection, gate, and `$attribute!`, which compiles an item for it. `$d` is a dollar sign.
#[cfg(any(
    all(target_arch = "x86_64", target_feature = "sse2"),
    all(target_arch = "aarch64", target_feature = "neon")
))]
macro_rules! instruction_set {
    ($d:tt $(#[$doc:meta])* $token:ident, $attribute:ident, [$($feature:tt)+]) => {
        $(#[$doc])*
        #[derive(Copy, Clone, PartialEq, Eq, Debug)]
        pub struct $token(());

        impl $token {
            /// The token, if this machine has the instruction set.
            #[must_use]
            pub fn detect() -> Option<Self> {
                if !($(detected!($feature))&&+) {
                    return None;
                }
                // SAFETY: each feature that the constructor is compiled for was just detected.
                Some(unsafe { Self::assume_supported() })
            }

            /// The token, if the crate is compiled for it anyway.
            #[must_use]
            pub const fn baseline() -> Option<Self> {
                if !($(cfg!(target_feature = $feature))&&+) {
                    return None;
                }
                // SAFETY: each feature that the constructor is compiled for is enabled for the whole crate.
                Some(unsafe { Self::assume_supported() })
            }

            /// The token, without a question. Safe to call from a function compiled for the same features.
            ///
            /// # Safety
            /// Elsewhere: the machine must have every feature this function is compiled for, and the operating system must save
            /// their registers.
            #[inline]
            #[must_use]
            $(#[target_feature(enable = $feature)])+
            pub const fn assume_supported() -> Self {
                Self(())
            }

            /// Runs `f` compiled for the instruction set, as far as `f` is inlined.
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

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
instruction_set! { $
    /// x86-64 with AVX2 and F16C: Intel since Haswell, AMD since Zen.
    Avx2, compiled_for_avx2, ["avx2" "bmi1" "bmi2" "f16c" "lzcnt" "popcnt"]
}

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
instruction_set! { $
    /// x86-64 with AVX-512F, BW and VL: Intel servers since Skylake, AMD since Zen 4.
    Avx512, compiled_for_avx512,
    ["avx2" "avx512bw" "avx512f" "avx512vl" "bmi1" "bmi2" "f16c" "lzcnt" "popcnt"]
}

#[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
instruction_set! { $
    /// aarch64 with NEON (Advanced SIMD).
    Neon, compiled_for_neon, ["neon"]
}

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
impl Avx512 {
    /// AVX-512 includes AVX2.
    #[must_use]
    pub const fn as_avx2(self) -> Avx2 {
        // SAFETY: the list of features of `Avx512` includes that of `Avx2`, and `self` proves it.
        unsafe { Avx2::assume_supported() }
    }
}

/// The instruction set that a query runs on.
///
/// ```
/// use simdop::isa::Isa;
/// let isa = Isa::detect();
/// assert!(Isa::available().any(|each| each == isa));
/// assert_eq!(isa.at_most(Isa::SCALAR), Isa::SCALAR);
/// assert_eq!(isa.name().parse(), Ok(isa));
/// ```
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum Isa {
    /// Plain Rust.
    Scalar(Scalar),
    /// NEON.
    #[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
    Neon(Neon),
    /// AVX2.
    #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
    Avx2(Avx2),
    /// AVX-512.
    #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
    Avx512(Avx512),
}

/// A name that is no [`Isa`] here.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum IsaError {
    /// No instruction set has this name.
    Unknown,
    /// The library has kernels for it, but this machine has not got it.
    NotAvailable,
}

impl fmt::Display for IsaError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unknown => "no such instruction set: scalar, neon, avx2 or avx512",
            Self::NotAvailable => "this machine does not have that instruction set",
        })
    }
}

impl core::error::Error for IsaError {}

impl Isa {
    /// Plain Rust.
    pub const SCALAR: Self = Self::Scalar(Scalar::new());
    /// The names of all instruction sets with kernels, on any machine, weakest first.
    pub const NAMES: [&'static str; 4] = ["scalar", "neon", "avx2", "avx512"];

    /// The best instruction set of this machine. Ask once and keep the answer.
    #[must_use]
    pub fn detect() -> Self {
        Self::available().last().unwrap_or(Self::SCALAR)
    }

    /// The best instruction set among those that the crate is compiled for.
    #[must_use]
    pub const fn baseline() -> Self {
        #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
        {
            if let Some(token) = Avx512::baseline() {
                return Self::Avx512(token);
            }
            if let Some(token) = Avx2::baseline() {
                return Self::Avx2(token);
            }
        }
        #[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
        if let Some(token) = Neon::baseline() {
            return Self::Neon(token);
        }
        Self::SCALAR
    }

    /// All instruction sets of this machine, weakest first.
    pub fn available() -> impl Iterator<Item = Self> + Clone {
        [
            Some(Self::SCALAR),
            #[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
            Neon::detect().map(Self::Neon),
            #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
            Avx2::detect().map(Self::Avx2),
            #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
            Avx512::detect().map(Self::Avx512),
        ]
        .into_iter()
        .flatten()
    }

    /// The weaker of the two: caps a detected instruction set.
    #[must_use]
    pub fn at_most(self, cap: Self) -> Self {
        if self.rank() > cap.rank() { cap } else { self }
    }

    /// Its name, as [`FromStr`] reads it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        Self::NAMES[self.rank()]
    }

    /// Place in [`Isa::NAMES`].
    const fn rank(self) -> usize {
        match self {
            Self::Scalar(_) => 0,
            #[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
            Self::Neon(_) => 1,
            #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
            Self::Avx2(_) => 2,
            #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
            Self::Avx512(_) => 3,
        }
    }
}

impl fmt::Display for Isa {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Isa {
    type Err = IsaError;

    fn from_str(name: &str) -> Result<Self, IsaError> {
        if !Self::NAMES.contains(&name) {
            return Err(IsaError::Unknown);
        }
        Self::available().find(|isa| isa.name() == name).ok_or(IsaError::NotAvailable)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_caps_and_errors() {
        for isa in Isa::available() {
            assert_eq!(isa.name().parse(), Ok(isa));
            assert_eq!(isa.at_most(isa), isa);
            assert_eq!(Isa::SCALAR.at_most(isa), Isa::SCALAR);
            assert_eq!(isa.at_most(Isa::SCALAR), Isa::SCALAR);
        }
        assert_eq!("sse9".parse::<Isa>(), Err(IsaError::Unknown));
        for name in Isa::NAMES {
            let here = Isa::available().any(|isa| isa.name() == name);
            assert_eq!(name.parse::<Isa>().is_ok(), here, "{name}");
        }
        assert!(Isa::available().any(|isa| isa == Isa::baseline()), "the baseline is available");
    }
}
