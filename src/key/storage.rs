//! The common interface of the two storages of planes.

use core::fmt;
use core::hash::Hash;

/// How a plane is stored in 16 bits. Implemented by [`Fixed`](super::Fixed) and [`Half`](super::Half) only.
pub trait Storage: Copy + Ord + Hash + Default + fmt::Debug + Send + Sync + sealed::Sealed + 'static {
    /// The storage in the header of a tree.
    const CODE: u16 = Self::KIND as u16;
    /// The storage as a value.
    const KIND: StorageKind;
    /// Whether codes are half floats, for kernels that convert a register at a time.
    const IS_HALF: bool = matches!(Self::KIND, StorageKind::Half);
    /// A plane's value minus its [number](Storage::number), in steps. Sums of planes add it once.
    const OFFSET: f32;
    /// The code of a plane that is unbounded.
    const INFINITY: i16;
    /// The code of the greatest plane of a body. The lowest is its complement.
    const GREATEST: i16;

    /// The number of a code, which kernels multiply by weights. Exact.
    fn number(code: i16) -> f32;

    /// The value of a code, in steps. Exact.
    #[inline(always)]
    #[must_use]
    fn value(code: i16) -> f32 {
        Self::number(code) + Self::OFFSET
    }

    /// The code that kernels round a rotated plane to: a bound not below x, at most one code above the least.
    /// [`Storage::INFINITY`] if x is NaN or above all planes; the lowest plane if x is below all planes.
    fn around(x: f32) -> i16;

    /// The least code that bounds x. Saturates as [`Storage::around`] does.
    fn round_up(x: f64) -> i16;

    /// Whether a code can be a plane of a body.
    fn is_plane(code: i16) -> bool;
}

/// A [`Storage`] that is chosen at run time. The numbers are those in headers of trees.
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Debug)]
pub enum StorageKind {
    /// [`Fixed`](super::Fixed).
    #[default]
    Fixed = 0,
    /// [`Half`](super::Half).
    Half = 1,
}

impl StorageKind {
    /// The storage with this code in the header of a tree, if there is one.
    #[must_use]
    pub const fn from_code(code: u16) -> Option<Self> {
        const FIXED: u16 = StorageKind::Fixed as u16;
        const HALF: u16 = StorageKind::Half as u16;
        match code {
            FIXED => Some(Self::Fixed),
            HALF => Some(Self::Half),
            _ => None,
        }
    }
}

impl fmt::Display for StorageKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Fixed => "fixed point",
            Self::Half => "half floats",
        })
    }
}

/// The code of every plane of an unused lane, in every storage.
pub(crate) const EMPTY: i16 = i16::MIN;

pub(super) mod sealed {
    pub trait Sealed {}
}
