//! Children against children, and re-alignment.

use super::super::{SEPARATED, Turned};
use crate::key::{Key, decode};
use crate::realign::{OwnSlab, Realignment};

/// Whether some plane separates body `a` of the query from child `b`.
pub(super) fn separated<const W: usize, const K: usize>(
    query: &Turned<W, K>,
    a: usize,
    planes: &[[i16; W]; K],
    b: usize,
) -> bool {
    query.iter().zip(planes).any(|(q, p)| q[a] > p[b])
}

/// Bit i: no plane separates body i of the query from the hull of all children.
pub(super) fn overlap_hull<const K: usize>(query: &Turned<16, K>, planes: &[[i16; 16]; K]) -> u16 {
    let mut mask = u16::MAX;
    for (bodies, planes) in query.iter().zip(planes) {
        let greatest = planes.iter().copied().fold(i16::MIN, i16::max);
        for (i, body) in bodies.iter().enumerate() {
            mask &= !(u16::from(*body > greatest) << i);
        }
        // Often after a few planes.
        if mask == 0 {
            break;
        }
    }
    mask
}

/// Bit i: child i lies beyond the slab.
pub(super) fn beyond<const W: usize, const K: usize>(slab: &OwnSlab, planes: &[[i16; W]; K]) -> u16 {
    (0..W).filter(|&i| slab.is_beyond(|source| planes[source][i])).fold(0, |mask, i| mask | 1 << i)
}

pub(super) fn realign<const W: usize, const K: usize>(
    map: &Realignment<K>,
    planes: &[[i16; W]; K],
    query: &mut Turned<W, K>,
) {
    // Each is a term of several sums.
    let mut decoded = [[0.0; W]; K];
    for (decoded, codes) in decoded.as_flattened_mut().iter_mut().zip(planes.as_flattened()) {
        *decoded = decode(*codes);
    }
    for j in 0..K {
        let [(x, u), (y, v), (z, w)] = map.terms(j).map(|(source, weight)| (&decoded[source], weight));
        for lane in 0..W {
            let sum = ((u * x[lane] + v * y[lane]) + w * z[lane]) + map.offset[j];
            query[j ^ 1][lane] = !Key::round_up_single(sum).code();
        }
    }
    for lane in 0..W {
        if planes[0][lane] == Key::EMPTY.code() {
            query[0][lane] = SEPARATED;
        }
    }
}
