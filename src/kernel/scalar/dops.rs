//! Children against children, and re-alignment.

use super::super::{SEPARATED, Turned};
use crate::key::Key;
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
    query.iter().zip(planes).fold(u16::MAX, |mask, (bodies, planes)| mask & below(bodies, planes))
}

/// Bit i: one plane of body i does not separate it from the hull of all children.
fn below(bodies: &[i16; 16], planes: &[i16; 16]) -> u16 {
    let greatest = planes.iter().copied().fold(i16::MIN, i16::max);
    (0..16).filter(|&i| bodies[i] <= greatest).fold(0, |mask, i| mask | 1 << i)
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
    let decoded = decoded(planes);
    for j in 0..K {
        turn(map, &decoded, j, &mut query[j ^ 1]);
    }
    separate_unused(planes, query);
}

/// [`realign`], and [`overlap_hull`] of `b` with its result. Plane by plane, and no further than until all bodies are
/// separated: often after a few planes.
pub(super) fn realign_over_hull<const K: usize>(
    map: &Realignment<K>,
    a: &[[i16; 16]; K],
    query: &mut Turned<16, K>,
    b: &[[i16; 16]; K],
) -> u16 {
    let decoded = decoded(a);
    let mut mask = u16::MAX;
    for j in 0..K {
        turn(map, &decoded, j, &mut query[j ^ 1]);
        if j == 1 {
            separate_unused(a, query);
        }
        mask &= below(&query[j ^ 1], &b[j ^ 1]);
        if mask == 0 {
            return 0;
        }
    }
    mask
}

/// Each plane is a term of several sums.
fn decoded<const W: usize, const K: usize>(planes: &[[i16; W]; K]) -> [[f32; W]; K] {
    let mut decoded = [[0.0; W]; K];
    for (decoded, codes) in decoded.as_flattened_mut().iter_mut().zip(planes.as_flattened()) {
        *decoded = f32::from(*codes);
    }
    decoded
}

/// Plane j of all children, turned.
fn turn<const W: usize, const K: usize>(
    map: &Realignment<K>,
    decoded: &[[f32; W]; K],
    j: usize,
    turned: &mut [i16; W],
) {
    let [(x, u), (y, v), (z, w)] = map.terms(j).map(|(source, weight)| (&decoded[source], weight));
    for lane in 0..W {
        let sum = ((u * x[lane] + v * y[lane]) + w * z[lane]) + map.offset[j];
        turned[lane] = !Key::around(sum).code();
    }
}

fn separate_unused<const W: usize, const K: usize>(planes: &[[i16; W]; K], query: &mut Turned<W, K>) {
    for lane in 0..W {
        if planes[0][lane] == Key::EMPTY.code() {
            query[0][lane] = SEPARATED;
        }
    }
}
