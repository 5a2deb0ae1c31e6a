//! Faces and weights without a search, for the four sets with the symmetry of the cube (k = 6, 14, 18, 26).
//!
//! The cube has 48 symmetries: permutations of the axes, and signs. One of them maps any u to `hi >= mid >= lo >= 0`,
//! where the hull has one face, or two:
//!
//! | k | vertices of the face | weights |
//! |---|---|---|
//! | 6 | (1,0,0) (0,1,0) (0,0,1) | hi, mid, lo |
//! | 14 | (1,0,0) (1,1,1) (1,1,-1) | hi - mid, (mid + lo) / 2, (mid - lo) / 2 |
//! | 18, `a = hi - mid - lo >= 0` | (1,0,0) (1,1,0) (1,0,1) | a, mid, lo |
//! | 18, a < 0 | (0,1,1) (1,1,0) (1,0,1) | -a / 2, mid + a / 2, lo + a / 2 |
//! | 26 | (1,0,0) (1,1,0) (1,1,1) | hi - mid, mid - lo, lo |
//!
//! The tests compare with the cheapest of all triples. No branch depends on u: searching the grid took 13 ns per
//! direction, 116 of the 380 ns of a set-up at k = 18.

use super::table::table;

/// For each order and sign combination of the coordinates, and each of two faces: its vertices, padded to four bytes,
/// which are moved at once.
pub(super) type Sectors = [[u8; 4]; 128];

/// Whether the directions have the symmetry of the cube.
pub(super) const fn applies(k: usize) -> bool {
    k != 32
}

/// The vertices of the face in the sector, in (hi, mid, lo) coordinates.
const fn corners(k: usize, second: bool) -> [[i8; 3]; 3] {
    match k {
        14 => [[1, 0, 0], [1, 1, 1], [1, 1, -1]],
        18 if second => [[0, 1, 1], [1, 1, 0], [1, 0, 1]],
        18 => [[1, 0, 0], [1, 1, 0], [1, 0, 1]],
        26 => [[1, 0, 0], [1, 1, 0], [1, 1, 1]],
        _ => [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    }
}

/// Which axes are hi, mid and lo, indexed by bits 0, 1, 2: x >= y, y >= z, x >= z. Two of the eight cases do not
/// occur.
const ORDER: [[usize; 3]; 8] =
    [[2, 1, 0], [2, 0, 1], [1, 2, 0], [0, 1, 2], [0, 1, 2], [0, 2, 1], [1, 0, 2], [0, 1, 2]];

pub(super) const fn sectors(k: usize) -> Sectors {
    let mut sectors = [[0; 4]; 128];
    if !applies(k) {
        return sectors;
    }
    let mut code = 0;
    while code < 128 {
        let order = ORDER[code & 7];
        let corners = corners(k, code >> 6 != 0);
        let mut l = 0;
        while l < 3 {
            let mut v = [0; 3];
            let mut i = 0;
            while i < 3 {
                let sign = if code >> (3 + order[i]) & 1 == 0 { 1 } else { -1 };
                v[order[i]] = sign * corners[l][i];
                i += 1;
            }
            sectors[code][l] = index_of(k, v);
            l += 1;
        }
        code += 1;
    }
    sectors
}

/// # Panics
/// If no direction is `v`. This file then contradicts the directions, and does not compile.
const fn index_of(k: usize, v: [i8; 3]) -> u8 {
    let vectors = table(k).vectors;
    let mut j = 0;
    while j < k {
        let n = vectors[j];
        if n[0] == v[0] && n[1] == v[1] && n[2] == v[2] {
            return j as u8;
        }
        j += 1;
    }
    panic!("not one of the directions")
}

/// Like [`f64::max`], but one instruction on x86. If either is NaN, the result is `b`.
#[inline]
pub(crate) fn greater<T: PartialOrd>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

/// The precision of a decomposition: `f32` in set-ups, `f64` for bounds of distances.
pub(crate) trait Float: Copy + PartialOrd {
    /// An integer of the same width, so that numbers and sectors share vector instructions.
    type Sector: Copy;
    const NO_SECTOR: Self::Sector;

    fn from_f64(x: f64) -> Self;
    fn to_f64(self) -> f64;
    fn index(sector: Self::Sector) -> usize;
    /// The weights of u, and the sector that determines their directions.
    fn split<const K: usize>(u: [Self; 3]) -> ([Self; 3], Self::Sector);
}

macro_rules! impl_float {
    ($float:ident, $bits:ident) => {
        impl Float for $float {
            type Sector = $bits;
            const NO_SECTOR: $bits = 0;

            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                x as $float
            }

            #[inline(always)]
            fn to_f64(self) -> f64 {
                self.into()
            }

            #[inline(always)]
            fn index(sector: $bits) -> usize {
                sector as usize & 127
            }

            #[inline(always)]
            fn split<const K: usize>(u: [Self; 3]) -> ([Self; 3], $bits) {
                let lesser = |a: $float, b: $float| if a < b { a } else { b };
                let bit = |condition: bool| if condition { 1 as $bits } else { 0 };
                let negative = |x: $float| x.to_bits() >> ($bits::BITS - 1);
                let [x, y, z] = [u[0].abs(), u[1].abs(), u[2].abs()];
                let hi = greater(x, greater(y, z));
                let mid = greater(lesser(x, y), lesser(greater(x, y), z));
                let lo = lesser(x, lesser(y, z));
                let a = (hi - mid) - lo;
                let weights = match K {
                    14 => [hi - mid, 0.5 * (mid + lo), 0.5 * (mid - lo)],
                    18 => {
                        let half = 0.5 * lesser(a, 0.0);
                        [greater(a, -half), mid + half, lo + half]
                    }
                    26 => [hi - mid, mid - lo, lo],
                    _ => [hi, mid, lo],
                };
                let order = bit(x >= y) | bit(y >= z) << 1 | bit(x >= z) << 2;
                let signs = negative(u[0]) | negative(u[1]) << 1 | negative(u[2]) << 2;
                // The weights of a finite u are not negative; this is for other u.
                let weights = [greater(weights[0], 0.0), greater(weights[1], 0.0), greater(weights[2], 0.0)];
                (weights, order | signs << 3 | bit(a < 0.0) << 6)
            }
        }
    };
}

impl_float!(f32, u32);
impl_float!(f64, u64);
