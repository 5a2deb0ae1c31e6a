//! Children against children, and re-alignment.

use super::super::{SEPARATED, Turned};
use crate::key::{EMPTY, Storage};
use crate::realign::{PrimitiveSlab, Realignment};

/// Whether some plane separates body `a` of the query from child `b`.
pub(super) fn separated<const W: usize, const V: usize, const K: usize>(
    query: &Turned<W, K>,
    a: usize,
    planes: &[[i16; V]; K],
    b: usize,
) -> bool {
    query.iter().zip(planes).any(|(q, p)| q[a] > p[b])
}

/// Bit i: no plane separates body i of the query from the hull of all children.
pub(super) fn overlap_hull<const K: usize>(query: &Turned<16, K>, planes: &[[i16; 16]; K]) -> u16 {
    query.iter().zip(planes).fold(u16::MAX, |mask, (bodies, planes)| {
        let greatest = planes.iter().copied().fold(i16::MIN, i16::max);
        mask & (0..16).filter(|&i| bodies[i] <= greatest).fold(0, |mask, i| mask | 1 << i)
    })
}

/// Bit i: child i lies beyond the slab.
pub(super) fn beyond<const W: usize, const K: usize, S: Storage>(
    slab: &PrimitiveSlab,
    planes: &[[i16; W]; K],
) -> u16 {
    (0..W).filter(|&i| slab.is_beyond::<S>(|source| planes[source][i])).fold(0, |mask, i| mask | 1 << i)
}

pub(super) fn realign<const W: usize, const K: usize, S: Storage>(
    map: &Realignment<K, S>,
    planes: &[[i16; W]; K],
    query: &mut Turned<W, K>,
) {
    let decoded = decoded::<W, K, S>(planes);
    for j in 0..K {
        turn(map, &decoded, j, &mut query[j ^ 1]);
    }
    separate_unused(planes, query);
}

/// [`crate::kernel::Kernel::realign_16_over`]. Rotates plane by plane, and only for children that no earlier plane has
/// separated: two planes separate most.
pub(super) fn realign_over<const K: usize, S: Storage>(
    map: &Realignment<K, S>,
    a: &[[i16; 16]; K],
    query: &mut Turned<16, K>,
    whole: &mut u16,
    b: &[[i16; 16]; K],
    lane: Option<usize>,
) -> u16 {
    // 32-bit masks match the registers of the small cores that this code is for. `separate`, below, sets the planes of
    // unused lanes above every key.
    let unused = (0..16).filter(|&i| a[0][i] == EMPTY).fold(0_u32, |mask, i| mask | 1 << i);
    let known = u32::from(*whole);
    let mut mask = u32::from(u16::MAX);
    for j in 0..K {
        let (turned, limits) = (&mut query[j ^ 1], &b[j ^ 1]);
        let limit = match lane {
            Some(lane) => limits[lane & 15],
            None => limits.iter().copied().fold(i16::MIN, i16::max),
        };
        let [(x, u), (y, v), (z, w)] = map.terms(j).map(|(source, weight)| (&a[source], weight));
        let offset = map.offset[j];
        let mut left = mask;
        while left != 0 {
            let i = left.trailing_zeros() as usize & 15;
            let bit = 1 << i;
            left ^= bit;
            if known & bit == 0 {
                let code = |codes: &[i16; 16]| S::number(codes[i]);
                turned[i] = !S::around(((u * code(x) + v * code(y)) + w * code(z)) + offset);
            }
            if turned[i] > limit {
                mask ^= bit;
            }
        }
        if j == 1 && mask & unused & !known != 0 {
            mask = separate(unused & !known, turned, limit, mask);
        }
        if mask == 0 {
            return 0;
        }
    }
    *whole |= mask as u16;
    mask as u16
}

/// Marks unused lanes, and clears their bits unless the plane they are compared with is above every key.
#[cold]
fn separate(unused: u32, turned: &mut [i16; 16], limit: i16, mask: u32) -> u32 {
    for i in (0..16).filter(|i| unused >> i & 1 != 0) {
        turned[i] = SEPARATED;
    }
    if SEPARATED > limit { mask & !unused } else { mask }
}

/// Each plane is a term of several sums, so it is decoded once.
fn decoded<const W: usize, const K: usize, S: Storage>(planes: &[[i16; W]; K]) -> [[f32; W]; K] {
    let mut decoded = [[0.0; W]; K];
    for (decoded, codes) in decoded.as_flattened_mut().iter_mut().zip(planes.as_flattened()) {
        *decoded = S::number(*codes);
    }
    decoded
}

/// Rotates plane j of all children.
fn turn<const W: usize, const K: usize, S: Storage>(
    map: &Realignment<K, S>,
    decoded: &[[f32; W]; K],
    j: usize,
    turned: &mut [i16; W],
) {
    let [(x, u), (y, v), (z, w)] = map.terms(j).map(|(source, weight)| (&decoded[source], weight));
    for lane in 0..W {
        let sum = ((u * x[lane] + v * y[lane]) + w * z[lane]) + map.offset[j];
        turned[lane] = !S::around(sum);
    }
}

fn separate_unused<const W: usize, const K: usize>(planes: &[[i16; W]; K], query: &mut Turned<W, K>) {
    for lane in 0..W {
        if planes[0][lane] == EMPTY {
            query[0][lane] = SEPARATED;
        }
    }
}
