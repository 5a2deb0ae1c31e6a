//! Instruction sets as values.
//!
//! A *token* ([`Scalar`], `Avx2`, `Avx512`, `Neon`) is a zero-sized proof that this machine supports an instruction
//! set. Safe code gets one only by detection, or inside a function that is itself compiled for those features, so a
//! kernel that takes a token needs no check of its own. [`Isa`] is one of the tokens, chosen at run time: a plain
//! value that the caller stores and passes to queries.
//!
//! Each list of features is written once, as a row in `token.rs`. A row generates the token, its detection, its gate
//! (`run`), and the attribute macro that compiles the token's kernels.
//!
//! `build.rs` decides from the target which instruction sets have kernels, and sets the conditions `simdop_x86` and
//! `simdop_neon`.
//!
//! Without `std`, x86-64 is detected by CPUID and XCR0. On aarch64 the crate's target features decide, which include
//! NEON on nearly every aarch64 target. Targets with a soft-float ABI (`x86_64-unknown-none`) cannot pass vector
//! registers, so they have [`Scalar`] only. Bare-metal code that knows its processor can make a token with
//! `unsafe { Avx2::assume_supported() }`.

#![cfg_attr(
    any(simdop_x86, simdop_neon),
    expect(
        unsafe_code,
        reason = "entering a function compiled for detected features is the point of this module"
    )
)]

#[cfg(all(simdop_x86, any(test, not(feature = "std"))))]
mod cpuid;
mod token;

#[cfg(simdop_neon)]
pub use token::Neon;
pub use token::Scalar;
#[cfg(simdop_neon)]
pub(crate) use token::compiled_for_neon;
#[cfg(simdop_x86)]
pub use token::{Avx2, Avx512};
#[cfg(simdop_x86)]
pub(crate) use token::{compiled_for_avx2, compiled_for_avx512};

use core::fmt;
use core::str::FromStr;

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
pub enum Isa {
    /// Plain Rust.
    Scalar(Scalar),
    /// NEON.
    #[cfg(simdop_neon)]
    Neon(Neon),
    /// AVX2.
    #[cfg(simdop_x86)]
    Avx2(Avx2),
    /// AVX-512.
    #[cfg(simdop_x86)]
    Avx512(Avx512),
}

// One macro per kind of target: a `cfg` on an arm would be evaluated in the crate that uses the macro.
#[cfg(simdop_x86)]
#[doc(hidden)]
#[macro_export]
macro_rules! __on_isa {
    ($isa:expr, $token:ident => $call:expr) => {
        match $isa {
            $crate::isa::Isa::Scalar($token) => $call,
            $crate::isa::Isa::Avx2($token) => $call,
            $crate::isa::Isa::Avx512($token) => $call,
        }
    };
}

#[cfg(simdop_neon)]
#[doc(hidden)]
#[macro_export]
macro_rules! __on_isa {
    ($isa:expr, $token:ident => $call:expr) => {
        match $isa {
            $crate::isa::Isa::Scalar($token) => $call,
            $crate::isa::Isa::Neon($token) => $call,
        }
    };
}

#[cfg(not(any(simdop_x86, simdop_neon)))]
#[doc(hidden)]
#[macro_export]
macro_rules! __on_isa {
    ($isa:expr, $token:ident => $call:expr) => {
        match $isa {
            $crate::isa::Isa::Scalar($token) => $call,
        }
    };
}

/// Evaluates an expression with the token of an [`Isa`]: dispatches from the run-time value to a type.
///
/// ```
/// use simdop::isa::{Isa, on_isa};
/// use simdop::{low_level::kernel::Kernel, node::{Node, Node16}};
/// let empty = Node16::<18>::EMPTY;
/// for isa in Isa::available() {
///     let rows = on_isa!(isa, token => token.overlap_16v_hull(&[[0; 16]; 18], &empty));
///     assert_eq!(rows, 0, "{isa}: nothing overlaps an empty node");
/// }
/// ```
#[doc(inline)]
pub use __on_isa as on_isa;

/// A name that is not an [`Isa`] of this machine.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum IsaError {
    /// No instruction set has this name.
    Unknown,
    /// The library has kernels for it, but this machine does not support it.
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
    /// The names of all instruction sets with kernels, on any target, weakest first.
    pub const NAMES: [&'static str; 4] = ["scalar", "neon", "avx2", "avx512"];

    /// The best instruction set of this machine. Detect once and keep the result.
    #[must_use]
    pub fn detect() -> Self {
        Self::available().last().unwrap_or(Self::SCALAR)
    }

    /// The best instruction set that is enabled at compile time.
    #[must_use]
    pub const fn baseline() -> Self {
        #[cfg(simdop_x86)]
        {
            if let Some(token) = Avx512::baseline() {
                return Self::Avx512(token);
            }
            if let Some(token) = Avx2::baseline() {
                return Self::Avx2(token);
            }
        }
        #[cfg(simdop_neon)]
        if let Some(token) = Neon::baseline() {
            return Self::Neon(token);
        }
        Self::SCALAR
    }

    /// All instruction sets of this machine, weakest first.
    pub fn available() -> impl Iterator<Item = Self> + Clone {
        [
            Some(Self::SCALAR),
            #[cfg(simdop_neon)]
            Neon::detect().map(Self::Neon),
            #[cfg(simdop_x86)]
            Avx2::detect().map(Self::Avx2),
            #[cfg(simdop_x86)]
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

    /// Its name, as parsed by [`FromStr`].
    #[must_use]
    pub const fn name(self) -> &'static str {
        Self::NAMES[self.rank()]
    }

    /// Index in [`Isa::NAMES`].
    const fn rank(self) -> usize {
        match self {
            Self::Scalar(_) => 0,
            #[cfg(simdop_neon)]
            Self::Neon(_) => 1,
            #[cfg(simdop_x86)]
            Self::Avx2(_) => 2,
            #[cfg(simdop_x86)]
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
