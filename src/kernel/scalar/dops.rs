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

/// Bit i: child i lies beyond the slab.
pub(super) fn beyond<const W: usize, const K: usize>(slab: &OwnSlab, planes: &[[i16; W]; K]) -> u16 {
    (0..W).filter(|&i| slab.is_beyond(|source| planes[source][i])).fold(0, |mask, i| mask | 1 << i)
}

pub(super) fn realign<const W: usize, const K: usize>(
    map: &Realignment<K>,
    planes: &[[i16; W]; K],
    query: &mut Turned<W, K>,
) {
    for lane in 0..W {
        // Each is a term of several sums.
        let mut decoded = [0.0; K];
        for (decoded, plane) in decoded.iter_mut().zip(planes) {
            *decoded = decode(plane[lane]);
        }
        for s in 0..K / 2 {
            let [ahead, behind] = map.slab_of(s, &decoded);
            (query[2 * s + 1][lane], query[2 * s][lane]) = (!ahead.code(), !behind.code());
        }
        if planes[0][lane] == Key::EMPTY.code() {
            query[0][lane] = SEPARATED;
        }
    }
}
